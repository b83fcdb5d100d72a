//! Tests that need a graphics adapter (software will do), in a harness that can say "ignored" at run time.
//!
//! Without an adapter every test is ignored and says so; with `RIPSTOP_REQUIRE_GPU=1` it fails instead.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod gpu {
    /// A device for every thread of tests, and their verdict where there is none.
    pub(crate) mod harness {
        use std::process::ExitCode;

        use libtest_mimic::{Arguments, Completion, Trial};
        use ripstop::gpu::{Device, adapters, device};

        /// Set to 1 where a missing adapter must not go unnoticed.
        const REQUIRE: &str = "RIPSTOP_REQUIRE_GPU";
        /// Why a test did not run.
        const MISSING: &str = "no graphics adapter";

        /// Result of a test: nothing, or the fault it found.
        pub(crate) type Outcome = Result<(), String>;

        /// The device of this thread's tests, opened by its first; `None` without an adapter. One of all threads would be waited for: software
        /// Vulkan compiles shaders and runs them in one thread of the device, and most of these tests' time is that.
        fn device() -> Result<Option<&'static Device>, String> {
            thread_local! {
                static DEVICE: Result<Option<&'static Device>, String> = open();
            }
            DEVICE.with(Clone::clone)
        }

        /// A device that stays open.
        fn open() -> Result<Option<&'static Device>, String> {
            let adapters = adapters();
            let Ok(adapter) = device::choose(&adapters, None) else { return Ok(None) };
            Device::open(&adapter).map(|device| Some(&*Box::leak(Box::new(device)))).map_err(|e| e.to_string())
        }

        /// A test on the device; it may also panic.
        pub(crate) fn trial(
            name: impl Into<String>,
            test: impl FnOnce(&'static Device) -> Outcome + Send + 'static,
        ) -> Trial {
            Trial::ignorable_test(name, || match device()? {
                Some(device) => test(device).map(|()| Completion::Completed).map_err(Into::into),
                None if std::env::var(REQUIRE).is_ok_and(|value| value == "1") => Err(MISSING.into()),
                None => Ok(Completion::ignored_with(MISSING)),
            })
        }

        /// Runs the tests of every module, two at a time unless asked otherwise: one prepares and compares while the other has the queue.
        pub(crate) fn run<const N: usize>(modules: [Vec<Trial>; N]) -> ExitCode {
            let mut arguments = Arguments::from_args();
            arguments.test_threads.get_or_insert(2);
            libtest_mimic::run(&arguments, modules.into_iter().flatten().collect()).exit_code()
        }
    }
    pub(crate) mod kernels;
    pub(crate) mod limits;
    pub(crate) mod mutants;
    pub(crate) mod shots;
}
#[allow(dead_code, reason = "shared with the other test binary, which uses the rest")]
mod support;

fn main() -> std::process::ExitCode {
    use gpu::{harness, kernels, limits, mutants, shots};
    // Those that take longest first, so that no thread is left alone with one.
    harness::run([limits::tests(), shots::tests(), kernels::tests(), mutants::tests()])
}
