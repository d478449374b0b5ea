//! Evaluation on the CPU: the kernels' lane code, on many threads.

#[cfg_attr(target_family = "wasm", path = "cpu/alone.rs")]
mod workers;

use std::num::NonZero;
use std::ops::Range;
use std::thread;

use oneiro_shaders::episode::{Dispatch, Group};
use oneiro_shaders::{Kernel, Words};
use rayon::prelude::*;

use crate::batch::{Batch, LANES, Observer, Outcome, Part, PartResult, Worlds};
use crate::devices::code::{LaneCode, Specialised, interpreted_because, interpreter, interprets};
use crate::devices::threads::startable;
use crate::devices::variants::Specialise;
use crate::evaluator::{Control, Device, Error, Evaluator};
use workers::Workers;

/// Cycles between checks for cancellation: about ten milliseconds of 64 episodes.
const CHUNK: u32 = 16_384;
/// Said of a processor that kernels can't be compiled for.
const SLOW: &str = "; kernels composed at run time are interpreted, which is slow";
/// How many times the bound of its loops' turns a call of code made at run time may take before it is stopped. The bound is that of
/// one episode. Of several lanes, some may leave a loop earlier than others; the pass in which the last ones leave it goes on to its end
/// without any. So a loop may take one pass more than the bound says, which is at most twice as many for each loop around
/// it: this is for ten.
const MARGIN: u64 = 1 << 10;
/// Records of each episode that an observer is shown at a time: those of a call's lanes stay in a core's cache.
const SHOWN: u32 = 64;
/// Most turns of loops between such checks, for kernels that loop much in a cycle.
const TURNS_OF_CHUNK: u32 = 10_000_000;

/// The CPU evaluator: a pool of threads, and for each batch the lane code that suits its size.
#[derive(Debug)]
pub struct Cpu {
    workers: Workers,
    variant: Option<&'static str>,
    checks: bool,
    chunk: u32,
    specialised: Specialised,
    warnings: Vec<String>,
}

