use super::*;

/// A difference of so many times the tolerance of a line.
fn difference(what: usize, times: f64, hardware: bool) -> BackendDifference {
    let limit = TOLERANCES[what].limit(hardware);
    let relative = times * limit;
    BackendDifference {
        step: 0,
        what,
        place: [0; 3],
        component: 0,
        cpu: 0.0,
        gpu: relative,
        wide: 0.0,
        relative,
        rounding: 0.0,
        limit,
    }
}

#[test]
fn every_line_turns_red_at_twice_its_tolerance_and_not_at_half() {
    let everywhere = TOLERANCES.iter().enumerate().flat_map(|line| [(line, false), (line, true)]);
    for ((what, line), hardware) in everywhere {
        let of = |times: f64| difference(what, times, hardware);
        assert!(!of(0.5).is_over(), "{line:?}");
        let twice = if line.roundings == 0.0 { BackendDifference { relative: 1e-30, ..of(2.0) } } else { of(2.0) };
        let mut comparison = Comparison::new(hardware);
        comparison.see(twice.clone());
        assert!(twice.is_over() && comparison.first == Some(twice), "{line:?}");
        assert!(BackendDifference { relative: f64::NAN, ..of(0.0) }.is_over(), "{line:?}");
    }
}

#[test]
fn every_line_says_what_it_is_measured_by_and_stands_once() {
    for (what, Tolerance { kernel, quantity, scale, reason, .. }) in TOLERANCES.iter().enumerate() {
        assert_eq!(line(kernel, quantity), what, "{quantity} of {kernel}");
        assert!(!scale.is_empty() && !reason.is_empty(), "{quantity} of {kernel}");
    }
}
