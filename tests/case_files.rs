//! Case files: what is read, what is refused and how that is said. Public API only.
//!
//! Promise: any bytes whatever give a checked case or one error with place, expectation and finding; never a panic. The words of
//! refusals and the fields of cases are those of `snapshots/`, whose lines that begin with `#` are what is read.
//! Red when: a text of these, a number or its source changes. Cannot see: a refusal that has no line there.

mod changes;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use ripstop::case::{self, BuiltInFabric, Case, CaseError, Edge, Field};
use ripstop::physics::projectile_body::Body;
use serde_json::{Map, Value, json};

use crate::fuzz::assert_well_formed;
use crate::support::close;

/// A case that gives every key that a free cylinder and a pack of two kinds of plies can have.
fn good() -> Value {
    serde_json::from_str(include_str!("case_files/good.json")).unwrap()
}

/// A shot with as few keys as can be.
fn plain() -> Value {
    json!({
        "title": "plain",
        "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 50, "height_mm": 50},
        "projectile": {"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 100},
    })
}

/// A case of 3 mm by 2 mm elements, 30 mm along warp 10 of them, 8 mm along weft 4; its second group has half as many along the warp.
fn laid() -> Value {
    let yarn = |count: f64| {
        json!({"linear_density_denier": 1420, "modulus_gpa": 96, "failure_strain": 0.035, "count_per_cm": count,
            "crimp": 0.01})
    };
    let mut document = good();
    put(&mut document, "/fabric/warp", yarn(10.0 / 3.0));
    put(&mut document, "/fabric/weft", yarn(5.0));
    let mut coarse = document["fabric"].clone();
    put(&mut coarse, "/name", json!("coarse"));
    put(&mut coarse, "/warp", yarn(10.0 / 6.0));
    put(&mut document, "/pack", json!({"width_mm": 30, "height_mm": 8, "layup": [{}, {"fabric": coarse, "plies": 2}]}));
    remove(&mut document, "/sources");
    document
}

/// A document and changes from the command line, of a line such as `good & /pack/plies=2 & -/title & --set /pack/friction=0`: a case, then
/// what is changed in it. `-/pointer` leaves a key out, `--set` is a change from the command line, all else is put into the file.
fn document_of(line: &str) -> (Value, Vec<String>) {
    let mut parts = line.split(" & ");
    let mut document = match parts.next().unwrap() {
        "good" => good(),
        "laid" => laid(),
        shape => {
            let mut document = plain();
            if shape != "plain" {
                put(&mut document, "/projectile/shape", json!(shape));
                put(&mut document, "/projectile/length_mm", json!(12));
            }
            document
        }
    };
    let mut sets = Vec::new();
    for part in parts {
        match (part.strip_prefix("--set "), part.strip_prefix('-'), part.split_once('=')) {
            (Some(set), ..) => sets.push(set.to_owned()),
            (_, Some(pointer), _) => remove(&mut document, pointer),
            (.., Some((pointer, value))) => put(&mut document, pointer, serde_json::from_str(value).unwrap()),
            _ => panic!("{line}"),
        }
    }
    (document, sets)
}

/// The case of such a line.
fn case_of(line: &str) -> Result<Case, CaseError> {
    let (document, sets) = document_of(line);
    case::from_str("case.json", &document.to_string(), &sets)
}

fn read(value: &Value) -> Result<Case, CaseError> {
    case::from_str("good.json", &value.to_string(), &[])
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = good();
    put(&mut document, pointer, value);
    document
}

fn put(document: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(map) => drop(map.insert(unescape(key), value)),
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        other => panic!("{pointer} is inside {other}"),
    }
}

fn remove(document: &mut Value, pointer: &str) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().shift_remove(&unescape(key));
}

fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}

/// Every pointer into a document, itself aside.
fn pointers(value: &Value) -> Vec<String> {
    fn collect(prefix: &str, value: &Value, found: &mut Vec<String>) {
        let children: Vec<(String, &Value)> = match value {
            Value::Object(map) => map.iter().map(|(key, child)| (key.replace('/', "~1"), child)).collect(),
            Value::Array(list) => list.iter().enumerate().map(|(index, child)| (index.to_string(), child)).collect(),
            _ => Vec::new(),
        };
        for (part, child) in children {
            let pointer = format!("{prefix}/{part}");
            collect(&pointer, child, found);
            found.push(pointer);
        }
    }
    let mut found = Vec::new();
    collect("", value, &mut found);
    found
}

