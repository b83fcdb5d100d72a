use super::*;
#[test]
fn a_product_of_half_words_is_the_product() {
    for [a, b] in [[0, 1], [u32::MAX, u32::MAX], [0xFFFF, 0xFFFF_0000], [0x8000_0000, 3], [123_456_789, 987_654_321]] {
        let [high, low] = product(a, b);
        assert_eq!((u64::from(high) << 32) | u64::from(low), u64::from(a) * u64::from(b), "{a} {b}");
    }
}
