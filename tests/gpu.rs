//! Tests that need a graphics adapter (software will do), in a harness that can say "ignored" at run time.
//!
//! Without an adapter every test is ignored and says so; with `RIPSTOP_REQUIRE_GPU=1` it fails instead.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod gpu {
    pub(crate) mod harness;
    pub(crate) mod kernels;
    pub(crate) mod limits;
    pub(crate) mod mutants;
    pub(crate) mod shots;
}
#[allow(dead_code, reason = "shared with the other test binary, which uses the rest")]
mod kept;
#[allow(dead_code, reason = "shared with the other test binary, which uses the rest")]
mod scene;
#[allow(dead_code, reason = "shared with the other test binary, which uses the rest")]
mod support;

fn main() -> std::process::ExitCode {
    use gpu::{harness, kernels, limits, mutants, shots};
    harness::run([shots::tests(), kernels::tests(), mutants::tests(), limits::tests()])
}
