//! `ripstop bench --objectivity`: how far results depend on what is numerical.

use std::path::Path;
use std::time::Instant;

use ripstop::output::Folder;
use ripstop::study::bench::objectivity::{
    self, ObjectivityPlan, ObjectivityResult, ObjectivityRow, VariedAxis, report,
};
use serde_json::Value;

use super::failure::CommandFailure;
use super::progress::Bar;
use super::study_arguments::BenchArguments;
use super::table::{Align, TextTable};
use super::{bench, interrupt, screen, studies};
use ripstop::output::number::{fixed, short};

/// What is written.
const FILES: [&str; 1] = ["objectivity.json"];
/// Width of the bracket at which bisection ends, over the limit: half of what the time step is allowed.
const WIDTH: f64 = 0.005;

/// Measures a case, writes `objectivity.json` and says which figures are met.
pub(crate) fn objectivity(arguments: &BenchArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let interrupted = interrupt::watch()?;
    let subjects = bench::subjects(arguments)?;
    let [subject] = subjects.as_slice() else {
        let failure = CommandFailure::expected("bench --objectivity", "one case", subjects.len());
        return Err(failure.help("run them one after the other"));
    };
    let read: Vec<&Path> = arguments.cases.iter().map(|path| path.as_path()).collect();
    let folder = Folder::prepare_for(&arguments.out, &FILES, &read)?;
    let threads = studies::threads(arguments.threads);
    let plan = ObjectivityPlan { threads, quick: arguments.quick, width: WIDTH };
    let bar = Bar::new(!arguments.quiet);
    let measured = objectivity::measure(subject, plan, &interrupted, &|done, of| bar.show_count("", done, of, "parts"));
    bar.clear();
    let measured = match measured {
        Ok(measured) => measured,
        Err(error) => {
            folder.abandon();
            return Err(bench::failed(subject, error));
        }
    };
    let json = report::json(&measured, plan, start.elapsed().as_secs_f64());
    let written = folder.put(&[(FILES[0], format!("{json:#}\n"))], &FILES);
    if arguments.json {
        screen::print(&format!("{json:#}\n"))?;
    } else if arguments.markdown {
        screen::print(&report::markdown(&json))?;
    } else if !arguments.quiet {
        screen::print(&text(&measured, &json))?;
        if let Ok(names) = &written {
            screen::print(&format!("files  {}: {}\n", folder.path().display(), names.join(", ")))?;
        }
    }
    written?;
    verdict(&measured, &folder)
}

/// Both tables.
fn text(measured: &ObjectivityResult, json: &Value) -> String {
    let [settings, figures] = [settings(measured), figures(json)];
    format!("{}\n\n{settings}\n{figures}\n", measured.case.title)
}

/// What every setting gave.
fn settings(measured: &ObjectivityResult) -> TextTable {
    use Align::{Left, Right};
    let mut table = TextTable::new(&[
        ("varied", Left),
        ("", Left),
        ("limit m/s", Right),
        ("1.5 × limit: left m/s", Right),
        ("mean of many m/s", Right),
        ("± one shot", Right),
        ("before failure", Right),
        ("first failure µs", Right),
        ("shots", Right),
        ("", Left),
    ]);
    let mut axis = VariedAxis::Reference;
    for row in &measured.rows {
        let head = if row.setting.axis == axis && axis != VariedAxis::Reference { "" } else { row.setting.axis.name() };
        axis = row.setting.axis;
        table.row(cells(head, row));
    }
    table
}

fn cells(head: &str, row: &ObjectivityRow) -> [String; 10] {
    let number = |value: Option<f64>, decimals: usize| value.map_or_else(|| "-".to_owned(), |v| fixed(v, decimals));
    let limit = row.limit.map_or_else(
        || "-".to_owned(),
        |limit| format!("{} ± {}", fixed(limit.middle(), 1), fixed(limit.middle() - limit.stopped, 1)),
    );
    let (mean, deviation) = row.scatter.map_or_else(
        || ("-".to_owned(), "-".to_owned()),
        |s| (format!("{} ± {}", fixed(s.mean, 1), fixed(s.error(), 1)), fixed(s.deviation, 1)),
    );
    let note = match (row.shots.undecided, row.shots.unstable) {
        (0, 0) => String::new(),
        (undecided, 0) => format!("{undecided} undecided"),
        (undecided, unstable) => format!("{undecided} undecided, {unstable} unstable"),
    };
    let before = row.before_failure.map_or_else(|| "-".to_owned(), |part| format!("{} %", short(part * 100.0, 2)));
    [
        head.to_owned(),
        row.setting.name.clone(),
        limit,
        number(row.residual, 1),
        mean,
        deviation,
        before,
        number(row.first_failure.map(|time| time * 1e6), 1),
        row.shots.all.to_string(),
        note,
    ]
}

/// What is asked, and what was got.
fn figures(json: &Value) -> TextTable {
    use Align::{Left, Right};
    let mut table =
        TextTable::new(&[("", Left), ("quantity", Left), ("varied", Left), ("allowed", Right), ("got", Right)]);
    let percent = |value: &Value| value.as_f64().map_or_else(|| "-".to_owned(), |v| format!("{} %", fixed(v, 2)));
    for figure in json["figures"].as_array().into_iter().flatten() {
        let mark = if figure["met"] == true { "met" } else { "MISSED" };
        let words = |key: &str| figure[key].as_str().unwrap_or_default().to_owned();
        table.row([
            mark.to_owned(),
            words("quantity"),
            words("varied"),
            percent(&figure["allowed_percent"]),
            percent(&figure["got_percent"]),
        ]);
    }
    table
}

/// What the exit code says.
fn verdict(measured: &ObjectivityResult, folder: &Folder) -> Result<(), CommandFailure> {
    if measured.interrupted {
        return Err(CommandFailure::interrupted(format!(
            "interrupted; what was measured until then: {}",
            folder.path().display()
        )));
    }
    let missed = report::figures(measured).into_iter().filter(|figure| !figure.met()).count();
    if missed > 0 {
        return Err(CommandFailure::check(format!("error: objectivity: {missed} figures are missed")));
    }
    Ok(())
}
