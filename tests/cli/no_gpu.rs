//! Without a graphics adapter: what is asked of one is refused, what leaves the choice runs on the processor.
#![cfg(target_os = "linux")] // elsewhere a program cannot be kept from the adapters

use super::*;

#[test]
fn what_needs_an_adapter_is_3_and_nothing_is_written() {
    let bench = Bench::new(&small());
    let refused: [&[&str]; 8] = [
        &["run", "shot.json", "--backend", "gpu"],
        &["run", "shot.json", "--backend", "gpu", "--precision", "f32", "--adapter", "0"],
        &["run", "shot.json", "--adapter", "0"],
        &["verify", "--backend", "gpu"],
        &["bench", "shot.json", "--backend", "gpu"],
        &["v50", "shot.json", "--backend", "gpu"],
        &["sweep", "shot.json", "--over", "/pack/plies=1,2", "--backend", "gpu"],
        &["compare", "shot.json"],
    ];
    for arguments in refused {
        let output = bench.ripstop(arguments);
        let message = stderr(&output);
        assert_eq!(code(&output), 3, "{arguments:?}: {message}");
        for part in ["error: --backend gpu", "expected: a graphics adapter", "found: none", "help: take --backend cpu"]
        {
            assert!(message.contains(part), "{arguments:?}: {part} in {message}");
        }
        assert_eq!(message.lines().count(), 4, "{message}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(bench.names("."), ["shot.json"]);
}

#[test]
fn auto_takes_the_processor_and_says_why() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["run", "shot.json"]);
    assert_eq!(code(&output), 0);
    assert_eq!(stderr(&output), "note: --backend auto takes the CPU: no graphics adapter was found\n");
    let summary = bench.json("out/shot/summary.json");
    assert_eq!(summary["backend"], "cpu");
    assert_eq!(summary["precision"], "f64");
    let output = bench.ripstop(&["run", "shot.json", "--precision", "f64", "--quiet"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
}

#[test]
fn info_says_that_there_is_none() {
    let output = Bench::new(&small()).ripstop(&["info"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    let text = stdout(&output);
    for line in
        ["backend gpu   no graphics adapter was found", "auto chooses  cpu, because no graphics adapter was found"]
    {
        assert!(text.contains(line), "{line} in\n{text}");
    }
    assert!(!text.contains("adapter 0"), "{text}");
}
