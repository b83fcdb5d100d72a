#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use super::*;
use crate::case;

/// Places are counted from the hit, or from the mirror planes through it.
#[test]
fn the_device_counts_places_from_the_middle_of_the_finest_elements() {
    let origin = |sets: &[&str], part: bool| {
        let case = case::shipped(sets);
        let model = if part { Model::<f32>::part(&case) } else { Model::<f32>::new(&case) };
        let model = model.unwrap();
        (device_origin(&model), model.ply_type(0).mesh.length, model.projectile.clone().unwrap().position)
    };
    let far = "/projectile/offset_mm=[20.1,-12.3]";
    let turned = [90, 30].map(|angle| format!(r#"/pack/layup=[{{"orientation_deg":{angle}}}]"#));
    for sets in [&[far][..], &[far, &turned[0]], &[far, &turned[1]]] {
        let (from, length, hit) = origin(sets, false);
        assert!((from.x - hit.x).hypot(from.y - hit.y) < length[0].hypot(length[1]), "{sets:?}: {from} {hit}");
        assert!(from.x > 0.019 && from.y < -0.011 && from.z == 0.0);
    }
    // A quarter, and a half whose hit lies off the other axis.
    assert_eq!(origin(&[], true).0, Vector3::zeros());
    let (half, ..) = origin(&["/projectile/offset_mm=[0,15]"], true);
    assert!(half.x == 0.0 && half.y > 0.014, "{half}");
    assert_eq!(origin(&[far, "/solver/numerics=paper"], false).0, Vector3::zeros());
}

/// Lines of nodes at the hit are told to a fraction of what they would round to from the centre.
#[test]
fn lines_at_the_hit_keep_their_digits() {
    let model = Model::<f32>::new(&case::shipped(&["/projectile/offset_mm=[30.1,0.2]"])).unwrap();
    let (from, ply_type) = (device_origin(&model), model.ply_type(0));
    let mesh = &ply_type.mesh;
    let near = (0..=mesh.columns).filter(|line| (mesh.reference(0, *line)[0] - from.x).abs() < 2e-3);
    let mut seen = 0;
    for at in near {
        let told = f64::from(f32::from_bits(super::super::line(ply_type, &from, 0, at).words()[0]));
        let off = (told + from.x - mesh.reference(0, at)[0]).abs();
        assert!(off < 1.3e-10, "{off} m");
        seen += 1;
    }
    assert!(seen > 8, "{seen}");
}
