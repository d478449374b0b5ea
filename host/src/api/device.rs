//! Evaluators that are opened once and kept, and what this machine has.

use std::collections::BTreeMap;
use std::process;
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use oneiro::evaluator::{Device, Evaluator};
use oneiro_base::console::{Console, Output};
use oneiro_base::exit::Failure;

use super::{Error, Result};
use crate::cli::Backend;
use crate::commands::device::{list, test};

/// What a process has opened. A forked process has the memory of its parent, but none of its threads: it begins anew, and what was its
/// parent's stays as it is for ever.
struct Process {
    id: u32,
    forked: bool,
    evaluators: Mutex<BTreeMap<String, Shared>>,
    /// Threads of a forked process, in place of those that all libraries share.
    threads: OnceLock<rayon::ThreadPool>,
}

type Shared = Arc<Mutex<Box<dyn Evaluator>>>;

static HERE: AtomicPtr<Process> = AtomicPtr::new(ptr::null_mut());

/// This process.
fn here() -> &'static Process {
    let (known, id) = (HERE.load(Ordering::Acquire), process::id());
    // SAFETY: it is null, or was leaked below and is never changed or freed.
    let of = |known: *mut Process| unsafe { known.as_ref() };
    if let Some(own) = of(known).filter(|own| own.id == id) {
        return own;
    }
    let new = Box::into_raw(Box::new(Process {
        id,
        forked: !known.is_null(),
        evaluators: Mutex::default(),
        threads: OnceLock::new(),
    }));
    match HERE.compare_exchange(known, new, Ordering::AcqRel, Ordering::Acquire) {
        Ok(_) => of(new),
        // Another thread was first. The new one has nothing, and is forgotten.
        Err(first) => of(first),
    }
    .unwrap_or_else(|| unreachable!("both were leaked"))
}

/// Does work in which packing and reading may use several threads.
pub(super) fn threaded<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let here = here();
    if !here.forked {
        return work();
    }
    let made = || rayon::ThreadPoolBuilder::new().build();
    let threads = match here.threads.get() {
        Some(threads) => threads,
        // A second pool of another thread is dropped again.
        None => match made() {
            Ok(threads) => here.threads.get_or_init(|| threads),
            Err(_) => return work(),
        },
    };
    threads.install(work)
}

/// A console that says nothing.
pub(super) fn quiet() -> Console {
    Console::new(Output {
        json: true,
        quiet: true,
        verbose: false,
    })
}

/// Works with an evaluator. It is opened for the first work, and kept.
pub(super) fn with<T>(name: &str, work: impl FnOnce(&mut dyn Evaluator) -> T) -> Result<T> {
    let mut evaluators = here().evaluators.lock().unwrap_or_else(PoisonError::into_inner);
    let shared = if let Some(shared) = evaluators.get(name) {
        Arc::clone(shared)
    } else {
        let shared = Arc::new(Mutex::new(Backend::named(name).open()?));
        evaluators.insert(name.to_owned(), Arc::clone(&shared));
        shared
    };
    drop(evaluators);
    let mut evaluator = shared.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(work(&mut **evaluator))
}

/// A device in words, such as `cpu (native256x16, 2 threads)`.
pub(super) fn words(device: &Device) -> String {
    format!("{} ({})", device.name, device.detail)
}

/// This machine's devices as JSON, as `oneiro device list --json` prints them.
pub fn devices() -> String {
    list::answer(false).value.to_string()
}

/// Checks that this machine computes the same bits as every other, as `oneiro device test --json` does, with `rollouts` lives of each
/// controller, 1000 or more. Returns its report as JSON.
///
/// # Errors
/// Exit 4 if there is no such device. What a failed check found is in the report.
pub fn selftest(backend: &str, rollouts: u32) -> Result<String> {
    let report = threaded(|| test::report(backend, rollouts, quiet()))?;
    serde_json::to_string(&report).map_err(|error| Error::from(Failure::failed(error)))
}
