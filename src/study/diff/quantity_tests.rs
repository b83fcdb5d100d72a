use super::*;

#[test]
fn every_column_of_the_history_is_itself() {
    for column in &history::COLUMNS {
        assert_eq!(of(column.name), Some(Quantity { name: column.name, factor: 1.0 }), "{}", column.name);
    }
}

#[test]
fn headings_of_cameras_are_understood() {
    let velocity = "projectile_velocity_m_s";
    let known = [
        ("time_ms", TIME, 1e3),
        ("Time [µs]", TIME, 1.0),
        ("t_s", TIME, 1e6),
        ("velocity_m_s", velocity, 1.0),
        (" Velocity (ft/s) ", velocity, 0.3048),
        ("projectile_velocity_km_s", velocity, 1e3),
        ("Deflection (mm)", "max_deflection_mm", 1.0),
        ("displacement_in", "projectile_displacement_mm", 25.4),
        ("force_kn", "contact_force_n", 1e3),
        ("failed_warp", "failed_warp", 1.0),
    ];
    for (heading, name, factor) in known {
        assert_eq!(of(heading), Some(Quantity { name, factor }), "{heading}");
    }
    // A quantity without its unit, or in one of another kind, says nothing.
    for heading in ["time", "velocity", "velocity_mm", "mass_g", "", "m_s", "_us"] {
        assert_eq!(of(heading), None, "{heading}");
    }
    assert_eq!(words("max_deflection_mm"), "max deflection [mm]");
    assert_eq!(words("failed_warp"), "failed warp");
    assert_eq!(unit_of(velocity), " m/s");
}
