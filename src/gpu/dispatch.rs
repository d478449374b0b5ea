//! A part of a batch on a device: cut to what fits, each cut run in chunks of cycles, its state kept there.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::time::Instant;

use bytemuck::Zeroable;
use oneiro_shaders::Kernel;
use oneiro_shaders::life::{Dispatch, Group, Record};

use super::buffers::{Bench, Scene};
use super::device::{Device, Fault, Pipeline};
use super::pace::Pace;
use crate::batch::{LANES, Part};
use crate::evaluator::{Control, PartResult};

/// Bytes that a cut's own buffers should take together: enough rollouts to fill any device, few enough for
/// a small one. Two cuts are on the device at a time.
const CUT_BYTES: u64 = 64 << 20;

/// Iterations of all loops together that an invocation makes in a dispatch. Mesa's software driver leaves every loop
/// of an invocation after 65,535 in all and tells nobody, so that results would be wrong.
const GREATEST_LOOPS: u32 = 60_000;

/// The greatest dispatch, besides what time and memory allow. No result depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Groups in a cut, at least 1.
    pub groups: u32,
    /// Cycles in a chunk, at least 1.
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

/// Runs lives on one device, and keeps what the next batch can use: buffers and speeds.
#[derive(Debug, Default)]
pub(super) struct Lives {
    scene: Scene,
    benches: [Bench; 2],
    paces: BTreeMap<&'static str, Pace>,
    pub(super) bounds: Bounds,
}

impl Lives {
    /// Runs a part, in smaller cuts if the device's memory doesn't hold them.
    ///
    /// # Errors
    /// See [`Fault`]; progress told to `control` is then taken back.
    pub(super) fn run(&mut self, device: &mut Device, part: &Part<'_>, control: &Control) -> Result<PartResult, Fault> {
        let mut groups = self.bounds.groups.min(part.group_table().len() as u32);
        loop {
            match self.run_cut(device, part, control, groups) {
                Err(Fault::OutOfMemory) if groups > 1 => groups = groups.div_ceil(2),
                done => return done,
            }
        }
    }

    /// Runs a part in cuts of so many groups at most.
    fn run_cut(
        &mut self,
        device: &mut Device,
        part: &Part<'_>,
        control: &Control,
        groups: u32,
    ) -> Result<PartResult, Fault> {
        let pipeline = device.pipeline(part.kernel())?;
        let cuts = cuts(part, Bytes::of(device, groups))?;
        self.scene.worlds.keep(device, bytemuck::cast_slice(part.worlds()));
        self.scene.shapes.keep(device, bytemuck::cast_slice(part.shapes()));
        self.scene.tables.keep(device, bytemuck::cast_slice(part.tables()));

        let records = part.trace_records() as usize;
        let mut run = Run {
            device,
            kernel: part.kernel(),
            pipeline: &pipeline,
            part,
            control,
            scene: &self.scene,
            benches: &mut self.benches,
            pace: self.paces.entry(pipeline.kernel).or_default(),
            most_cycles: self.bounds.cycles.min(GREATEST_LOOPS / part.loops()).max(1),
            flights: VecDeque::new(),
            told_steps: 0,
            landed: Instant::now(),
            result: PartResult {
                fitness: room(part.slots(), 0.0)?,
                trace: room(part.slots() * records, Record::zeroed())?,
            },
        };
        match run.all(&cuts) {
            Ok(()) => Ok(run.result),
            Err(fault) => {
                control.take_back_steps(run.told_steps);
                // Their buffers may still be in use, on their way to being mapped, or never have come to be.
                self.benches = Default::default();
                self.scene = Scene::default();
                Err(fault)
            }
        }
    }
}

/// A vector of so many values, or an error if the host hasn't the memory.
fn room<T: Clone>(len: usize, value: T) -> Result<Vec<T>, Fault> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| {
        Fault::TooLarge(format!(
            "the results take {} MB, which there is no memory for; trace fewer rollouts or fewer of their cycles",
            (len * size_of::<T>()) >> 20
        ))
    })?;
    values.resize(len, value);
    Ok(values)
}

/// What bounds a cut.
#[derive(Clone, Copy, Debug)]
struct Bytes {
    groups: usize,
    binding: u64,
    cut: u64,
}

impl Bytes {
    fn of(device: &Device, groups: u32) -> Self {
        let limits = device.adapter().limits();
        Self {
            groups: limits.workgroups.min(groups).max(1) as usize,
            binding: limits.binding_bytes.min(limits.buffer_bytes),
            cut: CUT_BYTES,
        }
    }
}