#[track_caller]
fn refused(result: Result<Case, CaseError>, location: &str, words: &str) {
    let error = result.map(|_| format!("accepted, but {location}: {words}")).unwrap_err();
    assert_well_formed(&error);
    assert_eq!(error.location, location, "{error}");
    assert!(error.to_string().contains(words), "{words:?} is not in\n{error}");
}

fn field<'a>(case: &'a Case, pointer: &str) -> &'a Field {
    case.fields.iter().find(|field| field.pointer == pointer).unwrap_or_else(|| panic!("no field {pointer}"))
}

#[test]
fn every_key_reaches_its_field_in_si_units() {
    let case = read(&good()).unwrap();
    assert_eq!((&case.as_run, case.name.as_str()), (&good(), "good"));
    let Case { fabric, pack, projectile, solver, output, expect, .. } = &case;
    insta::assert_debug_snapshot!("good", (fabric, pack, projectile, solver, output, expect));
    close(fabric.warp.linear_density, 1420.0 / 9e6, 1e-15);
    close(fabric.warp.count, 20.0 / 25.4e-3, 1e-15);
    close(fabric.crossover.compression.unwrap().b, 0.12e-3, 1e-15);
    close(projectile.as_ref().unwrap().obliquity, std::f64::consts::FRAC_PI_6, 1e-15);
}

#[test]
fn a_straight_curve_is_the_modulus_and_another_keeps_its_points_in_pascal() {
    let with = |curve: Value| {
        let mut document = good();
        remove(&mut document, "/fabric/warp/modulus_gpa");
        put(&mut document, "/fabric/warp/curve", curve);
        read(&document).unwrap().fabric.warp
    };
    let linear = read(&good()).unwrap().fabric.warp;
    for curve in [json!([[0, 0], [0.035, 3.36]]), json!([[0, 0], [0.01, 0.96], [0.021, 2.016], [0.035, 3.36]])] {
        assert_eq!(with(curve), linear);
    }
    let bent = with(json!([[0, 0], [0.01, 0.8], [0.04, 4.1]]));
    assert_eq!((bent.curve.len(), bent.curve[0], bent.curve[2][0]), (3, [0.0; 2], 0.04));
    close(bent.curve[2][1], 4.1e9, 1e-15);
    close(bent.modulus, 110e9, 1e-12);
}

/// Lines of a snapshot that say what it is of, as [`document_of`] reads them; of fields, `?` and pointers follow.
fn lines(snapshot: &str) -> impl Iterator<Item = &str> {
    snapshot.lines().filter_map(|line| line.strip_prefix("# "))
}

#[test]
fn fields_have_their_values_and_sources() {
    let mut texts = String::new();
    for line in lines(include_str!("snapshots/suite__case_files__fields.snap")) {
        let (case, asked) = line.split_once(" ? ").unwrap();
        let case = case_of(case).unwrap_or_else(|error| panic!("{line}: {error}"));
        writeln!(texts, "# {line}").unwrap();
        for asked in asked.split(' ') {
            let below = format!("{asked}/");
            for Field { pointer, value, unit, origin, source, assumed, .. } in &case.fields {
                if pointer == asked || pointer.starts_with(&below) {
                    let mark = if *assumed { "*" } else { " " };
                    writeln!(texts, "{mark} {pointer} = {value} {unit} ({}: {source})", origin.word()).unwrap();
                }
            }
        }
        texts.push('\n');
    }
    insta::assert_snapshot!("fields", texts);
}

#[test]
fn the_report_names_every_field_with_its_source() {
    let turned = "every key
1 ply of S-720 at 0°, 10 × 4 elements of 3.0000 × 2.0000 mm: 30.00 × 8.00 mm
2 plies of coarse at 90°, 1 × 15 elements of 6.0000 × 2.0000 mm: 6.00 × 30.00 mm\n\n";
    for (line, head) in [("plain", "plain\n1 ply, "), ("laid & /pack/layup/1/orientation_deg=90", turned)] {
        let case = case_of(line).unwrap();
        let report = case::report(&case);
        assert!(report.starts_with(head), "{report}");
        for field in &case.fields {
            let line = report.lines().find(|line| line.split_whitespace().any(|word| word == field.pointer)).unwrap();
            assert!(line.contains(&field.value) && line.ends_with(&field.source), "{line}");
            assert_eq!(line.starts_with("* "), field.assumed, "{line}");
        }
    }
}

