//! Page of a study in one file that asks nothing of a network, and its drawings.

use std::fmt::Write as _;

use super::fit::Fit;
use super::limit::Limit;
use super::report::{Report, ReportTable};
use super::residual_fit::ResidualModel;
use super::sweep::SweepPoint;
use super::threshold::ThresholdSample;
use super::v50_result::V50Result;
use crate::output::chart::{self, ChartAxis, escape};
use crate::output::number::short;

/// Size of a drawing.
const SIZE: [f64; 2] = [520.0, 340.0];
/// Points of a curve.
const POINTS: usize = 240;
/// Colours of Okabe and Ito, which colour-blind people can distinguish: perforations, stops, curves, computed limits.
const PERFORATED: &str = "#d55e00";
const STOPPED: &str = "#0072b2";
const CURVE: &str = "#222";
const COMPUTED: &str = "#009e73";
const COLOURS: [&str; 7] = [STOPPED, PERFORATED, COMPUTED, "#cc79a7", "#e69f00", "#56b4e9", CURVE];
/// Dashes of a second curve.
const DASHES: &str = "7 4";
/// Rows of a table at most.
const MAX_ROWS: usize = 400;

const STYLE: &str = "
:root { color-scheme: light; --line: #d5dbe3; --soft: #566273 }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 70em; margin: 1.5em auto; padding: 0 1em; color: #17202b; background: #fff }
h1 { font-size: 1.5rem; overflow-wrap: anywhere } h2 { font-size: 1.15rem; margin: 1.8em 0 .5em } .answer { font-size: 1.1rem }
table { border-collapse: collapse; font-size: .92rem } .scroll { overflow-x: auto }
th, td { text-align: right; padding: .3em 1em .3em 0; border-bottom: 1px solid var(--line); font-variant-numeric: tabular-nums }
th { font-weight: 500; color: var(--soft) } .text { text-align: left; color: inherit }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 12px }
figure { margin: 0 } figure svg { width: 100%; height: auto; font-size: 12px }
.note { color: var(--soft); font-size: .95rem }
@media print { figure, tr { break-inside: avoid } }
";

impl Report {
    /// Page of a self. `numbers`: the files that hold every number.
    pub fn html(&self, title: &str, numbers: &str) -> String {
        let title = escape(title);
        let paragraph = |class: &str, lines: &[String]| match lines {
            [] => String::new(),
            lines => format!(
                "<p class=\"{class}\">{}</p>\n",
                lines.iter().map(|line| escape(line)).collect::<Vec<_>>().join("<br>")
            ),
        };
        let figure = |panel: &Panel| {
            let [width, height] = SIZE;
            let (name, drawing) = (escape(&panel.name), &panel.drawing);
            format!(
                "<figure><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\">\n{drawing}</svg></figure>\n"
            )
        };
        let mut body = paragraph("answer", &self.answer) + &paragraph("counts", &self.counts);
        body.extend(self.notes.iter().map(|note| paragraph("note", &[format!("{note}.")])));
        let figures: String = self.panels.iter().map(figure).collect();
        let _ = write!(body, "<div class=\"plots\">\n{figures}</div>\n");
        body.extend(self.tables.iter().chain(&self.page_tables).map(table));
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
             base-uri 'none'; form-action 'none'\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
             <title>{title} – ripstop</title>\n<style>{STYLE}{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\
             <p class=\"note\">ripstop {}. All numbers are in {numbers}.</p>\n</body>\n</html>\n",
            chart::STYLE,
            env!("CARGO_PKG_VERSION"),
        )
    }

    /// Picture of the drawings beside each other, under a title.
    pub fn svg(&self, title: &str) -> String {
        let mut out = chart::text(24.0, 26.0, "font-size=\"14\" font-weight=\"bold\"", title);
        for (n, panel) in self.panels.iter().enumerate() {
            let (left, drawing) = (SIZE[0] * n as f64, &panel.drawing);
            let _ = writeln!(out, "<g transform=\"translate({left} 40)\">\n{drawing}</g>");
        }
        chart::svg([SIZE[0] * self.panels.len() as f64, SIZE[1] + 40.0], "", chart::STYLE, &out)
    }
}

