use super::*;

#[test]
fn labels_make_room_for_each_other() {
    let mut taken = Vec::new();
    for _ in 0..12 {
        let place = free_place(&taken, [400.0, 200.0], 80.0);
        assert!(
            taken.iter().all(|t: &[f64; 4]| place[1] < t[0] || t[1] < place[0] || place[3] <= t[2] || t[3] <= place[2])
        );
        taken.push(place);
    }
}
