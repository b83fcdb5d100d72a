use super::*;
use crate::solver::element_totals::field as element;

#[test]
fn kinetic_energy_after_a_step_without_force_is_that_before() {
    let zero = [0.0; 4];
    let mut rows = [[0.0; 3], [0.0; 3], [0.0; 3], [1.0, 2.0, 3.0], [0.0, 5.0, 0.0], [7.0, 0.0, 0.0]];
    for sample in [false, true] {
        let [a, b, c, d, e, f] = &mut rows;
        let mut node: NodeRow<'_, f64> = [a, b, c, d, e, f];
        let around = Neighbours { below: [&zero[..]; element::FORCES.end], above: [&zero[..]; element::FORCES.end] };
        let (inverse, mass) = ([&[0.5, 0.25, 0.5][..]; 3], &[2.0, 4.0, 2.0][..]);
        let times = [0.1, 0.2];
        let pass = NodePass { around, inverse, mass, range: 0..3, columns: 3, edge_row: false, times, sample };
        let totals = node_update(0.0, &pass, &mut node);
        // ½ Σ m v²: 1·(1 + 49) + 2·(4 + 25) + 1·9.
        assert_eq!((totals.kinetic, totals.max_speed_squared), (117.0, 50.0));
        assert_eq!(totals.kinetic_now, if sample { 117.0 } else { 0.0 });
    }
}