/// Groups that are on the device together.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Cut {
    /// Of the part's groups.
    groups: Range<usize>,
    /// Words of the part's inputs.
    inputs: Range<usize>,
    /// The longest life.
    cycles: u32,
}

impl Cut {
    fn slots(&self) -> u64 {
        (self.groups.len() * LANES) as u64
    }
}

/// Cuts a part to what fits, in order.
fn cuts(part: &Part<'_>, bounds: Bytes) -> Result<Vec<Cut>, Fault> {
    let groups = part.group_table();
    let first_input = part.first_input() as usize;
    let inputs_end = |group: usize| {
        groups
            .get(group)
            .map_or(part.inputs().len(), |g| g.inputs as usize - first_input)
    };
    let fixed = (LANES * (part.kernel().stride("state") + size_of::<f32>())) as u64;
    let traced = (LANES * size_of::<Record>()) as u64 * u64::from(part.trace_records());
    if traced > bounds.binding {
        return Err(Fault::TooLarge(format!(
            "the trace of {LANES} rollouts takes {} MB, and the device binds {} MB at once; trace fewer cycles",
            traced >> 20,
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
            end - start <= bounds.groups && largest <= bounds.binding && input + (fixed + traced) * count <= bounds.cut
        };
        // One group always goes, whatever the aim says; the bindings hold it (32 hidden units are 90 kB).
        let mut end = start + 1;
        while end < groups.len() && fits(end + 1) {
            end += 1;
        }
        let cycles = groups[start..end]
            .iter()
            .map(|g| part.worlds()[g.world as usize].steps)
            .max()
            .unwrap_or(0);
        cuts.push(Cut {
            groups: start..end,
            inputs: first_word..inputs_end(end),
            cycles,
        });
        start = end;
    }
    Ok(cuts)
}

/// A dispatch that was submitted.
struct Flight {
    submission: wgpu::SubmissionIndex,
    submitted: Instant,
    bench: usize,
    slots: u64,
    cycles: u32,
    steps: u64,
    /// The slots whose results it brings: those of its cut, if it is the cut's last.
    brings: Option<Range<usize>>,
}

/// One part under way.
struct Run<'a> {
    device: &'a mut Device,
    kernel: &'static Kernel,
    pipeline: &'a Pipeline,
    part: &'a Part<'a>,
    control: &'a Control,
    scene: &'a Scene,
    benches: &'a mut [Bench; 2],
    pace: &'a mut Pace,
    most_cycles: u32,
    flights: VecDeque<Flight>,
    told_steps: u64,
    landed: Instant,
    result: PartResult,
}

impl Run<'_> {
    /// One cut after the other, chunk by chunk, each submitted while the one before is worked on.
    fn all(&mut self, cuts: &[Cut]) -> Result<(), Fault> {
        for (index, cut) in cuts.iter().enumerate() {
            let bench = index % self.benches.len();
            let mut begin = 0;
            while begin < cut.cycles {
                // Until the speed is known there is nothing to plan the next chunk with.
                self.land_until(usize::from(self.pace.is_known()))?;
                let cycles = self
                    .pace
                    .cycles(cut.slots())
                    .min(self.most_cycles)
                    .min(cut.cycles - begin);
                self.launch(cut, bench, begin..begin + cycles)?;
                begin += cycles;
            }
        }
        self.land_until(0)
    }

    /// Makes room for a cut.
    fn make_room(&mut self, cut: &Cut, bench: usize) {
        let device = &*self.device;
        let bench = &mut self.benches[bench];
        bench.dispatch.reserve(device, size_of::<Dispatch>() as u64);
        bench
            .state
            .reserve(device, cut.slots() * self.kernel.stride("state") as u64);
        let fitness = cut.slots() * size_of::<f32>() as u64;
        bench.fitness.reserve(device, fitness);
        bench.fitness_out.reserve(device, fitness);
        // A binding can't be empty: without a trace it is one record that nobody writes.
        let records = cut.slots() * u64::from(self.part.trace_records());
        let trace = records.max(1) * size_of::<Record>() as u64;
        bench.trace.reserve(device, trace);
        if records > 0 {
            bench.trace_out.reserve(device, trace);
        }
    }

    /// Submits a chunk of a cut.
    fn launch(&mut self, cut: &Cut, bench_index: usize, cycles: Range<u32>) -> Result<(), Fault> {
        let part = self.part;
        let group_table = &part.group_table()[cut.groups.clone()];
        let is_first = cycles.start == 0;
        let is_last = cycles.end == cut.cycles;
        let traced = part.trace_records() > 0;
        let label = Some(self.pipeline.kernel);
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
            if traced {
                // A life that ends before the batch's longest leaves the rest of its records as they were.
                encoder.clear_buffer(bench.trace.buffer(), 0, Some(bench.trace.used()));
            }
        }
        let dispatch = Dispatch {
            step_begin: cycles.start,
            step_end: cycles.end,
            trace_every: part.trace_every(),
            trace_records: part.trace_records(),
            first_input: group_table[0].inputs,
            ..Dispatch::zeroed()
        };
        bench.dispatch.write(self.device, bytemuck::bytes_of(&dispatch));
        let bind_group = bind(self.device, self.pipeline, self.kernel, self.scene, bench)?;
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label,
                timestamp_writes: None,
            });
            pass.set_pipeline(&self.pipeline.compute);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(group_table.len() as u32, 1, 1);
        }
        if is_last {
            bench.fitness.bring(&mut encoder, &bench.fitness_out);
            if traced {
                bench.trace.bring(&mut encoder, &bench.trace_out);
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
            steps: steps(part, group_table, &cycles),
            brings: is_last.then(|| cut.groups.start * LANES..cut.groups.end * LANES),
        });
        Ok(())
    }

    /// Waits until no more than so many dispatches are under way.
    fn land_until(&mut self, under_way: usize) -> Result<(), Fault> {
        if self.control.is_cancelled() {
            return Err(Fault::Cancelled);
        }
        while self.flights.len() > under_way {
            let Some(flight) = self.flights.pop_front() else { break };
            self.device.wait(&flight.submission, self.control)?;
            // It began when it was submitted, or when the one before was done.
            let now = Instant::now();
            self.pace
                .observe(flight.slots, flight.cycles, now - flight.submitted.max(self.landed));
            self.landed = now;
            self.control.add_steps(flight.steps);
            self.told_steps += flight.steps;
            if let Some(slots) = flight.brings {
                let bench = &self.benches[flight.bench];
                bench.fitness_out.read(&mut self.result.fitness[slots.clone()])?;
                let records = self.part.trace_records() as usize;
                if records > 0 {
                    bench
                        .trace_out
                        .read(&mut self.result.trace[slots.start * records..slots.end * records])?;
                }
            }
        }
        Ok(())
    }
}

