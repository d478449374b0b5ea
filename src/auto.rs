//! The CPU and a GPU that take turns: each batch goes to the one that is expected to be done with it sooner.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::batch::{Part, PartResult};
use crate::evaluator::{Control, Device, Error, Evaluator};

/// Batches that the CPU does in less time, s, never go to a GPU, which takes about as long for a single life
/// (`docs/gpu.md`).
const LEAST: f64 = 0.001;
/// Time that longer batches take on the CPU before the GPU is opened, s: about what opening takes.
const PATIENCE: f64 = 0.25;
/// Robot-steps of a batch for which the GPU is opened at once. A few processors do them in 0.1 s at best.
const MANY: u64 = 10_000_000;
/// Every batch of this number goes to the slower device, to see whether it still is,
const AGAIN: u32 = 64;
/// unless it takes so many times as long.
const HOPELESS: f64 = 4.0;

/// Opens a GPU, if it is exact.
pub type Opener = Box<dyn FnOnce() -> Option<Box<dyn Evaluator>> + Send>;

/// Evaluates each batch on the CPU or on a GPU, which is opened once there is enough to do. What it expects of either is what
/// batches of the same kernel took there. Results don't depend on the choice.
pub struct Auto {
    cpu: Member,
    gpu: Option<Member>,
    opener: Option<Opener>,
    name: String,
    /// Time that the CPU has worked on batches that a GPU might have done sooner, s.
    spent: f64,
    batches: u32,
    warnings: Vec<String>,
}

/// One of the two.
struct Member {
    evaluator: Box<dyn Evaluator>,
    /// For each kernel the time of its batches, by the binary logarithm of their robot-steps; empty after its first one, which may
    /// have included compiling.
    times: BTreeMap<&'static str, BTreeMap<u32, f64>>,
    /// Number of its warnings that have been passed on.
    heard: usize,
}

impl Auto {
    /// Joins the CPU's evaluator and a GPU of this name, which is not opened yet.
    pub fn new(cpu: Box<dyn Evaluator>, name: String, opener: Opener) -> Self {
        Self {
            cpu: Member::new(cpu),
            gpu: None,
            opener: Some(opener),
            name,
            spent: 0.0,
            batches: 0,
            warnings: Vec::new(),
        }
    }

    /// The device for a part.
    fn choose(&mut self, part: &Part<'_>) -> &mut Member {
        let expected = self.cpu.expected(part, true);
        let is_long = part.steps() >= MANY || expected.is_some_and(|time| time >= LEAST);
        if is_long
            && (part.steps() >= MANY || self.spent >= PATIENCE)
            && let Some(open) = self.opener.take()
        {
            self.gpu = open().map(Member::new);
        }
        let Some(gpu) = self.gpu.as_mut().filter(|_| is_long) else {
            return &mut self.cpu;
        };
        let (Some(there), Some(here)) = (gpu.expected(part, false), expected) else {
            // Either the GPU has no time yet, or the batch is a large one.
            return gpu;
        };
        self.batches = self.batches.wrapping_add(1);
        let is_second_chance = self.batches.is_multiple_of(AGAIN) && there.max(here) < HOPELESS * there.min(here);
        if (there < here) == is_second_chance {
            &mut self.cpu
        } else {
            gpu
        }
    }
}

impl Member {
    fn new(evaluator: Box<dyn Evaluator>) -> Self {
        Self {
            evaluator,
            times: BTreeMap::new(),
            heard: 0,
        }
    }

    /// The time that a part is expected to take, s, if anything is known of its kernel. Fewer steps take less time in proportion, or
    /// as long.
    fn expected(&self, part: &Part<'_>, in_proportion: bool) -> Option<f64> {
        let times = self.times.get(part.kernel().name)?;
        let size = size(part);
        let smaller = times.range(..=size).next_back();
        let larger = || times.range(size..).next();
        let (known, time) = smaller.or_else(larger)?;
        let ratio = 2.0_f64.powi(size as i32 - *known as i32);
        Some(time * if in_proportion { ratio } else { ratio.max(1.0) })
    }

