//! The shaders against their Rust twins, without a graphics adapter: what both sides of the fence have written down.
//!
//! Goes red when a kernel no longer compiles, binds other buffers than the host gives it, lays a struct out in another
//! way than the host fills it, or has another value of a shared constant.

mod layouts;

use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;
use std::path::Path;

use naga::compact::{KeepUnused, compact};
use naga::{AddressSpace, Module, StorageAccess};
use ripstop::case::Case;
use ripstop::gpu::buffers::Sizes;
use ripstop::gpu::shader::{self, Access, KERNELS, Kernel};
use ripstop::gpu::stepper::DeviceStepper;
use ripstop::gpu::{Device, layout};
use ripstop::model::{Model, layup, unit_cell};
use ripstop::physics::{
    coupled_newton, crossover, kinematics, membrane, ply_contact, projectile_shape, viscous_force, yarn_law,
};
use ripstop::solver::contact::{edge_contact, projectile_contact};
use ripstop::solver::element_force;
use serde::Serialize;
use serde_json::{Value, json};
use wgpu::naga;

use crate::support::{SOLVER_LAWS, builtin, patch};

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
        // Packing two halves into a word is part of WGSL.
        let capabilities = naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        let flags = naga::valid::ValidationFlags::all();
        let checked = naga::valid::Validator::new(flags, capabilities).validate(&module);
        checked.unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string("")));
    }
}

#[test]
fn entry_points_have_the_names_and_sizes_the_host_dispatches() {
    for (name, module) in modules() {
        let [entry] = &module.entry_points[..] else { panic!("{name}: one entry point is expected") };
        assert_eq!(entry.name, name);
        if name.starts_with("projectile_") {
            let width = entry.workgroup_size_overrides.unwrap()[0].unwrap();
            let naga::Expression::Override(width) = module.global_expressions[width] else { panic!("{name}") };
            assert_eq!(module.overrides[width].name.as_deref(), Some("WIDTH"), "{name}");
        } else {
            let group = if name == "sweep" { 256 } else { layout::GROUP };
            assert_eq!(entry.workgroup_size, [group, 1, 1], "{name}");
        }
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
            "sweep" | "yarn_load" => &["scene", "step", "plies", "law"],
            _ => &["scene", "step", "plies"],
        };
        let common = names.iter().zip(0..).chain([(&"shots", 4)]);
        let common = common.map(|(name, at)| ((0, at), ((*name).to_owned(), None)));
        assert_eq!(found, common.chain(own).collect(), "{}", kernel.name);
        assert!(kernel.bindings.len() <= 10, "{}: a device is asked for ten storage buffers", kernel.name);
    }
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
        assert_eq!(kernel.sources[0], own, "its own file comes first, so that line numbers stay right");
    }
}