impl Cpu {
    /// Opens the CPU with a number of threads, by default one per processor. Where so many can't be started, it has fewer and a
    /// warning.
    ///
    /// ```
    /// use oneiro::cpu::Cpu;
    /// use oneiro::evaluator::Evaluator;
    ///
    /// let cpu = Cpu::new(Some(2))?;
    /// assert!(cpu.device().exact);
    /// # Ok::<(), oneiro::evaluator::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoDevice`] for no threads or too many, or if threads don't round to nearest or don't keep subnormals;
    /// [`Error::Short`] if not one can be started.
    pub fn new(threads: Option<usize>) -> Result<Self, Error> {
        const GREATEST: usize = 1024;
        if threads.is_some_and(|threads| threads == 0 || threads > GREATEST) {
            let threads = threads.unwrap_or_default();
            return Err(Error::NoDevice(format!("{threads} threads; allowed: 1 to {GREATEST}")));
        }
        let wanted = threads.unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get));
        let threads = startable(wanted);
        let workers = Workers::start(threads)?;
        if !workers.all(float_mode::is_default) {
            return Err(Error::NoDevice(
                "this program's threads do not round floats to nearest, or flush subnormal ones to zero; allowed: the \
                 processor's default mode"
                    .into(),
            ));
        }
        Ok(Self {
            workers,
            variant: None,
            checks: false,
            chunk: CHUNK,
            specialised: Specialised::default(),
            warnings: (threads < wanted)
                .then(|| format!("only {threads} of {wanted} threads could be started"))
                .into_iter()
                .collect(),
        })
    }

    /// Names of the lane codes that this processor can run, such as `scalarx1`, the fastest first: those compiled with this
    /// program, and those such as `native128x16`, which are compiled at run time where that is possible.
    pub fn variants() -> Vec<&'static str> {
        LaneCode::all(&oneiro_shaders::LIFE_PERCEPTRON)
            .map(|(name, _)| name)
            .collect()
    }

    /// Names of the lane codes that this processor can run of the kernel of these worlds, the fastest first, those in the user's
    /// cache included. Where there is none, the kernel is interpreted, and the interpreter's name is the only one.
    pub fn variants_for(worlds: &Worlds) -> Vec<&'static str> {
        let names: Vec<_> = LaneCode::all(worlds.kernel()).map(|(name, _)| name).collect();
        if names.is_empty() {
            interpreter().into_iter().collect()
        } else {
            names
        }
    }

    /// Always runs one lane code instead of choosing one for each batch. A kernel that isn't compiled so wide runs the
    /// widest code of the same instruction set, and one that isn't compiled ahead of time at all runs code compiled at run time.
    /// `interpretedx1` is the interpreter, which is only chosen by itself for a kernel composed at run time where that can't be
    /// compiled.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if this processor can't run a lane code with that name.
    pub fn with_variant(mut self, name: &str) -> Result<Self, Error> {
        let known: Vec<_> = Self::variants().into_iter().chain(interpreter()).collect();
        let Some(variant) = known.iter().find(|known| **known == name) else {
            let problem = format!("this CPU has no lane code `{name}`; allowed: {}", known.join(", "));
            return Err(Error::NoDevice(problem));
        };
        self.variant = Some(variant);
        Ok(self)
    }

    /// Interprets kernels and checks each operation: evaluations end with [`Error::Inexact`] at the first result that is not a
    /// number, infinite or subnormal, or a number that is converted out of range. Slow.
    #[must_use]
    pub fn checking(mut self) -> Self {
        self.checks = true;
        self
    }

    /// Sets the number of cycles in one call of a kernel, at least 1. Results don't depend on it.
    #[must_use]
    pub fn with_chunk(mut self, cycles: u32) -> Self {
        self.chunk = cycles.max(1);
        self
    }

    /// Sets when kernels compiled at run time are specialised to their worlds. Results don't depend on it.
    #[must_use]
    pub fn with_specialise(mut self, when: Specialise) -> Self {
        self.specialised.set(when);
        self
    }

    /// The number of threads.
    pub fn threads(&self) -> usize {
        self.workers.count()
    }

    /// Runs some groups of a batch and returns results in the order of `groups`. With `report_progress`, `control`
    /// counts the steps. With an observer the results have no traces.
    pub(crate) fn run(
        &self,
        batch: &Batch,
        groups: &[u32],
        control: &Control,
        report_progress: bool,
        observer: Option<Observer<'_>>,
    ) -> Result<PartResult, Error> {
        let parts: Vec<Part<'_>> = groups.iter().map(|&group| batch.part(group..group + 1)).collect();
        let code = self.choose(batch.kernel(), &parts)?;
        let mut result = match observer {
            Some(_) => PartResult::untraced(batch, parts.len() * LANES)?,
            None => PartResult::blank(batch, parts.len() * LANES)?,
        };
        let shown = observer.map(|observer| Shown {
            observer,
            rollouts: batch.rollouts_by_slot(),
        });
        if batch.keeps_states() {
            let states = result.states.chunks_exact_mut(LANES * batch.state_words());
            for (part, states_of_part) in parts.iter().zip(states).filter(|(part, _)| !part.states().is_empty()) {
                states_of_part.copy_from_slice(part.states());
            }
        }
        let steps = if report_progress { Some(control) } else { None };
        let ready = self.specialised.ready(&code, &parts, control);
        let few = self.for_few(&code, &parts);
        let mut fitness = result.fitness.chunks_mut(LANES);
        let mut traces = result.trace.chunks_mut((LANES * batch.trace_words()).max(1));
        let mut states = result.states.chunks_mut(LANES * batch.state_words());
        let groups: Vec<GroupRun<'_>> = parts
            .iter()
            .enumerate()
            .map(|(group, part)| GroupRun {
                part,
                code: [&ready, &few]
                    .into_iter()
                    .find_map(|codes| codes.get(group)?.as_ref())
                    .unwrap_or(&code),
                chunk: self.chunk.min((TURNS_OF_CHUNK / part.loops().max(1)).max(1)),
                control,
                steps,
                fitness: written(fitness.next().unwrap_or_default()),
                trace: traces.next().map(written),
                shown: shown.as_ref(),
                states: states.next().map(written),
            })
            .collect();
        // Idle lanes aren't run.
        let calls: Vec<(&GroupRun<'_>, usize)> = groups
            .iter()
            .flat_map(|group| (0..group.calls()).map(move |call| (group, call)))
            .collect();
        self.specialised.timed(&code, &parts, &ready, || match calls[..] {
            // A thread takes longer to wake up than a cycle of one episode to compute.
            [(group, call)] if float_mode::is_default() => group.run(call),
            _ => {
                let run = || calls.into_par_iter().try_for_each(|(group, call)| group.run(call));
                self.workers.install(run)
            }
        })?;
        Ok(result)
    }

    /// Whether a lane code is of the requested instruction set, if any.
    fn is_wanted(&self, name: &str) -> bool {
        self.variant
            .is_none_or(|wanted| instruction_set(wanted) == instruction_set(name))
    }

    /// This device, with the name of a lane code.
    fn described(&self, lane_code: &str) -> Device {
        let slow = if interprets() { SLOW } else { "" };
        Device {
            name: "cpu".into(),
            detail: format!(
                "{lane_code}, {} {}{slow}",
                self.threads(),
                if self.threads() == 1 { "thread" } else { "threads" }
            ),
            exact: true,
        }
    }

    /// Returns the lane code requested by name, or else the one with the shortest estimated time. With few episodes,
    /// narrow ones keep more threads busy.
    fn choose(&self, kernel: &'static Kernel, parts: &[Part<'_>]) -> Result<LaneCode, Error> {
        if self.checks {
            return LaneCode::checked(kernel);
        }
        if let Some(name) = self.variant
            && let Some(code) = LaneCode::named(kernel, name)?
        {
            return Ok(code);
        }
        let time = |(name, lanes): (&str, u32)| {
            let calls: usize = parts.iter().map(|part| part.rollouts().div_ceil(lanes as usize)).sum();
            calls.div_ceil(self.threads()) as f32 * cost(name, lanes)
        };
        let mut codes: Vec<_> = LaneCode::all(kernel).filter(|(name, _)| self.is_wanted(name)).collect();
        codes.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
        // A kernel may be too large for the code generator with the widest vectors.
        let fastest = codes.iter().find_map(|(name, _)| LaneCode::named(kernel, name).ok()?);
        match fastest {
            Some(code) => Ok(code),
            None if kernel.variants.is_empty() => LaneCode::composed(kernel),
            None => {
                let problem = format!("this CPU has no lane code for the kernel {}", kernel.name);
                Err(Error::NoDevice(problem))
            }
        }
    }

    /// Runs a part, and warns if it has to be interpreted.
    fn run_part(
        &mut self,
        part: &Part<'_>,
        control: &Control,
        observer: Option<Observer<'_>>,
    ) -> Result<PartResult, Error> {
        let groups: Vec<u32> = part.groups().collect();
        let result = self.run(part.batch(), &groups, control, true, observer);
        let of_code = interpreted_because(part.kernel()).map(|problem| {
            format!("{problem}; the kernel is interpreted instead, which is slow: make its parts smaller")
        });
        self.warn(of_code);
        result
    }

    /// Warns of something, once.
    fn warn(&mut self, warning: Option<String>) {
        self.warnings
            .extend(warning.filter(|warning| !self.warnings.contains(warning)));
    }

    /// For each group, narrower lane code if that is faster: a world's last group is rarely full. Empty where the lane code is fixed.
    fn for_few(&self, code: &LaneCode, parts: &[Part<'_>]) -> Vec<Option<LaneCode>> {
        let few = |part: &Part<'_>| match part.rollouts() {
            full if full.is_multiple_of(code.lanes() as usize) => None,
            rollouts => code.for_few(part.kernel(), rollouts, cost),
        };
        match self.variant {
            None if !self.checks => parts.iter().map(few).collect(),
            _ => Vec::new(),
        }
    }
}

