//! `report.html`: one file that tells what happened in a run, whether to trust it, and shows it moving.
//!
//! It asks nothing of a network and says so in its content security policy; style and script are `page.css`, `page.js` and `values.js`. All
//! text that a user wrote is escaped. But for machine and timing, the same run gives the same bytes.

#[doc(hidden)]
pub mod animated_ply;
mod animation;
mod colour;
mod fabric;
mod figure;
mod history;
mod map;
mod playback;
mod sections;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::chart::escape;
use super::checks::checks;
use super::number::short;
use crate::case::Case;
use crate::run::Run;
pub use animation::Animation;

/// What the page looks like, and how it plays.
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = concat!(include_str!("page.js"), include_str!("values.js"));

/// The page. With a animation of less than two pictures it has neither playback nor maps.
pub fn report(case: &Case, run: &Run, summary: &Value, animation: &Animation) -> String {
    let animation = animation.shown();
    let animation = Some(&animation).filter(|animation| animation.keyframes.len() > 1);
    let signs = checks(case, run);
    let mut out = head(case);
    out += "<body>\n<main>\n";
    out += &sections::header(case, run, &signs);
    out += &animation.map_or(String::new(), |animation| player(case, animation));
    out += "<section id=\"plots\"><h2>The shot in figures</h2><div class=\"plots\">\n";
    if case.projectile.is_some() {
        out += &history::velocity(run).html();
        out += &history::force(run).html();
    }
    out += &animation.and_then(fabric::deflection).map_or(String::new(), |figure| figure.html());
    out += &history::energy(run).html();
    out += &history::plies(run).map_or(String::new(), |figure| figure.html());
    out += &history::failures(case, run).html();
    let fabric = [fabric::profiles(case, run, animation), fabric::unit_cell(case)];
    out += &fabric.iter().flatten().map(figure::Figure::html).collect::<String>();
    out += &animation.map_or(String::new(), |animation| map::maps(animation, run));
    out += "</div></section>\n";
    out += &sections::trust(case, &signs, summary);
    out += &sections::energy(run);
    out += &sections::case(case);
    out += &sections::machine(run, summary);
    out += "<p class=\"note\">Files beside this page: summary.json, history.csv, events.csv, case.json.</p>\n";
    out + "</main>\n<script>" + SCRIPT + "</script>\n</body>\n</html>\n"
}

fn head(case: &Case) -> String {
    let hash = BASE64_STANDARD.encode(Sha256::digest(SCRIPT));
    let title = escape(&case.title);
    let style = STYLE.replace("GRADIENT", &colour::gradient());
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
         script-src 'sha256-{hash}'; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title} – ripstop</title>\n<style>{style}</style>\n</head>\n"
    )
}

/// The playback: what it needs, and its controls, which the script brings to life.
fn player(case: &Case, animation: &Animation) -> String {
    let Some(playback) = playback::pack(case, animation) else { return String::new() };
    // No `<` in a script element: nothing can end it.
    let description = playback.description.to_string().replace('<', "\\u003c");
    let shown: Vec<String> = animation.strips.iter().map(|strip| (strip.ply + 1).to_string()).collect();
    let plies = if animation.plies > shown.len() {
        format!(" Of {} plies these are shown: {}.", animation.plies, shown.join(", "))
    } else {
        String::new()
    };
    let peak = short(f64::from(animation.peak_tension()), 3);
    format!(
        "<section id=\"playback\"><h2>The shot in motion</h2>\n\
         <div class=\"player\" hidden>\n\
         <canvas id=\"scene\" tabindex=\"0\" role=\"img\" aria-label=\"Fabric and projectile in three dimensions\"></canvas>\n\
         <div class=\"controls\">\n\
         <button type=\"button\" id=\"play\" aria-pressed=\"false\">Play</button>\n\
         <input type=\"range\" id=\"scrub\" min=\"0\" value=\"0\" step=\"1\" aria-label=\"Time\">\n\
         <output id=\"clock\" for=\"scrub\">0 µs</output>\n</div>\n\
         <div class=\"controls\">\n\
         <label>Colour <select id=\"colour\"><option value=\"0\">tension, both yarns</option><option value=\"1\">tension, warp</option>\
         <option value=\"2\">tension, weft</option><option value=\"3\">deflection</option></select></label>\n\
         <label>View <select id=\"view\"><option value=\"0\">section</option><option value=\"1\">oblique</option>\
         <option value=\"2\">side</option><option value=\"3\">exit side</option><option value=\"4\">struck side</option></select></label>\n\
         <label><input type=\"checkbox\" id=\"cut\"> cut open</label>\n\
         <button type=\"button\" id=\"save\">Save picture</button>\n</div>\n\
         <p class=\"scale\"><span id=\"low\">0 N</span><i></i><span id=\"high\" data-tension=\"{peak} N\">{peak} N</span></p>\n\
         <p class=\"note\">Space plays and pauses, ← → step, Home and End jump, drag turns, wheel or + − zoom.{plies} \
         The projectile comes from below. Drawn to scale from a thinned mesh; the numbers are in the files.</p>\n</div>\n\
         <figure class=\"printed\" id=\"paper\" hidden></figure>\n\
         <p class=\"still\" id=\"instead\">The moving picture needs a screen, JavaScript and WebGL 2; the tension maps below show three moments of it.</p>\n\
         <script type=\"application/json\" id=\"animation\">{description}</script>\n\
         <script type=\"application/octet-stream\" id=\"animation-numbers\">{}</script>\n</section>\n",
        playback.base64
    )
}
