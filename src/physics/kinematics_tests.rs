use super::*;
/// Elements of 2 × 1.5 mm.
const SIZE: ElementGeometry<f64> = ElementGeometry {
    gradient: [250.0, 1.0 / 3e-3],
    membrane: [1.0; 2],
    half_length: [1.0; 2],
    hourglass: [0.0; 2],
    viscosity: [0.0; 2],
    steep_viscosity: [0.0; 2],
    viscous_length: 1.0,
    mode_share: 1.0 / 3.0,
    cells: 1.0,
    area: 3e-6,
};

#[test]
fn a_stretch_is_the_root_of_the_mean_square_over_the_element() {
    // Corners of an element of 2 × 1.5 mm, moved anyhow, counter-clockwise.
    let place = [[0.1, 0.2, -0.3], [2.3, 0.1, 0.4], [1.9, 1.6, -0.2], [-0.2, 1.4, 0.5]].map(|p| p.map(|x| 1e-3 * x));
    let flat = [[0.0, 0.0, 0.0], [2e-3, 0.0, 0.0], [2e-3, 1.5e-3, 0.0], [0.0, 1.5e-3, 0.0]];
    let [x, y, z] = [0, 1, 2].map(|a| differences(&[0, 1, 2, 3].map(|c: usize| place[c][a] - flat[c][a])));
    // Gradients across the element, and Simpson's rule, which is exact for their squares.
    let gradient = |from: [usize; 2], to: [usize; 2], length: f64, at: f64| {
        let edge = |i: usize, a: usize| (place[to[i]][a] - place[from[i]][a]) / length;
        (0..3).map(|a| ((1.0 - at) * edge(0, a) + at * edge(1, a)).powi(2)).sum::<f64>()
    };
    let mean = |from, to, length| {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|at| gradient(from, to, length, at));
        ((low + 4.0 * middle + high) / 6.0).sqrt()
    };
    let k = kinematics(&SIZE, [&x, &y, &z]);
    let (warp, weft) = (mean([0, 3], [1, 2], 2e-3), mean([0, 1], [3, 2], 1.5e-3));
    assert!((k.extension[0] - (warp - 1.0)).abs() < 1e-14 && (k.extension[1] - (weft - 1.0)).abs() < 1e-14);
    // The paper's stretch is that at the centre.
    let centre = kinematics(&ElementGeometry { mode_share: 0.0, ..SIZE }, [&x, &y, &z]);
    assert!(centre.extension[0] < k.extension[0] - 1e-3);
}

#[test]
fn stretches_grow_by_what_their_rates_say_to_second_order() {
    // By component: differences along X and Y, and of opposite edges [m], [m/s].
    let u = [[2e-4, 4e-4, -6e-4], [-3e-4, 1e-4, 3e-4], [5e-4, -6e-4, 9e-4]];
    let v = [[30.0, -20.0, 25.0], [14.0, 35.0, -31.0], [-25.0, 40.0, 18.0]];
    let now = kinematics(&SIZE, u.each_ref());
    let off = |dt: f64| {
        let before = [0, 1, 2].map(|a: usize| [0, 1, 2].map(|i: usize| u[a][i] - dt * v[a][i]));
        let before = kinematics(&SIZE, before.each_ref());
        let grown = Growth::new(&SIZE, &now, &v, dt).stretching(&now);
        [0, 1].map(|i| (grown[i] - (now.extension[i] - before.extension[i])).abs())
    };
    let [coarse, fine] = [off(4e-6), off(2e-6)];
    for i in 0..2 {
        // The error is of third order.
        assert!(coarse[i] < 1e-3 && fine[i] < coarse[i] / 6.0, "{coarse:?} {fine:?}");
    }
}
