//! `ripstop sweep`: shots or a V50 at many points.

use std::path::Path;

use ripstop::case::CaseError;
use ripstop::output::Folder;
use ripstop::output::number::short;
use ripstop::study::StudyError;
use ripstop::study::shots::ShotsRequest;
use ripstop::study::sweep::factor::{Factor, grid};
use ripstop::study::sweep::{self, SweepOf, SweepRequest, SweepResult};
use ripstop::study::v50::V50Request;

use super::batch;
use super::campaign_arguments::{SweepArguments, SweepKind};
use super::failure::CommandFailure;
use super::input::Source;
use super::run::Print;
use super::terminal::{self, Align, Bar, TextTable};

/// Realisations, and half the width of an interval over V50, where nothing is asked for.
const COUNT: u32 = 64;
const WIDTH: f64 = 0.02;
/// Rows that are printed at most.
const MAX_ROWS: usize = 60;

/// Runs, prints and writes.
pub(crate) fn sweep(arguments: &SweepArguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let source = Source::open(&arguments.case)?;
    let case = batch::case(&source, &arguments.batch)?;
    let request = request(arguments, &source)?;
    let chosen = batch::choose(&arguments.batch)?;
    let options = batch::options(&arguments.batch, &case, &chosen, &interrupted);
    let out = batch::out(arguments.out.as_deref(), &case, "sweep");
    let folder = Folder::prepare_for(&out, sweep::FILES, &[case.path.as_path()])?;
    let bar = Bar::new(!arguments.batch.quiet);
    let count = request.points.len();
    let show = |done: usize| bar.show_count("sweep", done, count, "points");
    let done = sweep::run(&request, &options, &folder, arguments.batch.resume, &case.title, &show);
    bar.clear();
    let done = done.map_err(|error| batch::failure(error, &out))?;
    let print = Print::of(arguments.batch.json, arguments.batch.quiet);
    print.show(|| sweep::json(&request, &done), || text(&case.title, &request, &done, folder.path()))
}

/// The points, each with its case.
fn request(arguments: &SweepArguments, source: &Source<'_>) -> Result<SweepRequest, CommandFailure> {
    let factors = arguments.over.iter().map(|text| Factor::parse(text)).collect::<Result<Vec<_>, StudyError>>()?;
    let points = grid(&factors)?;
    let mut cases = Vec::new();
    for point in &points {
        let over = factors.iter().zip(point).map(|(factor, value)| format!("{}={value}", factor.pointer));
        let sets: Vec<String> = arguments.batch.sets.iter().cloned().chain(over).collect();
        let case = source.case(&sets).map_err(|error| of_over(error, &factors))?;
        let of = match arguments.run {
            SweepKind::Shots => SweepOf::Shots(ShotsRequest {
                count: arguments.count.unwrap_or(1),
                velocity: None,
                until_width: arguments.batch.until_width,
                fit: arguments.batch.fit(),
            }),
            SweepKind::V50 => SweepOf::V50(V50Request {
                count: arguments.count.unwrap_or(COUNT),
                until_width: arguments.batch.until_width.or(arguments.count.is_none().then_some(WIDTH)),
                bracket: arguments.bracket,
                // Points are compared with each other, all on the mesh of their case.
                refined: 0,
                level: arguments.batch.level,
            }),
        };
        cases.push((case, of));
    }
    Ok(SweepRequest { factors, level: arguments.batch.level, points, cases })
}

/// An error of a value of `--over`, which is a change of the case like those of `--set`.
fn of_over(mut error: CaseError, factors: &[Factor]) -> CaseError {
    let of_set = error.of_set();
    if let Some(Factor { pointer, .. }) = factors.iter().find(|factor| of_set == Some(&factor.pointer)) {
        error.location = format!("--over {pointer}");
        if error.found.starts_with("a list") {
            let help = format!("values stand without brackets: --over {pointer}=1,2");
            error.help.get_or_insert(help);
        }
    }
    error.next = error.next.map(|next| Box::new(of_over(*next, factors)));
    error
}

/// The whole text.
fn text(title: &str, request: &SweepRequest, results: &SweepResult, folder: &Path) -> String {
    use Align::{Left, Right};
    let names = request.factors.iter().map(Factor::name).chain(request.columns().iter().copied());
    let heads: Vec<(&str, Align)> = names.map(|name| (name, Right)).chain([("", Left)]).collect();
    let mut table = TextTable::new(&heads);
    for (values, result) in request.points.iter().zip(&results.points).take(MAX_ROWS) {
        let numbers =
            result.numbers.iter().map(|number| number.map_or_else(|| "-".to_owned(), |number| short(number, 4)));
        let reason: String = result.reason.chars().take(40).collect();
        table.row(values.iter().cloned().chain(numbers).chain([reason]));
    }
    let more = results.points.len().saturating_sub(MAX_ROWS);
    let more = if more > 0 { format!("… and {more} more\n") } else { String::new() };
    format!(
        "{title}\n\n{table}{more}{}\n{}  {}\n  {}, points/\n",
        batch::device_text(results.device),
        terminal::heading("files"),
        folder.display(),
        sweep::FILES.join(", ")
    )
}
