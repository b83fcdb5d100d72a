//! The command line: arguments, text for people, exit codes. All physics is in the library.

pub(crate) mod arguments;
pub(crate) mod backend;
pub(crate) mod bench;
pub(crate) mod campaign_arguments;
pub(crate) mod check;
pub(crate) mod crossover;
pub(crate) mod explain;
pub(crate) mod failure;
pub(crate) mod input;
pub(crate) mod new;
pub(crate) mod result;
pub(crate) mod resume;
pub(crate) mod run;
pub(crate) mod studies;
pub(crate) mod terminal;
pub(crate) mod verify;
