//! Report of a study in words, tables and figures: the terminal and the page show the same.

use maud::{Markup, html};

use super::binary_response::ThresholdSample;
use super::fit::{Fit, VelocityUnit};
use super::limit::{Limit, ResidualModel};
use super::shots::ShotRow;
use super::v50_result::V50Result;
use crate::case::{Drawn, in_words};
use crate::output::number::short;
use crate::output::plot::{Figure, Plot};
use crate::output::report::{figure, page, table};
use crate::run::outcome::Outcome;

/// Points of a curve.
const POINTS: usize = 240;
/// Classes of perforations and stops.
const PERFORATED: &str = "k1";
const STOPPED: &str = "k0";
const UNDECIDED: &str = "k6";

/// Result of a study: on its page a card with the answer and the counts, then figures, then tables.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Title of the case; empty where the first line of counts names the file of shots.
    pub title: String,
    /// Lines `name: number, more` on how many shots there were, and what became of them.
    pub counts: Vec<String>,
    /// Lines of the answer; the first begins with V50 up to its first comma. None in a sweep.
    pub answer: Vec<String>,
    /// Sentences that a reader should know before the numbers are used.
    pub notes: Vec<String>,
    /// Tables in their order.
    pub tables: Vec<ReportTable>,
    /// Drawings for the page.
    pub(super) panels: Vec<Figure>,
}

/// Table of a report.
#[derive(Clone, Debug, Default)]
pub struct ReportTable {
    /// Title; empty of a table that stands alone.
    pub title: &'static str,
    /// Names of the columns; none where the cells say what they are.
    pub heads: Vec<String>,
    /// First column of numbers. A last column without a name is text.
    pub first_number: usize,
    /// Cells by row.
    pub rows: Vec<Vec<String>>,
    /// Lines below it.
    pub foot: String,
    /// Addresses that the first cells of a page lead to; none where it is empty.
    pub links: Vec<String>,
    /// Whether it is on the page alone, folded.
    pub is_folded: bool,
}

impl ReportTable {
    pub(super) fn new(title: &'static str, heads: &[&str], first_number: usize) -> Self {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        Self { title, heads, first_number, ..Self::default() }
    }

    /// This table with its rows, and lines below them.
    pub(super) fn rows(self, rows: impl IntoIterator<Item = Vec<String>>, foot: &str) -> Self {
        Self { rows: rows.into_iter().collect(), foot: foot.to_owned(), ..self }
    }

    /// Whether a column holds text.
    pub fn is_text(&self, column: usize) -> bool {
        column < self.first_number || (column + 1 == self.heads.len() && self.heads[column].is_empty())
    }
}

/// Headline of a V50 with its interval.
pub(super) fn headline(v50: f64, unit: VelocityUnit, level: f64, [low, high]: [String; 2]) -> String {
    let (v50, level, unit) = (short(v50, 4), short(100.0 * level, 3), unit.symbol());
    format!("V50 {v50} {unit}, {level} % interval {low} to {high} {unit}")
}

impl Report {
    /// Page of the report. `numbers`: the files that hold every number.
    pub fn html(&self, title: &str, numbers: &str) -> String {
        let paragraph = |class: &str, lines: &[String]| {
            html! {
                @if !lines.is_empty() {
                    p class=(class) { @for (n, line) in lines.iter().enumerate() { @if n > 0 { br; } (line) } }
                }
            }
        };
        let (headline, rest) = self.answer.split_first().map_or((title, &[][..]), |(first, rest)| (first, rest));
        let (word, story) = headline.split_once(", ").filter(|_| !self.answer.is_empty()).unwrap_or((headline, ""));
        let body = html! {
            header {
                @if self.answer.is_empty() { h1 { (title) } }
                @else {
                    p class="over" { (title) }
                    h1 class="verdict plain" { (word) }
                    p class="story" { (story) @for line in rest { br; (line) } }
                }
                dl class="figures" {
                    @for line in &self.counts {
                        @let (name, number) = line.split_once(": ").unwrap_or(("shots", line));
                        @let (number, more) = number.split_once(", ").unwrap_or((number, ""));
                        div { dt { (name) } dd { (number) " " small { (more) } } }
                    }
                }
                (paragraph("answer look", &self.notes))
            }
            div class="plots" { @for panel in &self.panels { (figure(panel)) } }
            @for one in &self.tables { (section(one)) }
            p class="note" { "ripstop " (env!("CARGO_PKG_VERSION")) ". All numbers are in " (numbers) "." }
        };
        page(title, "", &body)
    }
}

