use super::*;

#[test]
fn a_camera_that_goes_on_keeps_what_the_whole_run_keeps() {
    let dt = 1e-6;
    let on = |mut camera: SnapshotTaker, from: u64| {
        (from..100).for_each(|step| camera.schedule.pass(step, dt));
        camera.kept().collect::<Vec<_>>()
    };
    for (frames, end_time) in [(1, 60e-6), (2, 60e-6), (13, 60.5e-6), (200, 60e-6), (7, 1.0)] {
        let whole = on(SnapshotTaker::new(frames, end_time), 0);
        assert_eq!(whole[0], 0);
        for step in 0..100 {
            assert_eq!(
                on(SnapshotTaker::resume(frames, end_time, step, dt), step),
                whole,
                "{frames} frames, step {step}"
            );
        }
    }
}
