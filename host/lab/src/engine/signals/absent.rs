//! Stands in for signals where there are none.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro_base::exit::Result;

/// A flag that nothing sets.
#[expect(clippy::unnecessary_wraps, reason = "as the one that it stands in for")]
pub fn stop_signal() -> Result<Arc<AtomicBool>> {
    Ok(Arc::default())
}
