#![no_main]
#![allow(dead_code, unused_imports, reason = "the suite uses more of it")]

#[path = "../mutator.rs"]
mod mutator;
#[path = "../../tests/fuzz/targets/mod.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::case(bytes));

// Bytes changed at random are seldom JSON. Three in four changes are made to the document itself.
libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let changed = if seed % 4 == 0 { None } else { mutator::json(&data[..size], seed) };
    match changed {
        Some(new) if new.len() <= max_size.min(data.len()) => {
            data[..new.len()].copy_from_slice(&new);
            new.len()
        }
        _ => libfuzzer_sys::fuzzer_mutate(data, size, max_size),
    }
});
