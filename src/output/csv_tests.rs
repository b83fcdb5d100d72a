use super::number;

#[test]
fn numbers_read_back_and_stay_short() {
    for value in [0.1, -3.25e-20, 1.0 / 3.0, 6.02e23, 42.0, f64::MIN_POSITIVE] {
        assert_eq!(number(value).parse(), Ok(value));
    }
    assert_eq!(number(-0.0), "0");
    assert_eq!(number(400.0), "400");
    assert_eq!(number(f64::NAN), "NaN");
}
