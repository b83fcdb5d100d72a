//! Packs of plies end to end: on the device as on the processor, whatever the batches and whatever is left out.

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::run::{Precision, Run, Skips};

use super::batches::equal_rows;
use super::{Outcome, Tests, run_in_batches, run_on, simulated};
use crate::scene::{builtin, run_as};

pub(super) const TESTS: Tests = &[
    ("up_to_the_first_failure_a_pack_is_the_references", references),
    ("the_batch_length_does_not_matter_to_a_pack", lengths),
    ("what_is_left_at_rest_changes_no_bit_of_a_pack", skips),
];

/// Plies in touch at rest, with gaps between them, of two fabrics and turned.
const PACKS: [(&str, &[&str]); 3] = [
    ("touching", &["/pack/plies=3"]),
    ("with gaps", &["/pack/plies=3", "/pack/spacing_mm=0.45"]),
    (
        "turned",
        &[r#"/pack/layup=[{},{"orientation_deg":30,"edges":"free"},
            {"orientation_deg":90,"fabric":{"name":"coarse","fibre_density_kg_m3":1440,"areal_density_g_m2":190,
                "thickness_mm":0.2,
                "warp":{"linear_density_denier":1420,"modulus_gpa":96,"failure_strain":0.035,"count_per_inch":17,"crimp":0.02},
                "weft":{"linear_density_denier":1420,"modulus_gpa":96,"failure_strain":0.035,"count_per_inch":15,"crimp":0.02},
                "crossover":{"law":"published","gap_mm":0,"compression":{"a_mm":0.1,"b_mm_n13":0.1}},
                "shear":{"g1_mpa":10,"g2_mpa":1000,"gamma1":0.35,"gamma2":0.6}}}]"#],
    ),
];

/// An oblique shot at 300 m/s on a small pack.
fn shot(pack: &[&str], more: &[&str]) -> Case {
    let small =
        ["/pack/width_mm=30", "/pack/height_mm=25", "/solver/end_time_us=16", "/output/history_interval_us=0.25"];
    builtin("cases/verify/mirror.json", &[&small[..], pack, more].concat())
}

/// When the first yarn breaks [s].
fn first_failure(run: &Run) -> f64 {
    run.events.first().map_or(f64::INFINITY, |e| e.step as f64 * run.time_step)
}

fn references(device: &'static Device) -> Outcome {
    let mut wrong = Vec::new();
    for (name, pack) in PACKS {
        let case = shot(pack, &[]);
        let gpu = run_on(device, &case);
        let contact = gpu.history.last().map_or(0.0, |row| row.balance.contact + row.balance.friction);
        assert!(contact > 0.0, "{name}: nothing touches");
        for precision in [Precision::F64, Precision::F32] {
            let cpu = run_as(&case, precision, 2);
            assert_eq!(gpu.time_step, cpu.time_step);
            let broken = first_failure(&cpu).min(first_failure(&gpu));
            let rows = || cpu.history.iter().zip(&gpu.history).take_while(|(c, _)| c.time <= broken);
            assert!(rows().count() > 8, "{name}: {} rows before the first failure", rows().count());
            for (c, g) in rows() {
                let off = (c.projectile_velocity - g.projectile_velocity).abs();
                if off > 1e-4 * 300.0 {
                    wrong.push(format!("{name}, {precision:?}: {off} m/s at {} s", c.time));
                }
            }
        }
        if gpu.energy_error > 5e-3 {
            wrong.push(format!("{name}: energy error {:e}", gpu.energy_error));
        }
        if gpu.momentum_error > 1e-4 {
            wrong.push(format!("{name}: momentum error {:e}", gpu.momentum_error));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

fn lengths(device: &'static Device) -> Outcome {
    for (name, pack) in PACKS {
        let case = shot(pack, &[]);
        let one = run_in_batches(device, &case, 1);
        for steps in [7, 64] {
            equal_rows(&one, &run_in_batches(device, &case, steps), &format!("{name}, batches of {steps} steps"));
        }
        equal_rows(&one, &run_on(device, &case), &format!("{name}, batches of the run's own choice"));
    }
    Ok(())
}

fn skips(device: &'static Device) -> Outcome {
    for (name, pack) in PACKS {
        let case = shot(pack, &["/pack/width_mm=60", "/pack/height_mm=50", "/solver/end_time_us=9"]);
        let [part, whole] =
            [false, true].map(|whole| simulated(device, &case, Skips { wavefront: !whole, ..Skips::WHOLE }));
        equal_rows(&part, &whole, name);
        assert_eq!(whole.element_steps_computed, whole.steps * whole.elements as u64, "{name}");
        let saved = 1.0 - part.element_steps_computed as f64 / whole.element_steps_computed as f64;
        assert!(saved > 0.3, "{name}: {saved} left out");
    }
    Ok(())
}
