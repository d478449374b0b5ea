//! Runs a part of a batch on a device: cut into pieces that fit, each run in chunks of cycles, with its state kept
//! there.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use oneiro_shaders::Kernel;
use oneiro_shaders::episode::Dispatch;

use super::buffers::{Bench, Scene};
use super::device::{Device, Fault, Pipeline};
use super::pace::Pace;
use super::specialised::{self, Variants};
use crate::batch::{LANES, Part, PartResult};
use crate::evaluator::Control;

/// Target size of a cut's own buffers, in bytes: enough episodes to fill any device, few enough for a small one. Two
/// cuts are on the device at a time.
const CUT_BYTES: u64 = 64 << 20;

/// Most iterations of all loops of an invocation in a dispatch. Mesa's software driver leaves every loop of an
/// invocation after 65,535 in total, silently, corrupting results. Where a cycle takes more, loops are unrolled.
const GREATEST_LOOPS: u32 = 60_000;

/// Limits on a dispatch, besides those of time and memory. Results don't depend on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Most groups in a cut, at least 1.
    pub groups: u32,
    /// Most cycles in a chunk, at least 1.
    pub cycles: u32,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            groups: u32::MAX,
            cycles: u32::MAX,
        }
    }
}

/// Runs episodes on one device, and keeps buffers and measured speeds for the next batch.
#[derive(Debug, Default)]
pub(super) struct Dispatcher {
    scene: Scene,
    benches: [Bench; 2],
    /// By kernel, of the generic one and of its variants.
    paces: BTreeMap<&'static str, [Pace; 2]>,
    pub(super) variants: Variants,
    pub(super) bounds: Bounds,
}

impl Dispatcher {
    /// Runs a part, in smaller cuts if the device's memory is too small for them.
    ///
    /// # Errors
    /// See [`Fault`]; progress reported to `control` is then taken back.
    pub(super) fn run(&mut self, device: &mut Device, part: &Part<'_>, control: &Control) -> Result<PartResult, Fault> {
        let mut groups = self.bounds.groups.min(part.group_table().len() as u32);
        loop {
            match self.run_cut(device, part, control, groups) {
                Err(Fault::OutOfMemory) if groups > 1 => groups = groups.div_ceil(2),
                done => return done,
            }
        }
    }

    /// Runs a part in cuts of at most `groups` groups.
    fn run_cut(
        &mut self,
        device: &mut Device,
        part: &Part<'_>,
        control: &Control,
        groups: u32,
    ) -> Result<PartResult, Fault> {
        let turns = Turns {
            begin: part.begin_loops(),
            cycle: part.loops(),
        };
        let unrolls = device.adapter().is_software() && turns.of_first(part) > GREATEST_LOOPS;
        let bytes = Bytes {
            one_world: unrolls || super::divides(self.variants.when, part.group_table()),
            ..Bytes::of(device, groups)
        };
        let cuts = cuts(part, bytes)?;
        self.scene.worlds.keep(device, bytemuck::cast_slice(part.worlds()));
        self.scene.shapes.keep(device, bytemuck::cast_slice(part.shapes()));
        self.scene.tables.keep(device, bytemuck::cast_slice(part.tables()));

        let mut run = Run {
            device,
            part,
            control,
            scene: &self.scene,
            benches: &mut self.benches,
            paces: self.paces.entry(part.kernel().name).or_default(),
            variants: &mut self.variants,
            bounds: self.bounds,
            turns,
            unrolls,
            flights: VecDeque::new(),
            told_steps: 0,
            landed: Instant::now(),
            result: PartResult::blank(part.batch(), part.slots())
                .map_err(|error| Fault::TooLarge(error.to_string()))?,
        };
        match run.all(&cuts) {
            Ok(()) => Ok(run.result),
            Err(fault) => {
                control.take_back_steps(run.told_steps);
                // The buffers may still be in use, waiting to be mapped, or incomplete.
                self.benches = Default::default();
                self.scene = Scene::default();
                Err(fault)
            }
        }
    }
}

/// Limits on a cut.
#[derive(Clone, Copy, Debug)]
struct Bytes {
    groups: usize,
    binding: u64,
    cut: u64,
    /// Whether all groups of a cut have the same world.
    one_world: bool,
}

impl Bytes {
    fn of(device: &Device, groups: u32) -> Self {
        let limits = device.adapter().limits();
        Self {
            groups: limits.workgroups.min(groups).max(1) as usize,
            binding: limits.binding_bytes.min(limits.buffer_bytes),
            cut: CUT_BYTES,
            one_world: false,
        }
    }
}

