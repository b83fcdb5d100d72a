//! Tension maps of the struck ply at three moments, as images inside plots with axes.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, PreEscaped, html};

use super::animation::{AnimatedPly, Animation, Keyframe};
use super::number::short;
use super::plot::{self, Axis};
use crate::run::Run;

/// Width of a drawing, and the ends of its image.
const WIDTH: f64 = 300.0;
const SIDES: [f64; 2] = [52.0, WIDTH - 10.0];
const TOP: f64 = 8.0;
/// Pixels along the longer side of an image.
const PIXELS: f64 = 200.0;

/// Colour of a share of the largest value.
pub(super) fn colour(share: f64) -> [u8; 3] {
    let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0));
    [r, g, b]
}

/// All colours as a gradient of CSS, from left to right.
pub(super) fn gradient() -> String {
    let stops = (0..=16).map(|n| colour(f64::from(n) / 16.0)).map(|[r, g, b]| format!(",#{r:02x}{g:02x}{b:02x}"));
    format!("linear-gradient(to right{})", stops.collect::<String>())
}

/// The maps with their scales.
pub(super) fn maps(animation: &Animation, run: &Run) -> Markup {
    let Some(ply) = animation.plies.first() else { return Markup::default() };
    let peak = animation.peak_tension();
    let of_ply = |keyframe: &Keyframe| {
        let tensions = keyframe.tension.iter().take(ply.cells()).flatten().flatten().copied();
        tensions.filter(|tension| tension.is_finite()).fold(0.0, f32::max)
    };
    let map_at = |(n, (at, what)): (usize, (usize, &str))| {
        let keyframe = &animation.keyframes[at];
        let own = of_ply(keyframe);
        let top = if own < 0.5 * peak { own } else { peak };
        let words = format!("{} µs: {what}", short(keyframe.time * 1e6, 3));
        html! {
            div class="map" {
                h4 { (words) }
                (map(ply, keyframe, top, &format!("tension-{n}"), &words))
                p class="scale" { span { "0 N" } i {} span { (short(f64::from(top), 3)) " N" } }
            }
        }
    };
    html! {
        figure class="plot wide" id="tension" {
            figcaption {
                h3 { "Yarn tension in the struck ply" }
                p {
                    "The larger of warp and weft; holes are where both yarns have failed. A map whose tension stays below half the \
                     largest of the shot has a scale of its own."
                }
            }
            div class="maps" { @for map in moments(animation, run).into_iter().enumerate().map(map_at) { (map) } }
        }
    }
}

/// Keyframes to show and their names: on the way, when the fabric holds most, and the last.
fn moments(animation: &Animation, run: &Run) -> Vec<(usize, &'static str)> {
    let last = animation.keyframes.len().saturating_sub(1);
    let strongest =
        |at: &usize| animation.keyframes[*at].tension.iter().flatten().flatten().copied().fold(0.0, f32::max);
    let (most, what) = match run.events.first() {
        Some(event) => {
            let time = event.step as f64 * run.time_step;
            let after = animation.keyframes.partition_point(|keyframe| keyframe.time <= time);
            (after.saturating_sub(1), "just before the first yarn fails")
        }
        None => {
            let most = (0..=last).max_by(|a, b| strongest(a).total_cmp(&strongest(b)));
            (most.unwrap_or(last), "when the tension is largest")
        }
    };
    let most = if most == last || most == 0 { (last / 2, "halfway") } else { (most, what) };
    let mut all = vec![(most.0.div_ceil(2), "on the way"), most, (last, "at the end")];
    all.retain(|(at, _)| *at < animation.keyframes.len());
    all.dedup_by_key(|(at, _)| *at);
    all
}

fn map(ply: &AnimatedPly, keyframe: &Keyframe, peak: f32, id: &str, words: &str) -> Markup {
    let spans = [0, 1].map(|axis| Span::new(ply, axis));
    let [across, up] = spans.each_ref().map(|span| 1e3 * span.whole);
    let width = SIDES[1] - SIDES[0];
    let height = (width * up / across).clamp(40.0, 320.0);
    let x = Axis::linear([-0.5 * across, 0.5 * across], SIDES);
    let y = Axis::linear([-0.5 * up, 0.5 * up], [TOP + height, TOP]);
    let axes = plot::axes(&x, &y, ["along the warp [mm]", "along the weft [mm]"]);
    let image = BASE64_STANDARD.encode(image(ply, &spans, keyframe, peak));
    html! {
        svg viewBox={ "0 0 " (WIDTH) " " (TOP + height + 44.0) } role="img" aria-labelledby=(id) {
            title id=(id) { (words) }
            (PreEscaped(axes))
            image x=(SIDES[0]) y=(TOP) width=(width) height=(height) preserveAspectRatio="none"
                href={ "data:image/png;base64," (image) } {}
        }
    }
}

