//! Hard scenes: finite numbers, bounded energy, or a diagnosis.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Row, simulate};
use crate::case;
use crate::simulation::{Options, Run};

const GROUP: &str = "stability";
const SCENE: &str = include_str!("../../cases/verify/mirror.json");

/// What is made hard, and how.
const HARD: &[(&str, &[&str])] = &[
    ("Courant 0.99", &["/solver/courant=0.99"]),
    ("strike at 1 m/s", &["/projectile/velocity_m_s=1"]),
    ("strike at 2000 m/s", &["/projectile/velocity_m_s=2000"]),
    ("projectile of 0.01 g", &["/projectile/mass_g=0.01"]),
    ("projectile of 100 kg", &["/projectile/mass_g=100000"]),
    ("no crimp", &["/fabric/warp/crimp=0", "/fabric/weft/crimp=0"]),
    // The published law is not conservative, at this crimp by 5 % of the energy; the variational one is.
    (
        "25 % crimp, variational law",
        &["/fabric/warp/crimp=0.25", "/fabric/weft/crimp=0.25", "/fabric/crossover/law=variational"],
    ),
    ("modulus ratio 1000:1", &["/fabric/weft/modulus_gpa=0.096"]),
    ("element aspect 10:1", &["/fabric/weft/count_per_inch=200", "/pack/height_mm=8"]),
    ("one yarn direction absent", &["/fabric/weft={\"absent\":true,\"count_per_inch\":20}"]),
    ("hit on an edge", &["/projectile/offset_mm=[25.4,0]"]),
    ("hit in a corner", &["/projectile/offset_mm=[25.4,20.32]"]),
    ("60° obliquity", &["/projectile/obliquity_deg=60"]),
    ("everything erodes", &["/fabric/warp/failure_strain=0.002", "/fabric/weft/failure_strain=0.002"]),
    ("a mesh of one element", &["/pack/width_mm=1.27", "/pack/height_mm=1.27", "/projectile/offset_mm=[0,0]"]),
];

/// One row per hard scene: the energy there is, by state functions, over the energy given.
pub(super) fn rows(options: Options<'_>, interrupt: &AtomicBool, keep: &mut dyn FnMut(Row)) {
    for (name, sets) in HARD {
        if interrupt.load(Ordering::Relaxed) {
            return;
        }
        let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
        let case = match case::from_str("mirror", SCENE, &sets) {
            Ok(case) => case,
            Err(error) => {
                keep(row(name, error.to_string(), false));
                continue;
            }
        };
        match simulate(GROUP, &case, options, interrupt) {
            Ok(run) if run.interrupted => return,
            Ok(run) => {
                let most = largest_energy(&run);
                let sound = run.newton.unconverged == 0 && most.is_finite();
                keep(row(name, format!("{most:.4}"), sound && most < 1.02));
            }
            Err(failed) => keep(Row { name: (*name).to_owned(), ..*failed }),
        }
    }
    keep(refused());
}

fn row(name: &str, got: String, pass: bool) -> Row {
    Row {
        group: GROUP,
        name: name.to_owned(),
        expected: "energy ≤ given".into(),
        got,
        tolerance: "+2 %".into(),
        source: "kinetic + stored + hourglass + projectile + lost, over the start".into(),
        pass,
    }
}

/// Largest sum of all energies over the first one.
fn largest_energy(run: &Run) -> f64 {
    let sums: Vec<f64> = run.history.iter().map(|s| s.balance.by_state()).collect();
    sums.iter().copied().fold(0.0, f64::max) / sums.first().copied().unwrap_or(f64::NAN)
}

/// A step above the critical one is refused.
fn refused() -> Row {
    let error = case::from_str("mirror", SCENE, &["/solver/courant=1.2".to_owned()]).err();
    let pass = error.is_some();
    Row {
        group: GROUP,
        name: "Courant 1.2".into(),
        expected: "refused".into(),
        got: if pass { "refused".into() } else { "accepted".into() },
        tolerance: String::new(),
        source: "above 1 the step exceeds the critical one".into(),
        pass,
    }
}