/// Groups that are on the device at the same time.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Cut {
    /// Range of the part's groups.
    groups: Range<usize>,
    /// Range of words of the part's inputs.
    inputs: Range<usize>,
    /// Cycles up to the end of the longest episode.
    cycles: Range<u32>,
    /// The world of all of its episodes, if they have the same.
    world: Option<u32>,
}

impl Cut {
    fn slots(&self) -> u64 {
        (self.groups.len() * LANES) as u64
    }
}

/// Cuts a part into pieces that fit, in order.
fn cuts(part: &Part<'_>, bounds: Bytes) -> Result<Vec<Cut>, Fault> {
    let groups = part.group_table();
    let first_input = part.first_input() as usize;
    let inputs_end = |group: usize| {
        groups
            .get(group)
            .map_or(part.inputs().len(), |g| g.inputs as usize - first_input)
    };
    let batch = part.batch();
    let kept = (4 * LANES * batch.state_words()) as u64;
    let traced = (4 * LANES * batch.trace_words()) as u64;
    let fixed = kept + (LANES * size_of::<f32>()) as u64;
    if traced.max(kept) > bounds.binding {
        return Err(Fault::TooLarge(format!(
            "the trace of {LANES} episodes needs {} MB and their state {} MB; the device binds at most {} MB. Trace \
             fewer cycles or simulate fewer robots",
            traced >> 20,
            kept >> 20,
            bounds.binding >> 20
        )));
    }

    let mut cuts = Vec::new();
    let mut start = 0;
    while start < groups.len() {
        let first_word = inputs_end(start);
        let fits = |end: usize| {
            let count = (end - start) as u64;
            let input = 4 * (inputs_end(end) - first_word) as u64;
            let largest = input.max(traced * count).max(fixed * count);
            let is_of_world = !bounds.one_world || groups[end - 1].world == groups[start].world;
            is_of_world
                && end - start <= bounds.groups
                && largest <= bounds.binding
                && input + (fixed + traced) * count <= bounds.cut
        };
        // A cut has at least one group, whatever the target; the bindings hold it (32 hidden units are 90 kB).
        let mut end = start + 1;
        while end < groups.len() && fits(end + 1) {
            end += 1;
        }
        let cycles = groups[start..end]
            .iter()
            .map(|g| part.worlds()[g.world as usize].steps)
            .max()
            .unwrap_or(0);
        let world = groups[start].world;
        cuts.push(Cut {
            world: groups[start..end]
                .iter()
                .all(|group| group.world == world)
                .then_some(world),
            groups: start..end,
            inputs: first_word..inputs_end(end),
            cycles: batch.cycles().start..batch.cycles().end.min(cycles),
        });
        start = end;
    }
    Ok(cuts)
}

/// Most turns of all loops of an invocation.
#[derive(Clone, Copy, Debug)]
struct Turns {
    /// In the beginning of an episode.
    begin: u32,
    /// In a cycle.
    cycle: u32,
}

impl Turns {
    /// In the first cycle of a part.
    fn of_first(self, part: &Part<'_>) -> u32 {
        let begin = if part.batch().cycles().start == 0 {
            self.begin
        } else {
            0
        };
        begin.saturating_add(self.cycle)
    }

    /// Most cycles of a dispatch, at least 1. `begins` is whether it begins episodes.
    fn most_cycles(self, begins: bool) -> u32 {
        let begin = if begins { self.begin } else { 0 };
        (GREATEST_LOOPS.saturating_sub(begin) / self.cycle).max(1)
    }
}

/// A submitted dispatch.
struct Flight {
    submission: wgpu::SubmissionIndex,
    submitted: Instant,
    bench: usize,
    slots: u64,
    cycles: u32,
    steps: u64,
    world: Option<u32>,
    is_specialised: bool,
    /// Slots whose results it returns: those of its cut, if it is the cut's last dispatch.
    brings: Option<Range<usize>>,
}

/// A part in progress.
struct Run<'a> {
    device: &'a mut Device,
    part: &'a Part<'a>,
    control: &'a Control,
    scene: &'a Scene,
    benches: &'a mut [Bench; 2],
    paces: &'a mut [Pace; 2],
    variants: &'a mut Variants,
    bounds: Bounds,
    /// Most turns of the kernel's loops, unless they are unrolled.
    turns: Turns,
    /// Whether the device leaves them before a cycle is over, so that they must be.
    unrolls: bool,
    flights: VecDeque<Flight>,
    told_steps: u64,
    landed: Instant,
    result: PartResult,
}

