//! The Python package's native module, `oneiro._native`: [`oneiro_host::api`] with `NumPy`'s arrays. The package's Python files say
//! what users may call.

#![expect(
    clippy::needless_pass_by_value,
    reason = "Python's arguments are converted to values of these types"
)]

mod controller;
mod evolution;
mod experiment;
mod recorded;
mod stepped;
mod watched;

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use oneiro_host::api::{self, Error, Task};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// Robot-steps that take some ten milliseconds: less is done on the caller's own thread, which takes no signal meanwhile.
const SHORT: u64 = 1_000_000;
/// Time between two looks for signals.
const TICK: Duration = Duration::from_millis(50);

/// The exception that Python sees.
fn raised(py: Python<'_>, error: &Error) -> PyErr {
    static MAKE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let make = || -> PyResult<Py<PyAny>> { Ok(py.import("oneiro._errors")?.getattr("of")?.unbind()) };
    let made = MAKE.get_or_try_init(py, make);
    match made.and_then(|make| make.call1(py, (error.code(), error.to_string()))) {
        Ok(exception) => PyErr::from_value(exception.into_bound(py)),
        Err(error) => error,
    }
}

/// Does work without holding Python's lock.
fn done<T: Send>(py: Python<'_>, work: impl FnOnce() -> api::Result<T> + Send) -> PyResult<T> {
    py.detach(work).map_err(|error| raised(py, &error))
}

/// What a Python object holds. Its threads wait for each other.
pub(crate) struct Shared<T>(Mutex<T>);

impl<T: Send> Shared<T> {
    fn new(own: T) -> Self {
        Self(Mutex::new(own))
    }

    /// Works with it, without holding Python's lock, for which another thread that works with it may wait.
    fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut T) -> R + Send) -> R {
        py.detach(|| work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// The same for work that may fail.
    fn done<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut T) -> api::Result<R> + Send) -> PyResult<R> {
        self.with(py, work).map_err(|error| raised(py, &error))
    }
}

/// [`done`] on another thread, so that Ctrl-C stops it, and with a function that is called with the robot-steps done and in all.
fn watched<T: Send>(
    py: Python<'_>,
    task: &Task,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce() -> api::Result<T> + Send,
) -> PyResult<T> {
    thread::scope(|scope| {
        let (sender, mut receiver) = mpsc::channel();
        // If nobody receives it, nobody needs it.
        scope.spawn(move || sender.send(work()).is_ok());
        let mut interrupted: Option<PyErr> = None;
        loop {
            let (back, received) = py.detach(move || {
                let received = receiver.recv_timeout(TICK);
                (receiver, received)
            });
            receiver = back;
            match (received, &interrupted) {
                (Ok(Ok(result)), None) => return Ok(result),
                (Ok(Err(error)), None) => return Err(raised(py, &error)),
                (Ok(result), Some(_)) => {
                    let interruption = interrupted.take().unwrap_or_else(|| unreachable!("there is one"));
                    if let Err(error) = result {
                        // How to go on; Python 3.10 has no notes.
                        let _ = interruption.value(py).call_method1("add_note", (error.to_string(),));
                    }
                    return Err(interruption);
                }
                (Err(RecvTimeoutError::Timeout), None) => {
                    let [steps, all] = task.steps();
                    let shown = progress.map_or(Ok(()), |progress| progress.call1((steps, all)).map(drop));
                    if let Err(error) = shown.and_then(|()| py.check_signals()) {
                        task.stop();
                        interrupted = Some(error);
                    }
                }
                (Err(RecvTimeoutError::Timeout), Some(_)) => (),
                (Err(RecvTimeoutError::Disconnected), _) => panic!("the work has panicked"),
            }
        }
    })
}

/// This machine's devices, as JSON.
#[pyfunction]
fn devices(py: Python<'_>) -> String {
    py.detach(api::device::devices)
}

/// The report of a self-test, as JSON.
#[pyfunction]
fn selftest(py: Python<'_>, backend: &str, rollouts: u32) -> PyResult<String> {
    // It can't be stopped: after Ctrl-C nobody waits for it.
    let backend = backend.to_owned();
    let (sender, mut receiver) = mpsc::channel();
    thread::spawn(move || sender.send(api::device::selftest(&backend, rollouts)).is_ok());
    loop {
        let (back, received) = py.detach(move || {
            let received = receiver.recv_timeout(TICK);
            (receiver, received)
        });
        receiver = back;
        match received {
            Ok(report) => return report.map_err(|error| raised(py, &error)),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => panic!("the self-test has panicked"),
        }
    }
}

/// The program `oneiro`, which `path` starts, with the words of a command line. Returns the exit code, if it doesn't end the process.
#[pyfunction]
fn main(py: Python<'_>, path: PathBuf, words: Vec<OsString>) -> u8 {
    py.detach(|| oneiro_host::main_within(path, words))
}

/// The class that pickles call for.
fn class<T: pyo3::PyTypeInfo>(py: Python<'_>) -> Bound<'_, PyType> {
    py.get_type::<T>()
}

#[pymodule]
#[pyo3(name = "_native")]
fn native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<experiment::Experiment>()?;
    module.add_class::<controller::Controllers>()?;
    module.add_class::<evolution::Evolution>()?;
    module.add_class::<recorded::Run>()?;
    module.add_class::<stepped::Stepped>()?;
    module.add_class::<stepped::Arena>()?;
    module.add_class::<watched::View>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(devices, module)?)?;
    module.add_function(wrap_pyfunction!(selftest, module)?)?;
    module.add_function(wrap_pyfunction!(experiment::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(experiment::examples_of_single_robots, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::run, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::resume, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::merge, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::sweep, module)?)
}
