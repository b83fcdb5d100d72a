//! Text of a case, changes by `--set`, and a fabric file, to a checked case and what follows from it.

use ripstop::case::{self, Case, CaseError};
use ripstop::model::Model;
use ripstop::output::checks::case_warnings;
use ripstop::run::Simulation;

use super::{assert_told, folder, parts, write};

/// Changes at most: more of them find nothing new.
const SETS: usize = 6;
/// Elements of a case that is computed for two steps; of one that becomes a model.
const COMPUTED: usize = 300;
const MODELLED: usize = 3000;

/// The case; then a change on every line; then the fabric file `fabrics/own.json`.
pub(crate) fn case(bytes: &[u8]) {
    let parts = parts(bytes);
    let changes = parts.get(1).map_or_else(String::new, |changes| String::from_utf8_lossy(changes).into_owned());
    let sets: Vec<String> = changes.lines().take(SETS).map(str::to_owned).collect();
    let read = match (std::str::from_utf8(parts[0]), parts.get(2)) {
        (Ok(text), None) => case::from_str("shot.json", text, &sets),
        (_, fabric) => {
            let folder = folder();
            let path = folder.path().join("shot.json");
            write(&path, parts[0]);
            write(&folder.path().join("fabrics/own.json"), fabric.unwrap_or(&&b"{}"[..]));
            case::read(&path, &sets)
        }
    };
    match read {
        Ok(case) => checked(case, &sets),
        Err(error) => well_formed(&error),
    }
}

fn well_formed(error: &CaseError) {
    for error in error.all() {
        for part in [&*error.file, &error.expected, &error.found] {
            assert!(!part.trim().is_empty() && !part.contains('\n'), "{error:?}");
        }
        assert!(
            !error.location.contains('\n') && error.help.as_ref().is_none_or(|help| !help.contains('\n')),
            "{error:?}"
        );
    }
    assert_told(&error.to_string());
}

/// What follows from a case that was taken.
fn checked(mut case: Case, sets: &[String]) {
    case.name_changes(sets);
    assert!(!case.name.contains(['/', '\\', '\0']) && case.name.len() < 200, "{}", case.name);
    assert!(!case::report(&case).is_empty());
    drop(case_warnings(&case));
    let elements: usize =
        case.layers().iter().map(|layer| layer.plies as usize * layer.counts().into_iter().product::<usize>()).sum();
    assert!(elements > 0 && case.elements() > 0, "{elements} of {}", case.elements());
    // The case as run is a case again, and the same one; memory alone may have become less.
    match case::from_str("again.json", &case.as_run.to_string(), &[]) {
        Ok(again) => assert_eq!(again.fields.len(), case.fields.len()),
        Err(error) => assert!(error.location == "/pack" && error.expected.contains("memory"), "{error}"),
    }
    if elements <= COMPUTED {
        if let Ok(mut simulation) = Simulation::<f64>::new(&case) {
            for _ in 0..2 {
                simulation.advance(&case);
            }
        }
    } else if elements <= MODELLED {
        Model::<f32>::part(&case).ok();
    }
}
