use super::*;

fn factors(texts: &[&str]) -> Vec<Factor> {
    texts.iter().filter_map(|text| Factor::parse(text).ok()).collect()
}

#[test]
fn a_grid_has_all_combinations_and_sobol_needs_ranges() {
    let lists = factors(&["/a=1,2", "/b=x,y,z"]);
    let grid = SweepDesign::Grid.points(&lists).unwrap_or_default();
    assert_eq!((grid.len(), grid[1].join(" ")), (6, "1 y".to_owned()));
    assert!(SweepDesign::Sobol(8).points(&lists).is_err() && SweepDesign::Total(8).points(&lists).is_err());
    let range = factors(&["/a=100..300"]);
    assert!(SweepDesign::Grid.points(&range).is_err());
    assert_eq!(SweepDesign::Sobol(3).points(&range).unwrap_or_default().concat(), ["200", "250", "150"]);
}

#[test]
fn a_group_for_total_indices_has_a_and_b_and_a_with_each_value_of_b() {
    let design = SweepDesign::Total(16);
    let points = design.points(&factors(&["/a=0..1", "/b=10..20", "/c=-1..1"])).unwrap_or_default();
    assert_eq!((points.len(), design.group(3)), (80, Some(5)));
    for group in points.chunks(5) {
        let [a, b] = [&group[0], &group[1]];
        assert_eq!(group[2], [&b[0], &a[1], &a[2]].map(Clone::clone));
        assert_eq!(group[3], [&a[0], &b[1], &a[2]].map(Clone::clone));
        assert_eq!(group[4], [&a[0], &a[1], &b[2]].map(Clone::clone));
    }
    let pairs = points.chunks(5).flat_map(|group| group[0].iter().zip(&group[1]));
    assert!(pairs.into_iter().all(|(a, b)| a != b));
    assert!(design.points(&factors(&["/a=0..1"; 9])).is_err());
    assert!(SweepDesign::Total(5000).points(&factors(&["/a=0..1"])).is_err());
}