    /// Runs a part. Also returns how long that took, s.
    fn evaluate(&mut self, part: &Part<'_>, control: &Control) -> Result<(PartResult, f64), Error> {
        let start = Instant::now();
        let result = self.evaluator.evaluate_part(part, control)?;
        let time = start.elapsed().as_secs_f64();
        match self.times.get_mut(part.kernel().name) {
            None => {
                self.times.insert(part.kernel().name, BTreeMap::new());
            }
            Some(times) => {
                let known = times.entry(size(part)).or_insert(time);
                // A single slow batch may have had other reasons.
                *known = time.min(2.0 * *known);
            }
        }
        Ok((result, time))
    }
}

/// The binary logarithm of a part's robot-steps.
fn size(part: &Part<'_>) -> u32 {
    part.steps().max(1).ilog2()
}

impl Evaluator for Auto {
    fn device(&self) -> Device {
        let cpu = self.cpu.evaluator.device();
        if self.gpu.is_none() && self.opener.is_none() {
            return cpu;
        }
        Device {
            name: format!("{} or {}", cpu.name, self.name),
            ..cpu
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let chosen = self.choose(part);
        let (result, time) = chosen.evaluate(part, control)?;
        let news: Vec<String> = chosen.evaluator.warnings()[chosen.heard..].to_vec();
        chosen.heard += news.len();
        self.warnings.extend(news);
        if self.gpu.is_none() && time >= LEAST {
            self.spent += time;
        }
        Ok(result)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        let members = [Some(&self.cpu), self.gpu.as_ref()];
        members
            .into_iter()
            .flatten()
            .map(|own| own.evaluator.specialised_steps())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{Batch, Rollout};
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    struct Named(&'static str);

    impl Evaluator for Named {
        fn device(&self) -> Device {
            Device {
                name: self.0.into(),
                detail: String::new(),
                exact: true,
            }
        }

        fn evaluate_part(&mut self, _: &Part<'_>, _: &Control) -> Result<PartResult, Error> {
            unreachable!("only the choice is tested")
        }
    }

    /// A batch of some rollouts of 512 cycles.
    fn batch(rollouts: usize) -> Batch {
        let spec = WorldSpec {
            cycles: 512,
            ..WorldSpec::miglino1995()
        };
        let rollout = Rollout {
            world: 0,
            genes: &[0.0; 18],
            key: Key::rollout(0, 0, 0, 0),
        };
        Batch::new(&[World::new(spec).unwrap()], &vec![rollout; rollouts], None).unwrap()
    }

    /// Of 320 batches of `rollouts`, how many go to the GPU, given the time of 64 rollouts on both, s.
    fn to_gpu(rollouts: usize, cpu: f64, gpu: f64) -> usize {
        let mut auto = Auto::new(Box::new(Named("cpu")), "gpu".into(), Box::new(|| None));
        auto.gpu = Some(Member::new(Box::new(Named("gpu"))));
        let known = batch(64);
        let of_size = |time| BTreeMap::from([(known.kernel().name, BTreeMap::from([(size(&known.all()), time)]))]);
        auto.cpu.times = of_size(cpu);
        auto.gpu.as_mut().unwrap().times = of_size(gpu);
        let batch = batch(rollouts);
        (0..320)
            .filter(|_| auto.choose(&batch.all()).evaluator.device().name == "gpu")
            .count()
    }

    #[test]
    fn the_slower_device_gets_another_chance_now_and_then() {
        assert_eq!(to_gpu(64, 0.020, 0.010), 315);
        assert_eq!(to_gpu(64, 0.010, 0.020), 5);
        assert_eq!(to_gpu(64, 0.010, 0.050), 0, "hopeless");
        assert_eq!(to_gpu(64, 0.050, 0.010), 320, "hopeless");
        assert_eq!(to_gpu(64, 0.0005, 0.0001), 0, "too short");
    }

    #[test]
    fn batches_of_other_sizes_are_judged_by_what_is_known() {
        // Twice the steps take both twice the time.
        assert_eq!(to_gpu(128, 0.010, 0.020), 5);
        // An eighth of them takes the CPU an eighth of its time, and the GPU as long as before.
        assert_eq!(to_gpu(64, 0.016, 0.005), 315);
        assert_eq!(to_gpu(8, 0.016, 0.005), 5);
    }
}
