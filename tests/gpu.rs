//! Tests that need a graphics adapter (software will do), in a harness that can say "ignored" at run time.
fn main() {}
