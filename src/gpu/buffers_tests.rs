use super::*;

#[test]
fn a_dispatch_covers_everything_within_the_limit() {
    for count in [0, 1, 64, 65, 25_600, 4_194_240, 4_194_241, 100_000_000] {
        let [x, y] = spread(count, 64, 65_535);
        assert!(x <= 65_535 && y <= 65_535);
        assert!(u64::from(x) * u64::from(y) * 64 >= count);
        assert!(u64::from(x) * u64::from(y) <= count.div_ceil(64) + u64::from(y));
    }
}
