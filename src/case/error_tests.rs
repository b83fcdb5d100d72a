use super::*;

#[test]
fn the_nearest_key_is_the_one_meant() {
    let keys = ["mass_g", "velocity_m_s", "standoff_mm", "yaw_deg", "growth_ratio"];
    for (word, meant) in
        [("mass_gg", 0), ("mass", 0), ("velocity", 1), ("veloctiy_m_s", 1), ("stand_off_mm", 2), ("growth", 4)]
    {
        assert_eq!(nearest(word, keys), Some(keys[meant]), "{word}");
    }
    assert_eq!(nearest("x", []), None);
}