/// A PNG of the whole ply, weft upwards, with a colour between those of the cells around a place, and none where both yarns are gone.
fn image(ply: &AnimatedPly, spans: &[Span; 2], keyframe: &Keyframe, peak: f32) -> Vec<u8> {
    let longest = spans[0].whole.max(spans[1].whole);
    let size = [0, 1].map(|axis| ((PIXELS * spans[axis].whole / longest).round() as usize).max(1));
    let [columns, rows] = [0, 1].map(|axis| {
        let place = |pixel: usize| (pixel as f64 + 0.5) / size[axis] as f64 * spans[axis].whole;
        (0..size[axis]).map(|pixel| spans[axis].around(place(pixel))).collect::<Vec<_>>()
    });
    let tension = |column: usize, row: usize| {
        keyframe.tension[row * ply.counts()[0] + column].into_iter().flatten().reduce(f32::max).map(f64::from)
    };
    let mut pixels = Vec::with_capacity(4 * size[0] * size[1]);
    for row in rows.iter().rev() {
        for column in &columns {
            if tension(column.cell, row.cell).is_none() {
                pixels.extend([0; 4]);
                continue;
            }
            let (mut sum, mut weights) = (0.0, 0.0);
            for (column, across) in [(column.cell, 1.0 - column.share), (column.next, column.share)] {
                for (row, up) in [(row.cell, 1.0 - row.share), (row.next, row.share)] {
                    if let Some(tension) = tension(column, row) {
                        sum += across * up * tension;
                        weights += across * up;
                    }
                }
            }
            pixels.extend(colour(sum / weights / f64::from(peak.max(1e-9))));
            pixels.push(255);
        }
    }
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    // Writing to memory cannot fail; an image that is not there leaves the axes.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { out } else { Vec::new() }
}

/// A ply along one of its axes.
struct Span {
    /// Distances of the lines kept from the first of them [m].
    lines: Vec<f64>,
    /// Distance of the first of them from the edge of the ply [m].
    start: f64,
    /// Length of the ply [m].
    whole: f64,
}

/// The cell at a place, and the neighbour on the side where the place is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Around {
    cell: usize,
    next: usize,
    /// Weight of the neighbour: 0 in the middle of the cell, a half at its edge between cells of one size.
    share: f64,
}

impl Span {
    fn new(ply: &AnimatedPly, axis: usize) -> Self {
        let kept = &ply.lines[axis];
        let step = if axis == 0 { 1 } else { ply.lines[0].len() };
        let first = ply.reference[0];
        let places = (0..kept.len()).map(|line| ply.reference[line * step]);
        let lines: Vec<f64> = places.map(|at| f64::from(at[0] - first[0]).hypot(f64::from(at[1] - first[1]))).collect();
        let (from, to, length) = (kept[0], kept[kept.len() - 1], lines[lines.len() - 1]);
        // What is not kept is the mirror image of what is.
        let whole = length * ply.elements[axis] as f64 / (to - from).max(1) as f64;
        Self { lines, start: if from == 0 { 0.0 } else { whole - length }, whole }
    }

    /// The cells at a place, counted from the edge of the ply [m].
    fn around(&self, place: f64) -> Around {
        let length = self.lines[self.lines.len() - 1];
        let kept = Some(place - self.start).filter(|at| (0.0..=length).contains(at));
        let at = kept.unwrap_or(self.whole - place - self.start).clamp(0.0, length);
        let last = self.lines.len().saturating_sub(2);
        let cell = self.lines.partition_point(|line| *line <= at).saturating_sub(1).min(last);
        let middle = |cell: usize| 0.5 * (self.lines[cell] + self.lines[(cell + 1).min(self.lines.len() - 1)]);
        let next = if at < middle(cell) { cell.saturating_sub(1) } else { (cell + 1).min(last) };
        let gap = (middle(next) - middle(cell)).abs();
        let share = if gap > 0.0 { ((at - middle(cell)).abs() / gap).min(1.0) } else { 0.0 };
        Around { cell, next, share }
    }
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
