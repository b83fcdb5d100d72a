//! Two things that `ripstop diff` compares, to the files that it writes.

use std::path::{Path, PathBuf};

use ripstop::study::diff::{self, DiffOptions, DiffRequest, Input};

use super::{assert_told, folder, parts, write};

/// `--column`s at most.
const COLUMNS: usize = 4;

/// A line with `--within` and `--shift`, then a `--column` on every line; a curve; then another one, or `history.csv`,
/// `summary.json` and `case.json` of a run.
pub(crate) fn diff(bytes: &[u8]) {
    let folder = folder();
    let Some((request, inputs)) = lay_out(folder.path(), bytes) else { return };
    let (options, columns) = request;
    let request = match DiffRequest::new(options, &columns) {
        Ok(request) => request,
        Err(error) => return assert_told(&error.to_string()),
    };
    for inputs in [[0, 1], [1, 0]].map(|order| order.map(|at| &inputs[at])) {
        let read: Result<Vec<Input>, _> = inputs.iter().map(|path| diff::input::read(path, &request)).collect();
        match read.and_then(|inputs| diff::diff(inputs, &request)) {
            Ok(found) => shown(&found),
            Err(error) => assert_told(&error.to_string()),
        }
    }
}

/// Options, and columns.
pub(crate) type Asked = (DiffOptions, Vec<String>);

/// What is asked for, and where the inputs lie, once they are written to a folder.
pub(crate) fn lay_out(folder: &Path, bytes: &[u8]) -> Option<(Asked, [PathBuf; 2])> {
    let parts = parts(bytes);
    let [asked, first, rest @ ..] = parts.as_slice() else { return None };
    let asked = String::from_utf8_lossy(asked).into_owned();
    let (numbers, columns) = asked.split_once('\n').unwrap_or((&asked, ""));
    let mut numbers = numbers.split_whitespace().map(|number| number.parse::<f64>().ok().filter(|x| x.is_finite()));
    let options = DiffOptions {
        within: numbers.next().flatten().map(f64::abs),
        shift_us: numbers.next().flatten().unwrap_or_default(),
    };
    let columns = columns.lines().take(COLUMNS).map(str::to_owned).collect();
    let curve = folder.join("a.csv");
    write(&curve, first);
    let other = match rest {
        [] => curve.clone(),
        [other] => {
            write(&folder.join("b.csv"), other);
            folder.join("b.csv")
        }
        of_run => {
            for (name, bytes) in ["history.csv", "summary.json", "case.json"].iter().zip(of_run) {
                write(&folder.join("run").join(name), bytes);
            }
            folder.join("run")
        }
    };
    Some(((options, columns), [curve, other]))
}

fn shown(found: &diff::Diff) {
    let rows = diff::csv(found).lines().count();
    assert!(rows > 0, "no rows");
    assert!(diff::svg(found).contains("</svg>"));
    assert!(diff::html(found).contains("</html>"));
    assert!(diff::json(found).is_object());
    for pair in &found.pairs {
        pair.failures().for_each(|line| assert!(!line.contains('\n'), "{line}"));
        for row in &pair.curves {
            assert!(row.difference.largest.is_finite() && row.difference.rms >= 0.0, "{row:?}");
        }
    }
}
