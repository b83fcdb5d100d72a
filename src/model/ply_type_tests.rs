use crate::case;
use crate::model::Model;

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
