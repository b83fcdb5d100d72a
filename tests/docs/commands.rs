//! Commands in pages: each is run, in order, in a folder of its page's own. Blocks below a comment `parsed only: why` take too long
//! or need what is not there: of these the arguments are checked, by `--help` after them. A comment `exit code N` says that
//! the command fails.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

use super::page::{self, Block, Page, is_update};
use crate::cli::DRIVER_FILES;

/// Other lines that a block may have.
const OTHERS: [&str; 3] = ["cargo install --path .", "cargo test --release", "mdbook serve docs"];
/// Lines that differ from run to run, up to here.
const VARYING: [&str; 2] = ["  wall time  ", "  on  "];
/// Lines left out.
const LEFT_OUT: &str = "…";
/// The picture of the first shot: where it stands in the book, and where the README's first command leaves it.
const PICTURE: [&str; 2] = ["docs/src/shot.svg", "out/s728-4ply-91/shot.svg"];

/// A line of a shell that finds the program, and no graphics adapter.
pub(super) fn program(line: &str) -> Command {
    let folder = Path::new(env!("CARGO_BIN_EXE_ripstop")).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([folder.to_owned()].into_iter().chain(std::env::split_paths(&others))).unwrap();
    let mut command = Command::new("sh");
    command.args(["-c", line]).env("PATH", path).stdin(Stdio::null());
    command.envs(DRIVER_FILES.map(|name| (name, "/nowhere/at/all"))).env("NODEVICE_SELECT", "1");
    command
}

/// The folder of a page: empty but for the cases.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let cases = folder.path().join("cases");
        for name in ["", "fabrics", "verify"] {
            fs::create_dir_all(cases.join(name)).unwrap();
            for entry in fs::read_dir(Path::new("cases").join(name)).unwrap().map(|entry| entry.unwrap()) {
                if entry.path().is_file() {
                    fs::copy(entry.path(), cases.join(name).join(entry.file_name())).unwrap();
                }
            }
        }
        Self(folder)
    }

    fn run(&self, line: &str) -> Output {
        program(line).current_dir(self.0.path()).output().unwrap()
    }

    /// Does what a page says.
    fn follow(&self, page: &Page) -> usize {
        let blocks = page.blocks();
        let blocks: Vec<&Block> = blocks.iter().filter(|block| ["sh", "console"].contains(&&*block.kind)).collect();
        let mut count = 0;
        for block in blocks {
            for (line, shown) in lines(block) {
                let place = format!("{}:{}: {line}", page.path.display(), block.at);
                self.check(&line, &shown, &block.comment, &place);
                count += 1;
            }
        }
        count
    }

    fn check(&self, line: &str, shown: &[&str], comment: &str, place: &str) {
        if OTHERS.iter().any(|other| line.starts_with(other)) {
            return;
        }
        assert!(line.starts_with("ripstop "), "{place}: not a command of this program");
        if comment.starts_with("parsed only: ") {
            return assert_eq!(parse(line), Ok(()), "{place}");
        }
        let code: i32 = comment.strip_prefix("exit code ").map_or(0, |code| code.parse().unwrap());
        let (answers, shown) = typed(shown, line.contains(" --from-sheet"));
        fs::write(self.0.path().join("answers"), answers).unwrap();
        let output = self.run(&format!("{line} < answers"));
        let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(output.status.code(), Some(code), "{place}\n{stdout}\n{stderr}");
        if !shown.is_empty() {
            let got = if code == 0 { stdout } else { stderr };
            let shown: Vec<&str> = shown.iter().map(String::as_str).collect();
            assert_eq!(compare(&shown, &got), Ok(()), "{place}\n{got}");
        }
    }
}

/// The commands of a block, each with what is shown of its output.
fn lines(block: &Block) -> Vec<(String, Vec<&str>)> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for line in &block.lines {
        let command = if block.kind == "console" { line.strip_prefix("$ ") } else { Some(&**line) };
        match command {
            Some("") => {}
            Some(command) => all.push((command.replace("cargo run --release -- ", "ripstop "), Vec::new())),
            None => all.last_mut().expect("a command before its output").1.push(line),
        }
    }
    all
}

/// Answers typed behind questions, and what is printed where answers come from a file: questions follow each other in one line.
fn typed(shown: &[&str], asks: bool) -> (String, Vec<String>) {
    let (mut answers, mut printed, mut questions) = (String::new(), Vec::new(), String::new());
    for line in shown {
        match line.split_once("):").filter(|_| asks) {
            Some((question, answer)) => {
                answers += &format!("{}\n", answer.trim());
                questions += &format!("{question}): ");
            }
            None => printed.push(std::mem::take(&mut questions) + line),
        }
    }
    (answers, printed)
}

/// Whether the program takes these arguments, without doing anything.
fn parse(line: &str) -> Result<(), String> {
    let output = program(&format!("{line} --help")).output().unwrap();
    let help = String::from_utf8_lossy(&output.stdout).contains("Usage: ripstop ");
    if output.status.success() && help { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// Whether the lines shown are those got, but for what is left out.
fn compare(shown: &[&str], got: &str) -> Result<(), String> {
    let cut = |line: &str| {
        VARYING.iter().find(|start| line.starts_with(**start)).map_or(line, |start| *start).to_owned() + "\n"
    };
    let got: String = got.lines().map(cut).collect();
    let parts = shown.split(|line| *line == LEFT_OUT).map(|part| part.iter().map(|line| cut(line)).collect());
    let parts: Vec<String> = parts.collect();
    let (mut rest, last) = (got.as_str(), parts.len() - 1);
    for (number, part) in parts.iter().enumerate() {
        let place = match number {
            0 => rest.starts_with(part).then_some(0),
            number if number == last => rest.ends_with(part).then(|| rest.len() - part.len()),
            _ => rest.find(part),
        };
        rest = &rest[place.ok_or_else(|| format!("not in the output, or not there:\n{part}"))? + part.len()..];
    }
    if last == 0 && !rest.is_empty() { Err(format!("there is more:\n{rest}")) } else { Ok(()) }
}

/// Two shots, as users see them: a few seconds.
#[test]
fn the_commands_of_the_readme_do_what_it_says_and_draw_its_picture() {
    let folder = Folder::new();
    assert!(folder.follow(&Page::read(Path::new("README.md"))) >= 6);
    let [shown, drawn] = PICTURE;
    let drawn = fs::read_to_string(folder.0.path().join(drawn)).unwrap();
    if is_update() {
        return fs::write(shown, drawn).unwrap();
    }
    assert!(fs::read_to_string(shown).unwrap() == drawn, "{shown}: RIPSTOP_UPDATE_DOCS=1 writes it anew");
}

/// Two shots of four plies: some seconds.
#[test]
fn the_tutorial_is_what_happens() {
    assert!(Folder::new().follow(&Page::read(Path::new("docs/src/tutorial.md"))) >= 8);
}

/// A handful of shots, as users see them: a few seconds.
#[test]
fn the_commands_of_other_pages_do_what_they_say() {
    let pages = page::book();
    let others = pages.iter().filter(|page| page.name() != "tutorial.md");
    assert!(others.map(|page| Folder::new().follow(page)).sum::<usize>() >= 15);
}
