use super::*;

fn list(text: &str) -> Option<Vec<String>> {
    match Factor::parse(text).ok()?.values {
        Values::List(values) => Some(values),
        Values::Between(_) => None,
    }
}

#[test]
fn lists_ranges_and_json_are_read() {
    assert_eq!(list("/pack/plies=1, 2,8"), Some(["1", "2", "8"].map(str::to_owned).to_vec()));
    assert_eq!(list("/a=0.1..0.3:0.1"), Some(["0.1", "0.2", "0.3"].map(str::to_owned).to_vec()));
    assert_eq!(list("/a=100..290:50").map(|values| values.len()), Some(4));
    assert_eq!(list("/a=[0,1],[2,3]"), Some(["[0,1]", "[2,3]"].map(str::to_owned).to_vec()));
    for wrong in ["a=1", "/a", "/a=", "/a=3..1:1", "/a=1..3:0", "/a=1..x"] {
        assert!(Factor::parse(wrong).is_err(), "{wrong}");
    }
}
