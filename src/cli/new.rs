//! `ripstop new`: a case to start from. Known fabrics and projectiles stand in `presets.json`.

use std::fs;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use ripstop::output::number::short;
use ripstop::{case, output};
use serde_json::{Map, Number, Value, json};

use super::terminal::{self, CommandFailure};

/// File beside every new case, for editors.
const SCHEMA: &str = "ripstop.schema.json";
/// Side of the pack [mm]: the paper's frame.
const SIDE: u32 = 203;
/// Density of steel [kg/m³].
const STEEL: f64 = 7850.0;
/// Text under `notes` of the new case.
const NOTES: &str = "Lengths in mm, masses in g, times in us; every key ends in its unit. `ripstop check` shows what each value is and \
    where it comes from. What has the source `assumed` was not published for this fabric or projectile: put your own value and say \
    under `sources` where you have it from. Keys left out have defaults; `ripstop schema` describes every key, and an editor that \
    knows JSON Schema shows it as you type. The run ends when its outcome is known, or at /solver/end_time_us.";

/// `ripstop new`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop new shot.json --fabric twaron-ct709 --plies 4 --projectile fsp-22 --velocity 350
  ripstop new shot.json --fabric my-fabric.json --projectile sphere:6.35 --velocity 300
  ripstop new shot.json --from-sheet

--fabric and --projectile without a known name list what there is.")]
pub(crate) struct NewArguments {
    /// Case file to write
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Fabric: a name, or a file with the keys of a fabric
    #[arg(long, value_name = "NAME|FILE", default_value = "s-720")]
    fabric: String,
    /// Ask for the numbers of the fabric's data sheet, with their units; answers may come from a file
    #[arg(long, conflicts_with = "fabric")]
    from_sheet: bool,
    /// Plies
    #[arg(long, value_name = "N", default_value = "1")]
    plies: Number,
    /// Projectile: a name, or sphere:D, ball:D, rcc:D, cylinder:DxL, ogive:DxL, cone:DxL with sizes in mm, of solid steel
    #[arg(long, value_name = "NAME", default_value = "rcc-paper")]
    projectile: String,
    /// Velocity [m/s], or with its unit, such as "510 ft/s"
    #[arg(long, value_name = "M_S", default_value = "200", allow_negative_numbers = true)]
    velocity: String,
    /// Write over FILE where there is one
    #[arg(long)]
    force: bool,
}

/// Writes the case and its schema, and says what to do next.
pub(crate) fn new(arguments: &NewArguments) -> Result<(), CommandFailure> {
    let NewArguments { file, fabric, from_sheet, plies, projectile, velocity, force } = arguments;
    if file.exists() && !force {
        let failure = CommandFailure::expected(file.display(), "a file that is not there yet", "one that is");
        return Err(failure.help("--force writes over it"));
    }
    let given =
        if *from_sheet { ask_fabric(&mut io::stdin().lock(), io::stdin().is_terminal()) } else { read_fabric(fabric) };
    let (fabric_name, fabric, mut sources) = given?;
    let (what, mut projectile, its_sources) = read_projectile(projectile)?;
    let number = velocity.parse::<Number>().ok().map(Value::from).or_else(|| case::value_in("velocity_m_s", velocity));
    projectile["velocity_m_s"] = number.ok_or_else(|| {
        let found = format!("{velocity:?}");
        CommandFailure::expected("--velocity", "a number in m/s, or with its unit, such as \"510 ft/s\"", found)
    })?;
    projectile["friction"] = json!(0.2);
    let chosen = json!("chosen with `ripstop new`");
    sources.insert("/pack".to_owned(), chosen.clone());
    sources.extend(its_sources.into_iter().map(|(pointer, text)| (format!("/projectile{pointer}"), text)));
    sources.insert("/projectile/velocity_m_s".to_owned(), chosen);
    sources.insert("/projectile/friction".to_owned(), json!("assumed: not published"));
    let count = if *plies == Number::from(1) { "1 ply".to_owned() } else { format!("{plies} plies") };
    let mut title = format!("{fabric_name}, {count}, {what}");
    let mut document = json!({
        "$schema": SCHEMA,
        "title": title,
        "notes": NOTES,
        "fabric": fabric,
        "pack": { "plies": plies, "width_mm": SIDE, "height_mm": SIDE, "edges": "clamped", "friction": 0.2 },
        "projectile": projectile,
        "output": { "history_interval_us": 0.5, "profile_times_us": [20, 40, 60, 80, 100] },
        "sources": sources,
    });
    let name = file.display().to_string();
    let folder = file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    // In m/s whatever the unit of the answer: so changes of the velocity find it.
    let velocity = case::from_str(&name, &document.to_string(), &[])?.projectile.map_or(0.0, |body| body.velocity);
    title += &format!(" at {} m/s", short(velocity, 6));
    document["title"] = json!(title);
    let text = format!("{document:#}\n");
    for (path, text) in [(&folder.join(SCHEMA), format!("{:#}\n", case::schema())), (file, text)] {
        let refused = |error| CommandFailure::expected(path.display(), "a file that can be written", error);
        output::write_whole(path, |file| file.write_all(text.as_bytes())).map_err(refused)?;
    }
    let pointed = ["ogive", "cone"].iter().any(|shape| document["projectile"]["shape"] == *shape);
    let point =
        if pointed { "the radius of its tip, /projectile/edge_radius_mm, decides the limit: vary it\n" } else { "" };
    terminal::print(&format!(
        "{name}: {title}\n  ripstop check {name}   every value, with its source; assumed ones marked\n  \
         ripstop run {name}     the shot, until its outcome is known\n{point}",
    ))
}

