//! The shaders against their Rust twins, without a graphics adapter: what both sides of the fence have written down.
//!
//! Goes red when a kernel no longer compiles, binds other buffers than the host gives it, lays a struct out in another
//! way than the host fills it, or has another value of a shared constant.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use naga::{AddressSpace, Module, Scalar, ScalarKind, StorageAccess, TypeInner};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use ripstop::case::Case;
use ripstop::gpu::layout::{self, StepInfo};
use ripstop::gpu::shader::{self, Access, KERNELS, Kernel};
use ripstop::gpu::stepper::DeviceStepper;
use ripstop::gpu::{Device, buffers};
use ripstop::kernels::rigid_body::RigidBody;
use ripstop::kernels::{
    arc_length, coupled_newton, crossover, element_force, law_energy, ply_contact, predictor, projectile_chisel,
    projectile_contact, projectile_rim, projectile_shape, shear, yarn_law,
};
use ripstop::model::{Model, over};
use wgpu::naga;

use crate::scene::builtin;
use crate::support::patch;

fn parse(kernel: &Kernel) -> Module {
    let source = kernel.source();
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)))
}

fn modules() -> Vec<(&'static str, Module)> {
    KERNELS.iter().map(|kernel| (kernel.name, parse(kernel))).collect()
}

/// Scenes that between them fill every word of the uniforms.
fn cases() -> Vec<Case> {
    let mut patch = patch::case(3, 2);
    patch.pack.edges.left = ripstop::case::Edge::Clamped;
    patch.pack.edges.right = ripstop::case::Edge::Roller;
    patch.pack.edges.bottom = ripstop::case::Edge::Roller;
    patch.pack.edges.top = ripstop::case::Edge::Clamped;
    patch.fabric.crossover.gap = 1e-5;
    let shot = |sets: &[&str]| builtin("cases/s720-1ply-155.json", sets);
    let bar = shot(&["/projectile/friction=0.2", "/projectile/motion=prescribed"]);
    let mut moving = bar.clone();
    if let Some(p) = &mut moving.projectile {
        p.obliquity = 0.3;
        p.azimuth = 0.4;
        p.shape = ripstop::case::Shape::Bar { diameter: 5e-3, along: ripstop::case::Along::Warp };
        p.edge_radius = 0.0;
    }
    let nose = |shape: &str| {
        let set = format!(
            "/projectile={{\"shape\":\"{shape}\",\"diameter_mm\":6,\"length_mm\":12,\"mass_g\":2,\"velocity_m_s\":150}}"
        );
        shot(&[&set])
    };
    let layup = r#"/pack/layup=[{"plies":2},{"plies":2,"orientation_deg":30,"edges":"free"}]"#;
    let rim = shot(&["/solver/contact_sampling=edges"]);
    let pack = shot(&[layup, "/pack/plies=4"]);
    vec![patch, bar, moving, pack, nose("ogive"), nose("fragment"), rim, graded()]
}

/// Turned plies, longer along one side.
fn graded() -> Case {
    let layup = r#"/pack/layup=[{},{"orientation_deg":30}]"#;
    builtin(
        "cases/s720-1ply-155.json",
        &[
            "/pack/plies=2",
            layup,
            "/pack/width_mm=150",
            "/pack/mesh_grading=graded",
            "/solver/shock_viscosity=0.3",
            "/solver/failure_length_mm=2",
        ],
    )
}

#[test]
fn every_kernel_compiles_within_what_every_device_offers() {
    for (name, module) in modules() {
        let (flags, capabilities) = (naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        let checked = naga::valid::Validator::new(flags, capabilities).validate(&module);
        checked.unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string("")));
    }
}

#[test]
fn entry_points_have_the_names_and_sizes_the_host_dispatches() {
    for (name, module) in modules() {
        let [entry] = &module.entry_points[..] else { panic!("{name}: one entry point is expected") };
        assert_eq!(entry.name, name);
        assert_eq!(entry.workgroup_size, [layout::GROUP, 1, 1], "{name}");
    }
}

