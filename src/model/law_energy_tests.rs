use super::*;
use crate::case;
use crate::physics::yarn_law::Variational;

fn cell() -> UnitCellParameters<f64> {
    UnitCellParameters::new(&crate::case::shipped(&[]).fabric)
}

#[test]
fn a_law_that_is_a_slope_has_none_and_the_published_one_has() {
    let cell = cell();
    assert!(table_of(Law::Variational, &cell).is_none());
    for stretch in [[0.01, 0.0], [0.02, 0.02], [0.04, 0.01]] {
        let conserved = law_share::<Variational>(&cell, stretch).abs();
        let published = law_share::<Published>(&cell, stretch).abs();
        assert!(conserved < 0.05 * published && published < 0.3, "{stretch:?}: {conserved} {published}");
    }
}

#[test]
fn the_table_is_what_it_tabulates() {
    let cell = cell();
    let Some(table) = LawEnergy::new(&cell) else { unreachable!("the published law has a table") };
    for stretch in [[0.004, 0.003], [0.011, 0.002], [0.013, 0.017], [0.03, 0.012], [0.05, -0.01]] {
        let exact = law_share::<Published>(&cell, stretch);
        assert!((table.at(stretch) - exact).abs() < 0.02, "{stretch:?}: {} {exact}", table.at(stretch));
    }
    // Slack, and beyond the table: what is nearest.
    assert!(table.at([-0.2, -0.2]) == 0.0 && table.at([9.0, 9.0]).abs() <= 1.0);
}

#[test]
fn a_share_is_what_small_steps_on_the_way_miss() {
    let cell = cell();
    for stretch in [[0.02, 0.02], [0.04, 0.01], [0.015, 0.035], [0.05, -0.01]] {
        let (mut warm, mut work) = (cell.yarn.map(|yarn| yarn.height), 0.0);
        let steps = 2000;
        let mut end = solve::<f64, Published>(&cell, [0.0; 2], warm, true);
        for step in 1..=steps {
            let next = stretch.map(|s| s * f64::from(step) / f64::from(steps));
            let there = solve::<f64, Published>(&cell, next, warm, true);
            for i in 0..2 {
                let mean = 0.5 * (there.in_plane[i] + end.in_plane[i]);
                work += mean * 2.0 * cell.yarn[i].half_span * stretch[i] / f64::from(steps);
            }
            (warm, end) = (there.height, there);
        }
        let stored = cell_energy(&cell, &end.tension, &end.strain, end.force);
        let share = law_share::<Published>(&cell, stretch);
        assert!((share - (1.0 - work / stored)).abs() < 1e-3, "{stretch:?}: {share} {}", 1.0 - work / stored);
    }
    assert_eq!(law_share::<Published>(&cell, [-0.01, 0.0]), 0.0);
}

fn cell_of(set: &str) -> UnitCellParameters<f64> {
    UnitCellParameters::new(&case::shipped(&[set]).fabric)
}

#[test]
fn models_share_the_table_of_their_cell_and_no_other() {
    let law = Law::Published;
    for set in ["/fabric/warp/crimp=0.02", "/fabric/warp/crimp=0.021", "/fabric/weft/modulus_gpa=90"] {
        let cell = cell_of(set);
        let [first, again] = [table_of(law, &cell), table_of(law, &cell)];
        assert!(first.as_ref().zip(again.as_ref()).is_some_and(|(first, again)| Arc::ptr_eq(first, again)), "{set}");
        assert_eq!(first.as_deref(), LawEnergy::new(&cell).as_ref(), "{set}");
    }
    assert!(table_of(Law::Variational, &cell_of("/fabric/warp/crimp=0.02")).is_none());
}
