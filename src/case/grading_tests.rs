use super::*;

/// Lines of a mesh of 40 finest elements that is fine within 4 of a hit.
fn lines_around(hit: f64, lines_from: LinesFrom) -> Vec<f64> {
    let grading =
        Grading { hit: [0.0; 2], way: [0.0; 2], fine: [0.0; 2], growth_ratio: 1.2, max_size: 3.0, lines_from };
    grading.lines(40, [hit - 4.0, hit + 4.0], hit)
}

fn widths(lines: &[f64]) -> Vec<f64> {
    lines.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

#[test]
fn a_line_goes_through_the_hit_and_no_element_is_shorter_than_the_finest() {
    for tenth in 0..=400 {
        let hit = f64::from(tenth) / 10.0;
        let lines = lines_around(hit, LinesFrom::Hit);
        assert_eq!((lines[0], lines[lines.len() - 1]), (0.0, 40.0), "{hit}");
        let widths = widths(&lines);
        assert!(widths.iter().all(|width| *width > 1.0 - 1e-9 && *width <= 3.0 + 1e-9), "{hit}: {widths:?}");
        // Closer to the edge than an element there is no room for a line of its own.
        let at_line = lines.iter().any(|line| (line - hit).abs() < 1e-9);
        assert!(at_line || !(1.0..=39.0).contains(&hit), "{hit}: {lines:?}");
    }
}

#[test]
fn the_mesh_around_a_hit_does_not_depend_on_its_place_in_a_cell() {
    let around = |hit: f64| {
        let lines = lines_around(hit, LinesFrom::Hit);
        let near = lines.iter().filter(|line| (**line - hit).abs() < 4.0 + 1e-9);
        near.map(|line| ((line - hit) * 1e6).round()).collect::<Vec<_>>()
    };
    assert_eq!(around(20.0).len(), 9);
    assert!([20.25, 20.5, 19.9, 14.3].into_iter().all(|hit| around(hit) == around(20.0)));
    let [even, shifted] = [20.0, 20.5].map(|hit| lines_around(hit, LinesFrom::Edges));
    assert!(even.contains(&20.0) && shifted.contains(&20.0) && !shifted.contains(&20.5));
}
