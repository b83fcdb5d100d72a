//! Measured limits beside computed ones: rows of `cases/measured/limits.json`, for yarns as published and as woven.
//!
//! `cargo run --release --example measured [PART OF A NAME]` computes the rows, or those with that part in their name, and writes what
//! it found into that file, into the book and its picture. All rows take hours on two cores, for packs of up to 62 plies are among them.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::thread::available_parallelism;

use ripstop::case::{self, Case};
use ripstop::output::plot::{self, Plot};
use ripstop::output::{Folder, write_whole};
use ripstop::run::Precision;
use ripstop::study::batch::BatchOptions;
use ripstop::study::v50::{self, V50Request};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Folder of the rows.
const FOLDER: &str = "cases/measured";
/// Page of the book, and where its table stands.
const PAGE: &str = "docs/src/validation.md";
const START: &str = "<!-- generated: measured limits -->\n";
const END: &str = "<!-- /generated -->";
/// Its picture.
pub(crate) const PICTURE: &str = "docs/src/measured.svg";
/// Width of a bracket over its lower end.
const BRACKET: f64 = 0.02;

/// A measurement, and the limits computed for it.
#[derive(Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) name: String,
    /// Case file, from the folder of the rows, and its changes by pointer.
    case: String,
    set: Map<String, Value>,
    /// `v50`: a limit that was shot; `curve`: a limit on a curve through shots; `stopped`, `perforated`: one shot.
    kind: String,
    /// Limit or velocity of the shot [m/s].
    measured_m_s: f64,
    source: String,
    read: String,
    /// Highest stop and lowest perforation [m/s], of yarns as published and as woven.
    #[serde(default)]
    pub(crate) computed_m_s: [Option<[f64; 2]>; 2],
}

impl Row {
    /// Case of this row with that part of the published failure strain.
    ///
    /// # Errors
    /// When the case does not allow it.
    pub(crate) fn case(&self, retention: f64) -> Result<Case, Box<dyn Error>> {
        let mut sets: Vec<String> = self.set.iter().map(|(pointer, value)| format!("{pointer}={value}")).collect();
        sets.extend(["warp", "weft"].map(|yarn| format!("/fabric/{yarn}/strength_retention={retention}")));
        Ok(case::read(&Path::new(FOLDER).join(&self.case), &sets)?)
    }

    fn limit(&self, retention: f64) -> Result<[f64; 2], Box<dyn Error>> {
        let threads = available_parallelism()?.get();
        let (interrupt, folder) = (AtomicBool::new(false), tempfile::TempDir::new()?);
        let options = BatchOptions {
            seed: 0,
            threads,
            threads_per_shot: threads,
            precision: Precision::F64,
            device: None,
            interrupt: &interrupt,
            resume: false,
            progress: &|_| {},
        };
        let request = V50Request { count: 1, until_width: None, bracket: BRACKET, refined: 0, level: 0.9 };
        let folder = Folder::prepare_for(folder.path(), v50::FILES, &[])?;
        let mut found = v50::run(&self.case(retention)?, &request, &options, &folder)?;
        Ok(found.thresholds.remove(0)?)
    }

    /// Computed over measured limit [-]; of one shot that perforated at least that, of one that was stopped nothing.
    pub(crate) fn ratio(&self, woven: usize) -> Option<f64> {
        let computed = self.computed_m_s[woven].map(v50::middle)?;
        (self.kind != "stopped").then_some(computed / self.measured_m_s)
    }
}

/// Rows of the file.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn rows() -> Result<Vec<Row>, Box<dyn Error>> {
    Ok(serde_json::from_str(&fs::read_to_string(Path::new(FOLDER).join("limits.json"))?)?)
}

/// Number of ratios, their geometric mean, the standard deviation of their logarithm, the least and the largest.
pub(crate) fn scatter(ratios: &[f64]) -> (usize, [f64; 4]) {
    let count = ratios.len() as f64;
    let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / count;
    let squares: f64 = ratios.iter().map(|ratio| (ratio.ln() - mean).powi(2)).sum();
    let [least, largest] = [f64::min, f64::max].map(|of| ratios.iter().copied().reduce(of).unwrap_or(f64::NAN));
    (ratios.len(), [mean.exp(), (squares / (count - 1.0).max(1.0)).sqrt(), least, largest])
}

/// Sentence of the README.
pub(crate) fn sentence(rows: &[Row]) -> String {
    let of = |woven| scatter(&rows.iter().filter_map(|row| row.ratio(woven)).collect::<Vec<_>>());
    let [(count, [mean, spread, ..]), (_, [woven_mean, woven_spread, ..])] = [of(0), of(1)];
    format!(
        "Over {count} limits, measured or read from a curve of measured ones, computed ones are {mean:.2} times as high in the geometric mean,\n\
         with a scatter of {:.0} %. With the failure strain of fibres out of woven cloth they are {woven_mean:.2} times as high ({:.0} %).\n",
        100.0 * spread,
        100.0 * woven_spread
    )
}