#[test]
fn bindings_are_those_the_host_makes() {
    for kernel in &KERNELS {
        let module = parse(kernel);
        let mut found = BTreeMap::new();
        for (_, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let access = match variable.space {
                AddressSpace::Uniform | AddressSpace::Handle => None,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Some(Access::Write),
                AddressSpace::Storage { .. } => Some(Access::Read),
                space => panic!("{}: {space:?}", kernel.name),
            };
            found.insert((binding.group, binding.binding), (variable.name.clone().unwrap_or_default(), access));
        }
        let own = kernel
            .bindings
            .iter()
            .zip(0..)
            .map(|((name, access), at)| ((1, at), (name.variable().to_owned(), Some(*access))));
        let names: &[&str] = match kernel.name {
            "element_force" => &["scene", "step", "plies", "grid_lines", "law"],
            _ => &["scene", "step", "plies", "grid_lines"],
        };
        let common = names.iter().zip(0..).chain([(&"shots", 5)]);
        let common = common.map(|(name, at)| ((0, at), ((*name).to_owned(), None)));
        assert_eq!(found, common.chain(own).collect(), "{}", kernel.name);
        assert!(kernel.bindings.len() <= 8, "{}: WebGPU promises eight storage buffers", kernel.name);
    }
}

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
    assert_block("Line", &[layout::line(second, 0, 3), layout::line(second, 1, 4)]);
    assert_eq!(layout::line(second, 0, 3).words().len(), layout::LINE_WORDS);
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
        let of_rim = ["projectile_points", "projectile_rim"].contains(&kernel);
        assert_eq!(has("Point"), of_rim || kernel == "projectile_contact");
        assert_eq!(has("Touch"), of_rim || kernel == "ply_search");
        assert_eq!(has("Contact"), kernel == "ply_search" || kernel == "ply_impulse");
        if has("Contact") {
            assert_eq!(members("Contact").count() as u64, layout::CONTACT_WORDS);
        }
        if has("Event") {
            assert_eq!(members("Event").collect::<Vec<_>>(), ["step", "element", "yarn", "strain"]);
            assert_eq!(layout::EVENT_WORDS, 4);
        }
        if has("Point") {
            assert_eq!(members("Point").count() as u64, layout::POINT_WORDS[usize::from(of_rim)]);
        }
        if of_rim {
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
    let profile = &body.body.profile;
    let nose = profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius;
    let mut filled = layout::body(&body, &start.velocity);
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
            assert_eq!(Vector3::from(place), body.position);
        }
        let tip = body.position + body.orientation.transform_vector(&Vector3::new(0.0, 0.0, nose));
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
        let record = layout::read_body(&filled, &start);
        assert_eq!(record.impulse, [0.0, 1.0, 2.0]);
        assert_eq!(record.support, [10.0, 11.0, 12.0]);
        assert_eq!((record.energy, record.penetration), ([20.0, 21.0, 22.0], 23.0));
        assert!((record.body.velocity - body.velocity).norm() < 1e-5);
        assert_eq!(record.body.position, body.position);
        assert!(record.body.orientation.angle_to(&body.orientation) < 1e-6);
        assert_eq!(record.before.0.x, start.velocity.x + 9.0);
        assert!((record.before.1.x - 0.0).abs() < 0.001 && record.before.1.y == -2.5);
        filled = layout::body(&body, &start.velocity);
    }
}

/// The numbers of a constant expression.
fn numbers(module: &Module, at: naga::Handle<naga::Expression>) -> Vec<f64> {
    use naga::{Expression, Literal};
    match &module.global_expressions[at] {
        Expression::Literal(Literal::F32(x)) => vec![f64::from(*x)],
        Expression::Literal(Literal::U32(x)) => vec![f64::from(*x)],
        Expression::Literal(Literal::I32(x)) => vec![f64::from(*x)],
        Expression::Constant(constant) => numbers(module, module.constants[*constant].init),
        Expression::Compose { components, .. } => components.iter().flat_map(|c| numbers(module, *c)).collect(),
        other => panic!("{other:?}"),
    }
}

