//! What the host makes of the counters that a batch leaves behind, on a device that computes nothing.

use super::*;
use crate::case;
use crate::gpu::DeviceError;
use crate::gpu::layout::status;
use crate::gpu::submission::BatchResult;

fn small() -> Result<Case, Box<dyn std::error::Error>> {
    let text = r#"{"title": "rim", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 12.7, "height_mm": 12.7}, "solver": {"end_time_us": 1, "contact_sampling": "edges"},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 6, "mass_g": 1, "velocity_m_s": 50}}"#;
    Ok(case::from_str("rim", text, &[])?)
}

/// The counters of a batch in which nothing went wrong, but one.
fn counters(changes: &[(usize, u32)]) -> BatchResult {
    let mut result = BatchResult::default();
    result.status[status::BAD_STEP] = u32::MAX;
    changes.iter().for_each(|(at, value)| result.status[*at] = *value);
    result
}

#[test]
fn a_rim_without_room_ends_the_run_by_name() -> Result<(), Box<dyn std::error::Error>> {
    let (case, device) = (small()?, Device::noop());
    let mut run = DeviceSimulation::new(&case, &device)?;
    let DeviceLoop { stepper, shots, state, .. } = &mut run.device_loop;
    let mut take = |result: &BatchResult| shots[0].take(stepper, state, &case, &[], result);
    assert_eq!(take(&counters(&[])), Ok(()));
    let crowded = take(&counters(&[(status::OVERFLOW_EDGES, 999)]));
    let room = stepper.sizes().constraints;
    assert!(room > 20);
    assert_eq!(crowded, Err(DeviceError::CrowdedEdge { adapter: "noop".into(), found: 999, room }));
    Ok(())
}
