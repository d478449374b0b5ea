//! Decides whether a GPU is exact: runs every operation and function of the kernels on it and on the CPU.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::device::Path;
use super::{Gpu, Run};
use crate::devices::probe::{self, Case};
use crate::evaluator::Error;

/// Number of arguments that each function is tested with.
const ARGUMENTS: usize = 1024;

/// Verdicts of this process by adapter and driver: the reason why results aren't exact, or `None`.
static VERDICTS: Mutex<BTreeMap<String, Option<String>>> = Mutex::new(BTreeMap::new());

/// Returns the reason why a GPU's results aren't exact, or `None` if they are.
///
/// # Errors
/// As [`Gpu::run`].
pub(super) fn verdict(gpu: &mut Gpu) -> Result<Option<String>, Error> {
    if gpu.device.path() == Path::Wgsl {
        return Ok(Some(
            "it receives kernels as WGSL, which its driver may round differently".into(),
        ));
    }
    let adapter = gpu.adapter();
    let driver = format!("{}, {}, {}", adapter.name(), adapter.driver(), adapter.backend());
    if let Some(verdict) = verdicts().get(&driver) {
        return Ok(verdict.clone());
    }
    let mut cases = probe::operations();
    cases.extend(probe::functions(ARGUMENTS));
    let verdict = gpu.differences(&cases)?.into_iter().next();
    verdicts().insert(driver, verdict.clone());
    Ok(verdict)
}

fn verdicts() -> MutexGuard<'static, BTreeMap<String, Option<String>>> {
    VERDICTS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Runs cases on both devices. For each case that differs, returns the first pair of different results.
    ///
    /// # Errors
    /// As [`Gpu::run`].
    pub fn differences(&mut self, cases: &[Case]) -> Result<Vec<String>, Error> {
        let mut runs: Vec<Run<'_>> = cases.iter().map(run_of).collect();
        self.run(&mut runs)?;
        Ok(cases
            .iter()
            .zip(runs)
            .filter_map(|(case, run)| difference(case, run.buffers.last()?))
            .collect())
    }
}

fn run_of(case: &Case) -> Run<'static> {
    let results = vec![0; case.left.len()];
    Run {
        kernel: case.kernel,
        buffers: vec![case.parameters.to_vec(), case.left.clone(), case.right.clone(), results],
        workgroups: case.workgroups(),
    }
}

/// Describes the first difference from the CPU's results.
fn difference(case: &Case, there: &[u32]) -> Option<String> {
    let Some(here) = case.lane_codes().next().and_then(|variant| case.run(variant)) else {
        return Some(format!("there is no lane code to compare `{}` with", case.subject));
    };
    let at = here.iter().zip(there).position(|(here, there)| here != there)?;
    Some(format!(
        "`{}` of {:#010x} and {:#010x} is {:#010x} there, {:#010x} on the CPU",
        case.subject, case.left[at], case.right[at], there[at], here[at]
    ))
}