fn constants() -> Vec<(&'static str, Vec<f64>)> {
    use layout::{status, sum};
    let count = |name, value: usize| (name, vec![value as f64]);
    let number = |name, value: f64| (name, vec![f64::from(value as f32)]);
    let list = |name, values: &[f64]| (name, values.iter().map(|x| f64::from(*x as f32)).collect());
    vec![
        count("GROUP", layout::GROUP as usize),
        count("WIDTH", layout::GROUP as usize),
        count("BODY_WORDS", layout::BODY_WORDS),
        count("STATUS_WORDS", layout::STATUS_WORDS),
        count("SUMS", layout::SUMS),
        count("BAD_STEP", status::BAD_STEP),
        count("EVENTS", status::EVENTS),
        count("FAILED", status::FAILED),
        count("ERODED", status::ERODED),
        count("UNCONVERGED", status::UNCONVERGED),
        count("RESIDUAL", status::RESIDUAL),
        count("OVERFLOW", status::OVERFLOW),
        count("OVERFLOW_EDGES", status::OVERFLOW_EDGES),
        count("NOT_CONVERGED", status::NOT_CONVERGED),
        count("WORK", sum::WORK),
        count("RELEASED", sum::RELEASED),
        count("RELEASED_HOURGLASS", sum::RELEASED_HOURGLASS),
        count("STORED", sum::STORED),
        count("HOURGLASS_NOW", sum::HOURGLASS_NOW),
        count("TENSION", sum::TENSION),
        count("DEFLECTION", sum::DEFLECTION),
        count("EVALUATIONS", sum::EVALUATIONS),
        count("SOLVED", sum::SOLVED),
        count("KINETIC", sum::KINETIC),
        count("KINETIC_NOW", sum::KINETIC_NOW),
        count("FASTEST", sum::FASTEST),
        count("MOMENTUM", sum::MOMENTUM),
        count("SUPPORT", sum::SUPPORT),
        count("COVERED", sum::COVERED),
        count("PLY_LOSS", sum::PLY_LOSS),
        count("PLY_FRICTION_WORK", sum::PLY_RUBBED),
        count("PLY_SEPARATION_WORK", sum::PLY_LIFTED),
        count("VISCOUS_WORK", sum::VISCOUS),
        count("LAW_MADE", sum::LAW),
        count("LOAD", sum::LOAD),
        count("COMPUTED", status::COMPUTED),
        count("PLY_DEPTH", status::PLY_DEPTH),
        count("REACH", status::REACH),
        count("WALK", ply_contact::WALK),
        count("PENETRATING", over::PENETRATING as usize),
        number("POSITION_CORRECTION", ply_contact::POSITION_CORRECTION),
        number("DEEP_RECOVERY", ply_contact::DEEP_RECOVERY),
        number("DEEP", ply_contact::DEEP),
        number("RECOVERY_SPEED", ply_contact::RECOVERY_SPEED),
        number("DEEP_SPEED", ply_contact::DEEP_SPEED),
        number("NEAR_MIDDLE", ply_contact::NEAR_MIDDLE),
        number("PASSED", ply_contact::PASSED),
        number("PASSED_SPEED", ply_contact::PASSED_SPEED),
        number("SLOP", ply_contact::SLOP),
        number("EDGE", ply_contact::EDGE),
        number("MAX_INITIAL_PENETRATION", ply_contact::MAX_INITIAL_PENETRATION),
        number("MIN_AREA_RATIO", ply_contact::MIN_AREA_RATIO),
        number("SEGMENT_EXTENSION", ply_contact::SEGMENT_EXTENSION),
        number("EDGE_TOLERANCE", ply_contact::EDGE_TOLERANCE),
        number("FLATNESS_TOLERANCE", ply_contact::FLATNESS_TOLERANCE),
        count("NO_PLY", layout::NONE as usize),
        count("NONE", layout::NONE as usize),
        count("MAX_ITERATIONS", crossover::MAX_ITERATIONS as usize),
        count("NEWTON_ITERATIONS", coupled_newton::NEWTON_ITERATIONS as usize),
        count("SET_CHANGES", projectile_contact::SET_CHANGES),
        count("FRICTION_SWEEPS", projectile_contact::FRICTION_SWEEPS),
        count("ELLIPSE_STEPS", projectile_chisel::ELLIPSE_STEPS),
        number("RESOLVED", projectile_shape::RESOLVED),
        count("LAW_COUNT", law_energy::COUNT),
        number("BROKEN", element_force::BROKEN),
        number("FOLDED_STRETCH", element_force::FOLDED_STRETCH),
        number("STEEPEST", shear::STEEPEST),
        number("SHORTEST", yarn_law::SHORTEST),
        number("LEAST_STRAIN", predictor::LEAST_STRAIN),
        number("EPSILON", f64::from(f32::EPSILON)),
        number("PI", std::f64::consts::PI),
        number("HALF_PI", std::f64::consts::FRAC_PI_2),
        number("FIXED_POINT_SCALE", layout::FIXED_POINT_SCALE),
        list("SERIES", &arc_length::SERIES),
        list("ARC_SINE_SINGLE", &shear::ARC_SINE_SINGLE),
        count("LINES_ACROSS", layout::LINES_ACROSS),
        count("LINE_TEXELS", layout::LINE_TEXELS),
        number("HELD", projectile_contact::HELD),
        number("SHARED", projectile_rim::SHARED),
        number("FLOOR", projectile_rim::FLOOR),
    ]
}

/// Names that shaders alone have for the states of a point of contact. A fresh one is away: its words are zero.
const STATES: [&str; 3] = ["AWAY", "NEAR", "PUSHING"];

