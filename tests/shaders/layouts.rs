//! Structs of the shaders, word by word as the host fills and reads them.

use std::collections::BTreeMap;

use naga::{Module, Scalar, ScalarKind, TypeInner};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use ripstop::case::Case;
use ripstop::gpu::buffers;
use ripstop::gpu::layout::{self, StepInfo};
use ripstop::kernels::projectile_shape;
use ripstop::kernels::rigid_body::RigidBody;
use ripstop::model::Model;
use wgpu::naga;

use super::{cases, graded, modules};
use crate::scene::builtin;

/// A word of a struct: its member and what it holds.
#[derive(Clone, Debug, PartialEq)]
struct Word {
    member: String,
    kind: ScalarKind,
}

/// The struct of that name word by word; words between members are `None`.
fn words(module: &Module, name: &str) -> Vec<Option<Word>> {
    let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: TypeInner::Struct { members, span }, .. })) = found else {
        panic!("no struct {name}")
    };
    let mut words = vec![None; *span as usize / 4];
    for member in members {
        let (scalar, count) = scalars(module, member.ty);
        assert_eq!(scalar.width, 4, "{name}");
        let first = member.offset as usize / 4;
        let name = member.name.clone().unwrap_or_default();
        words[first..first + count].fill(Some(Word { member: name, kind: scalar.kind }));
    }
    words
}

fn member_start(members: &[naga::StructMember], name: &str) -> usize {
    members.iter().find(|m| m.name.as_deref() == Some(name)).map_or(0, |m| m.offset as usize / 4)
}

/// Scalar and number of words of a type without holes.
fn scalars(module: &Module, ty: naga::Handle<naga::Type>) -> (Scalar, usize) {
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) => (scalar, 1),
        TypeInner::Vector { size, scalar } => (scalar, size as usize),
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), stride } => {
            let (scalar, each) = scalars(module, base);
            assert_eq!(stride as usize, 4 * each);
            (scalar, each * count.get() as usize)
        }
        ref other => panic!("{other:?}"),
    }
}

/// Whether a word can be a number of that kind: counts are small, and small integers are tiny as floats.
fn plausible(kind: ScalarKind, word: u32) -> bool {
    let number = f32::from_bits(word);
    match kind {
        ScalarKind::Float => number == 0.0 || (number.is_normal() && (1e-30..1e31).contains(&number.abs())),
        _ => word < 1 << 20,
    }
}

fn assert_block(name: &str, blocks: &[layout::Block]) {
    for (kernel, module) in modules() {
        let struct_words = words(&module, name);
        let mut filled = vec![false; struct_words.len()];
        for block in blocks {
            let names: Vec<_> = block.names().collect();
            let values = block.words();
            assert_eq!(names.len(), struct_words.len(), "{kernel}: size of {name}");
            for (at, (word, value)) in struct_words.iter().zip(values).enumerate() {
                let word = word.as_ref().unwrap_or_else(|| panic!("{kernel}: a hole in {name} at word {at}"));
                assert_eq!(word.member, names[at], "{kernel}: {name}, word {at}");
                assert!(
                    plausible(word.kind, value),
                    "{kernel}: {name}.{} as {:?} is {value:#x}",
                    word.member,
                    word.kind
                );
                filled[at] |= value != 0 || word.member.starts_with("pad") || word.member == "profile";
            }
        }
        for (word, filled) in struct_words.iter().flatten().zip(filled) {
            assert!(filled, "no scene tells what kind of number {name}.{} is", word.member);
        }
    }
}

#[test]
fn the_scene_is_laid_out_as_the_host_fills_it() {
    let block = |case: &Case| {
        let model = Model::<f32>::part(case).unwrap();
        let sizes = buffers::Sizes::new(&model);
        let last = model.ply_types.len() - 1;
        layout::scene(&model, last, &sizes)
    };
    assert_block("Scene", &cases().iter().map(block).collect::<Vec<_>>());
}

#[test]
fn a_shot_is_laid_out_as_the_host_fills_it() {
    let shot = |case: &Case| layout::shot(&Model::<f32>::part(case).unwrap(), 3);
    let all: Vec<_> = cases().iter().map(shot).collect();
    assert_block("Shot", &all);
    assert_eq!(all[0].words().len() as u64, layout::SHOT_WORDS);
    for (kernel, module) in modules() {
        let shots = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("shots"));
        let Some(TypeInner::Array { size: naga::ArraySize::Constant(count), .. }) =
            shots.map(|(_, variable)| &module.types[variable.ty].inner)
        else {
            panic!("{kernel}: no shots")
        };
        assert_eq!(u64::from(count.get()), layout::SHOTS, "{kernel}");
    }
}

