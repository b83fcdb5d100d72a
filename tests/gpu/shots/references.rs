//! Shipped scenes and variants of them against the double-precision reference.

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::output::csv;
use ripstop::run::ProfilePoint;
use ripstop::run::Run;

use super::{EDGES, ERRORS, Outcome, Tests, impact, report, run_on, same_until_failure, within};
use crate::support::{builtin, checked, run, shipped};

pub(super) const TESTS: Tests = &[
    ("verification_scenes_follow_the_references", verification),
    ("the_papers_shot_is_the_references", paper),
    ("every_shape_law_and_edge_follows_the_reference", variants),
];

/// Paper's shot at full size, with contact at nodes and at edges. At 222 m/s single precision with edges ends at 181 or 151 m/s by the last
/// digit of the velocity; at 250 to 350 m/s both precisions end within 4e-6.
fn paper(device: &'static Device) -> Outcome {
    let edges = [EDGES, "/solver/shock_viscosity=0.3", "/expect=[]", "/projectile/velocity_m_s=250"];
    for (sets, rows, failures) in [(&[][..], 200, 4), (&edges, 100, 0)] {
        let case = builtin("cases/s720-1ply-155.json", sets);
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        same_until_failure(&cpu, &gpu, impact(&case), rows)?;
        within(&gpu, ERRORS)?;
        let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap().projectile_velocity);
        let allowed = if sets.is_empty() { 0.02 * c } else { 1e-4 * 250.0 };
        assert!(gpu.outcome == cpu.outcome && (g - c).abs() <= allowed, "leaves at {g} for {c} m/s");
        let [c, g] = [&cpu, &gpu].map(|run| run.events.len());
        assert!(c > 20 && c.abs_diff(g) <= failures, "{g} failures for {c}");
        assert!(checked(&case, &gpu).iter().all(|check| check["pass"] == true));
        if sets.is_empty() {
            assert_eq!((gpu.profiles.len(), cpu.profiles.len()), (6, 6));
            same_profiles(&cpu, &gpu);
        }
    }
    Ok(())
}