/// Robot-steps that a chunk makes.
fn steps(part: &Part<'_>, groups: &[Group], cycles: &Range<u32>) -> u64 {
    groups
        .iter()
        .map(|group| {
            let end = part.worlds()[group.world as usize].steps.min(cycles.end);
            u64::from(group.rollouts) * u64::from(end.saturating_sub(cycles.start))
        })
        .sum()
}

/// Binds each buffer of a life by its name in the kernel.
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
                    "`{}` binds `{other}`, which no life has",
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

    /// Rollouts in worlds of other sizes: 200 of 13 genes over 30 cycles, 100 of 24 over 80.
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
    };

    #[test]
    fn a_batch_that_fits_is_one_cut() {
        let batch = batch(None);
        let all = cuts(&batch.all(), ANY).expect("it fits");
        assert_eq!(
            all,
            [Cut {
                groups: 0..6,
                inputs: 0..64 * (4 * 15 + 2 * 26),
                cycles: 80
            }]
        );
        let part = cuts(&batch.part(1..5), ANY).expect("it fits");
        assert_eq!(
            part,
            [Cut {
                groups: 0..4,
                inputs: 0..64 * (3 * 15 + 26),
                cycles: 80
            }]
        );
        assert_eq!(cuts(&batch.part(2..2), ANY).expect("it fits"), []);
    }

    #[test]
    fn cuts_keep_to_every_bound_and_leave_nothing_out() {
        let plain = batch(None);
        let traced = batch(Some(TraceRequest { every: 10 }));
        // The inputs of a group of 13 genes take 3,840 bytes, of 24 genes 6,656.
        let kept = LANES as u64 * (plain.kernel().stride("state") + size_of::<f32>()) as u64;
        let eight_records = LANES as u64 * 8 * size_of::<Record>() as u64;
        for (batch, bounds, expected) in [
            (&plain, Bytes { groups: 4, ..ANY }, vec![0..4, 4..6]),
            (
                &plain,
                Bytes {
                    binding: 3 * 3_840,
                    ..ANY
                },
                vec![0..3, 3..5, 5..6],
            ),
            (
                &plain,
                Bytes {
                    cut: 2 * (6_656 + kept),
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
                assert_eq!(cut.cycles, if cut.groups.end > 4 { 80 } else { 30 });
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
