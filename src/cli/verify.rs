//! `ripstop verify`: the built-in verification table.

use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::output::Folder;
use ripstop::study::verify::stress::{self, Report, SceneNumbers, StressBackend, StressPlan, UnsoundScene};
use ripstop::study::verify::{self, Check};
use serde_json::{Value, json};

use super::failure::CommandFailure;
use super::progress::Bar;
use super::study_arguments::VerifyArguments;
use super::table::{Align, TextTable};
use super::{backend, interrupt, paint, screen};

/// Runs the table, or the stress scenes, and prints it; exit code 1 if a row fails.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), CommandFailure> {
    let interrupted = interrupt::watch()?;
    let report = if arguments.stress {
        stress(arguments, &interrupted)?
    } else {
        let chosen = backend::choose(&arguments.backend)?;
        chosen.note.iter().for_each(|note| screen::complain(note));
        Report { rows: verify::run(chosen.options(arguments.threads), &interrupted, &mut |_| {}), ..Report::default() }
    };
    let rows = &report.rows;
    let failed = rows.iter().filter(|row| !row.pass).count();
    let counts = format!("{} of {} rows pass", rows.len() - failed, rows.len());
    if arguments.json {
        let mut all = json!({ "pass": failed == 0, "rows": rows });
        if arguments.stress {
            all["unsound"] = report.found.iter().map(found_json).collect();
            let refused =
                |(machine, scene, why): &(&str, u64, String)| json!({"machine": machine, "scene": scene, "why": why});
            all["refused"] = report.refused.iter().map(refused).collect();
        }
        screen::print(&format!("{all:#}\n"))?;
    } else if arguments.markdown {
        screen::print(&verify::markdown(rows))?;
    } else {
        screen::print(&format!("{}\n{counts}\n", table(rows)))?;
        if arguments.out.is_none() {
            for found in &report.found {
                screen::print(&format!("\n{}, {}\n{:#}\n", found.machine, found.fault.what, found.case))?;
            }
        }
    }
    if interrupted.load(Ordering::Relaxed) {
        return Err(CommandFailure::interrupted("interrupted; rows after this are missing"));
    }
    if failed > 0 {
        return Err(CommandFailure::check(format!("error: verification: {counts}")));
    }
    Ok(())
}

/// Runs the stress scenes; the cases of those that are not sound go to the folder asked for.
fn stress(arguments: &VerifyArguments, interrupted: &AtomicBool) -> Result<Report, CommandFailure> {
    let (precisions, device) = backend::every(&arguments.backend)?;
    let folder = arguments.out.as_deref().map(|path| Folder::prepare_for(path, &[], &[])).transpose()?;
    let plan = StressPlan {
        machines: precisions
            .into_iter()
            .map(StressBackend::Cpu)
            .chain(device.as_ref().map(StressBackend::Gpu))
            .collect(),
        scenes: match arguments.alone.as_slice() {
            [] => SceneNumbers::First(arguments.scenes.into()),
            numbers => SceneNumbers::These(numbers.to_vec()),
        },
        steps: arguments.steps,
        seed: arguments.seed,
        threads: arguments.threads,
        list: arguments.alone.is_empty(),
    };
    let bar = Bar::new(!arguments.json);
    let report = stress::run(&plan, interrupted, &|name, done, of| bar.show_count(name, done, of, "scenes"));
    bar.clear();
    if let Some(folder) = folder {
        let names: Vec<String> = report.found.iter().map(UnsoundScene::file).collect();
        let cases = report.found.iter().map(|found| format!("{:#}\n", found.case));
        let texts: Vec<(&str, String)> = names.iter().map(String::as_str).zip(cases).collect();
        folder.put(&texts, &[])?;
    }
    Ok(report)
}

fn found_json(found: &UnsoundScene) -> Value {
    json!({
        "seed": found.seed,
        "scene": found.number,
        "machine": found.machine,
        "what": found.fault.what,
        "case": found.case,
    })
}

fn table(rows: &[Check]) -> TextTable {
    use Align::{Left, Right};
    let heads = [("", Left), ("what", Left), ("expected", Right), ("got", Right), ("tolerance", Right)];
    let mut table = TextTable::new(&heads);
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = row.group;
            table.group(group);
        }
        let mark = paint::mark(row.pass);
        table.row([&mark, &row.name, &row.expected, &row.got, &row.tolerance]);
    }
    table
}