impl Evaluator for Cpu {
    fn device(&self) -> Device {
        let widest = self
            .variant
            .or_else(|| Self::variants().first().copied())
            .unwrap_or("no lane code");
        self.described(widest)
    }

    fn device_for(&self, kernel: &'static Kernel) -> Device {
        let names: Vec<_> = LaneCode::all(kernel).map(|(name, _)| name).collect();
        let is_there = |name: &&str| names.contains(name) || interpreter() == Some(*name);
        let named = self.variant.filter(is_there);
        let wanted = || names.iter().copied().find(|name| self.is_wanted(name));
        let any = || names.first().copied().or(interpreter());
        self.described(named.or_else(wanted).or_else(any).unwrap_or("no lane code"))
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        self.run_part(part, control, None)
    }

    fn observe(&mut self, batch: &Batch, control: &Control, observer: Observer<'_>) -> Result<Outcome, Error> {
        let result = self.run_part(&batch.all(), control, Some(observer))?;
        Ok(batch.outcome_of(&result, &[]))
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn specialised_steps(&self) -> u64 {
        self.specialised.steps()
    }
}

/// The instruction set in a lane code's name, such as `neon` of `neonx16`.
fn instruction_set(name: &str) -> &str {
    name.rsplit_once('x').map_or(name, |(set, _)| set)
}

/// Approximate time of one call of a lane code: microseconds for 500 cycles of the perceptron's kernel, measured on a
/// server's core. It only affects the choice of a lane code.
fn cost(name: &str, lanes: u32) -> f32 {
    let each_lane = match instruction_set(name) {
        "neon" => 9.7,
        "simd128" => 14.0,
        "scalar" => 30.0,
        "checked" => 170.0,
        "native512" => 2.5,
        "native256" => 5.0,
        // Compiled at run time.
        _ => 10.0,
    };
    45.0 + each_lane * lanes as f32
}

/// Who is shown the traces of episodes, and which episode is in each slot of the batch.
struct Shown<'a> {
    observer: Observer<'a>,
    rollouts: Vec<u32>,
}

