use super::*;

fn list(text: &str) -> Option<Vec<String>> {
    Factor::parse(text).ok().map(|factor| factor.values)
}

#[test]
fn lists_ranges_and_json_are_read() {
    assert_eq!(list("/pack/plies=1, 2,8"), Some(["1", "2", "8"].map(str::to_owned).to_vec()));
    assert_eq!(list("/a=0.1..0.3:0.1"), Some(["0.1", "0.2", "0.3"].map(str::to_owned).to_vec()));
    assert_eq!(list("/a=100..290:50").map(|values| values.len()), Some(4));
    assert_eq!(list("/a=[0,1],[2,3]"), Some(["[0,1]", "[2,3]"].map(str::to_owned).to_vec()));
    for wrong in ["a=1", "/a", "/a=", "/a=3..1:1", "/a=1..3:0", "/a=1..x", "/a=1..3"] {
        assert!(Factor::parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn a_grid_holds_every_combination_the_last_factor_fastest() {
    let factors = |texts: &[&str]| texts.iter().map(|text| Factor::parse(text).unwrap()).collect::<Vec<_>>();
    let points = grid(&factors(&["/a=1,2", "/b=x,y,z"])).unwrap();
    assert_eq!(points.iter().map(|point| point.join("")).collect::<Vec<_>>(), ["1x", "1y", "1z", "2x", "2y", "2z"]);
    let error = grid(&factors(&["/a=1..5000:1", "/b=1,2,3"])).unwrap_err().to_string();
    assert!(error.contains("at most 10000 points") && error.contains("15000 of them at /b"), "{error}");
}
