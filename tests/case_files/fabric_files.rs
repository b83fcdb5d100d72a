//! Fabrics kept in files of their own.

use super::*;

fn in_folder(fabric_file: &Value, text: &str) -> (tempfile::TempDir, Result<Case, CaseError>) {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("fabrics")).unwrap();
    fs::write(folder.path().join("fabrics/f.json"), text).unwrap();
    let path = folder.path().join("case.json");
    fs::write(&path, with("/fabric", json!({"file": fabric_file})).to_string()).unwrap();
    let result = case::read(&path, &[]);
    (folder, result)
}

#[test]
fn stand_in_for_the_fabric_with_their_own_sources() {
    let mut fabric = good()["fabric"].clone();
    fabric["sources"] = json!({"/weft": "assumed: guessed", "/shear/g1_mpa": "paper"});
    let (_folder, result) = in_folder(&json!("fabrics/f.json"), &fabric.to_string());
    let case = result.unwrap();
    let field = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer).unwrap();
    assert!(field("/fabric/weft/crimp").assumed);
    assert_eq!(field("/fabric/shear/g1_mpa").source, "paper");
    assert_eq!(field("/fabric/shear/g2_mpa").source, "fabrics/f.json");
    assert_eq!(field("/fabric/warp/crimp").source, "paper, Table I");
    assert_eq!(case.as_run["fabric"]["name"], "S-720");
    assert!(case.as_run["fabric"].get("sources").is_none());
}

#[test]
fn are_named_in_errors_about_what_is_in_them() {
    for (change, value, location) in [
        ("/warp/crimp", json!(7), "/warp/crimp"),
        ("/sources", json!({"/wrap": "x"}), "/sources/~1wrap"),
        ("/file", json!("g.json"), "/file"),
    ] {
        let mut fabric = good()["fabric"].clone();
        put(&mut fabric, change, value);
        let (_folder, result) = in_folder(&json!("fabrics/f.json"), &fabric.to_string());
        let error = result.unwrap_err();
        assert_well_formed(&error);
        assert!(error.file.ends_with("fabrics/f.json"), "{error}");
        assert_eq!(error.location, location);
    }
    let (_folder, result) = in_folder(&json!("fabrics/f.json"), "{\"name\": }");
    let error = refused(result, "line 1, column 10", "value");
    assert!(error.file.ends_with("fabrics/f.json"), "{error}");
}

#[test]
fn stay_inside_the_folder_of_the_case() {
    for name in ["/etc/passwd", "../f.json", "fabrics/../../f.json", "", "none.json", "fabrics", "\0"] {
        let (_folder, result) = in_folder(&json!(name), "{}");
        let error = result.unwrap_err();
        assert_well_formed(&error);
        assert!(error.location == "/fabric/file" || error.found == "a folder", "{error}");
    }
    let (_folder, result) = in_folder(&json!(7), "{}");
    refused(result, "/fabric/file", "7");
    let error = read(&with("/fabric/file", json!("fabrics/s-720.json"))).unwrap_err();
    assert!(error.found.contains("beside"), "{error}");
    let unknown = read(&with("/fabric", json!({"file": "fabrics/s-721.json"})));
    refused(unknown, "/fabric/file", "built in");
    assert!(read(&with("/fabric", json!({"file": "fabrics/s-720.json"}))).is_ok());
}

#[cfg(unix)]
#[test]
fn do_not_leave_it_by_a_link() {
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("f.json"), good()["fabric"].to_string()).unwrap();
    let (folder, _) = in_folder(&json!("x.json"), "{}");
    std::os::unix::fs::symlink(outside.path().join("f.json"), folder.path().join("x.json")).unwrap();
    refused(case::read(&folder.path().join("case.json"), &[]), "/fabric/file", "link");
}