impl Run<'_> {
    /// Runs one cut after another, chunk by chunk, each submitted while the device works on the one before.
    fn all(&mut self, cuts: &[Cut]) -> Result<(), Fault> {
        for (index, cut) in cuts.iter().enumerate() {
            let bench = index % self.benches.len();
            let mut begin = cut.cycles.start;
            while begin < cut.cycles.end {
                let (variant, turns) = self.variant(cut)?;
                // The next chunk can't be planned until the speed is known.
                let pace = self.paces[usize::from(variant.is_some())];
                self.land_until(usize::from(pace.is_known()))?;
                let pace = self.paces[usize::from(variant.is_some())];
                let cycles = pace
                    .cycles(cut.slots())
                    .min(turns.most_cycles(begin == 0))
                    .min(self.bounds.cycles)
                    .min(cut.cycles.end - begin);
                self.launch(cut, bench, begin..begin + cycles, variant.as_deref())?;
                begin += cycles;
            }
        }
        self.land_until(0)
    }

    /// The variant that simulates a cut, if it isn't the kernel itself, and the turns of its loops.
    fn variant(&mut self, cut: &Cut) -> Result<(Option<Arc<Pipeline>>, Turns), Fault> {
        let Some(world) = cut.world else {
            return Ok((None, self.turns));
        };
        if !self.unrolls {
            let ready = specialised::ready(self.variants, self.device, self.part, world, self.control);
            return Ok((ready, self.turns));
        }
        let unrolled = specialised::unrolled(
            self.variants,
            self.device,
            self.part,
            world,
            GREATEST_LOOPS,
            self.control,
        );
        if self.control.is_cancelled() {
            return Err(Fault::Cancelled);
        }
        let Some(unrolled) = unrolled.map_err(Fault::Refused)? else {
            let Turns { begin, cycle } = self.turns;
            return Err(Fault::TooLarge(format!(
                "loops turn {cycle} times a cycle, and {begin} more times in the first. A software driver stops them \
                 after {GREATEST_LOOPS} turns, and unrolled they make the kernel too long; allowed there: shorter \
                 loops, fewer robots or another backend"
            )));
        };
        let turns = Turns {
            begin: unrolled.begin_turns,
            cycle: unrolled.turns,
        };
        Ok((Some(unrolled.made), turns))
    }

    /// Makes room for a cut.
    fn make_room(&mut self, cut: &Cut, bench: usize) {
        let device = &*self.device;
        let bench = &mut self.benches[bench];
        bench.dispatch.reserve(device, size_of::<Dispatch>() as u64);
        let batch = self.part.batch();
        let kept = 4 * cut.slots() * batch.state_words() as u64;
        bench.state.reserve(device, kept);
        if batch.keeps_states() {
            bench.state_out.reserve(device, kept);
        }
        let fitness = cut.slots() * size_of::<f32>() as u64;
        bench.fitness.reserve(device, fitness);
        bench.fitness_out.reserve(device, fitness);
        // A binding can't be empty: without a trace it is one record that isn't written.
        let words = (cut.slots() as usize * batch.trace_words()).max(batch.record_words());
        let trace = 4 * words as u64;
        bench.trace.reserve(device, trace);
        if batch.trace_records() > 0 {
            bench.trace_out.reserve(device, trace);
        }
    }

    /// Submits a chunk of a cut.
    fn launch(
        &mut self,
        cut: &Cut,
        bench_index: usize,
        cycles: Range<u32>,
        variant: Option<&Pipeline>,
    ) -> Result<(), Fault> {
        let generic;
        let pipeline = if let Some(variant) = variant {
            variant
        } else {
            generic = self.device.pipeline(self.part.kernel(), self.control)?;
            &generic
        };
        let part = self.part;
        let group_table = &part.group_table()[cut.groups.clone()];
        let batch = part.batch();
        let is_first = cycles.start == cut.cycles.start;
        let is_last = cycles.end == cut.cycles.end;
        let traced = part.trace_records() > 0;
        let label = Some(pipeline.kernel);
        if is_first {
            self.make_room(cut, bench_index);
        }
        let bench = &mut self.benches[bench_index];
        let mut encoder = self
            .device
            .raw
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        if is_first {
            bench.groups.keep(self.device, bytemuck::cast_slice(group_table));
            let inputs = bytemuck::cast_slice(&part.inputs()[cut.inputs.clone()]);
            bench
                .inputs_in
                .send(self.device, inputs, &mut encoder, &mut bench.inputs)?;
            // As on the CPU, words that no episode writes are 0: those of idle slots, after an early end, and beyond a small world's.
            bench.fitness.clear(&mut encoder);
            if traced {
                bench.trace.clear(&mut encoder);
            }
            if part.states().is_empty() {
                bench.state.clear(&mut encoder);
            } else {
                let words = LANES * batch.state_words();
                let states = &part.states()[cut.groups.start * words..cut.groups.end * words];
                bench.state.write(self.device, bytemuck::cast_slice(states));
            }
        }
        let dispatch = Dispatch {
            step_begin: cycles.start,
            step_end: cycles.end,
            trace_every: part.trace_every(),
            trace_records: part.trace_records(),
            trace_begin: batch.cycles().start,
            first_input: group_table[0].inputs,
            state_words: batch.state_words() as u32,
            record_words: batch.record_words() as u32,
        };
        bench.dispatch.write(self.device, bytemuck::bytes_of(&dispatch));
        let bind_group = bind(self.device, pipeline, part.kernel(), self.scene, bench)?;
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label,
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(group_table.len() as u32, 1, 1);
        }
        if is_last {
            bench.fitness.bring(&mut encoder, &bench.fitness_out);
            if traced {
                bench.trace.bring(&mut encoder, &bench.trace_out);
            }
            if batch.keeps_states() {
                bench.state.bring(&mut encoder, &bench.state_out);
            }
        }
        let submitted = Instant::now();
        let submission = self.device.submit(encoder);
        self.flights.push_back(Flight {
            submission,
            submitted,
            bench: bench_index,
            slots: cut.slots(),
            cycles: cycles.end - cycles.start,
            steps: part.steps_of(group_table, &cycles),
            world: cut.world,
            is_specialised: variant.is_some(),
            brings: is_last.then(|| cut.groups.start * LANES..cut.groups.end * LANES),
        });
        Ok(())
    }

    /// Waits until at most `under_way` dispatches are in progress.
    fn land_until(&mut self, under_way: usize) -> Result<(), Fault> {
        if self.control.is_cancelled() {
            return Err(Fault::Cancelled);
        }
        while self.flights.len() > under_way {
            let Some(flight) = self.flights.pop_front() else { break };
            self.device.wait(&flight.submission, self.control)?;
            // A dispatch begins when it is submitted, or when the one before is done.
            let now = Instant::now();
            let lasted = now - flight.submitted.max(self.landed);
            self.paces[usize::from(flight.is_specialised)].observe(flight.slots, flight.cycles, lasted);
            if flight.is_specialised {
                self.variants.steps += flight.steps;
            } else if let Some(world) = flight.world {
                specialised::spend(self.variants, self.device, self.part, world, lasted);
            }
            self.landed = now;
            self.control.add_steps(flight.steps);
            self.told_steps += flight.steps;
            if let Some(slots) = flight.brings {
                let bench = &self.benches[flight.bench];
                bench.fitness_out.read(&mut self.result.fitness[slots.clone()])?;
                let batch = self.part.batch();
                let words_of = |words: usize| slots.start * words..slots.end * words;
                if batch.trace_records() > 0 {
                    bench
                        .trace_out
                        .read(&mut self.result.trace[words_of(batch.trace_words())])?;
                }
                if batch.keeps_states() {
                    bench
                        .state_out
                        .read(&mut self.result.states[words_of(batch.state_words())])?;
                }
            }
        }
        Ok(())
    }
}