/// Episodes of one group, and the destination of their results.
struct GroupRun<'a> {
    part: &'a Part<'a>,
    code: &'a LaneCode,
    chunk: u32,
    control: &'a Control,
    /// Counter of steps, if wanted.
    steps: Option<&'a Control>,
    fitness: Words,
    /// `None` without a trace, and if an observer is shown the trace instead.
    trace: Option<Words>,
    shown: Option<&'a Shown<'a>>,
    /// `None` if states aren't requested. Otherwise they also hold the states that episodes begin with.
    states: Option<Words>,
}

// SAFETY: several calls fill the group's results at the same time, but each runs its own lanes, and the kernels write
// only to words of their own lanes.
unsafe impl Sync for GroupRun<'_> {}

impl GroupRun<'_> {
    /// Number of calls needed for all episodes.
    fn calls(&self) -> usize {
        self.part.rollouts().div_ceil(self.code.lanes() as usize)
    }

    /// Runs the episodes of one call's lanes.
    fn run(&self, call: usize) -> Result<(), Error> {
        let part = self.part;
        let batch = part.batch();
        let lanes = self.code.lanes() as usize;
        let first_lane = call * lanes;
        let active = Group {
            rollouts: (part.rollouts() - first_lane).min(lanes) as u32,
            ..part.group_table()[0]
        };
        let cycles = part.cycles();
        // The kernel addresses a whole group's state, of which these lanes are a part.
        let mut own_states = Vec::new();
        let states = self.states.unwrap_or_else(|| {
            own_states.extend_from_slice(part.states());
            own_states.resize(LANES * batch.state_words(), 0);
            written(&mut own_states)
        });
        let Some(shown) = self.shown else {
            // A buffer is never empty.
            let mut no_trace = vec![0_u32; batch.record_words()];
            let trace = self.trace.unwrap_or_else(|| written(&mut no_trace));
            return self.simulate(call, active, cycles, states, trace, part.trace_records());
        };
        let every = part.trace_every();
        let slot = part.groups().start * LANES as u32 + first_lane as u32;
        let width = batch.record_words();
        let piece = SHOWN.saturating_mul(every);
        let mut lines = vec![0; LANES * SHOWN as usize * width];
        for begin in cycles.clone().step_by(piece as usize) {
            let end = begin.saturating_add(piece).min(cycles.end);
            self.simulate(call, active, begin..end, states, written(&mut lines), SHOWN)?;
            let count = (end - begin).div_ceil(every) as usize * width;
            for (lane, slot) in (0..active.rollouts).zip(slot..) {
                let own = &mut lines[(first_lane + lane as usize) * SHOWN as usize * width..][..count];
                (shown.observer)(shown.rollouts[slot as usize] as usize, batch.written(slot, own));
                if batch.may_end_early(slot) {
                    own.fill(0);
                }
            }
        }
        Ok(())
    }

    /// Simulates some cycles of one call's lanes. The trace has room for so many records of each slot.
    fn simulate(
        &self,
        call: usize,
        active: Group,
        cycles: Range<u32>,
        states: Words,
        trace: Words,
        records: u32,
    ) -> Result<(), Error> {
        let part = self.part;
        let batch = part.batch();
        let first_lane = call * self.code.lanes() as usize;
        for begin in cycles.clone().step_by(self.chunk as usize) {
            if self.control.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let end = begin.saturating_add(self.chunk).min(cycles.end);
            let mut dispatch = Dispatch {
                step_begin: begin,
                step_end: end,
                trace_every: part.trace_every(),
                trace_records: records,
                trace_begin: cycles.start,
                first_input: part.first_input(),
                state_words: batch.state_words() as u32,
                record_words: batch.record_words() as u32,
            };
            let buffers = [
                written(std::slice::from_mut(&mut dispatch)),
                read(part.worlds()),
                read(part.shapes()),
                read(part.tables()),
                read(part.group_table()),
                read(part.inputs()),
                states,
                self.fitness,
                trace,
            ];
            let turns = u64::from(part.begin_loops()) + u64::from(part.loops()) * u64::from(end - begin);
            let turns = turns.saturating_mul(MARGIN);
            // SAFETY: the buffers are those of the kernel's bindings, in order (a test compares their names), none is
            // empty, and the words of these lanes belong to this call alone.
            unsafe { self.code.run(&buffers, 0, first_lane as u32, turns) }?;
            if let Some(control) = self.steps {
                control.add_steps(part.steps_of(&[active], &(begin..end)));
            }
        }
        Ok(())
    }
}