/// Table of a report; nothing without a row.
fn table(table: &ReportTable) -> String {
    let foot = table.foot.lines().map(|line| format!("<p class=\"note\">{}</p>\n", escape(line))).collect::<String>();
    if table.rows.is_empty() {
        return foot;
    }
    let cell = |(column, cell): (usize, &String)| {
        // Minus signs of numbers, not hyphens of words.
        let cell = if cell.parse::<f64>().is_ok() { cell.replace('-', "−") } else { cell.clone() };
        let class = if table.is_text(column) { " class=\"text\"" } else { "" };
        format!("<td{class}>{}</td>", escape(&cell))
    };
    let head = |head: &String| format!("<th scope=\"col\">{}</th>", escape(head));
    let heads: String = table.heads.iter().map(head).collect();
    let row = |row: &Vec<String>| format!("<tr>{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>());
    let rows: String = table.rows.iter().take(MAX_ROWS).map(row).collect();
    let left_out = table.rows.len().saturating_sub(MAX_ROWS);
    let more = if left_out > 0 { format!("<p class=\"note\">{left_out} more rows.</p>\n") } else { String::new() };
    let mut letters = table.title.chars();
    let title = letters
        .next()
        .map_or_else(String::new, |first| format!("<h2>{}{}</h2>\n", first.to_uppercase(), escape(letters.as_str())));
    format!(
        "{title}<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n\
         {more}{foot}"
    )
}

/// Drawing with two axes.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    name: String,
    x: ChartAxis,
    y: ChartAxis,
    drawing: String,
}

impl Panel {
    /// Axes with these ranges. `left`: room for the labels of the upright one.
    fn new(name: impl Into<String>, left: f64, ranges: [[f64; 2]; 2], titles: [&str; 2]) -> Self {
        let x = ChartAxis::linear(ranges[0], [left, SIZE[0] - 18.0]);
        let y = ChartAxis::linear(ranges[1], [SIZE[1] - 58.0, 22.0]);
        Self { name: name.into(), x, y, drawing: chart::axes(&x, &y, titles) }
    }