/// Binds each buffer of an episode by its name in the kernel.
fn bind(
    device: &Device,
    pipeline: &Pipeline,
    kernel: &Kernel,
    scene: &Scene,
    bench: &Bench,
) -> Result<wgpu::BindGroup, Fault> {
    let mut entries = Vec::with_capacity(kernel.bindings.len());
    for binding in kernel.bindings {
        let buffer = match binding.name {
            "dispatch" => &bench.dispatch,
            "worlds" => &scene.worlds,
            "shapes" => &scene.shapes,
            "tables" => &scene.tables,
            "groups" => &bench.groups,
            "inputs" => &bench.inputs,
            "state" => &bench.state,
            "fitness" => &bench.fitness,
            "trace" => &bench.trace,
            other => {
                return Err(Fault::Refused(format!(
                    "`{}` binds `{other}`, which no episode has",
                    kernel.name
                )));
            }
        };
        entries.push(wgpu::BindGroupEntry {
            binding: binding.binding,
            resource: buffer.binding(),
        });
    }
    Ok(device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(kernel.name),
        layout: &pipeline.bindings,
        entries: &entries,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{Batch, Rollout, TraceRequest};
    use crate::random::Key;
    use crate::world::{Controller, World, WorldSpec};

    /// Episodes in worlds of different sizes: 200 of 13 genes over 30 cycles, 100 of 24 over 80.
    fn batch(trace: Option<TraceRequest>) -> Batch {
        let world = |units, cycles| {
            World::new(WorldSpec {
                controller: Controller::Hidden { units },
                cycles,
                ..WorldSpec::miglino1995()
            })
            .expect("a good world")
        };
        let worlds = [world(1, 30), world(2, 80)];
        let genes = [0.5; 24];
        let rollout = |index: usize| {
            let world = usize::from(index % 3 == 2);
            Rollout {
                world,
                genes: &genes[..worlds[world].genes()],
                key: Key::rollout(0, 0, index as u64, 0),
            }
        };
        Batch::new(&worlds, &(0..300).map(rollout).collect::<Vec<_>>(), trace).expect("a good batch")
    }

    const ANY: Bytes = Bytes {
        groups: usize::MAX,
        binding: u64::MAX,
        cut: u64::MAX,
        one_world: false,
    };

    #[test]
    fn a_batch_that_fits_is_one_cut() {
        let batch = batch(None);
        let all = cuts(&batch.all(), ANY).expect("it fits");
        assert_eq!(
            all,
            [Cut {
                groups: 0..6,
                inputs: 0..64 * (4 * 16 + 2 * 27),
                cycles: 0..80,
                world: None
            }]
        );
        let part = cuts(&batch.part(1..5), ANY).expect("it fits");
        assert_eq!(
            part,
            [Cut {
                groups: 0..4,
                inputs: 0..64 * (3 * 16 + 27),
                cycles: 0..80,
                world: None
            }]
        );
        assert_eq!(cuts(&batch.part(2..2), ANY).expect("it fits"), []);
    }

    #[test]
    fn cuts_keep_to_every_bound_and_leave_nothing_out() {
        let plain = batch(None);
        let traced = batch(Some(TraceRequest { every: 10 }));
        // The inputs of a group take 4,096 bytes with 13 genes, and 6,912 with 24 genes. The kept buffers are larger than the former.
        let kept = (LANES * (4 * plain.state_words() + size_of::<f32>())) as u64;
        let eight_records = (4 * LANES * 8 * plain.record_words()) as u64;
        for (batch, bounds, expected) in [
            (&plain, Bytes { groups: 4, ..ANY }, vec![0..4, 4..6]),
            (&plain, Bytes { one_world: true, ..ANY }, vec![0..4, 4..6]),
            (
                &plain,
                Bytes {
                    binding: 3 * kept,
                    ..ANY
                },
                vec![0..3, 3..5, 5..6],
            ),
            (
                &plain,
                Bytes {
                    cut: 2 * (6_912 + kept),
                    ..ANY
                },
                vec![0..2, 2..4, 4..6],
            ),
            (
                &plain,
                Bytes { cut: 1, ..ANY },
                vec![0..1, 1..2, 2..3, 3..4, 4..5, 5..6],
            ),
            (
                &traced,
                Bytes {
                    binding: 2 * eight_records,
                    ..ANY
                },
                vec![0..2, 2..4, 4..6],
            ),
        ] {
            let part = batch.all();
            let cuts = cuts(&part, bounds).expect("each group fits");
            assert_eq!(
                cuts.iter().map(|cut| cut.groups.clone()).collect::<Vec<_>>(),
                expected,
                "{bounds:?}"
            );
            let mut word = 0;
            for cut in &cuts {
                assert_eq!(cut.inputs.start, word);
                assert_eq!(part.group_table()[cut.groups.start].inputs as usize, word);
                assert_eq!(cut.cycles, 0..if cut.groups.end > 4 { 80 } else { 30 });
                word = cut.inputs.end;
            }
            assert_eq!(word, part.inputs().len());
        }
    }

    #[test]
    fn a_trace_that_never_fits_says_so() {
        let batch = batch(Some(TraceRequest { every: 10 }));
        match cuts(&batch.all(), Bytes { binding: 36_863, ..ANY }) {
            Err(Fault::TooLarge(message)) => assert!(message.contains("trace"), "{message}"),
            other => panic!("{other:?}"),
        }
    }
}