/// Table of a report with its heading and foot; no table without a row.
fn section(of: &ReportTable) -> Markup {
    let cell = |(column, cell): (usize, &String)| {
        html! { @if of.is_text(column) { span class="text" { (cell) } } @else { (cell) } }
    };
    let heads: Vec<&str> = of.heads.iter().map(String::as_str).collect();
    let row = |(number, row): (usize, &Vec<String>)| -> Vec<Markup> {
        let mut cells: Vec<Markup> = row.iter().enumerate().map(cell).collect();
        if let (Some(first), Some(link)) = (cells.first_mut(), of.links.get(number)) {
            *first = html! { a href=(link) { (*first) } };
        }
        cells
    };
    let body = html! {
        @if !of.rows.is_empty() { (table("numbers", &heads, of.rows.iter().enumerate().map(row))) }
        @for line in of.foot.lines() { p class="note" { (line) } }
    };
    html! {
        @if of.is_folded { details { summary { (of.title) } (body) } }
        @else {
            @if !of.rows.is_empty() && !of.title.is_empty() { h2 { (of.title) } }
            (body)
        }
    }
}

/// Figure of shots over their velocity, in the colour of their outcome. `upright`: name of the other axis, and the value of a shot there.
pub(super) fn shot_panel<'a>(
    [id, title, upright]: [&str; 3],
    rows: impl IntoIterator<Item = &'a ShotRow>,
    value: impl Fn(&ShotRow) -> Option<f64>,
) -> Option<Figure> {
    let shots: Vec<_> = rows.into_iter().filter_map(|row| Some((row, [row.velocity, value(row)?]))).collect();
    let range = |axis: usize| match ends(shots.iter().map(|(_, at)| at[axis])) {
        [low, high] if low == high => [low - 1.0, high + 1.0],
        range => range,
    };
    let mut plot =
        Plot::new(roomy(range(0), 0.05, 1e-3), roomy(range(1), 0.05, 1e-3), ["impact velocity [m/s]", upright]);
    for (row, at) in &shots {
        let class = match row.perforated() {
            Some(true) => PERFORATED,
            Some(false) => STOPPED,
            None => UNDECIDED,
        };
        plot.dot(class, *at, 3.5, &format!("shot {}, {} m/s", row.order.shot, short(row.velocity, 4)));
    }
    name_outcomes(&mut plot);
    (!shots.is_empty()).then(|| Figure::new(id, title, "", Some(plot)))
}

/// Folded table of all shots, with lines below it.
pub(super) fn all_shots(rows: &[ShotRow], foot: &str) -> ReportTable {
    let line = |row: &ShotRow| {
        let residual = row.residual.map_or_else(|| "-".to_owned(), |residual| short(residual, 4));
        let outcome = row.outcome.map_or("failed", Outcome::word).to_owned();
        vec![row.order.shot.to_string(), short(row.velocity, 4), residual, outcome, row.trust.clone()]
    };
    let heads = ["shot", "velocity m/s", "residual m/s", "outcome", "trust"];
    ReportTable { is_folded: true, ..ReportTable::new("All shots", &heads, 0).rows(rows.iter().map(line), foot) }
}

/// Figures of each value that was drawn over the velocity.
pub(super) fn drawn_panels(rows: &[ShotRow]) -> Vec<Figure> {
    let columns = rows.iter().map(|row| &row.drawn).max_by_key(|drawn| drawn.len()).into_iter().flatten();
    let panel = |(n, column): (usize, &Drawn)| {
        let value =
            |row: &ShotRow| row.drawn.iter().find(|drawn| drawn.column == column.column).map(|drawn| drawn.value);
        let words = in_words(&column.column);
        let title = words.split(" [").next().unwrap_or_default();
        shot_panel([&format!("drawn-{n}"), &format!("Drawn: {title}"), &words], rows, value)
    };
    columns.enumerate().filter_map(panel).collect()
}

fn name_outcomes(plot: &mut Plot) {
    plot.name("dot k1", "perforated");
    plot.name("dot k0", "stopped");
}

/// Adds a dot for shots of one kind; larger where they are many.
fn dot(plot: &mut Plot, class: &str, at: [f64; 2], count: u64) {
    let words = if count == 1 { "1 shot".to_owned() } else { format!("{count} shots") };
    plot.dot(class, at, 3.5 * (count as f64).powf(0.25), &words);
}

/// Adds the curve of a chance over a range of velocities.
fn chance_curve(plot: &mut Plot, [class, name]: [&str; 2], range: [f64; 2], chance: impl Fn(f64) -> f64) {
    let points: Vec<[f64; 2]> = evenly(range).map(|velocity| [velocity, chance(velocity)]).collect();
    plot.line(class, name, &points);
}

fn evenly([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=POINTS).map(move |n| low + (high - low) * n as f64 / POINTS as f64)
}

