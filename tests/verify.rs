//! Every shipped case of `cases/verify` and `cases/stress` meets its own `expect` block, and an expectation can fail.
//! In single precision they run in `tests/cli`, by `ripstop verify`.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use ripstop::run::{self, Options};

use crate::scene::{builtin, checked, run, shipped};

/// Without viscosity tension rings behind a shock: between compressible crossovers waves run too fast and yarns break, and a slack strip
/// that is pulled taut becomes unstable.
const RINGS: [&str; 3] = ["strip-compressible-155", "strip-compressible-250", "strip-pulled-weft-free"];

/// Names of the shipped cases of a folder.
pub(crate) fn names(folder: &str) -> Vec<String> {
    let files = std::fs::read_dir(Path::new("cases").join(folder)).unwrap().map(|file| file.unwrap().path());
    files.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn every_case_meets_its_expectations() {
    for folder in ["verify", "stress"] {
        for name in names(folder) {
            let case = shipped(&format!("cases/{folder}/{name}.json"), &[]);
            let run = run::run(&case, Options::default().threads(2), &AtomicBool::new(false), &mut ()).unwrap();
            assert!(run.divergence.is_none(), "{name}: {:?}", run.divergence);
            let checked = checked(&case, &run);
            assert!(!checked.is_empty(), "{name} states nothing");
            let failed: Vec<_> = checked.iter().filter(|check| check["pass"] != true).collect();
            assert!(failed.is_empty(), "{name}: {failed:?}");
        }
    }
}

#[test]
fn waves_meet_their_expectations_with_the_papers_numerics() {
    for name in names("verify").iter().filter(|name| !RINGS.contains(&name.as_str())) {
        let case = builtin(&format!("cases/verify/{name}.json"), &[]);
        let failed: Vec<_> = checked(&case, &run(&case)).into_iter().filter(|check| check["pass"] != true).collect();
        assert!(failed.is_empty(), "{name}: {failed:?}");
    }
}

#[test]
fn compressible_crossovers_need_shock_viscosity() {
    for name in &RINGS[..2] {
        let case = builtin(&format!("cases/verify/{name}.json"), &[]);
        assert!(checked(&case, &run(&case)).iter().all(|check| check["pass"] == false), "{name}");
    }
}
