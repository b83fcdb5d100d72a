//! The paper's shot at full size against the double-precision reference.

use ripstop::gpu::Device;
use ripstop::run::Run;
use ripstop::run::profile::{DeflectionProfile, ProfilePoint};

use super::{Outcome, Tests, run_on};
use crate::scene::{builtin, checked, run};

pub(super) const TESTS: Tests = &[("the_perforating_shot_is_the_references", perforating)];

/// When the first yarn breaks [s].
fn first_failure(run: &Run) -> f64 {
    run.events.first().map_or(f64::INFINITY, |e| e.step as f64 * run.time_step)
}

fn perforating(device: &'static Device) -> Outcome {
    let case = builtin("cases/s720-1ply-155.json", &[]);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    assert_eq!(gpu.time_step, cpu.time_step);
    let broken = first_failure(&cpu).min(first_failure(&gpu));
    assert!((100e-6..150e-6).contains(&broken), "{broken}");
    let rows = || cpu.history.iter().zip(&gpu.history).take_while(|(c, _)| c.time <= broken);
    assert!(rows().count() > 200);
    for (c, g) in rows() {
        assert_eq!(c.time, g.time);
        let off = (c.projectile_velocity - g.projectile_velocity).abs();
        assert!(off <= 1e-4 * 155.0, "{off} m/s at {} s, before the first failure", c.time);
    }
    assert_eq!(gpu.outcome, cpu.outcome);
    let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap().projectile_velocity);
    assert!((g / c - 1.0).abs() <= 0.02, "leaves at {g} for {c} m/s");
    assert!(gpu.energy_error <= 5e-3, "{}", gpu.energy_error);
    let [c, g] = [&cpu, &gpu].map(|run| run.events.len());
    assert!(c.abs_diff(g) <= 4, "{g} failures for {c}");
    assert!(checked(&case, &gpu).iter().all(|c| c.pass));
    // Profiles are read back between batches.
    assert_eq!((gpu.profiles.len(), cpu.profiles.len()), (6, 6));
    for (c, g) in cpu.profiles.iter().zip(&gpu.profiles).filter(|(c, _)| c.time < broken) {
        same_profile(c, g);
    }
    Ok(())
}

type Read = fn(&ProfilePoint) -> f64;

#[track_caller]
fn same_profile(cpu: &DeflectionProfile, gpu: &DeflectionProfile) {
    assert_eq!((cpu.time, cpu.points.len()), (gpu.time, gpu.points.len()));
    let columns: [(&str, Read, f64); 4] = [
        ("position", |p| p.position, 1e-5),
        ("deflection", |p| p.deflection, 1e-4),
        ("strain", |p| p.strain, 1e-2),
        ("force", |p| p.force, 2e-2),
    ];
    for (name, read, allowed) in columns {
        let scale = cpu.points.iter().map(|p| read(p).abs()).fold(0.0, f64::max);
        let off = cpu.points.iter().zip(&gpu.points).map(|(c, g)| (read(c) - read(g)).abs()).fold(0.0, f64::max);
        assert!(off <= allowed * scale, "{name} is {off:e} of {scale:e} off at {} s", cpu.time);
    }
}