#[test]
fn the_plies_are_laid_out_as_the_host_fills_them() {
    let plies = |case: &Case| layout::plies(&Model::<f32>::new(case).unwrap());
    let all: Vec<_> = cases().iter().flat_map(plies).collect();
    assert_block("Ply", &all);
    assert_eq!(all[0].words().len(), layout::PLY_WORDS);
}

#[test]
fn the_grid_lines_are_laid_out_as_the_host_fills_them() {
    let model = Model::<f32>::part(&graded()).unwrap();
    let second = &model.ply_types[1];
    let from = layout::device_origin(&model);
    assert_block("Line", &[layout::line(second, &from, 0, 3), layout::line(second, &from, 1, 4)]);
    assert_eq!(layout::line(second, &from, 0, 3).words().len(), layout::LINE_WORDS);
    assert_eq!(layout::LINE_WORDS, 4 * layout::LINE_TEXELS);
    // By ply type, by axis; `line_at` finds them in a texture.
    let words = layout::lines(&model);
    let all: Vec<_> = words.chunks_exact(layout::LINE_WORDS).collect();
    assert!(all.len().is_multiple_of(layout::LINES_ACROSS));
    let room = model.grid.columns.max(model.grid.rows) + 2;
    let number = |word: u32| f64::from(f32::from_bits(word));
    for (at, ply_type) in model.ply_types.iter().enumerate() {
        for (axis, elements) in [ply_type.mesh.columns, ply_type.mesh.rows].into_iter().enumerate() {
            let lines = &all[(2 * at + axis) * room..];
            let mass: f64 = lines[..=elements].iter().map(|line| number(line[3])).sum();
            let widths: f64 = lines[..elements].iter().map(|line| number(line[1])).sum();
            let [first, last] = [0, elements].map(|line| number(lines[line][0]));
            let extent = ply_type.mesh.extent()[axis];
            assert!((mass / extent - 1.0).abs() < 1e-6 && (widths / extent - 1.0).abs() < 1e-6, "{mass} {widths}");
            assert!(((last - first) / (extent * ply_type.mesh.length[axis]) - 1.0).abs() < 1e-6);
            assert!(lines[..elements + 2].windows(2).all(|pair| number(pair[0][0]) < number(pair[1][0])));
            assert_eq!(lines[elements - 1][1], lines[elements][1], "what follows is as wide as the last element");
        }
    }
    let even = Model::<f32>::new(&builtin("cases/s720-1ply-155.json", &[])).unwrap();
    assert_eq!(layout::lines(&even).len(), layout::LINE_WORDS, "a line that nobody reads");
}

#[test]
fn the_step_is_laid_out_as_the_host_fills_it() {
    let info = StepInfo { index: 7, slot: Some(3), since: 5, dt: 1e-7 };
    assert_block("Step", &[layout::step(&info)]);
    let kicks = |info: &StepInfo| layout::step(info).words()[3..5].to_vec();
    let bits = |numbers: [f32; 2]| numbers.map(f32::to_bits).to_vec();
    assert_eq!(kicks(&info), bits([1e-7, 1e-7]));
    assert_eq!(kicks(&StepInfo { index: 0, ..info }), bits([0.5e-7, 0.0]), "velocities start half a step early");
}

#[test]
fn events_and_points_have_the_size_the_host_reads() {
    for (kernel, module) in modules() {
        let has = |name: &str| module.types.iter().any(|(_, t)| t.name.as_deref() == Some(name));
        let members = |name| words(&module, name).into_iter().map(|w| w.map_or(String::new(), |w| w.member));
        assert_eq!(has("Event"), kernel == "element_force");
        let of_contact = ["projectile_points", "projectile_contact"].contains(&kernel);
        assert_eq!(has("Point"), of_contact);
        assert_eq!(has("Touch"), of_contact || kernel == "ply_search");
        assert_eq!(has("Contact"), kernel == "ply_search" || kernel == "ply_impulse");
        if has("Contact") {
            assert_eq!(members("Contact").count() as u64, layout::CONTACT_WORDS);
        }
        if has("Event") {
            assert_eq!(members("Event").collect::<Vec<_>>(), ["step", "element", "yarn", "strain"]);
            assert_eq!(layout::EVENT_WORDS, 4);
        }
        if has("Point") {
            assert_eq!(members("Point").count() as u64, layout::POINT_WORDS);
        }
        if of_contact {
            assert_eq!(members("Touch").count() as u64, layout::TOUCH_WORDS);
        }
    }
}

/// A projectile of whose numbers no two are equal.
fn odd_body() -> (RigidBody, RigidBody) {
    let start = Model::<f32>::new(&builtin("cases/s720-1ply-155.json", &[])).unwrap().projectile.unwrap();
    let mut body = start.clone();
    body.position = Vector3::new(1.25, -2.5, 3.75);
    body.velocity = start.velocity + Vector3::new(1.0, 2.0, -4.0);
    body.orientation = UnitQuaternion::new_normalize(Quaternion::new(0.1, 0.2, -0.3, 0.4));
    body.angular_momentum = Vector3::new(1e-5, 2e-5, 3e-5);
    body.locked = false;
    (start, body)
}

