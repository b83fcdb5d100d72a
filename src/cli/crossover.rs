//! `ripstop crossover`: the unit cell alone, over a grid of stretches.

use ripstop::case::{self, Fabric};
use ripstop::model::unit_cell_curve::{self, CurveLaw, CurvePoint};
use ripstop::output::number::short;
use serde_json::{Map, Value, json};

use super::arguments::CrossoverArguments;
use super::choice::LAWS;
use super::failure::CommandFailure;
use super::screen;
use super::table::{Align, TextTable};

/// Points in one grid at most.
const MAX_POINTS: usize = 1_000_000;

/// Solves and prints the grid.
pub(crate) fn crossover(arguments: &CrossoverArguments) -> Result<(), CommandFailure> {
    let fabric = case::read(&arguments.case, &arguments.sets)?.fabric;
    let law = arguments.law.unwrap_or_else(|| fabric.crossover.law.into());
    let (warp, weft) = (arguments.warp_stretch.values(), arguments.weft_stretch.values());
    if warp.len() * weft.len() > MAX_POINTS {
        let [expected, found] = [format!("at most {MAX_POINTS} points"), format!("{} × {}", warp.len(), weft.len())];
        return Err(CommandFailure::expected("--warp-stretch, --weft-stretch", expected, found));
    }
    let points = unit_cell_curve::solve_with(&fabric, law, &warp, &weft);
    let text = if arguments.json {
        json_text(law, &points)
    } else if arguments.csv {
        csv_text(&points)
    } else {
        table_text(&fabric, law, &points)
    };
    screen::print(&text)
}

/// The word of a law.
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
    let mut lines = Vec::new();
    for point in points {
        if lines.is_empty() {
            lines.push(point.numbers().map(|(name, _)| name.to_owned()).join(","));
        }
        lines.push(point.numbers().map(|(_, number)| format!("{number:?}")).join(","));
    }
    lines.join("\n") + "\n"
}

fn table_text(fabric: &Fabric, law: CurveLaw, points: &[CurvePoint]) -> String {
    let heads = ["Λ warp", "Λ weft", "T warp N", "T weft N", "F N", "h warp mm", "h weft mm", "ε warp", "ε weft"];
    let mut columns = heads.map(|head| (head, Align::Right)).to_vec();
    columns.push(("", Align::Left));
    let mut table = TextTable::new(&columns);
    for point in points {
        let mut cells: Vec<String> =
            point.numbers().iter().take(heads.len()).map(|(_, number)| short(*number, 6)).collect();
        let broken = |yarn: usize| point.is_broken(fabric, yarn);
        cells.push(match (broken(0), broken(1)) {
            (true, true) => "beyond failure of both".to_owned(),
            (true, false) => "beyond failure of the warp".to_owned(),
            (false, true) => "beyond failure of the weft".to_owned(),
            _ => String::new(),
        });
        table.row(cells);
    }
    format!("{}, {} law\n\n{table}", fabric.name, word(law))
}
