//! What is in a file of this format.

use serde::Serialize;

use super::FORMAT;
use super::body::BodyMotion;
use crate::case;
use crate::output::report::Animation;
use crate::run::profile::ProfilePoint;
use crate::run::{PlySample, Sample, Simulation};
use crate::solver::FailureEvent;
use crate::solver::active_region::ActiveRegion;
use crate::solver::energy_balance::{EnergyBalance, PlyMoment};

fn bytes(value: &impl Serialize) -> usize {
    postcard::to_stdvec(value).map_or(0, |bytes| bytes.len())
}

/// Red when something is added to what a checkpoint holds, or taken away: that is another format.
#[test]
fn what_is_written_is_that_of_the_format() -> Result<(), Box<dyn std::error::Error>> {
    let text = r#"{"title": "one ply", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 12.7, "height_mm": 12.7}, "solver": {"end_time_us": 1, "symmetry": "none"},
        "projectile": {"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 50}}"#;
    let case = case::from_str("one", text, &[])?;
    let simulation = Simulation::<f64>::new(&case)?;
    let event = FailureEvent { step: 0, ply: 0, i: 0, j: 0, yarn: 0, strain: 0.0 };
    let point = ProfilePoint { reference: 0.0, position: 0.0, deflection: 0.0, strain: 0.0, force: 0.0 };
    let sizes = [
        bytes(&EnergyBalance::default()),
        bytes(&simulation.record),
        bytes(&simulation.stepper.memory()),
        bytes(&simulation.stepper.stopwatch),
        bytes(&simulation.state.body.as_ref().map(BodyMotion::of)),
        bytes(&ActiveRegion::nothing()),
        bytes(&Sample::default()),
        bytes(&PlySample::default()),
        bytes(&PlyMoment::default()),
        bytes(&event),
        bytes(&point),
        Animation::new(&case).to_bytes().len(),
    ];
    assert_eq!((FORMAT, sizes), (10, [204, 142, 17, 12, 105, 4, 188, 35, 24, 13, 40, 6]));
    Ok(())
}
