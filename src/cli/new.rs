//! `ripstop new`: a case to start from.

use std::io::{self, BufRead as _, IsTerminal as _, Write as _};
use std::path::Path;

use ripstop::{case, output};
use serde_json::{Map, Number, Value, json};

use super::arguments::NewArguments;
use super::failure::CommandFailure;
use super::presets::{self, FABRICS, Preset};
use super::{input, screen};

/// Beside every new case, for editors.
const SCHEMA: &str = "ripstop.schema.json";
/// Side of the pack [mm]: the paper's frame.
const SIDE: u32 = 203;

/// Writes the case and its schema, and says what to do next.
pub(crate) fn new(arguments: &NewArguments) -> Result<(), CommandFailure> {
    let file = &arguments.file;
    if file.exists() && !arguments.force {
        let failure = CommandFailure::expected(file.display(), "a file that is not there yet", "one that is");
        return Err(failure.help("--force writes over it"));
    }
    let (name, fabric, mut sources) =
        answer(arguments.fabric.as_deref(), "fabric", "s-720", &menu(&FABRICS), read_fabric)?;
    let plies = answer(arguments.plies.as_deref(), "plies", "1", "", |typed| {
        number("--plies", "pack/properties/plies", typed)
    })?;
    let projectile = answer(
        arguments.projectile.as_deref(),
        "projectile",
        "rcc-paper",
        &menu(&presets::projectiles()),
        read_projectile,
    )?;
    let velocity = answer(arguments.velocity.as_deref(), "velocity [m/s]", "200", "", |typed| {
        number("--velocity", "projectile/properties/velocity_m_s", typed)
    })?;
    let Preset { what, mut keys, sources: of_projectile } = projectile;
    keys.insert("velocity_m_s".to_owned(), json!(velocity));
    keys.insert("friction".to_owned(), json!(0.2));
    let chosen = "chosen with `ripstop new`";
    sources.insert("/pack".to_owned(), json!(chosen));
    for (key, text) in of_projectile {
        let place = if key.is_empty() { "/projectile".to_owned() } else { format!("/projectile/{key}") };
        sources.insert(place, json!(text));
    }
    sources.insert("/projectile/velocity_m_s".to_owned(), json!(chosen));
    sources.insert("/projectile/friction".to_owned(), json!("assumed: not published"));
    let count = if plies == Number::from(1) { "1 ply".to_owned() } else { format!("{plies} plies") };
    let document = json!({
        "$schema": SCHEMA,
        "title": format!("{name}, {count}, {what} at {velocity} m/s"),
        "notes": NOTES,
        "fabric": fabric,
        "pack": { "plies": plies, "width_mm": SIDE, "height_mm": SIDE, "edges": "clamped", "friction": 0.2 },
        "projectile": keys,
        "output": { "history_interval_us": 0.5, "profile_times_us": [20, 40, 60, 80, 100] },
        "sources": sources,
    });
    let text = format!("{document:#}\n");
    let name = file.display().to_string();
    let folder = input::folder(file);
    case::from_text(&name, &text, folder, &[])?;
    write(&folder.join(SCHEMA), &format!("{:#}\n", case::schema()))?;
    write(file, &text)?;
    screen::print(&format!(
        "{name}: {}\n  ripstop check {name}   every value, with its source; assumed ones marked\n  \
         ripstop run {name}     the shot, until its outcome is known\n",
        document["title"].as_str().unwrap_or_default(),
    ))
}

/// What stands in the new case under `notes`.
const NOTES: &str = "Lengths in mm, masses in g, times in us; every key ends in its unit. `ripstop check` shows what each value is and \
    where it comes from. What has the source `assumed` was not published for this fabric or projectile: put your own value and say \
    under `sources` where you have it from. Keys left out have defaults; `ripstop schema` describes every key, and an editor that \
    knows JSON Schema shows it as you type. The run ends when its outcome is known, or at /solver/end_time_us.";

/// What `read` makes of a flag's value, or of what is typed, asked for until it can be read, or of the default where nobody can
/// be asked.
fn answer<T>(
    given: Option<&str>,
    what: &str,
    default: &str,
    menu: &str,
    read: impl Fn(&str) -> Result<T, CommandFailure>,
) -> Result<T, CommandFailure> {
    if given.is_some() || !asks() {
        return read(given.unwrap_or(default));
    }
    screen::print(menu)?;
    loop {
        match read(&ask(what, default)?) {
            Err(failure) => screen::complain(failure.message()),
            read => return read,
        }
    }
}

