#![no_main]
#![allow(dead_code, reason = "the suite uses more of it")]

#[path = "../../tests/fuzz.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::checkpoint(bytes));
