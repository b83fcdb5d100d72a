//! Refusals: where an error points, what it expected, what it found, and its help.
//!
//! Promise: the texts below, in full, are those of `snapshots/`. Red when one of them changes. Cannot see: a refusal that has no line here.

use super::*;

/// One refusal a line, as [`document_of`] reads it.
const REFUSED: &str = include_str!("refused.txt");

/// A text without what differs from machine to machine.
fn anywhere(text: &str) -> String {
    let memory = "fits into the memory available, ";
    let line = |line: &str| line.split_once(memory).map_or(line.to_owned(), |(before, _)| format!("{before}{memory}…"));
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_refusal_keeps_its_words() {
    let mut texts = String::new();
    for line in REFUSED.trim().lines() {
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
    let Value::Array(odd) = json!([null, true, "zzz", [[]], {"zzz": 1}, -1e300, 0, 1, 2.5, [], {}, "none", "5%"])
    else {
        unreachable!("a list")
    };
    for pointer in pointers(&document) {
        let value = document.pointer(&pointer).unwrap();
        for (index, odd) in odd.iter().enumerate() {
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
