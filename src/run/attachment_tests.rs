#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;
use crate::case;

fn ply(deflection: f64) -> [PlyMoment; 1] {
    [PlyMoment { stored: 0.0, deflection, kinetic: 0.0 }]
}

#[test]
fn a_look_is_due_once_in_every_eightieth_of_the_run() {
    let case = case::shipped(&[]);
    let (apart, dt) = (case.solver.end_time / LOOKS, 1e-9);
    let mut deflections = Deflections::new(1);
    let attached = |_| Attached { deflection: 2e-3, debris: false };
    for look in 0..4 {
        let time = f64::from(look) * apart;
        assert!(!deflections.is_due(&case, time - dt, dt), "{look}");
        assert!(deflections.is_due(&case, time, dt), "{look}");
        deflections.look(&case, time, dt, &[[0; 2]], attached);
    }
    // Two that were missed are one.
    deflections.look(&case, 6.0 * apart, dt, &[[0; 2]], attached);
    assert!(!deflections.is_due(&case, 6.5 * apart, dt) && deflections.is_due(&case, 7.0 * apart, dt));
}

#[test]
fn debris_counts_until_it_is_found_and_attached_fabric_counts_always() {
    let case = case::shipped(&[]);
    let mut deflections = Deflections::new(1);
    deflections.sample(&ply(3e-3));
    deflections.sample(&ply(1e-3));
    assert_eq!(deflections.largest(), [3e-3]);
    // A ply without failure is not asked.
    deflections.look(&case, 0.0, 1e-9, &[[0; 2]], |_| Attached { deflection: 9e-3, debris: true });
    assert_eq!(deflections.largest(), [3e-3]);
    deflections.sample(&ply(8e-3));
    deflections.look(&case, 0.0, 1e-9, &[[1, 0]], |_| Attached { deflection: 4e-3, debris: true });
    assert_eq!(deflections.largest(), [4e-3], "debris that flew ahead before the look is forgotten");
    deflections.sample(&ply(20e-3));
    assert_eq!(deflections.largest(), [4e-3]);
    deflections.look(&case, 0.0, 1e-9, &[[0, 1]], |_| Attached { deflection: 5e-3, debris: false });
    assert_eq!(deflections.largest(), [5e-3]);
}