/// Profiles up to the first failure, which are read back between batches.
fn same_profiles(cpu: &Run, gpu: &Run) {
    let broken = cpu.events[0].step as f64 * cpu.time_step;
    for (c, g) in cpu.profiles.iter().zip(&gpu.profiles).filter(|(c, _)| c.time < broken) {
        assert_eq!((c.time, c.points.len()), (g.time, g.points.len()));
        for (n, allowed) in [1e-5, 1e-4, 1e-2, 2e-2].into_iter().enumerate() {
            let number = |p: &ProfilePoint| [p.position, p.deflection, p.strain, p.force][n];
            let scale = c.points.iter().map(|p| number(p).abs()).fold(0.0, f64::max);
            let mut off = c.points.iter().zip(&g.points).map(|(c, g)| (number(c) - number(g)).abs());
            assert!(off.all(|off| off <= allowed * scale), "column {n} at {} s", c.time);
        }
    }
}

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
/// Plies that fly flat store nothing: 1e-20 of 0.8 J is a rounding, and no largest value to compare with.
const FLAT: Allowed = &[("max_deflection_mm", 1e-4), ("kinetic_energy_j", 1e-3), ("contact_dissipation_j", 1e-2)];
/// Of a heavy body that drops for 18 000 steps each rounds the velocity, which is 3e-5 off in the end, and the balances 1e-5.
const DROP: Allowed = &[
    ("projectile_velocity_m_s", 1e-4),
    ("max_deflection_mm", 1e-4),
    ("crater_depth_mm", 1e-4),
    ("backing_energy_j", 1e-4),
    ("kinetic_energy_j", 1e-3),
    ("contact_dissipation_j", 1e-2),
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

/// Lines of `allowed` that do not hold, a number of failures that is off by more than `part` of them, or an energy error above `energy`.
fn off(cpu: &Run, gpu: &Run, allowed: Allowed, part: f64, energy: f64) -> Vec<String> {
    assert_eq!(cpu.time_step, gpu.time_step);
    let difference = |(name, allowed): &(&str, f64)| {
        let (_, read) = csv::find(name).unwrap();
        let [c, g] = [cpu, gpu].map(|run| run.history.iter().map(read).collect::<Vec<f64>>());
        let scale = c.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let within = |(c, g): (&f64, &f64)| (c - g).abs() <= allowed * scale;
        let row = c.iter().zip(&g).position(|numbers| !within(numbers))?;
        Some(format!("{name}: {} for {} of {scale:.3e} in row {row}, allowed {allowed:.0e}", g[row], c[row]))
    };
    let mut wrong: Vec<String> = allowed.iter().filter_map(difference).collect();
    let [c, g] = [cpu, gpu].map(|run| run.events.len());
    if c.abs_diff(g) as f64 > (part * c as f64).max(3.0) {
        wrong.push(format!("{g} failures for {c}"));
    }
    wrong.extend(within(gpu, [energy, f64::INFINITY]).err());
    wrong
}

/// Scenes of cases/verify of which each asks a device for something that no other does.
const VERIFY: [&str; 12] = [
    "clay-drop",
    "cone-on-membrane",
    "corner-clamps",
    "free-impact",
    "mass-on-strip",
    "mirror",
    "rate-of-strain",
    "smith-yarn-curve",
    "standoff",
    "strip-compressible-155",
    "strip-pulled-weft-held",
    "turned-in-window",
];

/// To the half of their time: what they state at their ends is held on the processor. A strip that is pulled slowly is
/// not far enough by then for its energies to be more than roundings. Of a drop on clay, 18 000 steps, and of a
/// struck strip of 1000 crossovers a tenth is enough.
fn verification(device: &'static Device) -> Outcome {
    let mut wrong = Vec::new();
    for name in VERIFY {
        let file = format!("cases/verify/{name}.json");
        // With the paper's numerics, but for the strip whose waves ring without viscosity until yarns break or energy is made.
        let rings = name == "strip-compressible-155";
        let read: fn(&str, &[&str]) -> Case = if rings { shipped } else { builtin };
        let part = match name {
            "strip-pulled-weft-held" => 1e6,
            "clay-drop" | "strip-compressible-155" => 0.1e6,
            _ => 0.5e6,
        };
        let end = format!("/solver/end_time_us={:?}", part * read(&file, &[]).solver.end_time);
        let case = read(&file, &[&end]);
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        // On a cone contact opens and closes all along its flank.
        let (allowed, part, [energy, momentum]) = match cpu.events.is_empty() {
            true if name == "standoff" => (FLAT, 0.0, ERRORS),
            true if name == "clay-drop" => (DROP, 0.0, [2e-5, 2e-4]),
            true if name == "cone-on-membrane" => (TEARING, 0.0, ERRORS),
            true => (WHOLE, 0.0, ERRORS),
            false => (TORN, 0.5, ERRORS),
        };
        let mut found = off(&cpu, &gpu, allowed, part, energy);
        if gpu.outcome != cpu.outcome || gpu.history.len() != cpu.history.len() {
            found.push(format!("{:?} for {:?}", gpu.outcome, cpu.outcome));
        }
        // Momentum errors are over the net impulse of the supports, which in a free vibration comes back to nothing, and in a strip that is
        // pulled slowly is the small rest of large ones: up to 5e-3 in single precision on the processor, too.
        let is_slow = ["strip-pulled-weft-held", "rate-of-strain"].contains(&name);
        if case.projectile.is_some() && !is_slow {
            found.extend(within(&gpu, [1.0, momentum]).err());
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
    const PRETENSION: &str = "/pack/pretension={\"warp_n_per_m\":2000,\"weft_n_per_m\":1000}";
    const CURVE: &str = r#"/fabric/warp={"linear_density_denier":1420,"curve":[[0,0],[0.004,0.2],[0.012,1.1],[0.03,2.3],[0.04,3.4]],
        "failure_strain":0.035,"count_per_inch":20,"crimp":0.0218}"#;
    let variants: [&[&str]; 16] = [
        &["/backing={\"gap_mm\":0.2,\"pressure_mpa\":20}"],
        &[CURVE],
        &[CURVE, "/fabric/crossover/law=variational"],
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
        &["/pack/edges=roller", PRETENSION],
        &["/fabric/weft={\"absent\":true,\"count_per_inch\":20}"],
    ];
    let mut wrong = Vec::new();
    for sets in variants {
        let case = builtin("cases/verify/mirror.json", &[sets, &["/solver/end_time_us=12"]].concat());
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        wrong.extend(off(&cpu, &gpu, TEARING, 0.1, ERRORS[0]).into_iter().map(|line| format!("{sets:?}: {line}")));
    }
    report(wrong)
}
