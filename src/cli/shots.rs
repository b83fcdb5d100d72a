//! `ripstop shots`: many shots of a case.

use std::path::Path;

use ripstop::case::Case;
use ripstop::output::Folder;
use ripstop::output::number::short;
use ripstop::study::batch::{ShotOrder, order_case};
use ripstop::study::fit::{self, Fit};
use ripstop::study::interval::Bounds;
use ripstop::study::shots::{self, BatchProgress, ShotsRequest, ShotsResult};

use super::batch::{self, ShotBar};
use super::campaign_arguments::ShotsArguments;
use super::failure::CommandFailure;
use super::fit::text as fit_text;
use super::input::Source;
use super::run::{Print, RunArguments, shoot};
use super::{result, terminal};

/// Fires, prints and writes.
pub(crate) fn shots(arguments: &ShotsArguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let case = batch::case(&Source::open(&arguments.case)?, &arguments.batch)?;
    let seed = batch::seed(&arguments.batch, &case);
    let out = batch::out(arguments.out.as_deref(), &case, "shots");
    let request = ShotsRequest {
        count: arguments.count.unwrap_or(1),
        velocity: arguments.velocity.map(|velocities| velocities.0),
        until_width: arguments.batch.until_width,
        fit: arguments.batch.fit(),
    };
    if let Some(number) = arguments.only {
        let shot = alone(&case, seed, shots::order(&request, seed, number))?;
        return shoot(&run_arguments(arguments), &shot, &out.join(format!("shot-{number}")), &interrupted);
    }
    let chosen = batch::choose(&arguments.batch)?;
    let options = batch::options(&arguments.batch, &case, &chosen, &interrupted);
    let folder = Folder::prepare_for(&out, shots::FILES, &[case.path.as_path()])?;
    let mut bar = ShotBar::new(!arguments.batch.quiet);
    let mut show = |at: BatchProgress<'_>| bar.show("shots", at.done, at.of, v50(at.fit));
    let done = shots::run(&case, &request, &options, &folder, arguments.batch.resume, &mut show);
    bar.clear();
    let done = done.map_err(|error| batch::failure(error, &out))?;
    let print = Print::of(arguments.batch.json, arguments.batch.quiet);
    print.show(|| fit::json(&done.fit), || text(&case, &request, &done, folder.path()))
}

/// The estimate that a bar shows.
fn v50(fit: Option<&Fit>) -> Option<(f64, Bounds)> {
    let v50 = fit?.v50()?;
    Some((v50.value?, v50.bounds))
}

/// The case of one shot, to be run by itself. What the case expects of its nominal shot is not expected of this one.
fn alone(case: &Case, seed: u32, order: ShotOrder) -> Result<Case, CommandFailure> {
    let mut shot = order_case(case, seed, order)?;
    shot.expect.clear();
    shot.title = format!("{}, shot {}", case.title, order.shot);
    Ok(shot)
}

/// What `ripstop run` would be told.
fn run_arguments(arguments: &ShotsArguments) -> RunArguments {
    RunArguments {
        cases: vec![arguments.case.clone()],
        backend: arguments.batch.backend(),
        out: None,
        sets: Vec::new(),
        threads: arguments.batch.threads,
        no_skip: Vec::new(),
        no_report: false,
        frames: None,
        checkpoint_every: None,
        quiet: arguments.batch.quiet,
        json: arguments.batch.json,
    }
}

/// The whole text.
fn text(case: &Case, request: &ShotsRequest, done: &ShotsResult, folder: &Path) -> String {
    let mut out = format!("{}\n", case.title);
    let trusted = done.rows.iter().filter(|row| row.trust == "trust").count();
    let failed: Vec<_> = done.rows.iter().filter(|row| row.perforated().is_none()).collect();
    out += &fit_text(Path::new("shots"), &done.fit, None);
    out += &result::remarks("note", &shots::notes(case));
    if done.early {
        let width = short(100.0 * request.until_width.unwrap_or_default(), 3);
        out += &format!(
            "stopped after {} of {} shots: the interval is within ± {width} %\n",
            done.rows.len(),
            request.count
        );
    }
    out += &format!("trust: {trusted} of {} shots\n", done.rows.len());
    if let Some(first) = failed.first() {
        let reason = terminal::wrapped(&first.reason, 2).join("\n  ");
        out += &format!(
            "{}: {} shots without an outcome; shot {}:\n  {reason}\n",
            terminal::caution("look"),
            failed.len(),
            first.order.shot
        );
    }
    out += &batch::device_text(done.device);
    out + &result::files(folder, shots::FILES)
}
