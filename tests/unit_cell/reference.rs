//! Against `tests/reference/unit_cell.json`: 40-digit solutions by another method in another language.

use super::*;
use serde_json::Value;

struct Record {
    place: String,
    fabric: Woven,
    stretch: [f64; 2],
    tension: [f64; 2],
    in_plane: [f64; 2],
    force: f64,
    /// None where both yarns are slack.
    height: Option<[f64; 2]>,
}

/// Every record; one of the published law gives two, one for each choice of in-plane force.
fn records() -> Vec<Record> {
    let list: Vec<Value> = serde_json::from_str(include_str!("../reference/unit_cell.json")).unwrap();
    assert_eq!(list.len(), 726);
    list.iter().enumerate().flat_map(|(index, value)| record(index, value)).collect()
}

fn record(index: usize, value: &Value) -> Vec<Record> {
    let number = |key: &str| value[key].as_f64().unwrap();
    let pair = |suffix: &str| ["warp", "weft"].map(|y| number(&format!("{y}_{suffix}")));
    let laws: &[(CurveLaw, &str)] = match value["law"].as_str().unwrap() {
        "published" => &[(CurveLaw::Published, "in_plane_n"), (CurveLaw::Projected, "projected_n")],
        "variational" => &[(CurveLaw::Variational, "in_plane_n")],
        "kawabata" => &[(CurveLaw::Kawabata, "in_plane_n")],
        other => panic!("record {index}: law {other}"),
    };
    let yarns = ["warp", "weft"].map(|y| {
        let of = |key: &str| value[y][key].as_f64().unwrap();
        yarn(of("ea_n"), of("w0_mm") * 1e-3, of("crimp"))
    });
    let rigid = value["rigid"].as_bool().unwrap();
    let compression = (!rigid).then(|| Compression { a: number("a_mm") * 1e-3, b: number("b_mm_n13") * 1e-3 });
    let slack = value["warp_height_mm"].is_null();
    let build = |&(law, in_plane): &(CurveLaw, &str)| Record {
        place: format!("record {index}: {law:?} {} {:?} rigid {rigid}", value["fabric"], pair("stretch")),
        fabric: fabric(yarns.clone(), law, number("gap_mm") * 1e-3, compression),
        stretch: pair("stretch"),
        tension: pair("tension_n"),
        in_plane: pair(in_plane),
        force: number("contact_force_n"),
        height: (!slack).then(|| pair("height_mm").map(|h| h * 1e-3)),
    };
    laws.iter().map(build).collect()
}

/// Largest errors over all records, each solved from the heights at rest and from bad starts.
#[derive(Default)]
struct Errors {
    tension: Worst,
    force: Worst,
    height: Worst,
}

fn errors<R: Scalar>(wanted: impl Fn(&Record) -> bool) -> Errors {
    let mut out = Errors::default();
    let mut random = Random(7);
    let all = records();
    let both = all.iter().filter(|r| wanted(r)).flat_map(|r| [(r, true), (r, false)]);
    for (r, joint) in both {
        let cell = Cell::<R>::with(&r.fabric, joint);
        let top = cell.exact.height_sum;
        let breaking = cell.breaking();
        let lost = [random.between(-top, 2.0 * top), random.between(-top, 2.0 * top)];
        let within = [random.between(0.0, top), random.between(0.0, top)];
        for warm in [cell.rest_heights(), [0.0; 2], [top; 2], within, lost] {
            let got = cell.solve(r.stretch, warm, true);
            let place = || format!("{} from {warm:?}, joint {joint}: {got:?}", r.place);
            assert!(got.converged, "{}", place());
            for i in [0, 1] {
                out.tension.see((got.tension[i] - r.tension[i]) / breaking[i], place);
                out.tension.see((got.in_plane[i] - r.in_plane[i]) / breaking[i], place);
                if let Some(height) = r.height {
                    out.height.see((got.height[i] - height[i]) / top, place);
                }
            }
            out.force.see((got.force - r.force) / cell.softer_breaking(), place);
        }
    }
    out
}

#[test]
fn every_record_in_double_precision() {
    let e = errors::<f64>(|_| true);
    // The accepted residual, 1e-12 EA or 3e-11 of the breaking force, is the error of F; that of T is up to
    // 1/(2 sin α) times as large. The residual moves a height most where compression is softest, at F → 0.
    e.tension.assert_at_most(1.5e-10);
    e.force.assert_at_most(5e-11);
    e.height.assert_at_most(1.5e-10);
}

/// Tolerance: what single precision owes, 1e-5 of the breaking tension. Heights are known to 2^-23 of their sum
/// times the softness of the crossover at F → 0.
fn single_precision(fabrics: &[&str]) {
    let e = errors::<f32>(|r| fabrics.iter().any(|name| r.place.contains(name)));
    e.tension.assert_at_most(1e-5);
    e.force.assert_at_most(1e-5);
    e.height.assert_at_most(1e-4);
}

#[test]
fn every_record_in_single_precision() {
    single_precision(&["S-720", "S-728", "unbalanced"]);
}

#[test]
fn every_record_of_the_high_crimp_fabric_in_single_precision() {
    single_precision(&["high-crimp"]);
}
