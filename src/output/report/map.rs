//! Tension maps of the struck ply at three moments, as pictures inside drawings with axes.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::super::chart::{self, Axis, escape};
use super::super::number::short;
use super::colour;
use super::film::{Film, Still, Strip};
use crate::simulation::Run;

/// Width of a drawing, and the ends of its picture.
const WIDTH: f64 = 300.0;
const SIDES: [f64; 2] = [52.0, WIDTH - 10.0];
const TOP: f64 = 8.0;

/// The maps with their legend; empty without a film.
pub(super) fn maps(film: &Film, run: &Run) -> String {
    let Some(strip) = film.strips.first() else { return String::new() };
    let peak = film.peak_tension();
    let moments = moments(film, run);
    let mut out = "<figure class=\"plot wide\" id=\"tension\">\n<figcaption><h3>Yarn tension in the struck ply</h3>\
                   <p>The larger of warp and weft in each crossover; holes are where both yarns have failed.</p></figcaption>\n\
                   <div class=\"maps\">\n"
        .to_owned();
    for (n, (at, what)) in moments.iter().enumerate() {
        let still = &film.stills[*at];
        let words = format!("{} µs: {what}", short(still.time * 1e6, 3));
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<div class=\"map\"><h4>{}</h4>{}</div>",
            escape(&words),
            map(strip, still, peak, &format!("tension-{n}"), &words)
        );
    }
    let _ = writeln!(
        out,
        "</div>\n<p class=\"scale\"><span>0 N</span><i></i><span>{} N</span></p></figure>",
        short(f64::from(peak), 3)
    );
    out
}

/// Pictures to show and what they show: on the way, when the fabric holds most, and the last.
fn moments(film: &Film, run: &Run) -> Vec<(usize, &'static str)> {
    let last = film.stills.len().saturating_sub(1);
    let strongest = |still: &Still| still.tension.iter().flatten().flatten().copied().fold(0.0, f32::max);
    let (most, what) = match run.events.first() {
        Some(event) => {
            let time = event.step as f64 * run.time_step;
            (
                film.stills.partition_point(|still| still.time <= time).saturating_sub(1),
                "just before the first yarn fails",
            )
        }
        None => {
            let most = (0..=last).max_by(|a, b| strongest(&film.stills[*a]).total_cmp(&strongest(&film.stills[*b])));
            (most.unwrap_or(last), "when the tension is largest")
        }
    };
    let most = if most == last || most == 0 { (last / 2, "halfway") } else { (most, what) };
    let mut all = vec![(most.0.div_ceil(2), "on the way"), most, (last, "the last picture")];
    all.retain(|(at, _)| *at < film.stills.len());
    all.dedup_by_key(|(at, _)| *at);
    all
}

fn map(strip: &Strip, still: &Still, peak: f32, id: &str, words: &str) -> String {
    let [across, up] = extent(strip);
    let width = SIDES[1] - SIDES[0];
    let height = (width * up / across).clamp(40.0, 320.0);
    let bottom = TOP + height;
    let x = Axis::linear([-0.5 * across, 0.5 * across], SIDES);
    let y = Axis::linear([-0.5 * up, 0.5 * up], [bottom, TOP]);
    let total = bottom + 44.0;
    let picture = BASE64_STANDARD.encode(picture(strip, still, peak));
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
fn extent(strip: &Strip) -> [f64; 2] {
    let length = strip.lines[0].len();
    let corner = strip.reference[0];
    let ends = [strip.reference[length - 1], strip.reference[strip.reference.len() - length]];
    [0, 1].map(|own| {
        let size = f64::from(ends[own][0] - corner[0]).hypot(f64::from(ends[own][1] - corner[1]));
        let kept = strip.lines[own][strip.lines[own].len() - 1] - strip.lines[own][0];
        1e3 * size * strip.elements[own] as f64 / kept.max(1) as f64
    })
}

/// A PNG with a pixel for each element of the whole ply, weft upwards; without a colour where both yarns are gone.
fn picture(strip: &Strip, still: &Still, peak: f32) -> Vec<u8> {
    let [columns, rows] = strip.elements;
    let cells = [0, 1].map(|own| (0..strip.elements[own]).map(|at| cell_of(strip, own, at)).collect::<Vec<_>>());
    let count = strip.counts()[0];
    let mut pixels = Vec::with_capacity(4 * columns * rows);
    for row in cells[1].iter().rev() {
        for column in &cells[0] {
            let tension = still.tension[row * count + column];
            let largest = tension.into_iter().flatten().reduce(f32::max);
            match largest {
                Some(tension) => {
                    pixels.extend(colour::colour(f64::from(tension / peak.max(1e-9))));
                    pixels.push(255);
                }
                None => pixels.extend([0; 4]),
            }
        }
    }
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    // Writing to memory cannot fail; a picture that is not there leaves the axes.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { out } else { Vec::new() }
}

/// The cell that shows an element of the whole ply along one of its axes, or that shows its mirror image.
fn cell_of(strip: &Strip, own: usize, element: usize) -> usize {
    let lines = &strip.lines[own];
    let inside = |at: usize| lines[0] <= at && at < lines[lines.len() - 1];
    let at = if inside(element) { element } else { strip.elements[own] - 1 - element };
    lines.partition_point(|line| *line <= at).saturating_sub(1).min(lines.len().saturating_sub(2))
}