#[test]
fn what_comes_after_the_end_is_left_out_and_noted() {
    let line = "good & /output/profile_times_us=[0, 50, 500] & /expect/4/at_us=401";
    let case = case_of(line).unwrap();
    assert_eq!(case.output.profile_times, [0.0, 50e-6]);
    assert_eq!(case.expect.len(), 4);
    let notes = case.notes.join("\n");
    assert!(notes.contains("500 µs left out") && notes.contains("/expect/4 at 401 µs"), "{notes}");
    let case = case_of(&format!("{line} & /output/history_interval_us=401")).unwrap();
    close(case.output.history_interval, case.solver.end_time, 0.0);
    assert!(read(&good()).unwrap().notes.is_empty());
}

/// The largest edge radius that the reader accepts [mm]; the solver's own check agrees just below it.
fn largest_edge(line: &str) -> f64 {
    let (mut fits, mut too_large) = (0.0, 6.0);
    let at = |edge: f64| case_of(&format!("{line} & /projectile/edge_radius_mm={edge}"));
    for _ in 0..60 {
        let middle = 0.5 * (fits + too_large);
        if at(middle).is_ok() { fits = middle } else { too_large = middle }
    }
    refused(at(too_large + 1e-6), "/projectile/edge_radius_mm", "room for");
    let body = Body::new(at(fits - 1e-9).unwrap().projectile.as_ref().unwrap());
    assert!(body.is_some(), "{line}: the reader accepts an edge of {fits} mm");
    fits
}

#[test]
fn a_body_has_room_for_its_edges() {
    for (line, edge) in [
        // A cone of radius 3 and height 4 holds a ball of radius 3·4/(3 + 5).
        ("cone & /projectile/length_mm=4", 1.5),
        // A ball within the wall, and one between arc and tail.
        ("ogive", 3.0),
        ("ogive & /projectile/length_mm=9", 2.7),
        // The wall, and the strip.
        ("fragment", 3.0),
        ("fragment & /projectile/nose_flat_mm=0.5 & /projectile/nose_angle_deg=60", 0.25 / 30_f64.to_radians().tan()),
    ] {
        assert!((largest_edge(line) - edge).abs() < 1e-9, "{line}: {}", largest_edge(line));
    }
    // Walls and flanks take room that the reader does not ask for, and the model does: a wall of one loses the radius at its tail and a
    // third of it at the nose, a flank the radius over the tangent of half its tip.
    for (line, edge) in [
        ("cylinder & /projectile/length_mm=4", 2.0),
        ("cone & /projectile/length_mm=5 & /projectile/nose_length_mm=4", 0.75),
        ("cone & /projectile/length_mm=14 & /projectile/nose_length_mm=4", 3.0),
    ] {
        let fits = |edge: f64| {
            let case = case_of(&format!("{line} & /projectile/edge_radius_mm={edge}"));
            case.is_ok_and(|case| Body::new(case.projectile.as_ref().unwrap()).is_some())
        };
        assert!(fits(edge * (1.0 - 1e-9)) && !fits(edge * (1.0 + 1e-9)), "{line}: {edge}");
    }
    // The room between flats and tail.
    assert!(largest_edge("fragment & /projectile/length_mm=3 & /projectile/nose_angle_deg=50") < 1.2);
}

#[test]
fn the_hash_knows_numbers_not_words_or_order() {
    let hash = |value: Value| case::case_hash(&value);
    let one = hash(json!({"title": "a", "pack": {"plies": 1, "width_mm": 30}, "sources": {"/pack": "x"}}));
    assert_eq!(one, hash(json!({"pack": {"width_mm": 30.0, "plies": 1}, "title": "b", "expect": []})));
    assert_ne!(one, hash(json!({"title": "a", "pack": {"plies": 1, "width_mm": 31}})));
    assert_eq!(hash(json!({})), "08f44b07b5901a25"); // FNV-1a of "{}"
}

