//! Every shipped case of `cases/verify` and `cases/stress` meets its own `expect` block, and an expectation can fail.
//! In single precision they run in `tests/cli`, by `ripstop verify`. The paper's shot at full size matches an independent prototype of the
//! same model and assumed parameters to 1 % of the velocity lost, whatever mesh and step before failure.

use std::path::Path;

use ripstop::run::Run;
use ripstop::run::outcome::Outcome;

use crate::support::{builtin, checked, run};

/// Without viscosity tension rings behind a shock: between compressible crossovers waves run too fast and yarns break, and a slack strip
/// that is pulled taut becomes unstable.
const RINGS: [&str; 3] = ["strip-compressible-155", "strip-compressible-250", "strip-pulled-weft-free"];

/// Names of the shipped cases of a folder.
pub(crate) fn names(folder: &str) -> Vec<String> {
    let files = std::fs::read_dir(Path::new("cases").join(folder)).unwrap().map(|file| file.unwrap().path());
    files.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn waves_meet_their_expectations_with_the_papers_numerics() {
    for name in names("verify").iter().filter(|name| !RINGS.contains(&name.as_str())) {
        let case = builtin(&format!("cases/verify/{name}.json"), &[]);
        let failed: Vec<_> = checked(&case, &run(&case)).into_iter().filter(|check| check["pass"] != true).collect();
        assert!(failed.is_empty(), "{name}: {failed:?}");
    }
}

#[test]
fn compressible_crossovers_need_shock_viscosity() {
    for name in &RINGS[..2] {
        let case = builtin(&format!("cases/verify/{name}.json"), &[]);
        assert!(checked(&case, &run(&case)).iter().all(|check| check["pass"] == false), "{name}");
    }
}

const PROTOTYPE: &str = "cases/verify/s720-prototype.json";

/// Velocity at a time by linear interpolation [m/s].
fn velocity_at(run: &Run, time: f64) -> f64 {
    let after = run.history.iter().position(|s| s.time >= time).unwrap();
    let (a, b) = (&run.history[after - 1], &run.history[after]);
    a.projectile_velocity + (b.projectile_velocity - a.projectile_velocity) * (time - a.time) / (b.time - a.time)
}

#[test]
fn mesh_and_step_do_not_matter_before_failure() {
    let reference = run(&builtin(PROTOTYPE, &["/solver/courant=0.9"]));
    let coarse = run(&builtin(PROTOTYPE, &["/pack/crossovers_per_element=2"]));
    let slow = run(&builtin(PROTOTYPE, &["/solver/courant=0.5"]));
    let prototype = [(20e-6, 152.99), (40e-6, 149.5), (60e-6, 144.8), (80e-6, 135.9)];
    for (time, expected) in prototype {
        let v = velocity_at(&reference, time);
        assert!((v - expected).abs() <= 0.01 * (155.0 - expected), "{v} for {expected} m/s at {time} s");
        assert!((velocity_at(&coarse, time) / v - 1.0).abs() < 0.02, "80 x 80 at {time} s");
        assert!((velocity_at(&slow, time) / v - 1.0).abs() < 0.002, "Courant 0.5 at {time} s");
    }
    assert!(reference.events.is_empty(), "no yarn fails before 82 µs");
    assert!(reference.hourglass_fraction < 0.02, "{}", reference.hourglass_fraction);
}

#[test]
fn a_pretension_of_nothing_is_none() {
    let history = |pretension: &str| {
        let sets = ["/pack/width_mm=40", "/pack/height_mm=40", "/solver/end_time_us=30", "/expect=[]", pretension];
        run(&builtin(PROTOTYPE, &sets)).history
    };
    let without = history("/pack/friction=0.2");
    for forces in [r#"{"warp_n_per_m": 0, "weft_n_per_m": 0}"#, r#"{"warp_n_per_m": 0}"#, r#"{"weft_n_per_m": 0.0}"#] {
        assert!(history(&format!("/pack/pretension={forces}")) == without, "{forces}");
    }
    assert!(history(r#"/pack/pretension={"warp_n_per_m": 1000}"#) != without);
}

#[test]
fn a_ricochet_rebounds() {
    let sets = [
        "/projectile/offset_mm=[0,0]",
        "/projectile/velocity_m_s=60",
        "/projectile/obliquity_deg=60",
        "/projectile/friction=0",
        "/solver/end_time_us=400",
        "/solver/run_until=outcome",
    ];
    assert_eq!(run(&builtin("cases/verify/mirror.json", &sets)).outcome, Outcome::Rebounded);
}

#[test]
fn a_body_that_only_comes_near_to_rest_is_stopped() {
    // Nodes that are held take a share of a bar's velocity in every step, and all of it never.
    let sets = [
        "/pack/width_mm=30",
        "/pack/height_mm=30",
        "/output/profile_times_us=[]",
        "/expect=[]",
        r#"/projectile={"shape": "bar", "diameter_mm": 4, "mass_g": 3, "velocity_m_s": 150}"#,
    ];
    let run = run(&builtin("cases/s720-1ply-155.json", &sets));
    assert_eq!(run.outcome, Outcome::Stopped);
    let [stop, end] = [run.stop_time.unwrap(), run.history.last().unwrap().time];
    assert!(0.0 < stop && stop <= end && end < 5e-6, "stops at {stop} s of {end} s");
    assert!(run.history.last().unwrap().projectile_velocity < 1e-6);
}