/// A number within the bounds that the schema has at `place`.
fn number(flag: &str, place: &str, typed: &str) -> Result<Number, CommandFailure> {
    let schema = case::schema();
    let key = &schema.pointer(&format!("/properties/{place}")).unwrap_or(&Value::Null);
    let bound = |name: &str| key[name].as_f64();
    let fits = |number: &Number| {
        let value = number.as_f64().unwrap_or(f64::NAN);
        bound("minimum").is_none_or(|least| value >= least)
            && bound("exclusiveMinimum").is_none_or(|least| value > least)
            && bound("maximum").is_none_or(|most| value <= most)
            && (key["type"] != "integer" || number.is_u64())
    };
    typed.parse().ok().filter(fits).ok_or_else(|| {
        let kind = if key["type"] == "integer" { "a whole number" } else { "a number" };
        let least = bound("minimum").map_or("above 0".to_owned(), |least| format!("from {least}"));
        let most = bound("maximum").unwrap_or(f64::INFINITY);
        CommandFailure::expected(flag, format!("{kind} {least}, at most {most}"), format!("{typed:?}"))
    })
}

/// Whether somebody sits at the terminal.
fn asks() -> bool {
    io::stdin().is_terminal() && io::stdout().is_terminal()
}

fn ask(what: &str, default: &str) -> Result<String, CommandFailure> {
    let failed = |error: io::Error| CommandFailure::input(format!("error: cannot ask for the {what}: {error}"));
    let mut out = io::stdout().lock();
    write!(out, "{what} [{default}]: ").and_then(|()| out.flush()).map_err(failed)?;
    let mut line = String::new();
    if io::stdin().lock().read_line(&mut line).map_err(failed)? == 0 {
        return Err(failed(io::ErrorKind::UnexpectedEof.into()));
    }
    let typed = line.trim();
    Ok(if typed.is_empty() { default } else { typed }.to_owned())
}

fn menu(known: &[(&str, &str)]) -> String {
    known.iter().map(|(name, what)| format!("  {name:14} {what}\n")).collect()
}

fn unknown(flag: &str, found: &str, known: &[(&str, &str)], more: &str) -> CommandFailure {
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    CommandFailure::expected(flag, format!("{}, {more}", names.join(", ")), format!("{found:?}"))
}

fn read_projectile(given: &str) -> Result<Preset, CommandFailure> {
    let more = "or sphere:D, rcc:D, cylinder:DxL [mm]";
    presets::projectile(given).ok_or_else(|| unknown("--projectile", given, &presets::projectiles(), more))
}

/// A fabric by name or from a file: its name, its keys, and its sources as pointers of a case.
fn read_fabric(given: &str) -> Result<(String, Value, Map<String, Value>), CommandFailure> {
    let text = match presets::fabric(given) {
        Some(text) => text.to_owned(),
        None => input::text(given).map_err(|error| {
            let more = format!("or a file with the keys of a fabric ({error})");
            unknown("--fabric", given, &FABRICS, &more)
        })?,
    };
    let wrong = |found: String| CommandFailure::expected(given, "an object with the keys of a fabric", found);
    let mut fabric: Value = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let Value::Object(keys) = &mut fabric else { return Err(wrong("something else".to_owned())) };
    let name = keys.get("name").and_then(Value::as_str).unwrap_or("fabric").to_owned();
    let own = keys.shift_remove("sources");
    let mut sources = Map::new();
    sources.insert("/fabric".to_owned(), json!(given));
    for (pointer, text) in own.as_ref().and_then(Value::as_object).into_iter().flatten() {
        sources.insert(format!("/fabric{pointer}"), text.clone());
    }
    Ok((name, fabric, sources))
}

/// Whole or not at all.
fn write(path: &Path, text: &str) -> Result<(), CommandFailure> {
    let staged = output::temporary(input::folder(path)).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        Ok(file)
    });
    let put = staged.and_then(|file| file.persist(path).map_err(|error| error.error));
    let failed = |error| CommandFailure::expected(path.display(), "a file that can be written", error);
    put.map(drop).map_err(failed)
}
