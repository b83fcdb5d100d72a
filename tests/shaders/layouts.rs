//! Structs of the shaders, field by field as the host declares them, and the values that the host puts into them.

use std::collections::{BTreeMap, BTreeSet};

use naga::{Module, ScalarKind, TypeInner};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use ripstop::gpu::layout::{self, Field};
use ripstop::model::Model;
use ripstop::run::Skips;
use wgpu::naga;

use super::modules;
use crate::support::builtin;

/// Members and size [bytes] of a struct, if the module has it.
fn members<'a>(module: &'a Module, name: &str) -> Option<(&'a [naga::StructMember], u32)> {
    let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name))?;
    match &found.inner {
        TypeInner::Struct { members, span } => Some((members, *span)),
        other => panic!("{name}: {other:?}"),
    }
}

/// Kind and number of the scalars in a type without holes.
fn scalars(module: &Module, ty: naga::Handle<naga::Type>) -> (ScalarKind, usize) {
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) => (scalar.kind, 1),
        TypeInner::Vector { size, scalar } => (scalar.kind, size as usize),
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), stride } => {
            let (kind, each) = scalars(module, base);
            assert_eq!(stride as usize, 4 * each);
            (kind, each * count.get() as usize)
        }
        ref other => panic!("{other:?}"),
    }
}

/// Names that one field of the host may have in the shaders: its own, or one for each number of a short list.
fn names(field: &Field) -> Vec<Vec<String>> {
    let words = field.size / 4;
    let lists: [&[&str]; 3] = [&["_x", "_y", "_z"], &["_warp", "_weft"], &["0", "1", "2"]];
    let of = |list: &&[&str]| list.iter().take(words).map(|end| format!("{}{end}", field.name)).collect::<Vec<_>>();
    let mut names: Vec<Vec<String>> = lists.iter().map(of).filter(|names| names.len() == words).collect();
    names.push(vec![field.name.to_owned(); words]);
    names
}

#[test]
fn every_struct_is_laid_out_as_the_host_declares_it() {
    let mut seen = BTreeSet::new();
    for (kernel, module) in modules() {
        for (name, fields, size) in layout::LAYOUTS {
            let Some((members, span)) = members(&module, name) else { continue };
            seen.insert(name);
            assert_eq!(span as usize, size, "{kernel}: size of {name}");
            let mut words = vec![None; size / 4];
            for member in members {
                let (kind, count) = scalars(&module, member.ty);
                let first = member.offset as usize / 4;
                words[first..first + count].fill(Some((member.name.clone().unwrap_or_default(), kind)));
            }
            let mut next = 0;
            for field in fields {
                assert_eq!(field.offset, next, "{kernel}: {name}.{}", field.name);
                next += field.size;
                let own = words[field.offset / 4..next / 4].iter().cloned().map(|word| word.expect("a hole"));
                let (found, kinds): (Vec<String>, Vec<ScalarKind>) = own.unzip();
                assert!(names(field).contains(&found), "{kernel}: {name}.{} is {found:?}", field.name);
                let kind = match field.kind.trim_start_matches('[').split(';').next() {
                    Some("f32") => ScalarKind::Float,
                    Some("i32") => ScalarKind::Sint,
                    Some("u32") => ScalarKind::Uint,
                    other => panic!("{other:?}"),
                };
                assert!(kinds.iter().all(|found| *found == kind), "{kernel}: {name}.{} is {kinds:?}", field.name);
            }
            assert_eq!(next, size, "{kernel}: {name}");
        }
    }
    assert_eq!(seen.len(), layout::LAYOUTS.len(), "{seen:?}");
}

