//! The command line: arguments, what people read, exit codes. All physics is in the library.

pub(crate) mod arguments;
pub(crate) mod backend;
pub(crate) mod bench;
pub(crate) mod campaign_arguments;
pub(crate) mod check;
pub(crate) mod choice;
pub(crate) mod completions;
pub(crate) mod crossover;
pub(crate) mod explain;
pub(crate) mod failure;
pub(crate) mod follow;
pub(crate) mod info;
pub(crate) mod input;
pub(crate) mod interrupt;
pub(crate) mod logging;
pub(crate) mod new;
pub(crate) mod paint;
pub(crate) mod presets;
pub(crate) mod progress;
pub(crate) mod range;
pub(crate) mod result;
pub(crate) mod resume;
pub(crate) mod run;
pub(crate) mod screen;
pub(crate) mod studies;
pub(crate) mod study_arguments;
pub(crate) mod table;
pub(crate) mod verify;

use arguments::SchemaArguments;
use failure::CommandFailure;

/// `ripstop schema`.
pub(crate) fn schema(arguments: &SchemaArguments) -> Result<(), CommandFailure> {
    match arguments.markdown {
        true => screen::print(&ripstop::case::reference()),
        false => screen::print(&format!("{:#}\n", ripstop::case::schema())),
    }
}
