//! Dialogues in pages, below a comment `typed at a terminal`: somebody sits there and answers as the page shows.

use std::process::Command;

use rexpect::session::spawn_command;
use tempfile::TempDir;

use super::commands::TYPED;
use super::page;

/// Longest wait for a line [ms].
const PATIENCE: u64 = 20_000;

#[test]
fn dialogues_go_as_pages_show_them() {
    let mut answers = 0;
    for page in page::all() {
        for block in page.blocks().iter().filter(|block| block.comment == TYPED) {
            let place = format!("{}:{}", page.path.display(), block.at);
            let folder = TempDir::new().unwrap();
            let arguments = block.lines[0].strip_prefix("$ ripstop ").expect("a command of this program");
            let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
            command.current_dir(folder.path()).args(arguments.split(' ')).env("NO_COLOR", "1");
            let mut terminal = spawn_command(command, Some(PATIENCE)).unwrap();
            for line in &block.lines[1..] {
                // A question ends with its default in brackets.
                let (question, answer) = line.split_once("]: ").map_or((&**line, None), |(q, a)| (q, Some(a)));
                // rexpect takes each byte for a character.
                let question: String = question.bytes().map(char::from).collect();
                let before = terminal.exp_string(&question).unwrap_or_else(|error| panic!("{place}: {line}: {error}"));
                assert!(
                    before.trim_matches(['\r', '\n', ']', ':', ' ']).is_empty(),
                    "{place}: before {line}: {before}"
                );
                if let Some(answer) = answer {
                    terminal.send_line(answer).unwrap();
                    answers += 1;
                }
            }
            terminal.exp_eof().unwrap();
        }
    }
    assert!(answers >= 4, "{answers} answers");
}
