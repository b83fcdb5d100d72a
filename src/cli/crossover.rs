//! `ripstop crossover`: the unit cell alone, over a grid of stretches.

use clap::ValueEnum;
use ripstop::case::{self, Case, Law};
use ripstop::kernels::crossover::{self, CellConstants, Equilibrium, LawKernel, Variant};
use ripstop::with_law;
use serde_json::{Map, Value, json};

use super::arguments::CrossoverArguments;
use super::failure::Failure;
use super::number::short;
use super::screen;
use super::table::{Align, Table};

/// Points in one grid at most.
const MAX_POINTS: usize = 1_000_000;

/// One solved cell.
struct Point {
    /// Λ of warp and weft [-].
    stretch: [f64; 2],
    cell: Equilibrium<f64>,
}

impl Point {
    /// The numbers of a point, in the order of the contract.
    fn numbers(&self) -> [(&'static str, f64); 11] {
        let cell = &self.cell;
        [
            ("warp_stretch", self.stretch[0]),
            ("weft_stretch", self.stretch[1]),
            ("warp_tension_n", cell.tension[0]),
            ("weft_tension_n", cell.tension[1]),
            ("contact_force_n", cell.force),
            ("warp_height_mm", cell.height[0] * 1e3),
            ("weft_height_mm", cell.height[1] * 1e3),
            ("warp_strain", cell.strain[0]),
            ("weft_strain", cell.strain[1]),
            ("iterations", cell.iterations),
            ("residual", cell.residual),
        ]
    }
}

/// Solves and prints the grid.
pub(crate) fn crossover(arguments: &CrossoverArguments) -> Result<(), Failure> {
    let mut sets = arguments.sets.clone();
    if let Some(law) = arguments.law.and_then(|law| law.to_possible_value()) {
        sets.push(format!("/fabric/crossover/law={:?}", law.get_name()));
    }
    let case = case::read(&arguments.case, &sets)?;
    let (warp, weft) = (arguments.warp_stretch.values(), arguments.weft_stretch.values());
    if warp.len() * weft.len() > MAX_POINTS {
        return Err(Failure::input(format!(
            "error: --warp-stretch, --weft-stretch\n  expected: at most {MAX_POINTS} points\n  found: {} × {}",
            warp.len(),
            weft.len()
        )));
    }
    let points = solve(&case, &warp, &weft);
    let text = if arguments.json {
        json_text(&case, &points)
    } else if arguments.csv {
        csv_text(&points)
    } else {
        table_text(&case, &points)
    };
    screen::print(&text)
}

fn solve(case: &Case, warp: &[f64], weft: &[f64]) -> Vec<Point> {
    let constants = CellConstants::new(&case.fabric);
    with_law!(Variant::of(&case.fabric.crossover), L => solve_as::<L>(case, &constants, warp, weft))
}

/// Every point from the heights at rest, so that none depends on another.
fn solve_as<L: LawKernel>(case: &Case, constants: &CellConstants<f64>, warp: &[f64], weft: &[f64]) -> Vec<Point> {
    let cell = CellConstants::<f64>::cast::<L>(constants);
    let rest = [cell.yarn[0].height, cell.yarn[1].height];
    let both = case.fabric.warp.present && case.fabric.weft.present;
    let at = |stretch: [f64; 2]| {
        let excess = stretch.map(|stretch| stretch - 1.0);
        Point { stretch, cell: crossover::solve::<f64, L>(&cell, excess, rest, both) }
    };
    warp.iter().flat_map(|&warp| weft.iter().map(move |&weft| at([warp, weft]))).collect()
}

fn law(case: &Case) -> &'static str {
    match case.fabric.crossover.law {
        Law::Published => "published",
        Law::Variational => "variational",
        Law::Kawabata => "kawabata",
    }
}

fn json_text(case: &Case, points: &[Point]) -> String {
    let object = |point: &Point| {
        let mut object = Map::from_iter(point.numbers().map(|(name, number)| (name.to_owned(), json!(number))));
        object.insert("iterations".to_owned(), json!(point.cell.iterations as u64));
        Value::Object(object)
    };
    let points: Vec<Value> = points.iter().map(object).collect();
    format!("{:#}\n", json!({ "law": law(case), "points": points }))
}

fn csv_text(points: &[Point]) -> String {
    let mut lines = Vec::new();
    for point in points {
        if lines.is_empty() {
            lines.push(point.numbers().map(|(name, _)| name.to_owned()).join(","));
        }
        lines.push(point.numbers().map(|(_, number)| format!("{number:?}")).join(","));
    }
    lines.join("\n") + "\n"
}

fn table_text(case: &Case, points: &[Point]) -> String {
    let fabric = &case.fabric;
    let heads = ["Λ warp", "Λ weft", "T warp N", "T weft N", "F N", "h warp mm", "h weft mm", "ε warp", "ε weft"];
    let mut columns = heads.map(|head| (head, Align::Right)).to_vec();
    columns.push(("", Align::Left));
    let mut table = Table::new(&columns);
    for point in points {
        let mut cells: Vec<String> =
            point.numbers().iter().take(heads.len()).map(|(_, number)| short(*number, 6)).collect();
        let broken = |i: usize| [&fabric.warp, &fabric.weft][i].present && point.cell.strain[i] >= limit(case, i);
        cells.push(match (broken(0), broken(1)) {
            (true, true) => "beyond failure of both".to_owned(),
            (true, false) => "beyond failure of the warp".to_owned(),
            (false, true) => "beyond failure of the weft".to_owned(),
            _ => String::new(),
        });
        table.row(cells);
    }
    format!("{}, {} law\n\n{table}", fabric.name, law(case))
}

/// Failure strain of warp (0) or weft (1) [-].
fn limit(case: &Case, yarn: usize) -> f64 {
    [&case.fabric.warp, &case.fabric.weft][yarn].failure_strain
}
