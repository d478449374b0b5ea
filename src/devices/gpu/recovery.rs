//! Recovery from a lost GPU: reopens it once, then uses another evaluator.

use super::Gpu;
use crate::batch::{Part, PartResult};
use crate::evaluator::{Control, Device, Error, Evaluator, pass_on};

/// Evaluates on a GPU. If its device is lost, it is reopened and the part repeated; if that fails too, this part and
/// all later ones run on the fallback. Results stay the same.
pub struct Recovering {
    gpu: Option<Gpu>,
    fallback: Box<dyn Evaluator>,
    warnings: Vec<String>,
    /// Number of the GPU's own warnings among them.
    heard: usize,
}

impl Recovering {
    /// Wraps a GPU and the evaluator that replaces it when it is lost.
    pub fn new(gpu: Gpu, fallback: Box<dyn Evaluator>) -> Self {
        Self {
            gpu: Some(gpu),
            fallback,
            warnings: Vec::new(),
            heard: 0,
        }
    }

    /// Runs the part on the GPU, which is reopened if it is lost; `None` if it is gone for good.
    fn on_gpu(&mut self, part: &Part<'_>, control: &Control) -> Option<Result<PartResult, Error>> {
        let gpu = self.gpu.as_mut()?;
        let lost = match gpu.evaluate_part(part, control) {
            Err(lost @ Error::Lost { .. }) => lost,
            done => return Some(done),
        };
        self.warnings.push(format!("{lost}; opening it again"));
        let again = gpu.reopen().and_then(|new| {
            *gpu = new;
            self.heard = 0;
            gpu.evaluate_part(part, control)
        });
        match again {
            Err(error @ (Error::Lost { .. } | Error::NoDevice(_))) => {
                let next = self.fallback.device().name;
                self.warnings
                    .push(format!("{error}; from now on {next} evaluates instead"));
                self.gpu = None;
                None
            }
            done => Some(done),
        }
    }
}

impl Evaluator for Recovering {
    fn device(&self) -> Device {
        self.gpu
            .as_ref()
            .map_or_else(|| self.fallback.device(), Evaluator::device)
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let done = self.on_gpu(part, control);
        if let Some(gpu) = &self.gpu {
            pass_on(gpu, &mut self.heard, &mut self.warnings);
        }
        match done {
            Some(done) => done,
            None => self.fallback.evaluate_part(part, control),
        }
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        self.gpu.as_ref().map_or(0, Evaluator::specialised_steps)
    }
}
