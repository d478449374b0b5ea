//! A pool: several evaluators share each batch.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::batch::{Part, PartResult};
use crate::evaluator::{Control, Device, Error, Evaluator, pass_on};

/// Minimum duration of a piece in seconds, so that fixed costs don't matter. A piece is never more than the member's
/// share.
const LEAST_PIECE: f64 = 0.02;

/// Evaluators that share each batch. Each takes pieces until none is left; faster ones take larger pieces. If a member
/// is lost, the others take over its piece. Results don't depend on the division of work.
pub struct Pool {
    members: Vec<Member>,
    warnings: Vec<String>,
}

struct Member {
    evaluator: Box<dyn Evaluator>,
    /// Robot-steps per second of its last piece.
    speed: Option<f64>,
    /// Number of its warnings that the pool has passed on.
    heard: usize,
    /// Error that ended its membership, if any.
    gone: Option<Error>,
}

impl Pool {
    /// Makes a pool of one or more evaluators.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if there are none, or if one isn't exact: results would depend on the division of work.
    pub fn new(evaluators: Vec<Box<dyn Evaluator>>) -> Result<Self, Error> {
        if evaluators.is_empty() {
            return Err(Error::NoDevice("the pool has no devices; allowed: at least one".into()));
        }
        for evaluator in &evaluators {
            let Device { name, exact, .. } = evaluator.device();
            if !exact {
                return Err(Error::NoDevice(format!(
                    "{name} is not exact; allowed in a pool: exact devices"
                )));
            }
        }
        let member = |evaluator| Member {
            evaluator,
            speed: None,
            heard: 0,
            gone: None,
        };
        Ok(Self {
            members: evaluators.into_iter().map(member).collect(),
            warnings: Vec::new(),
        })
    }
}

impl Evaluator for Pool {
    fn device(&self) -> Device {
        let devices: Vec<Device> = self.members.iter().map(|member| member.evaluator.device()).collect();
        let join = |text: fn(&Device) -> &str| devices.iter().map(text).collect::<Vec<_>>().join(" + ");
        Device {
            name: join(|device| &device.name),
            detail: join(|device| &device.detail),
            exact: true,
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        let work = Work::new(part, self.members.len())?;
        // One round is enough unless a member returns a piece after the others have left.
        while work.has_pieces() {
            if self.members.is_empty() {
                return Err(Error::NoDevice(format!(
                    "the pool has no device left: {}",
                    self.warnings.join("; ")
                )));
            }
            std::thread::scope(|scope| {
                for (index, member) in self.members.iter_mut().enumerate() {
                    let work = &work;
                    scope.spawn(move || member.work(index, work, control));
                }
            });
            self.hear();
            for member in &mut self.members {
                match member.gone.take() {
                    None => {}
                    Some(lost @ (Error::Lost { .. } | Error::NoDevice(_))) => {
                        self.warnings.push(format!("{lost}; the pool continues without it"));
                        member.gone = Some(lost);
                    }
                    Some(error) => return Err(error),
                }
            }
            self.members.retain(|member| member.gone.is_none());
        }
        Ok(work.into_result())
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        let members = self.members.iter();
        members.map(|member| member.evaluator.specialised_steps()).sum()
    }
}

impl Pool {
    /// Passes on the members' new warnings.
    fn hear(&mut self) {
        for member in &mut self.members {
            pass_on(member.evaluator.as_ref(), &mut member.heard, &mut self.warnings);
        }
    }
}

impl Member {
    /// Takes pieces until none is left or one fails.
    fn work(&mut self, index: usize, work: &Work<'_>, control: &Control) {
        while let Some(groups) = work.take(index, self.speed) {
            let piece = work.part.part(groups.clone());
            let start = Instant::now();
            match self.evaluator.evaluate_part(&piece, control) {
                Ok(result) => {
                    self.speed = Some(piece.steps() as f64 / start.elapsed().as_secs_f64().max(1e-9));
                    work.put(&groups, &result);
                }
                Err(error) => {
                    let others_can = matches!(error, Error::Lost { .. } | Error::NoDevice(_));
                    work.give_back(groups, others_can);
                    self.gone = Some(error);
                    return;
                }
            }
        }
    }
}

/// The work of a part: remaining pieces and results.
struct Work<'a> {
    part: &'a Part<'a>,
    shared: Mutex<Shared>,
}

struct Shared {
    /// Remaining groups.
    open: Vec<Range<u32>>,
    /// Known speeds of the members.
    speeds: Vec<Option<f64>>,
    stopped: bool,
    result: PartResult,
}

impl<'a> Work<'a> {
    fn new(part: &'a Part<'a>, members: usize) -> Result<Self, Error> {
        let result = PartResult::blank(part.batch(), part.slots())?;
        let all = 0..part.groups().len() as u32;
        Ok(Self {
            part,
            shared: Mutex::new(Shared {
                open: Vec::from([all]),
                speeds: vec![None; members],
                stopped: false,
                result,
            }),
        })
    }

    fn shared(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn has_pieces(&self) -> bool {
        self.shared().open.iter().any(|groups| !groups.is_empty())
    }

    /// Takes a piece for a member: half of its share of the remaining work, by its speed, so that all finish together.
    fn take(&self, member: usize, speed: Option<f64>) -> Option<Range<u32>> {
        let mut shared = self.shared();
        shared.open.retain(|groups| !groups.is_empty());
        if shared.stopped {
            return None;
        }
        shared.speeds[member] = speed;
        let left: u32 = shared.open.iter().map(|groups| groups.len() as u32).sum();
        let members = shared.speeds.len() as f64;
        let size = match speed {
            None => f64::from(left) / (8.0 * members),
            Some(speed) => {
                let known: Vec<f64> = shared.speeds.iter().copied().flatten().collect();
                let mean = known.iter().sum::<f64>() / known.len() as f64;
                let share = f64::from(left) * speed / (mean * members);
                let group_steps = self.part.steps() as f64 / self.part.groups().len() as f64;
                (0.5 * share).max(LEAST_PIECE * speed / group_steps).min(share)
            }
        } as u32;
        let open = shared.open.last_mut()?;
        let end = open.start.saturating_add(size.max(1)).min(open.end);
        let piece = open.start..end;
        open.start = end;
        Some(piece)
    }

    fn give_back(&self, groups: Range<u32>, others_can: bool) {
        let mut shared = self.shared();
        shared.open.push(groups);
        shared.stopped |= !others_can;
    }

    fn put(&self, groups: &Range<u32>, result: &PartResult) {
        self.shared().result.put(self.part.batch(), groups, result);
    }

    fn into_result(self) -> PartResult {
        self.shared.into_inner().unwrap_or_else(PoisonError::into_inner).result
    }
}