#[test]
fn the_projectile_is_laid_out_as_the_host_reads_and_writes_it() {
    let (start, body) = odd_body();
    let from = Vector3::new(0.5, -0.25, 0.0);
    let profile = &body.body.profile;
    let nose = profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius;
    let mut filled = layout::body(&body, &start.velocity, &from);
    for (_, module) in modules() {
        let Some(first) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some("Body")) else { continue };
        let TypeInner::Struct { members, span } = &first.1.inner else { panic!("Body is a struct") };
        assert_eq!(*span as usize, 4 * layout::BODY_WORDS);
        let at = |name: &str| member_start(members, name);
        assert!(members.iter().all(|m| m.offset % 16 == 0));
        let vector = |name: &str, words: &[u32]| Vector3::from([0, 1, 2].map(|a| f32::from_bits(words[at(name) + a])));
        let close = |got: Vector3<f32>, expected: Vector3<f64>| (got.cast::<f64>() - expected).norm() < 1e-6;
        assert!(close(vector("change", &filled), Vector3::new(1.0, 2.0, -4.0)));
        assert!(close(vector("change_before", &filled), Vector3::new(1.0, 2.0, -4.0)));
        assert!(close(vector("orientation", &filled), body.orientation.imag()));
        assert!(close(vector("angular_momentum", &filled) * 1e5, body.angular_momentum * 1e5));
        assert!(close(vector("velocity", &filled), body.velocity));
        let turning = body.angular_velocity();
        assert!(close(vector("turning", &filled) / turning.norm() as f32, turning.normalize()));
        assert!((f64::from(f32::from_bits(filled[at("velocity") + 3])) / body.speed_bound() - 1.0).abs() < 1e-6);
        for (coarse, fine) in [("coarse", "fine"), ("coarse_before", "fine_before")] {
            let place = [0, 1, 2].map(|a| {
                let [large, small] = [at(coarse), at(fine)].map(|at| f64::from(filled[at + a] as i32));
                large / 1024.0 + small / layout::FIXED_POINT_SCALE
            });
            assert_eq!(Vector3::from(place) + from, body.position);
        }
        let tip = body.position - from + body.orientation.transform_vector(&Vector3::new(0.0, 0.0, nose));
        for a in 0..3 {
            let [large, small] = [at("nose_coarse"), at("nose_fine")].map(|at| f64::from(filled[at + a] as i32));
            assert!(
                (large / 1024.0 + small / layout::FIXED_POINT_SCALE - tip[a]).abs() <= 1.0 / layout::FIXED_POINT_SCALE
            );
        }
        // And back.
        for (n, name) in ["impulse", "support", "energy"].into_iter().enumerate() {
            for a in 0..4 {
                filled[at(name) + a] = ((10 * n + a) as f32).to_bits();
            }
        }
        filled[at("change_before")] = 9.0_f32.to_bits();
        filled[at("coarse_before")] = 0;
        let record = layout::read_body(&filled, &start, &from);
        assert_eq!(record.impulse, [0.0, 1.0, 2.0]);
        assert_eq!(record.support, [10.0, 11.0, 12.0]);
        assert_eq!((record.energy, record.penetration), ([20.0, 21.0, 22.0], 23.0));
        assert!((record.body.velocity - body.velocity).norm() < 1e-5);
        assert_eq!(record.body.position, body.position);
        assert!(record.body.orientation.angle_to(&body.orientation) < 1e-6);
        assert_eq!(record.before.0.x, start.velocity.x + 9.0);
        assert!((record.before.1.x - from.x).abs() < 0.001 && record.before.1.y == -2.5);
        filled = layout::body(&body, &start.velocity, &from);
    }
}

#[test]
fn arrays_in_workgroups_have_room_for_their_sums() {
    let contact = ["projectile_points", "projectile_contact"].map(|kernel| (kernel, 27));
    let expected: BTreeMap<_, _> = contact.into_iter().chain([("energy_balance", layout::SUMS)]).collect();
    for (kernel, module) in modules() {
        let sums = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("sums"));
        let Some((_, variable)) = sums else { continue };
        let count = expected[kernel];
        // One row of invocations is one longer than their number, so that no two meet in a bank.
        assert_eq!(scalars(&module, variable.ty).1, count * (layout::GROUP as usize + 1), "{kernel}");
    }
    let profile = words(&modules()[0].1, "Scene").iter().flatten().filter(|w| w.member == "profile").count();
    assert_eq!(profile, 4 * projectile_shape::CORNERS);
}
