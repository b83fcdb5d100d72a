//! A half or a quarter of a scene on the device: as the whole there, and as the part on the processor.

use ripstop::gpu::Device;
use ripstop::run::{Precision, Skips};

use super::{Outcome, Tests, simulated};
use crate::scene::{builtin, run_as};

pub(super) const TESTS: Tests = &[("a_part_is_the_whole_and_the_processors_part", parts)];

fn parts(device: &'static Device) -> Outcome {
    let size = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/expect=[]", "/output/profile_times_us=[]"];
    let shot =
        ["/projectile/length_mm=8", "/projectile/mass_g=1", "/projectile/velocity_m_s=200", "/solver/end_time_us=9"];
    let scenes: [(&[&str], u64); 4] = [
        (&[], 4),
        (&["/projectile/offset_mm=[2.54,0]"], 2),
        (&["/projectile/obliquity_deg=20", "/projectile/azimuth_deg=90"], 2),
        (&["/pack/plies=2", "/pack/layup=[{},{\"orientation_deg\":90}]"], 4),
    ];
    let mut wrong = Vec::new();
    for (sets, copies) in scenes {
        let case = builtin("cases/s720-1ply-155.json", &[&size[..], &shot, sets].concat());
        let [part, whole] = [Skips::default(), Skips::WHOLE].map(|skips| simulated(device, &case, skips));
        let processor = run_as(&case, Precision::F32, 2);
        assert_eq!((part.planes.copies(), whole.planes.copies(), processor.planes), (copies, 1, part.planes));
        assert_eq!((part.elements, part.steps, part.history.len()), (whole.elements, whole.steps, whole.history.len()));
        assert!(part.element_steps_computed * copies <= whole.element_steps_computed + 64 * whole.steps);
        for (name, other) in [("whole", &whole), ("processor", &processor)] {
            for (p, o) in part.history.iter().zip(&other.history) {
                let off = [
                    (p.projectile_velocity - o.projectile_velocity) / 200.0,
                    (p.balance.kinetic - o.balance.kinetic) / 20.0,
                    (p.balance.contact - o.balance.contact) / 20.0,
                    (p.balance.friction - o.balance.friction) / 20.0,
                    (p.deflection - o.deflection) / 2e-3,
                ];
                if off.iter().any(|off| off.abs() > 2e-4) {
                    wrong.push(format!("{sets:?}, {name}, at {} s: {off:?}", p.time));
                    break;
                }
            }
        }
        if part.momentum_error > 1e-4 || part.energy_error > 1e-3 {
            wrong.push(format!("{sets:?}: momentum {:e}, energy {:e}", part.momentum_error, part.energy_error));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}
