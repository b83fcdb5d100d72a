//! Shipped scenes and variants of them against the double-precision reference, by integral quantities.

use std::path::{Path, PathBuf};

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::output::csv;
use ripstop::run::Run;

use super::{Outcome, Tests, places, run_on};
use crate::scene::{builtin, run};
use crate::support::Worst;

pub(super) const TESTS: Tests = &[
    ("verification_scenes_end_like_the_references", shipped),
    ("every_shape_law_and_edge_follows_the_reference", variants),
    ("failures_of_a_violent_shot_are_the_references", violent),
];

/// How far a column of the history may be off, over its largest value in the reference.
type Allowed = &'static [(&'static str, f64)];

/// Without failures nothing amplifies a rounding, except that contact opens and closes.
const WHOLE: Allowed = &[
    ("projectile_velocity_m_s", 1e-4),
    ("projectile_energy_j", 1e-4),
    ("external_work_j", 1e-4),
    ("max_deflection_mm", 1e-4),
    ("kinetic_energy_j", 1e-3),
    ("internal_energy_j", 1e-3),
    ("stored_energy_j", 1e-3),
    ("hourglass_energy_j", 1e-3),
    ("friction_j", 1e-3),
    ("contact_dissipation_j", 1e-2),
    ("max_yarn_tension_n", 2e-2),
];

/// Torn fabric is chaotic: one failure a step later moves the next. Single precision on the processor is off as much,
/// and double-precision runs of free-impact with the hit moved by a few nanometres break 50, 52, 58, 65, 69 yarns: 38 % apart.
const TORN: Allowed = &[
    ("projectile_velocity_m_s", 0.02),
    ("projectile_energy_j", 0.04),
    ("kinetic_energy_j", 0.15),
    ("max_deflection_mm", 0.2),
    ("failure_energy_j", 0.38),
];

/// Soon after the first failures nothing has been amplified much.
const TEARING: Allowed = &[
    ("projectile_velocity_m_s", 1e-4),
    ("projectile_energy_j", 2e-4),
    ("kinetic_energy_j", 5e-3),
    ("internal_energy_j", 2e-2),
    ("max_deflection_mm", 5e-3),
    ("friction_j", 1e-2),
    ("failure_energy_j", 2e-2),
];

/// What of `allowed` does not hold, or a number of failures that is off by more than `part` of them.
fn off(cpu: &Run, gpu: &Run, allowed: Allowed, part: f64) -> Vec<String> {
    assert_eq!(cpu.time_step, gpu.time_step);
    let difference = |(name, allowed): &(&str, f64)| {
        let column = csv::find(name).unwrap();
        let [c, g] = [cpu, gpu].map(|run| run.history.iter().map(column.read).collect::<Vec<f64>>());
        let scale = c.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut worst = Worst::default();
        c.iter().zip(&g).enumerate().for_each(|(row, (c, g))| worst.see(c - g, || format!("row {row}")));
        let worst = worst.error;
        (worst > allowed * scale).then(|| format!("{name}: {worst:.1e} of {scale:.3e}, allowed {allowed:.0e}"))
    };
    let mut wrong: Vec<String> = allowed.iter().filter_map(difference).collect();
    let [c, g] = [cpu, gpu].map(|run| run.events.len());
    if c.abs_diff(g) as f64 > (part * c as f64).max(3.0) {
        wrong.push(format!("{g} failures for {c}"));
    }
    if gpu.energy_error > 2e-6 {
        wrong.push(format!("energy error {:e}", gpu.energy_error));
    }
    wrong
}

