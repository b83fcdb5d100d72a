use super::*;
#[test]
fn errors_are_over_what_was_put_in_or_as_they_are_where_nothing_was() {
    let mut nothing = EnergyBalance::default();
    nothing.begin(Given::default());
    let balance = nothing.balance();
    assert_eq!([balance.error, balance.gained, balance.momentum_error], [0.0; 3]);

    let mut moving = EnergyBalance::default();
    moving.nodes_are(8.0, [0.0, 0.0, 4.0]);
    moving.begin(Given { energy: 8.0, momentum: Vector3::new(0.0, 0.0, 4.0), fabric_mass: 1.0 });
    moving.nodes_are(10.0, [0.0, 0.0, 5.0]);
    let balance = moving.balance();
    assert_eq!([balance.error, balance.momentum_error], [2.0 / 8.0, 1.0 / 4.0]);
    // What the supports took is no error, and counts as put in.
    moving.support = [3.0, 0.0, 9.0];
    moving.nodes_are(8.0, [0.0, 0.0, 13.0]);
    assert_eq!(moving.balance().momentum_error, 3.0 / 90.0_f64.sqrt());
}

#[test]
fn momentum_of_fabric_let_go_is_measured_by_what_its_energy_can_move() {
    let mut drum = EnergyBalance::default();
    drum.elements_are(0.5, 0.25, 0.0);
    drum.begin(Given { fabric_mass: 6.0, ..Given::default() });
    drum.nodes_are(0.5, [0.0, 0.0, 0.03]);
    // √(2 · 0.75 J · 6 kg) = 3 kg·m/s.
    assert!((drum.balance().momentum_error - 0.01).abs() < 1e-15);
}

#[test]
fn what_the_law_makes_is_told_apart_from_what_is_gained() {
    let mut balance = EnergyBalance::default();
    balance.elements_are(4.0, 0.0, 0.0);
    balance.cells_are(0.25, 0.5);
    balance.begin(Given { energy: 4.0, ..Given::default() });
    balance.elements_are(7.0, 0.0, 0.0);
    balance.cells_are(3.25, 0.5);
    let now = balance.balance();
    assert_eq!([now.law, now.gained, now.max_load], [3.0, 0.0, 0.5]);
}

#[test]
fn momentum_across_a_mirror_plane_is_not_looked_at() {
    let mut part = EnergyBalance::of_part(MirrorPlanes([true, false]));
    part.begin(Given { energy: 1.0, momentum: Vector3::new(0.0, 0.0, 2.0), fabric_mass: 1.0 });
    part.nodes_are(0.0, [7.0, 0.0, 0.0]);
    assert_eq!(part.balance().momentum_error, 0.0);
    part.nodes_are(0.0, [7.0, 1.0, 0.0]);
    assert_eq!(part.balance().momentum_error, 0.5);
}
