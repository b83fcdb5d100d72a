//! Standard output and error. A reader that has gone away (`| head`) is no error.

use std::io::{self, Write};

use super::failure::Failure;

/// Writes to standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error; where that fails there is no one left to tell.
pub(crate) fn complain(line: &str) {
    let mut err = io::stderr().lock();
    let told = writeln!(err, "{line}");
    drop(told);
}
