//! `plan.json`: what a batch is of. A batch that goes on must be the one that was begun.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::case::{Case, case_hash};
use crate::output::Folder;
use crate::study::StudyError;
use crate::study::batch::BatchError;

/// Name of the file.
const FILE: &str = "plan.json";

/// What a batch is of.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchPlan(Value);

impl BatchPlan {
    /// The plan of a command for a case; `options`: what else decides the rows.
    pub fn new(command: &str, case: &Case, seed: u32, options: Value) -> Self {
        Self(json!({
            "command": command,
            "version": env!("CARGO_PKG_VERSION"),
            "case": case.as_run,
            "case_hash": case_hash(&case.as_run),
            "seed": seed,
            "options": options,
        }))
    }

    /// The name and the text of its file.
    pub fn file(&self) -> (&'static str, String) {
        (FILE, format!("{:#}\n", self.0))
    }

    /// Whether a folder holds a plan.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(FILE).is_file()
    }

    /// Begins a batch in a folder, whose files of these names are of an earlier one; or goes on with the one that is there.
    ///
    /// # Errors
    /// When the disk refuses, or the plan in the folder is another one.
    pub fn begin(&self, folder: &Folder, files: &[&str], resume: bool) -> Result<(), BatchError> {
        if resume {
            self.check(folder.path())?;
        } else {
            folder.put(&[self.file()], files)?;
        }
        Ok(())
    }

    /// Checks that the plan in a folder is this one.
    ///
    /// # Errors
    /// When there is none, or another one; says in what it differs.
    pub fn check(&self, folder: &Path) -> Result<(), StudyError> {
        let path = folder.join(FILE);
        let place = path.display().to_string();
        let help = "leave --resume out to begin anew, or give the same case and options as before";
        let text = fs::read_to_string(&path).map_err(|error| {
            StudyError::new(&place, "the plan of a batch that was begun here", error.to_string(), help)
        })?;
        let found: Value = serde_json::from_str(&text)
            .map_err(|error| StudyError::new(&place, "the plan of a batch", error.to_string(), help))?;
        for name in ["version", "command", "seed", "options", "case"] {
            if found[name] != self.0[name] {
                let shown = |value: &Value| if name == "case" { "another case".to_owned() } else { value.to_string() };
                let expected = if name == "case" {
                    "the case of this batch".to_owned()
                } else {
                    format!("{name} {}", self.0[name])
                };
                return Err(StudyError::new(&place, expected, shown(&found[name]), help));
            }
        }
        Ok(())
    }
}
