#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

fn row(text: &str, got: Value) -> Prediction {
    let value: f64 = text.parse().unwrap();
    let (text, tolerance, because) = (text.to_owned(), 0.005 * value, "a test");
    let expected = Expected::Number { text, value, tolerance, because };
    Prediction::judged("group", "name", expected, got, "source")
}

#[test]
fn a_number_holds_within_its_tolerance() {
    let near = row("2.18", json!(2.1849));
    assert_eq!((near.pass, near.got_text(), near.difference_text()), (Some(true), "2.18".into(), "+0.22 %".into()));
    for wrong in [json!(2.1910), json!(2.1690), json!(f64::NAN), Value::Null, json!("2.18")] {
        assert_eq!(row("2.18", wrong.clone()).pass, Some(false), "{wrong}");
    }
    assert_eq!(row("96.0", json!(95.999)).difference_text(), "0 %");
    let json = near.to_json();
    assert_eq!((&json["expected"], &json["got"], &json["pass"]), (&json!(2.18), &json!(2.1849), &json!(true)));
    assert_eq!(counts(&[near, row("1", json!(2.0))]), [1, 1, 0]);
}

#[test]
fn a_curve_is_not_judged_and_what_could_not_be_computed_has_failed() {
    let curve = Expected::CurveOnly("a curve".to_owned());
    let row = Prediction::judged("group", "name", curve, json!(96.31), "paper");
    assert_eq!((row.mark(), row.got_text(), row.difference_text()), ("", "96.3".into(), String::new()));
    assert_eq!((&row.to_json()["judged"], &row.to_json()["pass"]), (&json!(false), &Value::Null));
    let failed = Prediction::failed("group", "no memory".to_owned());
    assert_eq!((failed.mark(), failed.got_text()), ("FAIL", "no memory".into()));
    assert_eq!(counts(&[row, failed]), [0, 1, 1]);
}
