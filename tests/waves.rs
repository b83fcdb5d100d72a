//! Every verification scene keeps its own `expect` block, with the paper's numerics too, and an expectation can fail.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use ripstop::run::Options;
use ripstop::study::verify;

use crate::scene::{builtin, checked, run};

fn scenes() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir("cases/verify").unwrap().map(|f| f.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "json"));
    files.sort();
    files
}

#[test]
fn every_verification_scene_meets_its_expectations() {
    let files = scenes();
    assert!(files.len() >= 9, "{files:?}");
    for file in files {
        let case = builtin(file.to_str().unwrap(), &[]);
        assert!(!case.expect.is_empty(), "{} promises nothing", file.display());
        let run = run(&case);
        // Without viscosity tension rings behind a shock between compressible crossovers: waves run too fast, yarns break.
        let rings = file.to_str().unwrap().contains("strip-compressible");
        for c in checked(&case, &run) {
            assert!(c.pass != rings, "{}: {c:?}", file.display());
        }
    }
}

#[test]
fn the_strip_goes_red_when_its_physics_is_wrong() {
    // Without the crossover the same strip is stiffer: every measured wave quantity must notice.
    let wrong =
        builtin("cases/verify/strip-crimped-155.json", &["/fabric/warp/crimp=0.001", "/fabric/weft/crimp=0.0005"]);
    let checked = checked(&wrong, &run(&wrong));
    assert_eq!(checked.len(), 3);
    assert!(checked.iter().all(|c| !c.pass), "{checked:?}");
}

#[test]
fn the_verification_table_holds_every_scene_and_passes() {
    let options = Options::default().threads(2);
    let rows = verify::run(options, &AtomicBool::new(false), &mut |_| {});
    let failed: Vec<_> = rows.iter().filter(|r| !r.pass).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(rows.len() > 60, "{}", rows.len());
    for file in scenes() {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(rows.iter().any(|r| r.name.starts_with(&name)), "{name} is not in the table");
    }
}
