//! Frames of a shot on the device.

use ripstop::FrameCollector;
use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::run::frame::Frame;
use ripstop::run::{self, Options, Precision};

use super::{Outcome, Tests};
use crate::scene::builtin;

pub(super) const TESTS: Tests = &[("are_those_of_the_processor", are_those_of_the_processor)];

fn frames(case: &Case, options: Options<'_>) -> Vec<Frame> {
    let mut collector = FrameCollector::new(case, case.output.frames as usize);
    run::run(case, options, &false.into(), &mut collector).unwrap_or_else(|e| panic!("{e}"));
    collector.frames()
}

/// Arrays of a frame, and how far they may be off, over their largest number: rounding of 100 steps in single precision.
/// Strains are small differences of stretches.
fn arrays(frame: &Frame) -> Vec<(&'static str, f64, Vec<f32>)> {
    let pose = frame.projectile.unwrap();
    let solid = |numbers: [f64; 3]| numbers.map(|number| number as f32).to_vec();
    vec![
        ("displacement", 1e-5, frame.displacement.concat()),
        ("velocity", 1e-4, frame.velocity.concat()),
        ("warp tension", 1e-3, frame.tension[0].clone()),
        ("weft tension", 1e-3, frame.tension[1].clone()),
        ("warp strain", 1e-3, frame.strain[0].clone()),
        ("weft strain", 1e-3, frame.strain[1].clone()),
        ("shear angle", 1e-3, frame.shear_angle.clone()),
        ("projectile position", 1e-6, solid(pose.position)),
        ("projectile velocity", 1e-5, solid(pose.velocity)),
    ]
}

/// Struck off centre and aslant, 24 × 16 elements.
fn are_those_of_the_processor(device: &'static Device) -> Outcome {
    let size =
        ["/pack/width_mm=30.48", "/pack/height_mm=20.32", "/expect=[]", "/solver/end_time_us=16", "/output/frames=9"];
    // So slow that no yarn breaks: the order of failures hangs on rounding.
    let case = builtin("cases/verify/mirror.json", &[&size[..], &["/projectile/velocity_m_s=100"]].concat());
    let cpu = frames(&case, Options::default().threads(1).precision(Precision::F32));
    let gpu = frames(&case, Options::default().threads(1).device(device));
    let steps = |frames: &[Frame]| frames.iter().map(|frame| (frame.step, frame.time.to_bits())).collect::<Vec<_>>();
    assert_eq!((cpu.len(), steps(&cpu)), (9, steps(&gpu)));
    let alive = |frames: &[Frame]| frames.iter().flat_map(|frame| frame.alive.concat()).collect::<Vec<u8>>();
    assert!(alive(&cpu) == alive(&gpu) && !alive(&cpu).contains(&0), "a yarn has broken: take a slower shot");
    for (n, (name, allowed, _)) in arrays(&cpu[0]).into_iter().enumerate() {
        let all =
            |frames: &[Frame]| frames.iter().flat_map(|frame| arrays(frame).swap_remove(n).2).collect::<Vec<f32>>();
        let (cpu, gpu) = (all(&cpu), all(&gpu));
        let largest = cpu.iter().fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
        let off = cpu.iter().zip(&gpu).map(|(c, g)| f64::from((c - g).abs())).fold(0.0, f64::max);
        assert!(largest > 0.0 && cpu.len() == gpu.len(), "{name}: {} and {} numbers", cpu.len(), gpu.len());
        assert!(off <= allowed * largest, "{name} is off by {:e} of its largest, allowed {allowed:e}", off / largest);
    }
    Ok(())
}
