//! `ripstop crossover`: the unit cell alone, over a grid of stretches.

use std::path::PathBuf;

use clap::Args;
use ripstop::case::{self, Fabric};
use ripstop::model::unit_cell_curve;
use ripstop::model::unit_cell_curve::{CurveLaw, CurvePoint};
use ripstop::output::number::short;
use serde_json::{Map, Value, json};

use super::failure::CommandFailure;
use super::input::{LAWS, Stretches, one_of};
use super::terminal::{self, Align, TextTable};

/// Points in one grid at most.
const MAX_POINTS: usize = 1_000_000;

/// `ripstop crossover`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop crossover cases/s720-1ply-155.json --warp-stretch 1:1.05:26 --weft-stretch 1
  ripstop crossover shot.json --warp-stretch 1.01 --weft-stretch 1 --law kawabata --json")]
pub(crate) struct CrossoverArguments {
    /// Case file; only its fabric matters
    #[arg(value_name = "CASE.json")]
    case: PathBuf,
    /// Fabric stretch along warp: one value, or first:last:count
    #[arg(long, value_name = "A[:B:N]")]
    warp_stretch: Stretches,
    /// Fabric stretch along weft: one value, or first:last:count
    #[arg(long, value_name = "C[:D:N]")]
    weft_stretch: Stretches,
    /// Unit-cell law [default: the case's]
    #[arg(long, value_parser = one_of(LAWS))]
    law: Option<CurveLaw>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    sets: Vec<String>,
    /// Print JSON, every digit
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print CSV, every digit
    #[arg(long)]
    csv: bool,
}

/// Solves and prints the grid.
pub(crate) fn crossover(arguments: &CrossoverArguments) -> Result<(), CommandFailure> {
    let fabric = case::read(&arguments.case, &arguments.sets)?.fabric;
    let law = arguments.law.unwrap_or_else(|| fabric.crossover.law.into());
    let (warp, weft) = (&arguments.warp_stretch.0, &arguments.weft_stretch.0);
    if warp.len() * weft.len() > MAX_POINTS {
        let [expected, found] = [format!("at most {MAX_POINTS} points"), format!("{} × {}", warp.len(), weft.len())];
        return Err(CommandFailure::expected("--warp-stretch, --weft-stretch", expected, found));
    }
    let points = unit_cell_curve::solve_with(&fabric, law, warp, weft);
    terminal::print(&match (arguments.json, arguments.csv) {
        (true, _) => json_text(law, &points),
        (_, true) => csv_text(&points),
        _ => table_text(&fabric, law, &points),
    })
}

/// Word of a law on the command line.
fn word(law: CurveLaw) -> &'static str {
    LAWS.iter().find(|choice| choice.2 == law).map_or("", |choice| choice.0)
}

fn json_text(law: CurveLaw, points: &[CurvePoint]) -> String {
    let object = |point: &CurvePoint| {
        let mut object = Map::from_iter(point.numbers().map(|(name, number)| (name.to_owned(), json!(number))));
        object.insert("iterations".to_owned(), json!(point.cell.iterations as u64));
        Value::Object(object)
    };
    let points: Vec<Value> = points.iter().map(object).collect();
    format!("{:#}\n", json!({ "law": word(law), "points": points }))
}

fn csv_text(points: &[CurvePoint]) -> String {
    let heading = points.first().map(|point| point.numbers().map(|(name, _)| name.to_owned()).join(","));
    let rows = points.iter().map(|point| point.numbers().map(|(_, number)| format!("{number:?}")).join(","));
    heading.into_iter().chain(rows).map(|line| line + "\n").collect()
}

fn table_text(fabric: &Fabric, law: CurveLaw, points: &[CurvePoint]) -> String {
    let heads = ["Λ warp", "Λ weft", "T warp N", "T weft N", "F N", "h warp mm", "h weft mm", "ε warp", "ε weft"];
    let columns: Vec<_> = heads.map(|head| (head, Align::Right)).into_iter().chain([("", Align::Left)]).collect();
    let mut table = TextTable::new(&columns);
    for point in points {
        let broken = [0, 1].map(|yarn| point.is_broken(fabric, yarn));
        let note = match broken {
            [true, true] => "beyond failure of both",
            [true, false] => "beyond failure of the warp",
            [false, true] => "beyond failure of the weft",
            _ => "",
        };
        let numbers = point.numbers().map(|(_, number)| short(number, 6));
        table.row(numbers.into_iter().take(heads.len()).chain([note.to_owned()]));
    }
    format!("{}, {} law\n\n{table}", fabric.name, word(law))
}