/// Table of the book.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut out =
        "| computed over measured | rows | geometric mean | scatter | from | to |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for (words, kinds) in [("all", "v50 curve perforated"), ("limits that were shot, and one shot", "v50 perforated")] {
        for (woven, yarns) in ["yarns as published", "failure strain × 0.785"].iter().enumerate() {
            let counted = rows.iter().filter(|row| kinds.contains(&row.kind));
            let (count, [mean, scatter, least, largest]) =
                scatter(&counted.filter_map(|row| row.ratio(woven)).collect::<Vec<_>>());
            out += &format!(
                "| {words}, {yarns} | {count} | {mean:.2} | {:.0} % | {least:.2} | {largest:.2} |\n",
                100.0 * scatter
            );
        }
    }
    out += "\n| fabric, pack, projectile | measured m/s | computed m/s | ratio | computed × 0.785 | ratio | source |\n|---|---|---|---|---|---|---|\n";
    let mut sources: Vec<String> = Vec::new();
    for row in rows {
        let source = format!("{}, {}", row.source, row.read);
        let number = sources.iter().position(|known| *known == source).unwrap_or(sources.len());
        if number == sources.len() {
            sources.push(source);
        }
        let kind = match row.kind.as_str() {
            "v50" => "V50, ",
            "curve" => "curve, ",
            "stopped" => "stopped, ",
            _ => "perforated, ",
        };
        let cells = [0, 1].map(|woven| {
            let limit = row.computed_m_s[woven].map_or("-".to_owned(), |limit| format!("{:.0}", v50::middle(limit)));
            let least = if row.kind == "perforated" { "over " } else { "" };
            format!("{limit} | {}", row.ratio(woven).map_or(String::new(), |ratio| format!("{least}{ratio:.2}")))
        });
        out += &format!("| {} | {kind}{} | {} | {} |\n", row.name, row.measured_m_s, cells.join(" | "), number + 1);
    }
    out += "\nSources:\n\n";
    for (number, source) in sources.iter().enumerate() {
        out += &format!("{}. {source}\n", number + 1);
    }
    out
}

/// Picture of the book: computed over measured limits.
pub(crate) fn picture(rows: &[Row]) -> String {
    const MOST: f64 = 800.0;
    let mut plot = Plot::new([0.0, MOST], [0.0, MOST], ["measured limit [m/s]", "computed limit [m/s]"]);
    plot.line("ink", "equal", &[[0.0; 2], [MOST; 2]]);
    plot.line("ink dashed", "0.8, 1.25 times", &[[0.0; 2], [MOST, 0.8 * MOST]]);
    plot.line("ink dashed", "", &[[0.0; 2], [0.8 * MOST, MOST]]);
    for (woven, (class, name)) in [("k0", "as published"), ("k1", "as woven, 0.785")].into_iter().enumerate() {
        plot.name(&format!("line {class}"), name);
        for row in rows.iter().filter(|row| row.ratio(woven).is_some()) {
            let computed = row.computed_m_s[woven].map_or(f64::NAN, v50::middle);
            let radius = if row.kind == "curve" { 3.0 } else { 6.0 };
            plot.dot(class, [row.measured_m_s, computed], radius, &row.name);
        }
    }
    plot::file("Computed over measured limits", "Large: limits that were shot; small: values of a curve.", &[plot])
}

/// Rows as the file has them, one a line.
fn text(rows: &[Row]) -> Result<String, serde_json::Error> {
    let lines: Vec<String> =
        rows.iter().map(|row| serde_json::to_string(row).map(|row| format!("  {row}"))).collect::<Result<_, _>>()?;
    Ok(format!("[\n{}\n]\n", lines.join(",\n")))
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let part = std::env::args().nth(1).unwrap_or_default();
    let mut rows = rows()?;
    for number in 0..rows.len() {
        if !rows[number].name.contains(&part) {
            continue;
        }
        for (woven, retention) in [1.0, v50::AS_WOVEN[0]].into_iter().enumerate() {
            let limit = rows[number].limit(retention)?;
            rows[number].computed_m_s[woven] = Some(limit);
            println!(
                "{} × {retention}: {:.0} to {:.0} m/s, measured {}",
                rows[number].name, limit[0], limit[1], rows[number].measured_m_s
            );
        }
        let file = text(&rows)?;
        write_whole(&Path::new(FOLDER).join("limits.json"), |out| std::io::Write::write_all(out, file.as_bytes()))?;
    }
    println!("{}", sentence(&rows));
    fs::write(PICTURE, picture(&rows))?;
    let page = fs::read_to_string(PAGE)?;
    let (before, rest) = page.split_once(START).ok_or("no table in the page")?;
    let (_, after) = rest.split_once(END).ok_or("no end of the table in the page")?;
    fs::write(PAGE, format!("{before}{START}{}{END}{after}", table(&rows)))?;
    Ok(())
}
