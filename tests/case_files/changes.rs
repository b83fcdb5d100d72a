//! `--set`: changes to a case from the command line.

use super::*;

#[test]
fn replace_and_create_values() {
    assert_eq!(set("/projectile/velocity_m_s=200").unwrap().projectile.unwrap().velocity, 200.0);
    assert_eq!(set("/solver/symmetry=auto").unwrap().solver.symmetry, case::Symmetry::Auto);
    assert_eq!(set("/solver/symmetry=\"auto\"").unwrap().solver.symmetry, case::Symmetry::Auto);
    assert_eq!(set("/projectile/offset_mm/1=5").unwrap().projectile.unwrap().offset, [1e-3, 5e-3]);
    assert_eq!(set("/expect/1/value=10").unwrap().expect[1].bound, Bound::Value { value: 10.0, tolerance: 1.0 });
    assert!(set("/projectile=null").unwrap().projectile.is_none());
    let text = without("/output").to_string();
    let change = |change: &str| case::from_str("case.json", &text, &[change.to_owned()]);
    assert_eq!(change("/output/frames=7").unwrap().output.frames, 7);
    assert_eq!(change("/fabric/file=fabrics/s-728.json").unwrap().fabric.name, "S-728");
    let both = ["/fabric/warp/crimp=0.03".to_owned(), "/fabric={\"file\": \"fabrics/s-728.json\"}".to_owned()];
    let case = case::from_str("case.json", &text, &both).unwrap();
    assert_eq!((case.fabric.name.as_str(), case.fabric.warp.crimp), ("S-728", 0.03));
    let text = without("/pack/initial_velocity_m_s").to_string();
    let case = case::from_str("case.json", &text, &["/pack/initial_velocity_m_s/2=4".to_owned()]).unwrap();
    assert_eq!(case.pack.initial_velocity, [0.0, 0.0, 4.0]);
}

#[test]
fn take_the_place_of_the_source() {
    let change = |change: &str| case::read(Path::new("cases/s720-1ply-155.json"), &[change.to_owned()]).unwrap();
    let field = |case: &Case, pointer: &str| case.fields.iter().find(|f| f.pointer == pointer).unwrap().clone();
    let case = change("/projectile/mass_g=4");
    assert_eq!(field(&case, "/projectile/mass_g").source, "--set");
    assert!(!field(&case, "/projectile/mass_g").assumed);
    let case = change("/fabric/shear/g1_mpa=4");
    assert!(field(&case, "/fabric/shear/g1_mpa").assumed, "an assumed value stays one when it is varied");
    assert_eq!(field(&case, "/fabric/shear/g2_mpa").source, "assumed: not published");
}

#[test]
fn are_refused_like_the_file() {
    for (change, location, words) in [
        ("/projectile/mass_gg=1", "--set /projectile/mass_gg", "\"mass_g\""),
        ("/projectile/velocity_m_s=fast", "--set /projectile/velocity_m_s", "\"fast\""),
        ("/projectile/velocity_m_s=NaN", "--set /projectile/velocity_m_s", "\"NaN\""),
        ("/projectile/velocity_m_s=1e999", "--set /projectile/velocity_m_s", "1e999"),
        ("/projectile/velocity_m_s=", "--set /projectile/velocity_m_s", "value"),
        ("/projectile={\"shape\":", "--set /projectile", "end of the text"),
        ("/projectile={\"shape\":1,\"shape\":2}", "--set /projectile", "duplicate"),
        ("/projectile/mass_g/x=1", "--set /projectile/mass_g", "object or a list"),
        ("/projectle/mass_g=1", "--set /projectle", "/projectile"),
        ("/projectile/offset_mm/2=1", "--set /projectile/offset_mm/2", "from 0 to 1"),
        ("/pack/edges=square", "--set /pack/edges", "clamped"),
        ("/fabric/shear/gamma1=1", "--set /fabric/shear/gamma1", "gamma2"),
        ("projectile=1", "--set projectile=1", "/json/pointer=value"),
        ("/projectile", "--set /projectile", "no ="),
        ("/=1", "--set /=1", "/json/pointer=value"),
        ("=1", "--set =1", "/json/pointer=value"),
        ("", "--set ", "/json/pointer=value"),
    ] {
        refused(set(change), location, words);
    }
    let word = with("/pack/edges", json!("free")).to_string();
    let inside = case::from_str("case.json", &word, &["/pack/edges/left=free".to_owned()]);
    refused(inside, "--set /pack/edges", "as a whole");
}
