//! Shots at graded meshes: elements that grow away from the hit.

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::model::Model;
use ripstop::run::{Precision, Skips};

use super::batches::equal_rows;
use super::{Outcome, Tests, places, run_in_batches, run_on, same_until_failure, simulated};
use crate::scene::{builtin, run_as};

pub(super) const TESTS: Tests = &[
    ("shots_follow_the_processor", shots),
    ("a_quarter_is_the_whole", quarter),
    ("neither_batches_nor_what_is_left_at_rest_change_a_bit", same_bits),
    ("outcomes_are_the_processors", outcomes),
];

const RIM: &str = "/solver/contact_sampling=edges";
const ASIDE: &str = "/projectile/offset_mm=[4,-3]";
const PAIR: [&str; 2] = ["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]"];

/// 40 × 32 crossovers, of whose elements most are larger than the finest.
fn shot(sets: &[&str]) -> Case {
    let size = ["/pack/width_mm=50.8", "/pack/height_mm=40.64", "/expect=[]", "/output/profile_times_us=[]"];
    let mesh = ["/pack/mesh_grading={\"fine_radius_mm\":5,\"growth_ratio\":1.3}"];
    let shot = ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=400"];
    let run = ["/solver/end_time_us=9", "/output/history_interval_us=0.05"];
    let case = builtin("cases/s720-1ply-155.json", &[&size[..], &mesh, &shot, &run, sets].concat());
    let mesh = &Model::<f32>::new(&case).unwrap().ply_types[0].mesh;
    assert!(mesh.is_graded() && mesh.elements() as f64 * 1.5 < mesh.finest_elements(), "{}", mesh.elements());
    case
}

/// One ply and two, centred and not, met at nodes and at the rim, with elements as long as a crossover, a half and a quarter. The finer
/// the elements the thinner the projectile: llvmpipe ends every loop of a kernel after 65 535 turns of all of them, which solves of more
/// points at a rim exceed.
fn all() -> Vec<(String, Case)> {
    let mut out = Vec::new();
    for (elements, fine, end) in [(1, 5.0, 9.0), (2, 2.5, 6.0), (4, 1.25, 3.0)] {
        let sets = [
            format!("/pack/elements_per_crossover={elements}"),
            format!("/pack/mesh_grading={{\"fine_radius_mm\":{fine},\"growth_ratio\":1.3}}"),
            format!("/projectile/diameter_mm={}", 5.5 / f64::from(elements)),
            format!("/solver/end_time_us={end}"),
        ];
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        for plies in [&[][..], &PAIR] {
            for place in [&[][..], &[ASIDE]] {
                for contact in [&[][..], &[RIM]] {
                    let more = [plies, place, contact].concat();
                    out.push((format!("{elements} per crossover, {more:?}"), shot(&[&sets[..], &more].concat())));
                }
            }
        }
    }
    out
}

fn shots(device: &'static Device) -> Outcome {
    for (name, case) in all() {
        let (cpu, gpu) = (run_as(&case, Precision::F32, 2), run_on(device, &case));
        assert_eq!(cpu.planes, gpu.planes, "{name}");
        same_until_failure(&cpu, &gpu, 400.0, 8);
        let [c, g] = [&cpu, &gpu].map(places);
        let same = c.iter().zip(&g).take_while(|(c, g)| c == g).count();
        assert!(
            same >= 4,
            "{name}: {same} of {} failures are the same; {:?} for {:?}",
            c.len(),
            g.get(same),
            c.get(same)
        );
        assert!(
            gpu.energy_error <= 5e-3 && gpu.momentum_error < 1e-4,
            "{name}: {} {}",
            gpu.energy_error,
            gpu.momentum_error
        );
    }
    Ok(())
}

/// What lies behind the mirror planes counts like what lies before them.
fn quarter(device: &'static Device) -> Outcome {
    for (sets, copies) in [(&[][..], 4), (&PAIR, 4), (&[RIM], 4), (&["/projectile/offset_mm=[3.81,0]"], 2)] {
        let case = shot(sets);
        let [part, whole] = [Skips::default(), Skips::WHOLE].map(|skips| simulated(device, &case, skips));
        assert_eq!((part.planes.copies(), whole.planes.copies()), (copies, 1));
        same_until_failure(&whole, &part, 400.0, 8);
        assert!(
            part.energy_error < 1e-3 && part.momentum_error < 1e-4,
            "{} {}",
            part.energy_error,
            part.momentum_error
        );
    }
    Ok(())
}

fn same_bits(device: &'static Device) -> Outcome {
    for sets in [&[ASIDE][..], &[&PAIR[..], &[ASIDE, RIM]].concat()] {
        let case = shot(sets);
        let once = run_on(device, &case);
        assert!(once.events.len() > 10, "{}", once.events.len());
        equal_rows(&once, &run_in_batches(device, &case, 7), "batches of 7 steps");
        let [part, whole] =
            [false, true].map(|whole| simulated(device, &case, Skips { wavefront: !whole, ..Skips::WHOLE }));
        equal_rows(&part, &whole, "the whole fabric");
        assert!(part.element_steps_computed < whole.element_steps_computed);
    }
    Ok(())
}

/// Far above and far below the limit no chance decides.
fn outcomes(device: &'static Device) -> Outcome {
    let run = ["/solver/end_time_us=150", "/output/history_interval_us=0.5", "/projectile/mass_g=0.3"];
    for (speed, word) in [("/projectile/velocity_m_s=600", "perforated"), ("/projectile/velocity_m_s=60", "stopped")] {
        let case = shot(&[&run[..], &[speed]].concat());
        let (cpu, gpu) = (run_as(&case, Precision::F32, 2), run_on(device, &case));
        assert_eq!(cpu.outcome.word(), word);
        assert_eq!(gpu.outcome, cpu.outcome, "{word}");
        let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap().projectile_velocity);
        let allowed = 0.02 * case.projectile.as_ref().unwrap().velocity;
        assert!((c - g).abs() < allowed, "{g} for {c} m/s");
    }
    Ok(())
}
