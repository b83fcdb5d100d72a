#![no_main]
#![allow(dead_code, unused_imports, reason = "the suite uses more of it")]

#[path = "../../tests/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::diff(bytes));