    fn line(&mut self, points: impl Iterator<Item = [f64; 2]>, colour: &str, dashes: &str) {
        let style = format!("stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"");
        self.drawing += &chart::line(&self.x, &self.y, points, &style);
    }

    /// Straight line between two points.
    fn segment(&mut self, [from, to]: [[f64; 2]; 2], style: &str) {
        let [x1, x2] = [from[0], to[0]].map(|value| self.x.at(value));
        let [y1, y2] = [from[1], to[1]].map(|value| self.y.at(value));
        // Writing to a string cannot fail.
        let _ = writeln!(self.drawing, "<line x1=\"{x1:.1}\" x2=\"{x2:.1}\" y1=\"{y1:.1}\" y2=\"{y2:.1}\" {style}/>");
    }

    /// Dot for shots of one kind; larger where they are many.
    fn dot(&mut self, [x, y]: [f64; 2], count: u64, colour: &str) {
        let radius = 3.5 * (count as f64).powf(0.25);
        let words = if count > 1 { format!("<title>{count} shots</title>") } else { String::new() };
        let _ = writeln!(
            self.drawing,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\" fill=\"{colour}\" fill-opacity=\"0.35\" stroke=\"{colour}\">{words}</circle>",
            self.x.at(x),
            self.y.at(y)
        );
    }

    /// Filled rectangle between two values on each axis.
    fn area(&mut self, [left, right]: [f64; 2], [low, high]: [f64; 2], style: &str, inside: &str) {
        let (x, y) = ([left, right].map(|value| self.x.at(value)), [high, low].map(|value| self.y.at(value)));
        self.drawing += &chart::area(x, y, style, inside);
    }

    /// Words below the axes.
    fn below(mut self, words: &str) -> Self {
        self.drawing += &chart::text(self.x.paper[0], SIZE[1] - 8.0, "font-size=\"11\"", words);
        self
    }
}

fn evenly([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=POINTS).map(move |n| low + (high - low) * n as f64 / POINTS as f64)
}

/// Least and largest of some numbers.
fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Range with room on both sides: a part of its length, or of its upper end where it is short.
fn roomy([low, high]: [f64; 2], part: f64, of_end: f64) -> [f64; 2] {
    let room = (part * (high - low)).max(of_end * high.abs()).max(1e-9);
    [low - room, high + room]
}

const CHANCE: [&str; 2] = ["impact velocity [m/s]", "chance of a perforation"];

/// Chance of a perforation over velocity, with the shots and the intervals.
pub(super) fn chance_panel(fit: &Fit) -> Panel {
    // Velocities of the shots and of the quantiles, and of intervals what lies near them.
    let [low, high] = fit.outcomes.range();
    let reach = 0.6 * (high - low).max(1e-3 * high.abs()).max(1e-9);
    let computed = fit.computed.iter().flat_map(|found| [Some(found.v50), found.bounds.low, found.bounds.high]);
    let quantiles = &fit.limit.quantiles;
    let shown = quantiles.iter().flat_map(|quantile| [quantile.value, quantile.bounds.low, quantile.bounds.high]);
    let near = shown.chain(computed).flatten().map(|velocity| velocity.clamp(low - reach, high + reach));
    let [low, high] = ends(near.chain([low, high]));
    let room = 0.04 * (high - low).max(reach);
    let range = [low - room, high + room];
    let mut panel = Panel::new("chance of a perforation over impact velocity", 64.0, [range, [0.0, 1.0]], CHANCE);
    for quantile in quantiles.iter().filter(|quantile| quantile.value.is_some()) {
        let ends = [quantile.bounds.low.unwrap_or(range[0]), quantile.bounds.high.unwrap_or(range[1])];
        let style = format!("stroke=\"{CURVE}\" stroke-opacity=\"0.45\" stroke-width=\"3\"");
        panel.segment(ends.map(|end| [end.clamp(range[0], range[1]), quantile.p]), &style);
    }
    if let Ok(found) = &fit.estimate {
        panel.line(evenly(range).map(|velocity| [velocity, found.probability(velocity)]), CURVE, "none");
    }
    if let Some(computed) = &fit.computed {
        panel.line(evenly(range).map(|velocity| [velocity, computed.probability(velocity)]), COMPUTED, DASHES);
    }
    for group in fit.outcomes.groups() {
        for (count, height, colour) in [(group.perforated, 1.0, PERFORATED), (group.stopped, 0.0, STOPPED)] {
            if count > 0 {
                panel.dot([group.velocity, height], count, colour);
            }
        }
    }
    let computed = if fit.computed.is_some() { "; dashed green: computed" } else { "" };
    let level = short(100.0 * fit.request.level, 3);
    panel.below(&format!("orange: perforated, blue: stopped; bars: {level} % intervals{computed}"))
}

/// Thresholds as a staircase of their distribution, the normal one, and the interval of V50.
pub(super) fn threshold_panel(result: &V50Result, sample: &ThresholdSample) -> Panel {
    let mut middles = result.middles();
    middles.sort_by(f64::total_cmp);
    let bounds = [result.bounds.low, result.bounds.high];
    let range = roomy(ends(middles.iter().copied().chain(bounds.into_iter().flatten())), 0.15, 2e-3);
    let mut panel = Panel::new("chance of a perforation over impact velocity", 64.0, [range, [0.0, 1.0]], CHANCE);
    if let [Some(low), Some(high)] = bounds {
        panel.area([low, high], [0.0, 1.0], &format!("fill=\"{CURVE}\" fill-opacity=\"0.08\""), "");
    }
    panel.line(evenly(range).map(|velocity| [velocity, sample.probability(velocity)]), CURVE, "none");
    for (rank, threshold) in middles.iter().enumerate() {
        panel.dot([*threshold, (rank as f64 + 0.5) / middles.len() as f64], 1, STOPPED);
    }
    panel.below("dots: thresholds of realisations; line: normal; band: interval of V50")
}

/// Residual over impact velocity, with the curves fitted to it; nothing where no residual velocity is known.
pub(super) fn residual_panel(limit: &Limit) -> Option<Panel> {
    let fits = || limit.residual.iter().filter_map(|(_, found)| found.as_ref().ok());
    let passed = &limit.passed;
    let fastest = passed.iter().map(|shot| shot.impact).reduce(f64::max)?;
    let [slowest, _] = ends(passed.iter().map(|shot| shot.impact).chain(fits().map(|found| found.limit)));
    let range = roomy([slowest, fastest], 0.05, 5e-5);
    let residuals = passed.iter().map(|shot| shot.residual).chain(fits().map(|found| found.residual(range[1])));
    let ranges = [range, chart::rounded_up([0.0, residuals.fold(0.0, f64::max)])];
    let titles = ["impact velocity [m/s]", "residual velocity [m/s]"];
    let mut panel = Panel::new("residual over impact velocity", 78.0, ranges, titles);
    for found in fits() {
        // The curve rises from the limit with an infinite slope: its points are dense there.
        let squared = evenly([0.0, 1.0]).map(|share| found.limit + (range[1] - found.limit) * share * share);
        let points = squared.filter(|impact| *impact >= range[0]).map(|impact| [impact, found.residual(impact)]);
        panel.line(points, CURVE, if found.curve == ResidualModel::RechtIpson { "none" } else { DASHES });
    }
    for shot in passed {
        panel.dot([shot.impact, shot.residual], shot.count, PERFORATED);
    }
    Some(panel.below("line: Recht-Ipson; dashed: Lambert-Jonas"))
}

/// Response of a sweep over the first factor, a line for each combination of the others; nothing without a response.
pub(super) fn lines_panel(names: &[&str], points: &[SweepPoint], response: &str) -> Option<Panel> {
    let shown = points.iter().flat_map(|point| point.bounds.unwrap_or([point.response; 2]));
    let ranges = [ends(points.iter().map(|point| point.x)), ends(shown)].map(|range| roomy(range, 0.05, 1e-3));
    let mut panel = Panel::new(format!("{response} over {}", names[0]), 84.0, ranges, [names[0], response]);
    let mut groups: Vec<&str> = points.iter().map(|point| point.others.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    let others = names[1..].join(", ");
    let mut at = 16.0 + 7.0 * others.chars().count() as f64;
    let step = ((SIZE[0] - at) / groups.len() as f64).min(62.0);
    let legend = |x: f64, colour: &str, words: &str| {
        chart::text(x, SIZE[1] - 8.0, &format!("font-size=\"11\" style=\"fill:{colour}\""), words)
    };
    panel.drawing += &legend(4.0, CURVE, &others);
    for (n, group) in groups.iter().enumerate() {
        let mut points: Vec<&SweepPoint> = points.iter().filter(|point| point.others == *group).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let colour = COLOURS[n % COLOURS.len()];
        panel.line(points.iter().map(|point| [point.x, point.response]), colour, "none");
        panel.drawing += &legend(at, colour, group);
        at += step;
        for point in points {
            if let Some(bounds) = point.bounds {
                panel.segment(bounds.map(|end| [point.x, end]), &format!("stroke=\"{colour}\""));
            }
            panel.dot([point.x, point.response], 1, colour);
        }
    }
    (!points.is_empty()).then_some(panel)
}