/// A buffer that kernels only read.
fn read<T: bytemuck::Pod>(items: &[T]) -> Words {
    let words: &[u32] = bytemuck::cast_slice(items);
    Words {
        start: words.as_ptr().cast_mut(),
        len: words.len(),
    }
}

/// A buffer that kernels may write.
fn written<T: bytemuck::Pod>(items: &mut [T]) -> Words {
    let words: &mut [u32] = bytemuck::cast_slice_mut(items);
    Words {
        start: words.as_mut_ptr(),
        len: words.len(),
    }
}

/// Floating-point mode of a thread.
mod float_mode {
    /// Returns whether this thread rounds to nearest and keeps subnormals, which is every thread's default.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn is_default() -> bool {
        const FLUSH_TO_ZERO: u32 = 1 << 15;
        const ROUNDING: u32 = 3 << 13;
        const DENORMALS_ARE_ZERO: u32 = 1 << 6;
        let mut mode = 0_u32;
        // SAFETY: stores the control register at the given address, and does nothing else.
        unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut mode, options(nostack, preserves_flags)) };
        mode & (FLUSH_TO_ZERO | ROUNDING | DENORMALS_ARE_ZERO) == 0
    }

    /// Returns whether this thread rounds to nearest and keeps subnormals, which is every thread's default.
    #[cfg(target_arch = "aarch64")]
    pub(super) fn is_default() -> bool {
        const FLUSH_TO_ZERO: u64 = 1 << 24;
        const ROUNDING: u64 = 3 << 22;
        const FLUSH_INPUTS: u64 = 1;
        let mode: u64;
        // SAFETY: reads the control register, and does nothing else.
        unsafe { std::arch::asm!("mrs {}, fpcr", out(reg) mode, options(nomem, nostack, preserves_flags)) };
        mode & (FLUSH_TO_ZERO | ROUNDING | FLUSH_INPUTS) == 0
    }

    /// Returns whether this thread rounds to nearest and keeps subnormals, found by trial because no register tells.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub(super) fn is_default() -> bool {
        use std::hint::black_box;
        let above = black_box(1.0_f32) + black_box(f32::EPSILON / 4.0);
        let below = black_box(-1.0_f32) - black_box(f32::EPSILON / 4.0);
        let small = black_box(f32::MIN_POSITIVE) * black_box(0.5);
        above == 1.0 && below == -1.0 && small.to_bits() == 0x0040_0000
    }
}

#[cfg(test)]
mod tests {
    use oneiro_shaders::kernel::Turns;
    use oneiro_shaders::{WordOf, episode};

    use super::*;
    use crate::batch::{Buffers, Rollout, WorldKind};
    use crate::parameter::Invalid;
    use crate::random::Key;
    use crate::world::{World, WorldSpec};