#[test]
fn lists_have_the_sizes_that_the_host_reckons_with() {
    let sums =
        BTreeMap::from([("projectile_search", 27), ("projectile_contact", 27), ("energy_balance", layout::sum::SUMS)]);
    let words = [("Contact", layout::CONTACT_WORDS), ("Point", layout::POINT_WORDS)];
    let mut checked = 0;
    for (kernel, module) in modules() {
        let list = |name: &str| module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some(name));
        let count = |name: &str| {
            list(name).map(|(_, variable)| match module.types[variable.ty].inner {
                TypeInner::Array { size: naga::ArraySize::Constant(count), .. } => count.get() as usize,
                ref other => panic!("{name}: {other:?}"),
            })
        };
        assert_eq!(count("shots"), Some(layout::SHOTS as usize), "{kernel}");
        // One row of invocations is one longer than their number, so that no two meet in a bank.
        let rows = sums.get(kernel).map(|sums| sums * (layout::GROUP as usize + 1));
        let found = list("sums").map(|(_, variable)| scalars(&module, variable.ty).1);
        assert_eq!(found, rows, "{kernel}");
        // The search among plies has a `Touch` of its own.
        let touch = kernel.starts_with("projectile").then_some(("Touch", layout::TOUCH_WORDS));
        for (name, words) in words.into_iter().chain(touch) {
            if let Some((_, span)) = members(&module, name) {
                assert_eq!(u64::from(span), 4 * words, "{kernel}: {name}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 7);
}

/// Coordinates begin at the hit, or at the mirror planes through it, so that lines there keep their digits.
#[test]
fn the_origin_of_a_graded_mesh_is_the_middle_of_its_finest_elements() {
    let model = |sets: &[&str], skips: Skips| {
        let case = crate::support::shipped("cases/s720-1ply-155.json", sets);
        if skips.symmetry { Model::<f32>::part(&case) } else { Model::<f32>::new(&case) }.unwrap()
    };
    let far = "/projectile/offset_mm=[20.1,-12.3]";
    let turned = [90, 30].map(|angle| format!(r#"/pack/layup=[{{"orientation_deg":{angle}}}]"#));
    for sets in [&[far][..], &[far, &turned[0]], &[far, &turned[1]]] {
        let model = model(sets, Skips::WHOLE);
        let (from, hit) = (layout::device_origin(&model), model.projectile.as_ref().unwrap().position);
        let mesh = &model.ply_type(0).mesh;
        assert!((from - hit).xy().norm() < mesh.length[0].hypot(mesh.length[1]), "{sets:?}: {from} {hit}");
        assert!(from.x > 0.019 && from.y < -0.011 && from.z == 0.0);
        let near = (0..=mesh.columns).filter(|line| {
            let place = mesh.reference(0, *line)[0] - mesh.to_ply(from.into())[0];
            let off = (f64::from(layout::line(model.ply_type(0), &from, 0, *line).place) - place).abs();
            assert!(off < 1.3e-10 || place.abs() > 2e-3, "{off} m");
            place.abs() < 2e-3
        });
        assert!(near.count() > 8);
    }
    assert_eq!(layout::device_origin(&model(&[], Skips::default())), Vector3::zeros());
    let half = layout::device_origin(&model(&["/projectile/offset_mm=[0,15]"], Skips::default()));
    assert!(half.x == 0.0 && half.y > 0.014, "{half}");
    let even = model(&[far, "/solver/numerics=paper"], Skips::WHOLE);
    assert_eq!(layout::device_origin(&even), Vector3::zeros());
}

/// A projectile of whose numbers no two are equal.
#[test]
fn the_projectile_comes_back_as_it_was_sent() {
    let start = Model::<f32>::new(&builtin("cases/s720-1ply-155.json", &[])).unwrap().projectile.unwrap();
    let mut body = start.clone();
    body.position = Vector3::new(1.25, -0.314_159, 1e3);
    body.velocity = start.velocity + Vector3::new(1.0, 2.0, -4.0);
    body.orientation = UnitQuaternion::new_normalize(Quaternion::new(0.1, 0.2, -0.3, 0.4));
    body.angular_momentum = Vector3::new(1e-5, 2e-5, 3e-5);
    body.locked = false;
    let from = Vector3::new(0.5, -0.25, 0.0);
    let mut sent = layout::body(&body, &start.velocity, &from);
    assert!((0..3).all(|a| (0..1 << 24).contains(&sent.fine[a]) && (0..1 << 24).contains(&sent.nose_fine[a])));
    let place = |coarse: [i32; 4], fine: [i32; 4]| {
        Vector3::from([0, 1, 2].map(|a| f64::from(coarse[a]) / 1024.0 + f64::from(fine[a]) / layout::FIXED_POINT_SCALE))
    };
    let profile = &body.body.profile;
    let nose = profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius;
    let tip = body.position - from + body.orientation.transform_vector(&Vector3::new(0.0, 0.0, nose));
    assert!((place(sent.nose_coarse, sent.nose_fine) - tip).amax() <= 1.0 / layout::FIXED_POINT_SCALE);
    assert!((f64::from(sent.velocity[3]) / body.speed_bound() - 1.0).abs() < 1e-6);
    let turning = Vector3::from([0, 1, 2].map(|a| f64::from(sent.turning[a])));
    assert!((turning - body.angular_velocity()).norm() < 1e-6 * turning.norm());
    (sent.impulse, sent.support, sent.energy) = ([0.0, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0], [8.0, 9.0, 10.0, 11.0]);
    sent.change_before[0] = 9.0;
    sent.coarse_before[0] = 0;
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytemuck::bytes_of(&sent));
    let record = layout::read_body(&words, &start, &from);
    assert_eq!((record.impulse, record.support), ([0.0, 1.0, 2.0], [4.0, 5.0, 6.0]));
    assert_eq!((record.energy, record.penetration), ([8.0, 9.0, 10.0], 11.0));
    assert!((record.body.velocity - body.velocity).norm() < 1e-5);
    assert!((record.body.angular_momentum - body.angular_momentum).norm() < 1e-11);
    assert!((record.body.position - body.position).amax() <= 0.5 / layout::FIXED_POINT_SCALE);
    assert!(record.body.orientation.angle_to(&body.orientation) < 1e-6);
    assert_eq!(record.before.0.x, start.velocity.x + 9.0);
    assert!((record.before.1.x - from.x).abs() < 0.001 && record.before.1.z == record.body.position.z);
}
