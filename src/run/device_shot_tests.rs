//! Results of a batch for the host, on a device that computes nothing.

use super::*;
use crate::case;
use crate::gpu::Device;
use crate::run::Skips;

#[test]
fn an_edge_without_room_ends_the_run_by_name() -> Result<(), Box<dyn std::error::Error>> {
    let text = r#"{"title": "edge", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 12.7, "height_mm": 12.7}, "solver": {"end_time_us": 1, "contact_sampling": "edges"},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 6, "mass_g": 1, "velocity_m_s": 50}}"#;
    let (case, device) = (case::from_str("edge", text, &[])?, Device::noop());
    let (model, mut state) = solver::state::set_up::<f32>(&case, false)?;
    let stepper = DeviceStepper::new(&device, &model)?;
    let mut shot = DeviceShot::new(0, Arc::new(model), &state, Skips::WHOLE);
    // Counters of a batch in which nothing went wrong but one.
    let mut take = |found: u32| {
        let mut result = BatchResult::default();
        result.status[status::BAD_STEP] = u32::MAX;
        result.status[status::OVERFLOW_EDGES] = found;
        shot.take(&stepper, &mut state, &case, &[], &result)
    };
    assert_eq!(take(0), Ok(()));
    let room = stepper.sizes().constraints;
    assert!(room > 20);
    assert_eq!(take(999), Err(DeviceError::CrowdedEdge { adapter: "noop".into(), found: 999, room }));
    Ok(())
}