/// Known fabrics or projectiles by name.
fn presets(kind: &str) -> Map<String, Value> {
    let all: Value = serde_json::from_str(include_str!("presets.json")).unwrap_or_default();
    all[kind].as_object().cloned().unwrap_or_default()
}

/// Refusal of a name, with those that are known and their meaning.
fn unknown(flag: &str, found: &str, more: &str) -> CommandFailure {
    let known = presets(&format!("{}s", &flag[2..]));
    let names: Vec<&str> = known.keys().map(String::as_str).collect();
    let what = |preset: &Value| preset.as_str().or(preset["what"].as_str()).unwrap_or_default().to_owned();
    let lines: Vec<String> = known.iter().map(|(name, preset)| format!("{name:14} {}", what(preset))).collect();
    let failure = CommandFailure::expected(flag, format!("{}, {more}", names.join(", ")), format!("{found:?}"));
    failure.help(lines.join("\n        "))
}

/// A projectile: its name in the title, keys, and sources by pointer within it.
type Projectile = (String, Value, Map<String, Value>);

/// A projectile by its name, or by shape and size [mm]: `sphere:6.35`, `rcc:5.5`, `cylinder:5.5x8`, `ogive:9x15`.
fn read_projectile(given: &str) -> Result<Projectile, CommandFailure> {
    if let Some(known) = presets("projectiles").get(given) {
        let sources = known["sources"].as_object().cloned().unwrap_or_default();
        return Ok((known["title"].as_str().unwrap_or(given).to_owned(), known["projectile"].clone(), sources));
    }
    solid(given)
        .ok_or_else(|| unknown("--projectile", given, "or sphere:D, rcc:D, cylinder:DxL, ogive:DxL, cone:DxL [mm]"))
}

/// A solid body of steel: its mass follows from its size.
fn solid(given: &str) -> Option<Projectile> {
    let (shape, size) = given.split_once(':')?;
    let sizes = size.split('x').map(|part| part.parse().ok().filter(|size: &f64| *size > 0.0));
    let (what, shape, diameter, length) = match (shape, &sizes.collect::<Option<Vec<f64>>>()?[..]) {
        ("sphere" | "ball", [d]) => (format!("{d} mm steel ball"), "sphere", *d, None),
        ("rcc", [d]) => (format!("{d} mm steel RCC"), "cylinder", *d, Some(*d)),
        ("cylinder", [d, length]) => (format!("{d} × {length} mm steel cylinder"), "cylinder", *d, Some(*length)),
        ("ogive" | "cone", [d, length]) => (format!("{d} × {length} mm steel {shape}"), shape, *d, Some(*length)),
        _ => return None,
    };
    let mut projectile = json!({ "shape": shape, "diameter_mm": diameter });
    if let Some(length) = length {
        projectile["length_mm"] = json!(length);
    }
    projectile["density_kg_m3"] = json!(STEEL);
    let sources = [("", "size of the name"), ("/density_kg_m3", "handbooks: steel")];
    Some((what, projectile, sources.into_iter().map(|(place, text)| (place.to_owned(), json!(text))).collect()))
}

/// A fabric by name or from a file: its name, its keys, and its sources as pointers of a case.
fn read_fabric(given: &str) -> Result<Projectile, CommandFailure> {
    let text = match case::builtin_fabric(&format!("fabrics/{given}.json")) {
        Some(text) => text.to_owned(),
        None => fs::read_to_string(given)
            .map_err(|error| unknown("--fabric", given, &format!("or a file with the keys of a fabric ({error})")))?,
    };
    let (fabric, sources) = case::fabric_from_str(given, &text)?;
    let name = fabric["name"].as_str().unwrap_or("fabric").to_owned();
    Ok((name, fabric, sources))
}

