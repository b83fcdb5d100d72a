//! The rooms of `src/` use one another in one direction only.
//!
//! Red when: a module imports from a room below its own in the list of `lib.rs`. Cannot see: a room that has grown past its idea.

use std::fs;
use std::path::{Path, PathBuf};

/// From the top down; each may use itself and those before it.
const ROOMS: [&str; 10] = ["num", "case", "physics", "model", "solver", "gpu", "run", "output", "study", "cli"];

/// Files of `src/` itself, and why they stand there.
const LOOSE: [&str; 2] = ["lib.rs", "main.rs"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
    found
}

/// Rooms that a source text names, comments left out.
fn used(text: &str) -> Vec<String> {
    let code: String = text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let mut rooms = Vec::new();
    for path in code.split("crate::").skip(1).chain(code.split("ripstop::").skip(1)) {
        match path.strip_prefix('{') {
            Some(group) => {
                let names = group.split(';').next().unwrap_or_default().split([',', '{', '}', ':', '\n']);
                rooms.extend(names.map(|name| name.trim().to_owned()));
            }
            None => rooms.push(path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()),
        }
    }
    rooms
}

fn rank(room: &str) -> Option<usize> {
    ROOMS.iter().position(|name| *name == room)
}

#[test]
fn every_file_stands_in_a_room_that_uses_none_below_it() {
    let mut wrong = Vec::new();
    for path in sources(Path::new("src")) {
        let room = path.components().nth(1).unwrap().as_os_str().to_string_lossy().into_owned();
        let Some(own) = rank(&room) else {
            assert!(LOOSE.contains(&room.as_str()), "src/{room} is in no room");
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        let text = text.split("\n#[cfg(test)]\n").next().unwrap();
        wrong.extend(
            used(text)
                .into_iter()
                .filter(|used| rank(used).is_some_and(|other| other > own))
                .map(|used| format!("{} uses {used}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
