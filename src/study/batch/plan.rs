//! `plan.json`: what a batch is of. A batch that goes on must be the one that was begun.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::case::{Case, case_hash};
use crate::output::Folder;
use crate::study::StudyError;
use crate::study::batch::{BatchError, BatchOptions};

/// Name of the file.
const FILE: &str = "plan.json";

/// What a batch is of.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchPlan(Value);

impl BatchPlan {
    /// The plan of a command for a case; `parts`: what else decides the rows.
    pub fn new(command: &str, case: &Case, options: &BatchOptions<'_>, mut parts: Value) -> Self {
        parts["precision"] = json!(options.precision.name());
        parts["backend"] = json!(if options.device.is_some() { "gpu" } else { "cpu" });
        if let Some(device) = options.device {
            parts["adapter"] = json!(device.name());
        }
        Self(json!({
            "command": command,
            "version": env!("CARGO_PKG_VERSION"),
            "case": case.as_run,
            "case_hash": case_hash(&case.as_run),
            "seed": options.seed,
            "options": parts,
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
                let [expected, found] = match name {
                    "case" => ["the case of this batch", "another case"].map(str::to_owned),
                    _ => [(&self.0, &found), (&found, &self.0)]
                        .map(|(one, other)| format!("{name} {}", differing(&one[name], &other[name]))),
                };
                return Err(StudyError::new(&place, expected, found, help));
            }
        }
        Ok(())
    }
}

/// A value, or of an object the members that another has not or has otherwise.
fn differing(one: &Value, other: &Value) -> Value {
    let Value::Object(members) = one else { return one.clone() };
    members
        .iter()
        .filter(|(name, value)| other.get(name.as_str()) != Some(*value))
        .map(|(n, v)| (n.clone(), v.clone()))
        .collect()
}
