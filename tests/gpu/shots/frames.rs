//! Frames of a shot on the device, read back from the file.

use std::path::Path;

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::output::frames::Recorder;
use ripstop::output::{self, Folder};
use ripstop::run::{self, Options, Precision};
use rust_hdf5::H5File;
use tempfile::TempDir;

use super::{Outcome, Tests};
use crate::scene::builtin;

pub(super) const TESTS: Tests = &[("are_those_of_the_processor", are_those_of_the_processor)];

/// Arrays of the fabric, and how far they may be off, over their largest number: rounding of 100 steps in single precision.
/// Strains are small differences of stretches.
const ARRAYS: [(&str, f64); 8] = [
    ("Points", 1e-6),
    ("PointData/displacement_mm", 1e-5),
    ("PointData/velocity_m_s", 1e-4),
    ("CellData/warp_tension_n", 1e-3),
    ("CellData/weft_tension_n", 1e-3),
    ("CellData/warp_strain", 1e-3),
    ("CellData/weft_strain", 1e-3),
    ("CellData/shear_angle_rad", 1e-3),
];
/// Arrays of the projectile.
const SOLID: [(&str, f64); 2] = [("Points", 1e-6), ("PointData/velocity_m_s", 1e-5)];

/// Times [µs] and arrays of a file of frames.
struct Read {
    times: Vec<f64>,
    fabric: Vec<Vec<f32>>,
    solid: Vec<Vec<f32>>,
    alive: Vec<u8>,
}

fn written(folder: &Path, case: &Case, options: Options<'_>) -> Read {
    let place = Folder::prepare(folder, case).unwrap_or_else(|e| panic!("{e}"));
    let mut recorder = Recorder::new(folder, case, &options, false, None);
    let run = run::run(case, options, &false.into(), &mut recorder).unwrap_or_else(|e| panic!("{e}"));
    let staged = recorder.finish().unwrap_or_else(|e| panic!("{e}"));
    place.write(case, &run, &output::summary(case, &run, 0.0), None, staged).unwrap_or_else(|e| panic!("{e}"));
    let file = H5File::open(folder.join("frames.vtkhdf")).unwrap();
    let floats = |part: &str, arrays: &[(&str, f64)]| {
        let read =
            |(name, _): &(&str, f64)| file.dataset(&format!("VTKHDF/{part}/{name}")).unwrap().read_raw().unwrap();
        arrays.iter().map(read).collect()
    };
    Read {
        times: file.dataset("VTKHDF/Steps/Values").unwrap().read_raw().unwrap(),
        fabric: floats("fabric", &ARRAYS),
        solid: floats("projectile", &SOLID),
        alive: file.dataset("VTKHDF/fabric/CellData/warp_alive").unwrap().read_raw().unwrap(),
    }
}

/// Struck off centre and aslant, 24 × 16 elements.
fn are_those_of_the_processor(device: &'static Device) -> Outcome {
    let size =
        ["/pack/width_mm=30.48", "/pack/height_mm=20.32", "/expect=[]", "/solver/end_time_us=16", "/output/frames=9"];
    // So slow that no yarn breaks: the order of failures hangs on rounding.
    let case = builtin("cases/verify/mirror.json", &[&size[..], &["/projectile/velocity_m_s=100"]].concat());
    let folders = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let cpu = Options::default().threads(1).precision(Precision::F32);
    let cpu = written(folders[0].path(), &case, cpu);
    let gpu = written(folders[1].path(), &case, Options::default().threads(1).device(device));
    assert_eq!(cpu.times.len(), 9);
    assert_eq!(cpu.times, gpu.times);
    assert!(cpu.alive == gpu.alive && !cpu.alive.contains(&0), "a yarn has broken: take a slower shot");
    let all = |read: &Read| [read.fabric.clone(), read.solid.clone()].concat();
    for (((name, allowed), cpu), gpu) in ARRAYS.iter().chain(&SOLID).zip(all(&cpu)).zip(all(&gpu)) {
        let largest = cpu.iter().fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
        let off = cpu.iter().zip(&gpu).map(|(c, g)| f64::from((c - g).abs())).fold(0.0, f64::max);
        assert!(largest > 0.0 && cpu.len() == gpu.len(), "{name}: {} and {} numbers", cpu.len(), gpu.len());
        assert!(off <= allowed * largest, "{name} is off by {:e} of its largest, allowed {allowed:e}", off / largest);
    }
    Ok(())
}
