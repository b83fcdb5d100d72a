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
        assert!(twice.is_over() && comparison.judged().first == Some(twice), "{line:?}");
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

#[test]
fn twice_what_single_precision_costs_in_a_run_is_allowed() {
    let first = |name: &str, rounding: f64| {
        let what = line("element_force", name);
        let mut comparison = Comparison::new(false);
        for (step, times) in [(0, 0.5), (1, 2.0), (2, 3.0), (3, 2.5)] {
            let mut d = difference(what, times, false);
            d.relative = d.relative.max(if TOLERANCES[what].roundings == 0.0 { times } else { 0.0 });
            let rounding = if step == 3 { rounding * d.limit.max(1.0) } else { 0.0 };
            comparison.see(BackendDifference { step, rounding, ..d });
        }
        comparison.judged().first.map(|d| d.step)
    };
    let limit = TOLERANCES[line("element_force", "membrane force")].limit(false);
    let found = [0.0, 0.9, 1.2, 1.6].map(|rounding| first("membrane force", rounding * limit));
    assert_eq!(found, [Some(1), Some(1), Some(2), None]);
    // What must be equal stays so.
    assert_eq!(first("yarn alive", 10.0), Some(0));
}
