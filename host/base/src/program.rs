//! This program: the words that it was called with, and how to start it again.

use std::env;
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::sync::OnceLock;

/// A call of this program by another one, which it is a part of.
struct Call {
    path: PathBuf,
    words: Vec<OsString>,
}

static CALL: OnceLock<Call> = OnceLock::new();

/// Says that this program is a part of another one, as of Python's interpreter: the executable file that starts it, and the words of the
/// command line, the program's name first. Only the first call counts.
pub fn called_by(path: PathBuf, words: Vec<OsString>) {
    let _ = CALL.set(Call { path, words });
}

/// The words of the command line, the program's name first.
pub fn words() -> Vec<OsString> {
    CALL.get()
        .map_or_else(|| env::args_os().collect(), |call| call.words.clone())
}

/// The executable file that starts this program.
///
/// # Errors
/// The system can't tell.
pub fn path() -> io::Result<PathBuf> {
    CALL.get().map_or_else(env::current_exe, |call| Ok(call.path.clone()))
}
