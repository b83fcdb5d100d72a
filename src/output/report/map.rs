//! Tension maps of the struck ply at three moments, as pictures inside drawings with axes.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::super::chart::{self, ChartAxis, escape};
use super::super::number::short;
use super::animated_ply::AnimatedPly;
use super::animation::{Animation, Keyframe};
use super::colour;
use crate::run::Run;

/// Width of a drawing, and the ends of its picture.
const WIDTH: f64 = 300.0;
const SIDES: [f64; 2] = [52.0, WIDTH - 10.0];
const TOP: f64 = 8.0;
/// Pixels along the longer side of a picture.
const PIXELS: f64 = 200.0;

/// The maps with their legend; empty without a animation.
pub(super) fn maps(animation: &Animation, run: &Run) -> String {
    let Some(strip) = animation.strips.first() else { return String::new() };
    let peak = animation.peak_tension();
    let moments = moments(animation, run);
    let mut out = "<figure class=\"plot wide\" id=\"tension\">\n<figcaption><h3>Yarn tension in the struck ply</h3>\
                   <p>The larger of warp and weft; holes are where both yarns have failed. A map whose tension stays below half \
                   the largest of the shot has a scale of its own.</p></figcaption>\n\
                   <div class=\"maps\">\n"
        .to_owned();
    for (n, (at, what)) in moments.iter().enumerate() {
        let keyframe = &animation.keyframes[*at];
        let own = peak_of(strip, keyframe);
        let top = if own < 0.5 * peak { own } else { peak };
        let words = format!("{} µs: {what}", short(keyframe.time * 1e6, 3));
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<div class=\"map\"><h4>{}</h4>{}<p class=\"scale\"><span>0 N</span><i></i><span>{} N</span></p></div>",
            escape(&words),
            map(strip, keyframe, top, &format!("tension-{n}"), &words),
            short(f64::from(top), 3)
        );
    }
    out + "</div></figure>\n"
}

/// Largest tension of a picture in the first strip [N].
fn peak_of(strip: &AnimatedPly, keyframe: &Keyframe) -> f32 {
    let tensions = keyframe.tension.iter().take(strip.cells()).flatten().flatten().copied();
    tensions.filter(|tension| tension.is_finite()).fold(0.0, f32::max)
}

/// Pictures to show and what they show: on the way, when the fabric holds most, and the last.
fn moments(animation: &Animation, run: &Run) -> Vec<(usize, &'static str)> {
    let last = animation.keyframes.len().saturating_sub(1);
    let strongest = |keyframe: &Keyframe| keyframe.tension.iter().flatten().flatten().copied().fold(0.0, f32::max);
    let (most, what) = match run.events.first() {
        Some(event) => {
            let time = event.step as f64 * run.time_step;
            (
                animation.keyframes.partition_point(|keyframe| keyframe.time <= time).saturating_sub(1),
                "just before the first yarn fails",
            )
        }
        None => {
            let most = (0..=last)
                .max_by(|a, b| strongest(&animation.keyframes[*a]).total_cmp(&strongest(&animation.keyframes[*b])));
            (most.unwrap_or(last), "when the tension is largest")
        }
    };
    let most = if most == last || most == 0 { (last / 2, "halfway") } else { (most, what) };
    let mut all = vec![(most.0.div_ceil(2), "on the way"), most, (last, "the last picture")];
    all.retain(|(at, _)| *at < animation.keyframes.len());
    all.dedup_by_key(|(at, _)| *at);
    all
}

fn map(strip: &AnimatedPly, keyframe: &Keyframe, peak: f32, id: &str, words: &str) -> String {
    let [across, up] = extent(strip);
    let width = SIDES[1] - SIDES[0];
    let height = (width * up / across).clamp(40.0, 320.0);
    let bottom = TOP + height;
    let x = ChartAxis::linear([-0.5 * across, 0.5 * across], SIDES);
    let y = ChartAxis::linear([-0.5 * up, 0.5 * up], [bottom, TOP]);
    let total = bottom + 44.0;
    let picture = BASE64_STANDARD.encode(picture(strip, keyframe, peak));
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {total:.0}\" role=\"img\" aria-labelledby=\"{id}\">\n<title id=\"{id}\">{}</title>\n\
         {}<image x=\"{}\" y=\"{TOP}\" width=\"{width}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{picture}\"/>\n</svg>",
        escape(words),
        chart::axes(&x, &y, ["along the warp [mm]", "along the weft [mm]"]),
        SIDES[0],
    )
}

/// Width and height of the whole ply [mm].
fn extent(strip: &AnimatedPly) -> [f64; 2] {
    [0, 1].map(|own| 1e3 * MapAxis::new(strip, own).whole)
}

/// A PNG of the whole ply, weft upwards, with a colour between those of the cells around a place, and none where both yarns are
/// gone.
fn picture(strip: &AnimatedPly, keyframe: &Keyframe, peak: f32) -> Vec<u8> {
    let spans = [0, 1].map(|own| MapAxis::new(strip, own));
    let longest = spans[0].whole.max(spans[1].whole);
    let size = [0, 1].map(|own| ((PIXELS * spans[own].whole / longest).round() as usize).max(1));
    let [columns, rows] = [0, 1].map(|own| {
        let middle = |pixel: usize| (pixel as f64 + 0.5) / size[own] as f64 * spans[own].whole;
        (0..size[own]).map(|pixel| spans[own].around(middle(pixel))).collect::<Vec<_>>()
    });
    let count = strip.counts()[0];
    let tension = |column: usize, row: usize| {
        keyframe.tension[row * count + column].into_iter().flatten().reduce(f32::max).map(f64::from)
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
            pixels.extend(colour::colour(sum / weights / f64::from(peak.max(1e-9))));
            pixels.push(255);
        }
    }
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    // Writing to memory cannot fail; a picture that is not there leaves the axes.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { out } else { Vec::new() }
}

/// A strip along one of its ply's axes.
struct MapAxis {
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

impl MapAxis {
    fn new(strip: &AnimatedPly, own: usize) -> Self {
        let lines = &strip.lines[own];
        let step = if own == 0 { 1 } else { strip.lines[0].len() };
        let first = strip.reference[0];
        let distance = |line: usize| {
            let at = strip.reference[line * step];
            f64::from(at[0] - first[0]).hypot(f64::from(at[1] - first[1]))
        };
        let distances: Vec<f64> = (0..lines.len()).map(distance).collect();
        let (from, to) = (lines[0], lines[lines.len() - 1]);
        let length = distances[distances.len() - 1];
        // What is not kept is the mirror image of what is.
        let whole = length * strip.elements[own] as f64 / (to - from).max(1) as f64;
        Self { lines: distances, start: if from == 0 { 0.0 } else { whole - length }, whole }
    }

    /// The cells at a place, counted from the edge of the ply [m].
    fn around(&self, place: f64) -> Around {
        let length = self.lines[self.lines.len() - 1];
        let is_kept = |at: &f64| (0.0..=length).contains(at);
        let kept = Some(place - self.start).filter(is_kept);
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
#[path = "map_tests.rs"]
mod tests;