/// Least and largest of some numbers.
pub(super) fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Range with room on both sides: a part of its length, or of its upper end where it is short.
pub(super) fn roomy([low, high]: [f64; 2], part: f64, of_end: f64) -> [f64; 2] {
    let room = (part * (high - low)).max(of_end * high.abs()).max(1e-9);
    [low - room, high + room]
}

/// Plot of the chance of a perforation over velocity, with nothing in it.
fn chance_plot(range: [f64; 2], unit: VelocityUnit) -> Plot {
    Plot::new(range, [0.0, 1.0], [&format!("impact velocity [{}]", unit.symbol()), "chance of a perforation"])
}

/// Chance of a perforation over velocity, with the shots and the intervals.
pub(super) fn chance_panel(fit: &Fit) -> Figure {
    let quantiles = &fit.limit.quantiles;
    let values = quantiles.iter().filter_map(|quantile| quantile.value);
    let range = roomy(ends(values.chain(fit.outcomes.groups().iter().map(|group| group.velocity))), 0.2, 1e-3);
    let mut plot = chance_plot(range, fit.limit.unit);
    for quantile in quantiles.iter().filter(|quantile| quantile.value.is_some()) {
        let ends = [quantile.bounds.low.unwrap_or(range[0]), quantile.bounds.high.unwrap_or(range[1])];
        plot.line("ink interval", "", &ends.map(|end| [end.clamp(range[0], range[1]), quantile.p]));
    }
    if let Ok(found) = &fit.estimate {
        chance_curve(&mut plot, ["ink", "fit"], range, |velocity| found.probability(velocity));
    }
    for group in fit.outcomes.groups() {
        for (count, height, class) in [(group.perforated, 1.0, PERFORATED), (group.stopped, 0.0, STOPPED)] {
            if count > 0 {
                dot(&mut plot, class, [group.velocity, height], count);
            }
        }
    }
    name_outcomes(&mut plot);
    let caption = format!("Bars: {} % intervals.", short(100.0 * fit.level, 3));
    Figure::new("chance", "Chance of a perforation", caption, Some(plot))
}

/// Thresholds as a staircase of their distribution, the normal one, and the interval of V50.
pub(super) fn threshold_panel(result: &V50Result, sample: &ThresholdSample) -> Figure {
    let mut middles = result.middles();
    middles.sort_by(f64::total_cmp);
    let bounds = [result.bounds.low, result.bounds.high];
    let range = roomy(ends(middles.iter().copied().chain(bounds.into_iter().flatten())), 0.15, 2e-3);
    let mut plot = chance_plot(range, result.limit.unit);
    if let [Some(low), Some(high)] = bounds {
        plot.line("ink interval", "", &[[low, 0.5], [high, 0.5]]);
    }
    chance_curve(&mut plot, ["ink", "normal"], range, |velocity| sample.probability(velocity));
    for (rank, threshold) in middles.iter().enumerate() {
        dot(&mut plot, STOPPED, [*threshold, (rank as f64 + 0.5) / middles.len() as f64], 1);
    }
    plot.name("dot k0", "thresholds of realisations");
    Figure::new("chance", "Chance of a perforation", "Bar: interval of V50.", Some(plot))
}

/// Residual over impact velocity, with the curves fitted to it; nothing where no residual velocity is known.
pub(super) fn residual_panel(limit: &Limit) -> Option<Figure> {
    let passed = &limit.passed;
    let fastest = passed.iter().map(|shot| shot.impact).reduce(f64::max)?;
    let [slowest, _] = ends(passed.iter().map(|shot| shot.impact).chain(limit.fitted().map(|found| found.limit)));
    let range = roomy([slowest, fastest], 0.05, 5e-5);
    let residuals = passed.iter().map(|shot| shot.residual).chain(limit.fitted().map(|found| found.residual(range[1])));
    let [impact, residual] = ["impact", "residual"].map(|of| format!("{of} velocity [{}]", limit.unit.symbol()));
    let mut plot = Plot::new(range, [0.0, residuals.fold(0.0, f64::max)], [&impact, &residual]);
    for found in limit.fitted() {
        // The curve rises from the limit with an infinite slope: its points are dense there.
        let squared = evenly([0.0, 1.0]).map(|share| found.limit + (range[1] - found.limit) * share * share);
        let points = squared.filter(|impact| *impact >= range[0]).map(|impact| [impact, found.residual(impact)]);
        let class = if found.curve == ResidualModel::RechtIpson { "ink" } else { "ink dashed" };
        plot.line(class, found.curve.words(), &points.collect::<Vec<_>>());
    }
    for shot in passed {
        dot(&mut plot, PERFORATED, [shot.impact, shot.residual], shot.count);
    }
    Some(Figure::new("residual", "Residual velocity", "Shots that perforated.", Some(plot)))
}
