//! Constants of the shaders, and what the host overrides.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;

use naga::Module;
use naga::compact::{KeepUnused, compact};
use ripstop::gpu::buffers::Sizes;
use ripstop::gpu::{layout, shader};
use ripstop::model::{Model, layup, unit_cell};
use ripstop::physics::{
    coupled_newton, crossover, kinematics, membrane, ply_contact, projectile_shape, viscous_force, yarn_law,
};
use ripstop::solver::contact::{edge_contact, projectile_contact};
use ripstop::solver::element_force;
use wgpu::naga;

use super::modules;
use crate::support::patch;

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
trait Numbers {
    fn numbers(&self) -> Vec<f64>;
}

impl Numbers for usize {
    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl Numbers for u32 {
    fn numbers(&self) -> Vec<f64> {
        vec![f64::from(*self)]
    }
}

impl Numbers for f64 {
    fn numbers(&self) -> Vec<f64> {
        vec![f64::from(*self as f32)]
    }
}

impl<const N: usize> Numbers for [f64; N] {
    fn numbers(&self) -> Vec<f64> {
        self.iter().flat_map(Numbers::numbers).collect()
    }
}

/// Names and values of constants that shaders and host share, by the module that has them.
macro_rules! constants {
    ($($module:ident: $($name:ident),+;)+) => {
        vec![$($((stringify!($name), Numbers::numbers(&$module::$name))),+),+]
    };
}

/// Constants by name; those that the host names otherwise come last.
fn expected() -> BTreeMap<&'static str, Vec<f64>> {
    use layout::{cell, clay, status, sum};
    let shared = constants! {
        layout: GROUP, INVOCATIONS, BODY_WORDS, STATUS_WORDS, NONE, FIXED_POINT_SCALE, LINES_ACROSS, LINE_TEXELS, MATRIX_ROW;
        status: BAD_STEP, EVENTS, FAILED, ERODED, UNCONVERGED, RESIDUAL, OVERFLOW, OVERFLOW_EDGES, COMPUTED, PLY_DEPTH, AT_LIMIT, REACH;
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
        ("SETTLED", 4_usize.numbers()),
        // What only the device rounds or counts.
        ("ROUNDOFF_TOLERANCE", 1e-6_f64.numbers()),
        ("WITHIN", 1e-3_f64.numbers()),
        ("SHARE_UNIT", 1_048_576_usize.numbers()),
        ("BODY_ORIENTATION", (offset_of!(layout::Body, orientation) / 16).numbers()),
        ("BODY_SUMS", (offset_of!(layout::Body, impulse) / 16).numbers()),
        ("BODY_NOSE", (offset_of!(layout::Body, nose_coarse) / 16).numbers()),
        ("LANES", 64_usize.numbers()),
        ("SHARES", 0_usize.numbers()), // as `frame` of src/gpu/layout/uniforms.rs writes them
        ("PRESENCE", 1_usize.numbers()),
        ("NO_PLY", layout::NONE.numbers()),
        ("LAW_COUNT", unit_cell::PLACES.numbers()),
        ("EPSILON", f64::from(f32::EPSILON).numbers()),
        ("PI", std::f64::consts::PI.numbers()),
        ("HALF_PI", std::f64::consts::FRAC_PI_2.numbers()),
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
    let set: BTreeSet<_> =
        shader::constants(&model.features(), &Sizes::new(&model)).iter().map(|(name, _)| (*name).to_owned()).collect();
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
        // What a kernel is not compiled for it asks at run time.
        assert!(used.difference(&named).all(|name| ["FRAME", "BACKING"].contains(name)), "{}: {used:?}", kernel.name);
    }
    for (_, module) in modules() {
        let terms = module.overrides.iter().find(|(_, o)| o.name.as_deref() == Some("TERMS"));
        let init = terms.and_then(|(_, o)| o.init).unwrap();
        assert_eq!(numbers(&module, init), [yarn_law::MAX_TERMS as f64]);
    }
}
