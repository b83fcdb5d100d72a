use crate::case;
use crate::model::Model;

#[test]
fn a_ply_at_rest_rounds_by_one_unit_of_stretch_and_compression_of_each_crossover() {
    let sets = ["/expect=[]", "/pack/width_mm=12.7", "/pack/height_mm=25.4", "/solver/numerics=paper"];
    let case = case::shipped(&sets);
    let model = Model::<f32>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
    let fabric = &case.fabric;
    // 10 by 20 crossovers; half a span of 0.635 mm, in newtons times metres a yarn.
    let yarn = 96e9 * fabric.warp.area(fabric.fibre_density) * 0.635e-3;
    let unit = f64::from(f32::EPSILON);
    let pressed = fabric.crossover.compression.map_or(0.0, |c| c.b.powi(3) / c.a.powi(2));
    // ∫F dd with d = a − a/∛(1 + x) and F = x·(b/a)³, as a series: x is a thousandth.
    let touched = fabric.crossover.compression.map_or(0.0, |c| {
        let stiff = (c.b / c.a).powi(3);
        let x = unit * yarn / 0.635e-3 / stiff;
        stiff * c.a * x * x * (1.0 / 6.0 - x * (4.0 / 27.0 - x * (7.0 / 54.0 - x * (28.0 / 243.0))))
    });
    let expected = 200.0 * (unit * (unit * 2.0 * yarn + pressed) + touched);
    let found = model.ply_type(0).rounding();
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
}

#[test]
fn shock_viscosity_grows_up_to_elements_of_one_crossover() {
    let length = |set: &str| {
        let case = case::shipped(&["/expect=[]", set]);
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        model.ply_type(0).element.viscous_length
    };
    for (set, expected) in [
        ("/pack/elements_per_crossover=4", 4.0),
        ("/pack/elements_per_crossover=8", 8.0),
        ("/pack/crossovers_per_element=2", 1.0),
    ] {
        assert!(length(set).iter().all(|got| (got / expected - 1.0).abs() < 1e-12), "{set}: {:?}", length(set));
    }
}
