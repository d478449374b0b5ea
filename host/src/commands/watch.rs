//! `oneiro watch`: a page about runs, sweeps and fleets while they evolve; also started by `oneiro run --watch` and `oneiro sweep run --watch`.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use oneiro_base::answer::Answer;
use oneiro_base::console::Console;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::program;
use oneiro_lab::engine::signals::stop_signal;
use oneiro_watch::{Server, snapshot};
use serde_json::json;

use super::places::{RUNS, SWEEPS, found};
use crate::cli;

/// Time in which a browser opens the page.
const OPENING: Duration = Duration::from_secs(15);
/// Time in which a page that nobody looks at ends.
const MOMENT: Duration = Duration::from_millis(900);

/// Serves the page until it is stopped.
pub(super) fn run(arguments: &cli::Watch, console: Console) -> Result {
    let folders = match &arguments.dirs[..] {
        [] => [RUNS, SWEEPS].map(PathBuf::from).to_vec(),
        // Those of the command that has started it may appear later.
        dirs if arguments.beside => dirs.to_vec(),
        dirs => dirs.iter().map(|dir| folder(dir, console)).collect::<Result<_>>()?,
    };
    let stop = stop_signal()?;
    if let Some(file) = &arguments.snapshot {
        disk::write(file, snapshot(folders, &stop)?.as_bytes())?;
        let file = file.display().to_string();
        return console.print_answer(&Answer::new(file.clone(), json!({ "page": file })));
    }
    let server = Server::open(folders, arguments.port, arguments.edit.as_deref(), &stop)?;
    let (link, port) = (server.link(), server.port());
    let over = Arc::new(AtomicBool::new(false));
    if arguments.beside {
        console.ask(format!("watch: {link}"));
        set_at_end_of_input(&over)?;
    } else {
        let elsewhere =
            format!("from another machine: ssh -L {port}:127.0.0.1:{port} THIS_MACHINE, and the same address there");
        let end = match arguments.edit {
            Some(_) => "Ctrl-C ends the page, and a run of its form, which `oneiro resume` continues",
            None => "Ctrl-C ends the page, and no run",
        };
        let text = format!("{link}\n{elsewhere}\n{end}");
        console.print_answer(&Answer::new(text, json!({ "url": link, "port": port })))?;
    }
    if arguments.open {
        open(&link, console);
    }
    server.serve(&stop, &over, if arguments.open { OPENING } else { Duration::ZERO })
}

/// The named directory.
fn folder(dir: &Path, console: Console) -> Result<PathBuf> {
    let dir = found(dir, &[RUNS, SWEEPS], console)?;
    if dir.is_file() {
        let problem = "is a file; allowed: directories of runs, sweeps and fleets";
        return Err(Failure::input(format_args!("{}: {problem}", dir.display())));
    }
    Ok(dir)
}

/// Sets the flag when the standard input ends: the other command has ended, in whatever way.
fn set_at_end_of_input(over: &Arc<AtomicBool>) -> Result {
    let over = Arc::clone(over);
    let wait = move || {
        let _ = io::copy(&mut io::stdin(), &mut io::sink());
        over.store(true, Ordering::Relaxed);
    };
    let thread = thread::Builder::new().spawn(wait);
    thread.map_err(|error| Failure::failed(format_args!("no thread waits for the input's end: {error}")))?;
    Ok(())
}

/// Opens the page in the browser.
fn open(link: &str, console: Console) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let started = Command::new(program)
        .arg(link)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let failed =
        move |why: &dyn Display| console.warn([format!("--open: {program}: {why}; open the address yourself")]);
    match started {
        Err(error) => failed(&error),
        Ok(mut child) => {
            let wait = move || match child.wait() {
                Ok(status) if !status.success() => failed(&status),
                _ => {}
            };
            // A thread that can't be started only tells less.
            let _ = thread::Builder::new().spawn(wait);
        }
    }
}

/// The page of a command. It ends with the command, or when no browser shows it any more.
pub(super) struct Page {
    process: Child,
    console: Console,
}

impl Page {
    /// Starts the page about these directories if it is wanted.
    ///
    /// # Errors
    /// Exit 1 if the process can't be started.
    pub(super) fn beside<'a>(
        wanted: &cli::Beside,
        directories: impl Iterator<Item = &'a Path>,
        console: Console,
    ) -> Result<Option<Self>> {
        if !wanted.watch {
            return Ok(None);
        }
        let failed = |error| Failure::failed(format_args!("--watch: the page's process: {error}"));
        let mut command = Command::new(program::path().map_err(failed)?);
        command
            .args(["watch", "--beside"])
            .args(wanted.open.then_some("--open"));
        let child = command
            .arg("--")
            .args(directories)
            .stdin(Stdio::piped())
            .stdout(Stdio::null());
        let process = child.spawn().map_err(failed)?;
        Ok(Some(Self { process, console }))
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        drop(self.process.stdin.take());
        thread::sleep(MOMENT);
        if matches!(self.process.try_wait(), Ok(None)) {
            self.console
                .say("the page is still open in a browser: close it, or press Ctrl-C");
        }
        let _ = self.process.wait();
    }
}
