//! Refusals: where an error points, what it expected, what it found, and its help.
//!
//! Promise: the texts below, in full, are those of `snapshots/`. Red when one of them changes. Cannot see: a refusal that has no line here.

use super::*;

/// One refusal a line, as [`document_of`] reads it.
const REFUSED: &str = r#"
good & /projectile/velocity_m_s=0
good & /projectile/velocity_m_s="155"
good & /projectile/velocity_m_s={"zzz": 1}
good & /projectile/offset_mm=[1]
good & /projectile/offset_mm=[1, "x"]
good & /projectile/edge_radius_mm=2.8
good & /projectile/nose_length_mm=5
good & /projectile/shape="spere"
good & /projectile/shape=3
good & /projectile/axial_inertia_g_mm2=1000
good & -/projectile/axial_inertia_g_mm2
good & /solver/courant=1.01
good & /solver/end_time_us=1e9
good & /solver/contact_sampling="rim"
good & /pack/plies=65
good & /pack/plies=2
good & /pack/plies=1.5
good & /pack/edges="square"
good & /pack/edges={"left": "open"}
good & /pack/mesh_grading={"growth": 1.2}
good & /pack/mesh_grading={"max_crossovers": 1} & /pack/crossovers_per_element=2
plain & /projectile=null & /solver={"end_time_us": 9} & /pack/mesh_grading="graded"
good & /pack/pretension={"warp": 1}
good & /fabric/shear/gamma1=0.7
good & /fabric/shear/thickness_mm=0.26
good & /fabric/crossover/compression={"a_mm": 0}
good & /fabric/crossover/compression={"b_mm_n13": 1e-9}
good & /fabric/crossover/compression="ridig"
good & /fabric/crossover/law="kawabata"
good & /fabric/crossover/law="publshed"
good & /fabric/crossover/membrane_force="projected"
good & /fabric/shear/modulus="secant"
good & /solver/unit_cell="safeguarded"
good & /fabric/warp/absent="yes"
good & /fabric/warp/absent=true
good & /fabric/warp={"absent": true, "count_per_cm": 8} & /fabric/weft={"absent": true, "count_per_cm": 8}
good & /fabric/warp/linear_density_tex=158
good & -/fabric/warp/linear_density_denier
good & /fabric=[{}]
good & /fabric/file="fabrics/s-720.json"
good & /fabric={"file": "fabrics/s-721.json"}
good & /fabric={"file": 7}
good & /expect/0/tolerance=1
good & /expect/1/tolerance="1 percent"
good & -/expect/1/tolerance
good & -/expect/0/value
good & /expect/2/value=1
good & /expect/2/min=1
good & /expect/2/tolerance=1
good & /expect/3/between_us=[20, 10]
good & /output/profile_times_us=[0, 2, 1]
good & /sources/~1fabric~1wrap="x"
good & /sources/~1pack=1
good & /sources=[]
good & /title=" "
good & -/title
good & -/projectile/length_mm
good & -/projectile/mass_g
good & /zzz=1
good & /pack/mass_g=1
good & /projectile/velocity=155 & -/projectile/velocity_m_s
good & /projectile/velocity_m_s="155" & /pack/widht_mm=1 & /solver/courant=2 & -/fabric/warp/crimp
good & /variability={"sede": 1, "velocity": {"scatter_m_s": 0}, "yarn_strength": {"shape": 0.5}}
good & /variability={"hit": "unit_cell"} & /projectile=null
good & /variability={"yaw": {"scatter_deg": 1}} & /projectile={"shape": "bar", "diameter_mm": 9, "mass_g": 1, "velocity_m_s": 5}
good & /variability={"shot": 1, "crimp": {"scatter": 0.5}} & /fabric/warp/crimp=0.5
plain & /solver={"run_until": "end_time"}
plain & /projectile/motion="prescribed"
plain & -/projectile/mass_g
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5}
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5, "mass_g": 1, "rotation": "free", "yaw_deg": 3}
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5, "mass_g": 1, "rotation": "free"}
cone & /projectile/length_mm=4 & /projectile/edge_radius_mm=1.501
cone & /projectile/length_mm=4 & /projectile/nose_length_mm=5
ogive & /projectile/nose_length_mm=2.9
ogive & /projectile/nose_length_mm=12.1
fragment & /projectile/nose_flat_mm=6.1
fragment & /projectile/length_mm=6 & /projectile/nose_angle_deg=75
fsp & /projectile/length_mm=6 & /projectile/nose_angle_deg=80
plain & /pack={"width_mm": 1e5, "height_mm": 1e5}
plain & /pack={"width_mm": 1e5, "height_mm": 3e4}
plain & /output={"history_interval_us": 1e-6} & /solver={"end_time_us": 1e8}
laid & /pack/layup=[]
laid & /pack/layup=[{}, 3]
laid & /pack/layup=[{"plies": 40}, {"plies": 25}]
laid & /pack/layup=[{}, {"orientation": 45}]
laid & /pack/layup=[{"fabric": {"name": "f"}}]
laid & /pack/layup=[{"fabric": {"file": "fabrics/none.json"}}]
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/width_mm=1e4 & /pack/height_mm=1e4
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/layup/1/plies=62 & /pack/width_mm=1e3 & /pack/height_mm=1e3
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/layup/1/plies=32 & /pack/width_mm=200 & /pack/height_mm=200
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /solver={"end_time_us": 2e7} & /output={"history_interval_us": 2e6}
laid & --set /pack/layup/2/plies=1
laid & --set /pack/layup/0/fabric=[1]
plain & --set /pack/layup/0/plies=1
plain & /pack/edges="free" & --set /pack/edges/left=free
good & --set /projectile/mass_gg=1
good & --set /projectile/velocity_m_s=fast
good & --set /projectile/velocity_m_s=NaN
good & --set /projectile/velocity_m_s=
good & --set /projectile={"shape":
good & --set /projectile/mass_g/x=1
good & --set /projectle/mass_g=1
good & --set /projectile/offset_mm/2=1
good & --set /pack/edges=square
good & --set /fabric/shear/gamma1=1
good & --set projectile=1
good & --set /projectile
"#;

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
        format!("\u{feff}{text}"),
        format!("{text} trailing"),
        text.replacen("\"mass_g\"", "\"diameter_mm\"", 1),
        text.replacen("\"mass_g\"", "mass_g", 1),
        text[..text.len() / 2].to_owned(),
        "[]".to_owned(),
        "null".to_owned(),
    ];
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
    for name in [
        "unknown-source.json",
        "no-value.json",
        "crimped.json",
        "none.json",
        "../case.json",
        "/etc/passwd",
        "",
        ".",
        "\0",
    ] {
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
    for pointer in pointers(&document) {
        let value = document.pointer(&pointer).unwrap();
        for wrong in [json!(null), json!(true), json!("zzz"), json!([[]]), json!({"zzz": 1}), json!(-1e300)] {
            let fits = wrong.is_null() && ["/projectile", "/pack/initial_deflection"].contains(&pointer.as_str())
                || wrong.is_boolean() && value.is_boolean()
                || wrong.is_string()
                    && (free.iter().any(|end| pointer.ends_with(end)) || pointer.starts_with("/sources/"));
            let result = read(&with(&pointer, wrong.clone()));
            if fits && result.is_ok() {
                continue;
            }
            let error = result.map(|_| format!("{pointer} accepts {wrong}")).unwrap_err();
            assert_well_formed(&error);
            let place = error.location.starts_with(&pointer) || fits;
            let group = pointer.ends_with("absent") || pointer.starts_with("/expect");
            assert!(place || group, "{pointer} = {wrong}: {error}");
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