/// A text without what differs from machine to machine.
fn anywhere(text: &str) -> String {
    let memory = "fits into the memory available, ";
    let line = |line: &str| line.split_once(memory).map_or(line.to_owned(), |(before, _)| format!("{before}{memory}…"));
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_refusal_keeps_its_words() {
    let mut texts = String::new();
    for line in lines(include_str!("snapshots/suite__case_files__refusals.snap")) {
        let error = case_of(line).map(|_| format!("{line} is accepted")).unwrap_err();
        assert_well_formed(&error);
        writeln!(texts, "# {line}\n{}\n", anywhere(&error.to_string())).unwrap();
    }
    insta::assert_snapshot!("refusals", texts);
}

#[test]
fn every_damage_of_a_text_or_a_file_keeps_its_words() {
    let text = serde_json::to_string_pretty(&plain()).unwrap();
    let values = ["NaN", "-Infinity", "1e999", "0x9b", "'155'", "+5", ".5", "5,", "5 // m/s"];
    let texts = [
        String::new(),
        " \n\t".to_owned(),
        "[".repeat(10_000),
        "\u{feff}$# a deck\n*KEYWORD\n".to_owned(),
        format!("{text} trailing"),
        text.replacen("\"mass_g\"", "\"diameter_mm\"", 1),
        text.replacen("\"mass_g\"", "mass_g", 1),
        text[..text.len() / 2].to_owned(),
        "[]".to_owned(),
        "null".to_owned(),
    ];
    assert!(case::from_str("marked.json", &format!("\u{feff}{text}"), &[]).is_ok(), "a byte order mark");
    let mut words = String::new();
    for damaged in texts.into_iter().chain(values.map(|value| text.replacen("100", value, 1))) {
        let error = case::from_str("damaged.json", &damaged, &[]).unwrap_err();
        assert_well_formed(&error);
        assert!(error.location.starts_with("line "), "{error}");
        writeln!(words, "{error}\n").unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    let mut say = |path: &Path| {
        let error = case::read(path, &[]).unwrap_err().to_string();
        writeln!(words, "{}\n", error.replace(&folder.path().display().to_string(), "FOLDER")).unwrap();
    };
    say(&path);
    say(folder.path());
    for bytes in [&b"{\n \"title\": \"\xff\"}"[..], b"\xff\xfe{\0}\0", &[b' '; (1 << 20) + 1]] {
        fs::write(&path, bytes).unwrap();
        say(&path);
    }
    let mut crimped = laid()["fabric"].clone();
    put(&mut crimped, "/warp/crimp", json!(7));
    for (name, fabric) in [
        ("unknown-source.json", r#"{"name": "f", "sources": {"/wrap": "x"}}"#),
        ("no-value.json", r#"{"name": }"#),
        ("crimped.json", &crimped.to_string()),
    ] {
        fs::write(folder.path().join(name), fabric).unwrap();
    }
    let files = ["unknown-source.json", "no-value.json", "crimped.json", "none.json"];
    for name in files.into_iter().chain(["../case.json", "/etc/passwd", "", ".", "\0"]) {
        let mut document = laid();
        put(&mut document, "/pack/layup/1/fabric", json!({"file": name}));
        fs::write(&path, document.to_string()).unwrap();
        say(&path);
    }
    insta::assert_snapshot!("damage", words);
}

#[test]
fn every_field_refuses_the_wrong_type_at_its_place() {
    let free = ["/title", "/name", "/notes", "/quantity", "/source", "/value"];
    let document = good();
    let odd = json!([null, true, "zzz", [[]], {"zzz": 1}, -1e300, 0, 1, 2.5, [], {}, "none", "5%"]);
    for pointer in pointers(&document) {
        let value = document.pointer(&pointer).unwrap();
        for (index, odd) in odd.as_array().unwrap().iter().enumerate() {
            let changed = with(&pointer, odd.clone());
            let fits = index > 5
                || odd.is_null() && ["/projectile", "/pack/initial_deflection"].contains(&pointer.as_str())
                || odd.is_boolean() && value.is_boolean()
                || odd.is_string()
                    && (free.iter().any(|end| pointer.ends_with(end)) || pointer.starts_with("/sources/"));
            match read(&changed) {
                Ok(_) => assert!(fits, "{pointer} accepts {odd}"),
                Err(error) => {
                    assert_well_formed(&error);
                    let place = error.location.starts_with(&pointer) || fits;
                    let group = pointer.ends_with("absent") || pointer.starts_with("/expect");
                    assert!(place || group, "{pointer} = {odd}: {error}");
                }
            }
        }
    }
}

#[test]
fn unknown_keys_at_every_level_name_the_nearest_one() {
    let document = good();
    let mut objects = pointers(&document);
    objects.retain(|pointer| document.pointer(pointer).unwrap().is_object() && pointer != "/sources");
    for object in objects.iter().map(String::as_str).chain([""]) {
        let known: &Map<String, Value> = document.pointer(object).unwrap().as_object().unwrap();
        let key = known.keys().next_back().unwrap();
        let wrong = format!("{object}/{key}x");
        refused(
            read(&with(&wrong, json!(1))),
            &wrong,
            &format!("did you mean \"{key}\"? `ripstop schema` lists every key"),
        );
    }
}

#[test]
fn a_dozen_of_many_errors_are_shown() {
    let many: Map<String, Value> = (0..100).map(|i| (format!("key {i}"), json!(1))).collect();
    let text = read(&Value::Object(many)).unwrap_err().to_string();
    assert!(text.matches("error: ").count() == 12 && text.ends_with(" more"), "{text}");
}
