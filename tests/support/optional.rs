//! Tests that need a program of others.

use libtest_mimic::{Completion, Trial};

/// A test that is ignored and says so where a program is missing, and fails instead where the variable `require` is 1.
pub(crate) fn trial(name: &str, missing: Option<&'static str>, require: &str, test: fn()) -> Trial {
    let required = std::env::var(require).is_ok_and(|value| value == "1");
    Trial::ignorable_test(name, move || match missing {
        Some(missing) if required => Err(missing.into()),
        Some(missing) => Ok(Completion::ignored_with(missing)),
        None => {
            test();
            Ok(Completion::Completed)
        }
    })
}
