//! Every shipped case of `cases/verify` and `cases/stress` meets its own `expect` block, and an expectation can fail.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use ripstop::run::{Options, Precision};
use ripstop::study::verify::{self, CASES};
use serde_json::Value;

use crate::scene::{builtin, checked, run};

/// Without viscosity tension rings behind a shock: between compressible crossovers waves run too fast and yarns break, and a slack strip
/// that is pulled taut becomes unstable.
const RINGS: [&str; 3] =
    ["verify/strip-compressible-155", "verify/strip-compressible-250", "verify/strip-pulled-weft-free"];

/// Expectations of a case that do not hold.
fn failed(case: (&str, &str), precision: Precision) -> Vec<Value> {
    let options = Options::default().threads(2).precision(precision);
    let checks =
        verify::check(case, options, &AtomicBool::new(false), &mut ()).unwrap_or_else(|e| panic!("{}: {e}", case.0));
    assert!(!checks.is_empty(), "{} states nothing", case.0);
    checks.into_iter().filter(|check| check["pass"] != true).collect()
}

#[test]
fn every_case_of_the_folders_is_built_in() {
    for folder in ["verify", "stress"] {
        let files = std::fs::read_dir(Path::new("cases").join(folder)).unwrap().map(|file| file.unwrap().path());
        let mut files: Vec<String> =
            files.map(|file| format!("{folder}/{}", file.file_stem().unwrap().to_str().unwrap())).collect();
        let mut built_in: Vec<&str> = CASES.iter().map(|case| case.0).filter(|name| name.starts_with(folder)).collect();
        files.sort();
        built_in.sort_unstable();
        assert_eq!(files, built_in);
    }
}

#[test]
fn every_case_meets_its_expectations() {
    for case in CASES {
        assert_eq!(failed(*case, Precision::F64), [Value::Null; 0], "{}", case.0);
    }
}

#[test]
fn hard_scenes_meet_their_expectations_in_single_precision() {
    for case in CASES.iter().filter(|case| case.0.starts_with("stress")) {
        assert_eq!(failed(*case, Precision::F32), [Value::Null; 0], "{}", case.0);
    }
}

#[test]
fn waves_meet_their_expectations_with_the_papers_numerics() {
    for (name, _) in CASES.iter().filter(|case| case.0.starts_with("verify") && !RINGS.contains(&case.0)) {
        let case = builtin(&format!("cases/{name}.json"), &[]);
        let failed: Vec<_> = checked(&case, &run(&case)).into_iter().filter(|check| check["pass"] == false).collect();
        assert!(failed.is_empty(), "{name}: {failed:?}");
    }
}

#[test]
fn compressible_crossovers_need_shock_viscosity() {
    for name in &RINGS[..2] {
        let case = builtin(&format!("cases/{name}.json"), &[]);
        assert!(checked(&case, &run(&case)).iter().all(|check| check["pass"] == false), "{name}");
    }
}

#[test]
fn the_strip_goes_red_when_its_physics_is_wrong() {
    // Without the crossover the same strip is stiffer: every measured wave quantity must notice.
    let wrong =
        builtin("cases/verify/strip-crimped-155.json", &["/fabric/warp/crimp=0.001", "/fabric/weft/crimp=0.0005"]);
    let checked = checked(&wrong, &run(&wrong));
    assert_eq!(checked.len(), 3);
    assert!(checked.iter().all(|check| check["pass"] == false), "{checked:?}");
}
