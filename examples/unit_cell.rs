//! One unit cell: tension of the warp as it is stretched, while the weft is held or free to straighten.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use ripstop::{BuiltInFabric, Case, unit_cell};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // Only the fabric matters here.
    let case = Case::builder("a unit cell").fabric(BuiltInFabric::S720).size_mm(10.0, 10.0).end_time_us(1.0).build()?;
    let warp: Vec<f64> = (0..=6).map(|step| 1.0 + 0.005 * f64::from(step)).collect();
    println!("warp stretch  weft stretch  warp tension [N]  weft tension [N]");
    for point in unit_cell::solve(&case.fabric, &warp, &[0.99, 1.0]) {
        let [warp, weft, warp_tension, weft_tension, ..] = point.numbers().map(|(_, number)| number);
        println!("{warp:12.3}  {weft:12.3}  {warp_tension:16.2}  {weft_tension:16.2}");
    }
    Ok(())
}
