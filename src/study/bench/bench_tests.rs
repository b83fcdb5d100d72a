use super::*;
use crate::case;

fn paper(changes: &[String]) -> Result<Case, CaseError> {
    case::from_str("s720-1ply-155", include_str!("../../../cases/s720-1ply-155.json"), changes)
}

#[test]
fn every_configuration_has_its_name_and_none_is_the_default_again() -> Result<(), CaseError> {
    let changes = ["/expect=[]", "/solver/courant=0.8", "/pack/crossovers_per_element=2"].map(str::to_owned);
    let all = configurations(&paper(&changes)?, true);
    let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
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
    for one in all {
        paper(&[&changes[..], &one.sets].concat())?;
    }
    Ok(())
}

#[test]
fn a_mesh_must_divide_the_crossovers() -> Result<(), CaseError> {
    let size =
        ["/expect=[]", "/pack/width_mm=17.8", "/pack/height_mm=20.3", "/solver/numerics=paper"].map(str::to_owned);
    let mesh = |mesh: u32| paper(&[&size[..], &[format!("/pack/crossovers_per_element={mesh}")]].concat());
    let base = mesh(1)?;
    assert_eq!((base.pack.columns, base.pack.rows), (14, 16));
    assert_eq!(covers_the_same(&base, &mesh(2)?), Ok(()));
    assert_eq!(covers_the_same(&base, &mesh(4)?), Err("14 crossovers along the warp do not divide by 4".to_owned()));
    Ok(())
}