/// A number of a data sheet: question, an example of the answer, yarn (empty: the fabric), keys it may be for, and what an empty answer means.
struct Question(&'static str, &'static str, &'static str, &'static [&'static str], Empty);

/// What an empty answer means.
#[derive(Clone, Copy)]
enum Empty {
    /// It is no answer.
    Refused,
    /// The key is left out.
    LeftOut(&'static str),
    /// This answer, which is assumed.
    Assumed(&'static str),
    /// That of the question before.
    Again,
}

/// Questions for a fabric. Counts of a sheet are yarns side by side, those of a case crossovers along a yarn.
const SHEET: [Question; 11] = [
    Question("density of the fibre", "1.44 g/cm3", "", &["fibre_density_kg_m3"], Empty::Assumed("1440 kg/m3")),
    Question("linear density, warp", "600 den, 670 dtex or 67 tex", "warp", &LINEAR_DENSITY, Empty::Refused),
    Question("linear density, weft", "600 den", "weft", &LINEAR_DENSITY, Empty::Again),
    Question("modulus", "84 GPa or 12.2 Msi", "warp", &["modulus_gpa"], Empty::Refused),
    Question("strength or elongation", "3.4 GPa, 24 g/den, 203 cN/tex or 3.6 %", "warp", &STRENGTH, Empty::Refused),
    Question("warp yarns side by side (ends)", "34 /in or 13.4 /cm", "weft", &COUNT, Empty::Refused),
    Question("weft yarns side by side (picks)", "34 /in", "warp", &COUNT, Empty::Again),
    Question("areal density", "180 g/m2 or 5.3 oz/yd2", "", &["areal_density_g_m2"], Empty::LeftOut("of the yarns")),
    Question("crimp, warp", "1 %", "warp", &["crimp"], Empty::LeftOut("from the areal density")),
    Question("crimp, weft", "1 %", "weft", &["crimp"], Empty::LeftOut("from the areal density")),
    Question("thickness", "0.23 mm or 9 mil", "", &["thickness_mm"], Empty::LeftOut("assumed")),
];
const LINEAR_DENSITY: [&str; 3] = ["linear_density_denier", "linear_density_dtex", "linear_density_tex"];
const COUNT: [&str; 2] = ["count_per_inch", "count_per_cm"];
const STRENGTH: [&str; 5] = ["strength_gpa", "strength_mpa", "tenacity_g_den", "tenacity_cn_tex", "failure_strain"];

/// Asks for a fabric, line by line: its name, its keys, and its sources as pointers of a case. `typed`: by a person, who may answer again.
fn ask_fabric(answers: &mut impl BufRead, typed: bool) -> Result<Projectile, CommandFailure> {
    let mut ask = |question: &str, more: &str| {
        terminal::print(&format!("{question} ({more}): "))?;
        let mut line = String::new();
        let refused = |error| CommandFailure::expected(question, "an answer that can be read", error);
        if answers.read_line(&mut line).map_err(refused)? == 0 && typed {
            return Err(CommandFailure::expected(question, "an answer", "the end of what was typed"));
        }
        Ok::<_, CommandFailure>(line.trim().to_owned())
    };
    let name = ask("name of the fabric", "Kevlar S-706")?;
    let name = if name.is_empty() { "fabric".to_owned() } else { name };
    let sheet = format!("data sheet of {name}");
    let mut fabric = json!({ "name": name, "warp": {}, "weft": {} });
    let mut sources = Map::from_iter([("/fabric".to_owned(), json!(sheet))]);
    let mut last = String::new();
    for Question(question, example, yarn, keys, empty) in SHEET {
        let more = match empty {
            Empty::Refused => example.to_owned(),
            Empty::LeftOut(how) => format!("{example}; empty: {how}"),
            Empty::Assumed(value) => format!("{example}; empty: {value}, assumed"),
            Empty::Again => format!("{example}; empty: {last}"),
        };
        let before = last;
        let (key, value) = loop {
            last = match (ask(question, &more)?, empty) {
                (answer, _) if !answer.is_empty() => answer,
                (_, Empty::Assumed(value)) => {
                    sources.insert(format!("/fabric/{}", keys[0]), json!("assumed: not on the sheet"));
                    value.to_owned()
                }
                (_, Empty::Again) => before.clone(),
                (answer, _) => answer,
            };
            let values: Vec<(&str, Value)> =
                keys.iter().filter_map(|key| Some((*key, case::value_in(key, &last)?))).collect();
            // The key in the unit of the answer, if there is one.
            match values.iter().find(|(_, value)| value.is_number()).or(values.first()) {
                Some((key, value)) => break (*key, value.clone()),
                None if last.is_empty() && matches!(empty, Empty::LeftOut(_)) => break ("", Value::Null),
                None => {
                    let expected = format!("a number with its unit: {example}");
                    let failure = CommandFailure::expected(question, expected, format!("{last:?}"));
                    // Who types is asked again; answers of a file would be taken for others from here on.
                    if !typed {
                        return Err(failure);
                    }
                    failure.report();
                }
            }
        };
        if !value.is_null() {
            let object = if yarn.is_empty() { &mut fabric } else { &mut fabric[yarn] };
            object[key] = value;
        }
    }
    // A sheet has one fibre.
    for key in ["modulus_gpa"].into_iter().chain(STRENGTH) {
        if let Some(value) = fabric["warp"].get(key).cloned() {
            fabric["weft"][key] = value;
        }
    }
    Ok((name, fabric, sources))
}