#[test]
fn constants_have_the_values_of_their_twins() {
    let laws = shader::LAWS.iter().enumerate().map(|(at, (name, _))| (*name, vec![at as f64]));
    let expected: BTreeMap<_, _> = constants().into_iter().chain(laws).collect();
    let mut seen = BTreeSet::new();
    for (kernel, module) in modules() {
        for (_, constant) in module.constants.iter() {
            let Some(name) = constant.name.as_deref().filter(|name| !STATES.contains(name)) else { continue };
            let got = numbers(&module, constant.init);
            let twin = expected.get(name).unwrap_or_else(|| panic!("{kernel}: {name} is not in the list above"));
            assert_eq!(&got, twin, "{kernel}: {name}");
            seen.insert(name.to_owned());
        }
    }
    let missing: Vec<_> = expected.keys().filter(|name| !seen.contains(**name)).collect();
    assert!(missing.is_empty(), "no shader has {missing:?}");
}

#[test]
fn states_of_a_contact_differ_and_a_fresh_one_is_away() {
    for (kernel, module) in modules() {
        let value = |name: &str| {
            let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
            found.map(|(_, constant)| numbers(&module, constant.init))
        };
        let states = STATES.map(value);
        let of_contact = kernel.starts_with("projectile_");
        assert_eq!(states.iter().flatten().count(), if of_contact { STATES.len() } else { 0 }, "{kernel}");
        if of_contact {
            assert_eq!(states[0], Some(vec![0.0]), "{kernel}");
            assert!(states[0] != states[1] && states[1] != states[2] && states[2] != states[0], "{kernel}");
        }
    }
}

#[test]
fn laws_are_numbered_alike() {
    let laws = crate::support::LAWS.map(|law| {
        let fabric = crate::support::s720(law, None);
        let mut case = patch::case(1, 1);
        case.fabric.crossover = fabric.crossover;
        let terms = Model::<f32>::new(&case).unwrap().features();
        shader::constants(&terms, false).iter().find(|(name, _)| *name == "LAW").map(|(_, value)| *value)
    });
    assert_eq!(laws, std::array::from_fn(|at| Some(at as f64)), "the order of `shader::LAWS`");
}

#[test]
fn overridable_constants_are_those_the_host_sets() {
    let terms = Model::<f32>::new(&patch::case(1, 1)).unwrap().features();
    let set: BTreeSet<_> = shader::constants(&terms, true).iter().map(|(name, _)| (*name).to_owned()).collect();
    for (kernel, module) in modules() {
        let found: BTreeSet<_> = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
        assert_eq!(found, set, "{kernel}");
    }
    for (_, module) in modules() {
        let terms = module.overrides.iter().find(|(_, o)| o.name.as_deref() == Some("TERMS"));
        let init = terms.and_then(|(_, o)| o.init).unwrap();
        assert_eq!(numbers(&module, init), [arc_length::MAX_TERMS as f64]);
    }
}

#[test]
fn arrays_in_workgroups_have_room_for_their_sums() {
    let contact = ["projectile_contact", "projectile_points", "projectile_rim"].map(|kernel| (kernel, 27));
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

#[test]
fn every_file_belongs_to_a_kernel_and_names_its_twin() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for entry in std::fs::read_dir(root.join("shaders")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(KERNELS.iter().any(|k| k.sources.contains(&text.as_str())), "{name} is in no kernel");
        assert!(text.starts_with(&format!("// {name}: ")), "{name} begins with another name");
        let twin = text.lines().find_map(|l| l.strip_prefix("// Twin: ")).unwrap_or_else(|| panic!("{name}: no twin"));
        let files: Vec<_> = twin.split([' ', ',']).filter(|word| word.starts_with("src/")).collect();
        assert!(!files.is_empty() && files.iter().all(|f| root.join(f).is_file()), "{name}: {twin}");
    }
    for kernel in &KERNELS {
        let own = std::fs::read_to_string(root.join(format!("shaders/{}.wgsl", kernel.name))).unwrap();
        assert_eq!(
            kernel.sources[0], own,
            "{}: its own file comes first, so that line numbers stay right",
            kernel.name
        );
    }
}

#[test]
fn pipelines_and_bindings_fit_together_for_every_kind_of_scene() {
    let device = Device::noop();
    let mut cases = cases();
    cases.extend(crate::support::LAWS.map(|law| {
        let mut case = patch::bare(patch::case(2, 3));
        case.fabric.crossover = crate::support::s720(law, None).crossover;
        case
    }));
    for case in cases {
        let model = Model::<f32>::new(&case).unwrap();
        DeviceStepper::new(&device, &model).map(|_| ()).unwrap_or_else(|e| panic!("{}: {e}", case.title));
        let broken =
            |kernel: &Kernel| kernel.source().replace("var<storage, read> nodes", "var<storage, read_write> nodes");
        let refused = DeviceStepper::with_sources(&device, &model, &broken);
        assert!(refused.is_err(), "a binding that does not fit is refused");
    }
}