#[test]
fn pipelines_and_bindings_fit_together_for_every_kind_of_scene() {
    let device = Device::noop();
    let mut cases = cases();
    cases.extend(SOLVER_LAWS.map(|law| {
        let mut case = patch::bare(patch::case(2, 3));
        (case.fabric.crossover.law, case.fabric.crossover.compression) = (law, None);
        case
    }));
    for case in cases {
        let model = Model::<f32>::new(&case).unwrap();
        DeviceStepper::new(&device, &model).map(|_| ()).unwrap_or_else(|e| panic!("{}: {e}", case.title));
        let broken =
            |kernel: &Kernel| kernel.source().replace("var<storage, read> cells", "var<storage, read_write> cells");
        let refused = DeviceStepper::with_sources(&device, &model, 1, &broken);
        assert!(refused.is_err(), "a binding that does not fit is refused");
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

/// Numbers of the host that a constant must have, as single precision has them.
fn single(value: impl Serialize) -> Vec<f64> {
    let number = |number: &Value| match number.as_f64().unwrap() {
        whole if number.is_u64() => whole,
        real => f64::from(real as f32),
    };
    match json!(value) {
        Value::Array(all) => all.iter().map(number).collect(),
        one => vec![number(&one)],
    }
}

/// Names and values of constants that shaders and host share, by the module that has them.
macro_rules! constants {
    ($($module:ident: $($name:ident),+;)+) => {
        vec![$($((stringify!($name), single(&$module::$name))),+),+]
    };
}

/// Constants by name; those that the host names otherwise come last.
fn expected() -> BTreeMap<&'static str, Vec<f64>> {
    use layout::{cell, clay, status, sum};
    let shared = constants! {
        layout: GROUP, INVOCATIONS, BODY_WORDS, STATUS_WORDS, NONE, FIXED_POINT_SCALE, LINE_NUMBERS, MARKS, MATRIX_ROW, FOUND_WORDS;
        status: BAD_STEP, EVENTS, FAILED, ERODED, UNCONVERGED, RESIDUAL, OVERFLOW, OVERFLOW_EDGES, COMPUTED, PLY_DEPTH, AT_LIMIT, HOLES, REACH;
        cell: YARNS, DRAG, STRAIN, CELL_FIELDS, RATE_FIELDS, HEIGHT_STEPS;
        sum: WORK, VISCOUS_WORK, EVALUATIONS, RELEASED, RELEASED_HOURGLASS, LAW_RELEASED, HALF_STEP, STORED,
            HOURGLASS_NOW, LAW_MADE, SOLVED, DEFLECTION, TENSION, LOAD, TILE_SUMS, KINETIC, FASTEST, MOMENTUM, SUPPORT,
            COVERED, PLY_LOSS, PLY_FRICTION_WORK, PLY_SEPARATION_WORK, CLAY_WORK, CLAY_DEPTH, SUMS;
        clay: CRATER, TAKEN, INTO_CLAY;
        ply_contact: WALK, POSITION_CORRECTION, RECOVERY_TIME, DEEP_RECOVERY, DEEP, RECOVERY_SPEED, DEEP_SPEED, NEAR_MIDDLE,
            PASSED, PASSED_SPEED, SLOP, EDGE, MAX_INITIAL_PENETRATION, MIN_AREA_RATIO, SEGMENT_EXTENSION, EDGE_TOLERANCE,
            FLATNESS_TOLERANCE;
        layup: PENETRATING;
        crossover: MAX_ITERATIONS, REFINEMENTS;
        coupled_newton: NEWTON_ITERATIONS, LEAST_STRAIN;
        projectile_contact: SET_CHANGES, FRICTION_SWEEPS, HELD;
        edge_contact: SHARED, FLOOR;
        projectile_shape: RESOLVED, ELLIPSE_STEPS;
        element_force: BROKEN;
        membrane: FOLDED_STRETCH, STEEPEST, ARC_SINE_SINGLE;
        kinematics: TINY;
        yarn_law: SHORTEST, RAMPS, SERIES;
        viscous_force: RATE_ITERATIONS;
    };
    let others = [
        ("SETTLED", single(4_usize)),
        // What only the device rounds or counts.
        ("ROUNDOFF_TOLERANCE", single(1e-6_f64)),
        ("WITHIN", single(1e-3_f64)),
        ("SHARE_UNIT", single(1_048_576_usize)),
        ("BEFORE", single(1_usize)),
        ("IDLE", single(2_usize)),
        ("FOUND_POINTS", single(27_usize)),
        ("FOUND_CONSTRAINTS", single(28_usize)),
        ("FOUND_PENETRATION", single(29_usize)),
        ("BODY_ORIENTATION", single(offset_of!(layout::Body, orientation) / 16)),
        ("BODY_SUMS", single(offset_of!(layout::Body, impulse) / 16)),
        ("BODY_NOSE", single(offset_of!(layout::Body, nose_coarse) / 16)),
        ("LANES", single(64_usize)),
        ("STRIDE", single(8_usize)),
        ("BLOCK", single(16_usize)),
        ("SHARES", single(0_usize)), // as `frame` of src/gpu/layout/scene.rs writes them
        ("PRESENCE", single(1_usize)),
        ("NO_PLY", single(layout::NONE)),
        ("LAW_COUNT", single(unit_cell::PLACES)),
        ("EPSILON", single(f64::from(f32::EPSILON))),
        ("PI", single(std::f64::consts::PI)),
        ("HALF_PI", single(std::f64::consts::FRAC_PI_2)),
    ];
    shared.into_iter().chain(others).collect()
}

/// Names that shaders alone have for the states of a point of contact. A fresh one is away: its words are zero.
const STATES: [&str; 3] = ["AWAY", "NEAR", "PUSHING"];

#[test]
fn constants_have_the_values_of_their_twins() {
    let expected = expected();
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
fn overridable_constants_are_those_the_host_sets() {
    let model = Model::<f32>::new(&patch::case(1, 1)).unwrap();
    let set: BTreeSet<_> = shader::constants(&KERNELS[0], &model.features(), &Sizes::new(&model))
        .iter()
        .map(|(name, _)| (*name).to_owned())
        .collect();
    for (kernel, module) in modules() {
        let found: BTreeSet<_> = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
        assert_eq!(found, set, "{kernel}");
    }
    // What is left of them where unreachable code is taken out.
    for (kernel, (_, mut module)) in shader::KERNELS.iter().zip(modules()) {
        compact(&mut module, KeepUnused::No);
        let used: BTreeSet<_> = module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
        let named: BTreeSet<_> = kernel.constants.iter().copied().collect();
        assert!(named.is_subset(&used), "{}: {named:?}", kernel.name);
        // What a kernel is not compiled for it asks at run time, or takes as it is for every mesh.
        let left = used.difference(&named).all(|name| ["GRADED", "FRAME", "BACKING"].contains(name));
        assert!(left, "{}: {used:?}", kernel.name);
    }
    for (_, module) in modules() {
        let terms = module.overrides.iter().find(|(_, o)| o.name.as_deref() == Some("TERMS"));
        let init = terms.and_then(|(_, o)| o.init).unwrap();
        assert_eq!(numbers(&module, init), [yarn_law::MAX_TERMS as f64]);
    }
}
