//! Shots whose yarns are judged by what lies around them.

use std::sync::atomic::AtomicBool;

use ripstop::case::Case;
use ripstop::gpu::{Device, compare};
use ripstop::simulation::{Precision, Skips};

use super::batches::equal_rows;
use super::{
    Outcome, Tests, ends_as_by_chance, first_failure, places, run_in_batches, run_on, same_until_failure, simulated,
    within_tolerances,
};
use crate::kept;
use crate::scene::{builtin, run_as};

pub(super) const TESTS: Tests = &[
    ("the_perforating_shot_is_the_processors", perforating),
    ("yarns_break_where_they_do_on_the_processor", violent),
    ("a_quarter_is_the_whole", quarter),
    ("neither_batches_nor_what_is_left_at_rest_change_a_bit", same_bits),
    ("kernel_by_kernel_a_shot_is_within_tolerance", kernels),
];

const NONLOCAL: &str = "/pack/failure=nonlocal";

/// A small ply and a small pack of two fabrics, turned, that tear.
fn torn() -> [Case; 2] {
    [kept::ply(), kept::pack()].map(|mut case| {
        case.pack.failure = ripstop::case::FailureMeasure::Nonlocal;
        case
    })
}

/// The paper's shot at full size, at one and a half times the limit: close to it chance decides when it is over.
fn perforating(device: &'static Device) -> Outcome {
    let fast = "/projectile/velocity_m_s=222";
    let case = builtin("cases/s720-1ply-155.json", &[NONLOCAL, fast, "/expect=[]"]);
    let (cpu, gpu) = (run_as(&case, Precision::F32, 2), run_on(device, &case));
    same_until_failure(&cpu, &gpu, 222.0, 90);
    ends_as_by_chance(&case, &gpu);
    assert!(gpu.energy_error <= 5e-3, "{}", gpu.energy_error);
    let local = run_on(device, &builtin("cases/s720-1ply-155.json", &[fast, "/expect=[]"]));
    assert!((first_failure(&local) - first_failure(&gpu)).abs() > 1e-6, "as if it were local");
    Ok(())
}

fn violent(device: &'static Device) -> Outcome {
    for case in torn() {
        let (cpu, gpu) = (run_as(&case, Precision::F32, 2), run_on(device, &case));
        same_until_failure(&cpu, &gpu, 400.0, 3);
        let [c, g] = [&cpu, &gpu].map(places);
        let same = c.iter().zip(&g).take_while(|(c, g)| c == g).count();
        assert!(
            same >= 20,
            "{same} of {} failures are the same; then {:?} for {:?}",
            c.len(),
            g.get(same),
            c.get(same)
        );
        for (c, g) in cpu.events.iter().zip(&gpu.events).take(20) {
            assert!((g.strain - c.strain).abs() < 1e-2 * 0.035, "{g:?} for {c:?}");
        }
        assert!(gpu.energy_error <= 5e-3, "{}", gpu.energy_error);
    }
    Ok(())
}

/// What lies behind the mirror planes counts like what lies before them.
fn quarter(device: &'static Device) -> Outcome {
    let size = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/expect=[]", "/output/profile_times_us=[]"];
    let shot =
        ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=400", "/solver/end_time_us=6"];
    let layup = "/pack/layup=[{},{\"orientation_deg\":90}]";
    for plies in [&[][..], &["/pack/plies=2", layup]] {
        let case = builtin("cases/s720-1ply-155.json", &[&size[..], &shot, &[NONLOCAL], plies].concat());
        let [part, whole] = [Skips::default(), Skips::WHOLE].map(|skips| simulated(device, &case, skips));
        let processor = run_as(&case, Precision::F32, 2);
        assert_eq!((part.planes.copies(), whole.planes.copies(), processor.planes), (4, 1, part.planes));
        for (name, other) in [("whole", &whole), ("processor", &processor)] {
            same_until_failure(other, &part, 400.0, 3);
            let [o, p] = [other, &part].map(places);
            let same = o.iter().zip(&p).take_while(|(o, p)| o == p).count();
            assert!(same >= 12, "{name}: {same} failures are the same; then {:?} for {:?}", p.get(same), o.get(same));
        }
    }
    Ok(())
}

fn same_bits(device: &'static Device) -> Outcome {
    for case in torn() {
        let once = run_on(device, &case);
        assert!(once.events.len() > 20, "{}", once.events.len());
        equal_rows(&once, &run_on(device, &case), "the second time");
        for steps in [1, 7, 64] {
            equal_rows(&once, &run_in_batches(device, &case, steps), &format!("batches of {steps} steps"));
        }
        let [part, whole] =
            [false, true].map(|whole| simulated(device, &case, Skips { wavefront: !whole, ..Skips::WHOLE }));
        equal_rows(&part, &whole, "the whole fabric");
    }
    Ok(())
}

fn kernels(device: &'static Device) -> Outcome {
    for mut case in torn() {
        // What is allowed of a contact is made for a shot like the paper's.
        case.projectile.as_mut().unwrap().velocity = 300.0;
        let found = compare::compare(&case, device, Some(120), 1, &AtomicBool::new(false));
        let found = found.map_err(|e| e.to_string())?;
        let lines = || compare::TOLERANCES.iter().zip(&found.worst);
        for kernel in ["element_force", "failure"] {
            assert!(lines().any(|(line, worst)| line.kernel == kernel && worst.is_some()), "{kernel} is not compared");
        }
        within_tolerances(&found)?;
    }
    Ok(())
}
