//! Signals that stop the work.

use std::io;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

#[cfg(unix)]
use oneiro_base::ending;
use oneiro_base::exit::{Code, Failure, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag, low_level};

/// A flag that the first Ctrl-C or SIGTERM sets. The next Ctrl-C then ends the program at once, exit 130.
pub fn stop_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let register = || {
        // In this order, so that the first Ctrl-C finds the flag unset.
        flag::register_conditional_shutdown(SIGINT, Code::Aborted as i32, Arc::clone(&stop))?;
        flag::register(SIGINT, Arc::clone(&stop))?;
        flag::register(SIGTERM, Arc::clone(&stop))
    };
    register().map_err(|error| deaf(&error))?;
    for early in std::mem::take(&mut *EARLY.lock().unwrap_or_else(PoisonError::into_inner)) {
        low_level::unregister(early);
    }
    Ok(stop)
}

/// The handlers that end the program at a signal until [`stop_signal`] is called.
static EARLY: Mutex<Vec<SigId>> = Mutex::new(Vec::new());

/// From now until [`stop_signal`] is called, Ctrl-C and SIGTERM end the program at once, exit 75: nothing has begun.
///
/// # Errors
/// Exit 1 if the system registers no signals.
#[cfg(unix)]
pub fn stop_at_once() -> Result {
    for signal in [SIGINT, SIGTERM] {
        // SAFETY: it only does what signal handlers may do.
        let early = unsafe { low_level::register(signal, || ending::stopped_early()) }.map_err(|error| deaf(&error))?;
        EARLY.lock().unwrap_or_else(PoisonError::into_inner).push(early);
    }
    Ok(())
}

fn deaf(error: &io::Error) -> Failure {
    Failure::failed(format_args!("can't listen for Ctrl-C: {error}"))
}
