//! Constants of the shaders, and what the host overrides.

use std::collections::{BTreeMap, BTreeSet};

use naga::Module;
use ripstop::gpu::{layout, shader};
use ripstop::model::law_energy;
use ripstop::model::{Model, layup};
use ripstop::physics::{
    arc_length, coupled_newton, crossover, kinematics, membrane, ply_contact, projectile_shape, shear, yarn_law,
};
use ripstop::solver::{edge_contact, element_force, projectile_contact};
use wgpu::naga;

use super::modules;
use crate::support::{SOLVER_LAWS, patch};

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

/// Name and value of a constant: one number, or as many as a list has.
type Constant = (&'static str, Vec<f64>);

fn count(name: &'static str, value: usize) -> Constant {
    (name, vec![value as f64])
}

fn list(name: &'static str, values: &[f64]) -> Constant {
    (name, values.iter().map(|x| f64::from(*x as f32)).collect())
}

fn number(name: &'static str, value: f64) -> Constant {
    list(name, &[value])
}

/// Places and sizes that the host shares.
fn of_the_layout() -> Vec<Constant> {
    use layout::{status, sum};
    vec![
        count("GROUP", layout::GROUP as usize),
        count("WIDTH", layout::CONTACT_GROUP as usize),
        count("LANES", layout::CONTACT_LANES as usize),
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
        count("PLY_SEPARATION_WORK", sum::PLY_SEPARATION_WORK),
        count("VISCOUS_WORK", sum::VISCOUS),
        count("LAW_MADE", sum::LAW),
        count("LOAD", sum::LOAD),
        count("COMPUTED", status::COMPUTED),
        count("PLY_DEPTH", status::PLY_DEPTH),
        count("REACH", status::REACH),
        count("NO_PLY", layout::NONE as usize),
        count("NONE", layout::NONE as usize),
        number("FIXED_POINT_SCALE", layout::FIXED_POINT_SCALE),
        count("LINES_ACROSS", layout::LINES_ACROSS),
        count("LINE_TEXELS", layout::LINE_TEXELS),
    ]
}

/// What the kernels reckon with.
fn of_the_kernels() -> Vec<Constant> {
    vec![
        count("WALK", ply_contact::WALK),
        count("PENETRATING", layup::PENETRATING as usize),
        number("POSITION_CORRECTION", ply_contact::POSITION_CORRECTION),
        number("RECOVERY_TIME", ply_contact::RECOVERY_TIME),
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
        count("MAX_ITERATIONS", crossover::MAX_ITERATIONS as usize),
        count("REFINEMENTS", crossover::REFINEMENTS as usize),
        count("NEWTON_ITERATIONS", coupled_newton::NEWTON_ITERATIONS as usize),
        count("SET_CHANGES", projectile_contact::SET_CHANGES),
        count("FRICTION_SWEEPS", projectile_contact::FRICTION_SWEEPS),
        count("ELLIPSE_STEPS", projectile_shape::ELLIPSE_STEPS),
        number("RESOLVED", projectile_shape::RESOLVED),
        count("LAW_COUNT", law_energy::COUNT),
        number("BROKEN", element_force::BROKEN),
        number("FOLDED_STRETCH", membrane::FOLDED_STRETCH),
        number("TINY", kinematics::TINY),
        number("STEEPEST", shear::STEEPEST),
        number("SHORTEST", yarn_law::SHORTEST),
        number("LEAST_STRAIN", coupled_newton::LEAST_STRAIN),
        number("EPSILON", f64::from(f32::EPSILON)),
        number("PI", std::f64::consts::PI),
        number("HALF_PI", std::f64::consts::FRAC_PI_2),
        list("SERIES", &arc_length::SERIES),
        list("ARC_SINE_SINGLE", &shear::ARC_SINE_SINGLE),
        number("HELD", projectile_contact::HELD),
        number("SHARED", edge_contact::SHARED),
        number("FLOOR", edge_contact::FLOOR),
    ]
}

/// Names that shaders alone have for the states of a point of contact. A fresh one is away: its words are zero.
const STATES: [&str; 3] = ["AWAY", "NEAR", "PUSHING"];

#[test]
fn constants_have_the_values_of_their_twins() {
    let expected: BTreeMap<_, _> = of_the_layout().into_iter().chain(of_the_kernels()).collect();
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
fn the_variational_law_is_the_one_of_the_case() {
    let variational = SOLVER_LAWS.map(|law| {
        let mut case = patch::case(1, 1);
        case.fabric.crossover.law = law;
        let terms = Model::<f32>::new(&case).unwrap().features();
        shader::constants(&terms, false).iter().find(|(name, _)| *name == "VARIATIONAL").map(|(_, value)| *value)
    });
    assert_eq!(variational, [Some(0.0), Some(1.0)]);
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