fn report(wrong: Vec<String>) -> Outcome {
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// With the paper's numerics, but for the strips whose waves ring without viscosity until yarns break.
fn read(file: &Path) -> Case {
    let name = file.to_str().unwrap();
    if name.contains("strip-compressible") { crate::scene::shipped(name, &[]) } else { builtin(name, &[]) }
}

fn shipped(device: &'static Device) -> Outcome {
    let folder = std::fs::read_dir("cases/verify").unwrap().map(|f| f.unwrap().path());
    let mut files: Vec<PathBuf> = folder.filter(|f| f.extension().is_some_and(|e| e == "json")).collect();
    files.sort();
    assert!(files.len() >= 10, "{files:?}");
    let mut wrong = Vec::new();
    for file in files {
        let case = read(&file);
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        let (allowed, part) = if cpu.events.is_empty() { (WHOLE, 0.0) } else { (TORN, 0.5) };
        let mut found = off(&cpu, &gpu, allowed, part);
        if gpu.outcome != cpu.outcome || gpu.history.len() != cpu.history.len() {
            found.push(format!("{:?} for {:?}", gpu.outcome, cpu.outcome));
        }
        // Momentum errors are over the net impulse of the supports, which in a free vibration comes back to nothing.
        if case.projectile.is_some() && gpu.momentum_error > 2e-6 {
            found.push(format!("momentum error {:e}", gpu.momentum_error));
        }
        wrong.extend(found.into_iter().map(|line| format!("{}: {line}", case.name)));
    }
    report(wrong)
}

fn variants(device: &'static Device) -> Outcome {
    const SPHERE: &str = r#"/projectile={"shape":"sphere","diameter_mm":5.5,"mass_g":1,"velocity_m_s":300,
        "offset_mm":[4.4,-2.3],"obliquity_deg":25,"azimuth_deg":35,"friction":0.2}"#;
    const OGIVE: &str = r#"/projectile={"shape":"ogive","diameter_mm":5.5,"length_mm":9,"edge_radius_mm":0,"mass_g":1,"velocity_m_s":300,
        "offset_mm":[4.4,-2.3],"obliquity_deg":25,"azimuth_deg":35,"friction":0.2}"#;
    // At 9° the yarns that break exceed their failure strain by 2.7 % at least: rounding does not decide.
    const FRAGMENT: &str = r#"/projectile={"shape":"fragment","diameter_mm":5.5,"length_mm":6.4,"mass_g":1.1,
        "velocity_m_s":300,"offset_mm":[4.4,-2.3],"obliquity_deg":9,"azimuth_deg":35,"roll_deg":30,"friction":0.2}"#;
    let variants: [&[&str]; 13] = [
        &[SPHERE],
        &[OGIVE],
        &[FRAGMENT],
        &["/projectile/shape=cone"],
        &["/projectile/edge_radius_mm=0.5"],
        &["/projectile/friction=0"],
        &["/projectile/angular_velocity_rad_s=[2000,-1000,5000]"],
        &["/fabric/crossover/law=variational"],
        &["/fabric/crossover/compression=rigid"],
        &["/fabric/shear=none"],
        &["/pack/edges=free"],
        &["/pack/edges=roller", "/pack/pretension={\"warp_n_per_m\":2000,\"weft_n_per_m\":1000}"],
        &["/fabric/weft={\"absent\":true,\"count_per_inch\":20}"],
    ];
    let mut wrong = Vec::new();
    for sets in variants {
        let case = builtin("cases/verify/mirror.json", &[sets, &["/solver/end_time_us=12"]].concat());
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        wrong.extend(off(&cpu, &gpu, TEARING, 0.1).into_iter().map(|line| format!("{sets:?}: {line}")));
    }
    report(wrong)
}

fn violent(device: &'static Device) -> Outcome {
    let case: Case = builtin("cases/verify/mirror.json", &["/projectile/velocity_m_s=600", "/solver/end_time_us=10"]);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    let [c, g] = [&cpu, &gpu].map(places);
    assert!(c.len() > 30, "{}", c.len());
    let same = c.iter().zip(&g).take_while(|(c, g)| c == g).count();
    assert!(same >= 20, "{same} of {} failures are the same; then {:?} for {:?}", c.len(), g.get(same), c.get(same));
    assert!(c.len().abs_diff(g.len()) <= 2, "{} failures for {}", g.len(), c.len());
    for (c, g) in cpu.events.iter().zip(&gpu.events).take(same) {
        assert!((g.strain / c.strain - 1.0).abs() < 1e-2, "{g:?} for {c:?}");
    }
    Ok(())
}
