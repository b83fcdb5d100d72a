use super::*;
use crate::case::CaseError;
use crate::study::bench::CaseSource;

#[test]
fn every_choice_has_its_name_and_none_is_the_default_again() -> Result<(), CaseError> {
    let subject = CaseSource::paper(&["/solver/courant=0.8".to_owned(), "/pack/crossovers_per_element=2".to_owned()]);
    let case = subject.case(&[])?;
    let names: Vec<String> = choices(&case, true).into_iter().map(|choice| choice.name).collect();
    let expected = [
        "default: f64, Courant 0.8, mesh 2",
        "f32",
        "Courant 0.95",
        "Courant 0.9",
        "Courant 0.5",
        "mesh 1",
        "mesh 4",
        "graded",
        "no symmetry",
        "no skip",
        "f32, Courant 0.95",
        "f32, graded",
        "gpu f32",
    ];
    assert_eq!(names, expected);
    for choice in choices(&case, true) {
        subject.case(&choice.sets)?;
    }
    Ok(())
}

#[test]
fn a_mesh_must_divide_the_crossovers() -> Result<(), CaseError> {
    let sets = ["/pack/width_mm=17.8", "/pack/height_mm=20.3", "/solver/numerics=paper"].map(str::to_owned);
    let case = CaseSource::paper(&sets).case(&[])?;
    assert_eq!((case.pack.columns, case.pack.rows), (14, 16));
    let mesh = |mesh: u32| fits(&case, &Configuration::default_of(&case).mesh(mesh));
    assert_eq!(mesh(2), Ok(()));
    assert_eq!(mesh(4), Err("14 crossovers along the warp do not divide by 4".to_owned()));
    Ok(())
}
