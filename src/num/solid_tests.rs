use super::*;
fn close(got: Solid, expected: Solid, tolerance: f64) {
    let pair = |s: Solid| [s.volume, s.centre, s.squared[0], s.squared[1], s.squared[2]];
    for (a, b) in pair(got).into_iter().zip(pair(expected)) {
        assert!((a / b - 1.0).abs() < tolerance, "{got:?} for {expected:?}");
    }
}

#[test]
fn the_shortest_ogive_is_half_a_ball() {
    let r: f64 = 1.7;
    // Half a ball: centre at 3/8 r, ∫ z² = r²/5 of its volume.
    let squared = [0.2 * r * r, 0.2 * r * r, (0.2 - 9.0 / 64.0) * r * r];
    let half = Solid { volume: 2.0 / 3.0 * PI * r.powi(3), centre: 0.375 * r, squared };
    close(Solid::ogive(r, r), half, 1e-10);
}

#[test]
fn a_slender_ogive_is_the_paraboloid_of_its_length() {
    // ρ = r (1 − (s/L)²) as r/L → 0: volume 8/15 π r² L, centre 5/16 L, ⟨s²⟩ = L²/7, ⟨x²⟩ = r²·(128/315)/(8/15)/4.
    let (r, length) = (1e-3, 1.0);
    let across = 0.25 * r * r * (128.0 / 315.0) / (8.0 / 15.0);
    let along = length * length * (1.0 / 7.0 - 25.0 / 256.0);
    let expected =
        Solid { volume: 8.0 / 15.0 * PI * r * r * length, centre: 0.3125 * length, squared: [across, across, along] };
    close(Solid::ogive(r, length), expected, 3.0 * r * r);
}

#[test]
fn wedges_down_to_the_axis_leave_a_known_volume() {
    // Flats that meet on the axis cut 4/3 r³ tan from a cylinder: two hoofs of 2/3 r² h.
    let (r, length, angle) = (1.5_f64, 4.0, 0.7_f64);
    let solid = Solid::chisel(r, length, 1e-12, angle);
    let volume = PI * r * r * length - 4.0 / 3.0 * r.powi(3) * angle.tan();
    assert!((solid.volume / volume - 1.0).abs() < 1e-9, "{solid:?}");
    assert!(solid.squared[0] > solid.squared[1], "what is cut away lies at large y");
}

#[test]
fn parts_make_a_whole() {
    let whole = Solid::cylinder(2.0, 5.0);
    close(Solid::cylinder(2.0, 2.0).with(Solid::cylinder(2.0, 3.0).raised(2.0)), whole, 1e-14);
    let nothing = Solid::cylinder(2.0, 0.0);
    close(nothing.with(whole), whole, 1e-14);
}
