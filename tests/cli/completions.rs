//! Completion scripts: every shell gets one, and it completes.

use super::*;

#[test]
fn every_shell_gets_a_script_that_knows_every_command() {
    let bench = Bench::new(&small());
    let help = stdout(&bench.ripstop(&["--help"]));
    let commands = help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    // Two blanks and a name; lines that only go on with a text are indented further.
    let named = commands.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    let commands: Vec<&str> = named.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() > 10 && commands.contains(&"explain"), "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = bench.ripstop(&["completions", shell]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        for command in &commands {
            assert!(stdout(&output).contains(command), "{command} for {shell}");
        }
    }
    assert_eq!(code(&bench.ripstop(&["completions", "tcsh"])), 2);
}

#[test]
#[cfg(unix)]
fn bash_completes_commands_options_and_their_values() {
    let bench = Bench::new(&small());
    let script = stdout(&bench.ripstop(&["completions", "bash"]));
    fs::write(bench.path("script.bash"), script).unwrap();
    let complete = |words: &str| {
        let ask = format!(
            "source script.bash; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
             _ripstop ripstop \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\"; echo \"${{COMPREPLY[@]}}\""
        );
        let output = Command::new("bash").args(["-c", &ask]).current_dir(bench.folder.path()).output().unwrap();
        stdout(&output).trim_end().to_owned()
    };
    assert_eq!(complete("ripstop expl"), "explain");
    assert_eq!(complete("ripstop run --prec"), "--precision");
    assert_eq!(complete("ripstop run --backend ''"), "auto cpu gpu");
}
