//! Table I of the paper: fabrics given by its numbers are pulled as a specimen would be, and must show them again.

use serde_json::{Value, json};

use super::{Expected, Row};
use crate::case::{self, CaseError, Fabric, builtin_fabric};
use crate::verify::unit_cell::solve;

const TABLE: &str = "paper, Table I";

/// A column of the table as printed.
struct Panel {
    name: &'static str,
    file: &'static str,
    /// [GPa]
    modulus: &'static str,
    /// Warp and weft, as the cases take them [%].
    crimp: [&'static str; 2],
    /// [threads/inch]
    count: f64,
    /// [g/m²]
    areal_density: &'static str,
}

const PANELS: [Panel; 2] = [
    Panel {
        name: "S-720",
        file: "fabrics/s-720.json",
        modulus: "96.0",
        crimp: ["2.18", "1.39"],
        count: 20.0,
        areal_density: "255.2",
    },
    Panel {
        name: "S-728",
        file: "fabrics/s-728.json",
        modulus: "96.0",
        crimp: ["1.76", "0.94"],
        count: 17.0,
        areal_density: "231.1",
    },
];

impl Panel {
    fn group(&self) -> String {
        format!("Kevlar 129 {}", self.name)
    }
}

/// Every row of the table that a computed specimen shows.
pub(super) fn rows() -> Vec<Row> {
    PANELS.iter().flat_map(|panel| panel_rows(panel).unwrap_or_else(|error| vec![unread(panel, &error)])).collect()
}

fn unread(panel: &Panel, error: &CaseError) -> Row {
    Row::failed(&panel.group(), error.to_string())
}

fn panel_rows(panel: &Panel) -> Result<Vec<Row>, CaseError> {
    let fabric = without_areal_density(panel)?;
    let group = panel.group();
    let row = |what: &str, expected: Expected, got: f64| Row::number(&group, what, expected, got, TABLE);
    let mut rows = Vec::new();
    let crimps = ["maximum crimp, where a strip grows taut [%]", "minimum crimp, where a strip grows taut [%]"];
    for (yarn, what) in crimps.into_iter().enumerate() {
        let taut = onset(&fabric, yarn);
        rows.push(row(what, Expected::printed(panel.crimp[yarn]), 100.0 * taut));
    }
    let slope = "fibre modulus, slope of a taut strip [GPa]";
    rows.push(row(slope, Expected::printed(panel.modulus), modulus(&fabric)));
    let areal =
        printed_within(panel.areal_density, 0.5 / panel.count, "the count is printed in whole threads per inch");
    let weighed = "areal density from denier, count and crimp [g/m²]";
    rows.push(row(weighed, areal, 1e3 * fabric.areal_density));
    Ok(rows)
}

/// A number that is right within a fraction.
fn printed_within(text: &str, fraction: f64, because: &'static str) -> Expected {
    let value: f64 = text.parse().unwrap_or(f64::NAN);
    Expected::Number { text: text.to_owned(), value, tolerance: fraction * value, because }
}

/// The fabric as the case reader completes it when its weight is not given.
fn without_areal_density(panel: &Panel) -> Result<Fabric, CaseError> {
    let text = builtin_fabric(panel.file).unwrap_or_default();
    let mut fabric: Value = serde_json::from_str(text).unwrap_or_default();
    if let Some(keys) = fabric.as_object_mut() {
        keys.remove("areal_density_g_m2");
        keys.remove("sources");
    }
    let pack = json!({ "width_mm": 25, "height_mm": 25 });
    let case = json!({ "title": panel.name, "fabric": fabric, "pack": pack, "solver": { "end_time_us": 1 } });
    Ok(case::from_str(panel.name, &case.to_string(), &[])?.fabric)
}

/// Tension of a yarn when a strip is stretched along it by so much and free across [N].
fn tension(fabric: &Fabric, yarn: usize, stretch: f64) -> f64 {
    // Across it the strip has drawn in so far that the other yarn hangs slack.
    let mut along = [-0.1; 2];
    along[yarn] = stretch;
    solve(fabric, along).tension[yarn]
}

/// Stretch of a strip at which its yarns begin to carry [-].
fn onset(fabric: &Fabric, yarn: usize) -> f64 {
    let (mut slack, mut taut) = (0.0, 0.1);
    for _ in 0..60 {
        let middle = 0.5 * (slack + taut);
        if tension(fabric, yarn, middle) > 0.0 {
            taut = middle;
        } else {
            slack = middle;
        }
    }
    taut
}

/// Slope of tension over section and strain of a taut warp [GPa].
fn modulus(fabric: &Fabric) -> f64 {
    let start = onset(fabric, 0);
    let section = fabric.warp.linear_density / fabric.fibre_density;
    let [one, two] = [0.01, 0.02].map(|more| tension(fabric, 0, start + more));
    // Strain is of the yarn's own length, which the strip reaches as it grows taut.
    1e-9 * (two - one) / section / (0.01 / (1.0 + start))
}