    /// Of 65 episodes in one world, one is left over from a group: it does not pay for a wide call.
    #[test]
    fn a_group_with_few_rollouts_takes_narrower_code() {
        let world = World::new(WorldSpec::miglino1995()).unwrap();
        let genes = vec![0.5; world.genes()];
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(1, 0, 0, 0),
        };
        let batch = Batch::new(&[world], &[rollout; LANES + 1], None).unwrap();
        let parts = [batch.part(0..1), batch.part(1..2)];
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let code = cpu.choose(batch.kernel(), &parts).unwrap();
        let [full, few] = &cpu.for_few(&code, &parts)[..] else {
            panic!("a code for each group")
        };
        assert!(full.is_none());
        assert!(few.as_ref().is_some_and(|few| few.lanes() < code.lanes()));
        cpu = cpu.with_variant(Cpu::variants()[0]).unwrap();
        assert!(cpu.for_few(&code, &parts).is_empty(), "a requested code is kept");
    }

    #[test]
    fn buffers_are_in_the_order_of_the_bindings() {
        const NAMES: [&str; 9] = [
            "dispatch", "worlds", "shapes", "tables", "groups", "inputs", "state", "fitness", "trace",
        ];
        for kernel in oneiro_shaders::KERNELS
            .iter()
            .filter(|kernel| !kernel.name.starts_with("probe"))
        {
            let names: Vec<&str> = kernel.bindings.iter().map(|binding| binding.name).collect();
            assert_eq!(names, NAMES, "{}", kernel.name);
            assert_eq!(kernel.workgroup_size as usize, LANES, "{}", kernel.name);
        }
    }

    /// A world whose kernel is said to loop less than it does.
    struct Understated(World, &'static Kernel);

    impl WorldKind for Understated {
        fn check(&self) -> Result<(), Invalid> {
            Ok(())
        }

        fn kernel(&self) -> &'static Kernel {
            self.1
        }

        fn genes(&self) -> usize {
            self.0.genes()
        }

        fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World {
            self.0.pack(variant, buffers)
        }
    }

    /// Loops that turn more often than a kernel's text allows end with an error, wherever code isn't compiled with the program.
    #[test]
    fn loops_beyond_their_bounds_end() {
        let world = World::new(WorldSpec {
            cycles: 40,
            ..WorldSpec::miglino1995()
        })
        .unwrap();
        let genes = vec![0.5; world.genes()];
        let batch = |turns: fn(u64) -> u64| {
            let shipped = world.kernel();
            let turns = Turns(Box::leak(Box::new(move |word: &WordOf<'_>| {
                turns((shipped.turns.0)(word))
            })));
            let kernel = Box::leak(Box::new(Kernel { turns, ..*shipped }));
            let rollout = Rollout {
                world: 0,
                genes: &genes,
                key: Key::rollout(1, 0, 0, 0),
            };
            Batch::new(&[Understated(world.clone(), kernel)], &[rollout], None).unwrap()
        };
        let compiled = LaneCode::all(world.kernel()).map(|(name, _)| name);
        let names: Vec<_> = compiled
            .filter(|name| name.starts_with("native"))
            .chain(interpreter())
            .collect();
        for name in names {
            let mut cpu = Cpu::new(Some(1)).unwrap().with_variant(name).unwrap();
            let mut evaluate = |turns| cpu.evaluate(&batch(turns), &Control::new());
            let whole = evaluate(|turns| turns).unwrap().fitness;
            assert!(whole[0].is_finite(), "{name}");
            let error = evaluate(|_| 0).unwrap_err();
            assert!(matches!(error, Error::Unbounded { .. }), "{name}: {error}");
            let text = error.to_string();
            assert!(text.starts_with("the kernel life_perceptron looped "), "{text}");
        }
    }

    /// A changed mode is detected.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn a_changed_float_mode_is_noticed() {
        assert!(float_mode::is_default());
        for changed in [0x9f80_u32, 0x1fc0, 0x3f80, 0x5f80] {
            let mode = thread::spawn(move || {
                // SAFETY: loads the control register with masked exceptions; the thread computes nothing.
                unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const changed, options(nostack)) };
                float_mode::is_default()
            });
            assert!(!mode.join().unwrap(), "{changed:#x}");
        }
    }
}
