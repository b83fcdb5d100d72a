//! One unit cell: tension of the warp as it is stretched, while the weft is held or free to straighten.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use ripstop::case;
use ripstop::model::unit_cell_curve;

/// Only the fabric matters here.
const CASE: &str = r#"{
  "title": "a unit cell",
  "fabric": { "file": "fabrics/s-720.json" },
  "pack": { "width_mm": 10, "height_mm": 10 },
  "solver": { "end_time_us": 1 }
}"#;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let case = case::from_str("unit cell", CASE, &[])?;
    let warp: Vec<f64> = (0..=6).map(|step| 1.0 + 0.005 * f64::from(step)).collect();
    println!("warp stretch  weft stretch  warp tension [N]  weft tension [N]");
    for point in unit_cell_curve::solve(&case.fabric, &warp, &[0.99, 1.0]) {
        let ([warp, weft], tension) = (point.stretch, point.cell.tension);
        println!("{warp:12.3}  {weft:12.3}  {:16.2}  {:16.2}", tension[0], tension[1]);
    }
    Ok(())
}
