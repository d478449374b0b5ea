//! What is evaluated in one call: rollouts in any mix of worlds, checked and packed once.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

/// One line of a trace: the pose at the start of a cycle, what was perceived there, and what came of it.
pub use oneiro_shaders::life::Record;
use oneiro_shaders::{Kernel, life};

use crate::evaluator::PartResult;
use crate::foraging::{self, Foraging};
use crate::random::Key;
use crate::tables::{MotorTable, SensorTable};
use crate::world::{Invalid, World};

/// Rollouts a group: the workgroup of the kernels.
pub const LANES: usize = 64;

/// Genes may be as large as this in size: no sum in a controller overflows.
pub const GREATEST_GENE: f32 = 1e6;

/// Genes smaller than this in size (2^-40), zero of either sign among them, count as 0. A gene times an output of a
/// unit, at least 2^-63, is then a multiple of 2^-126, and so is any sum of such: none is subnormal.
pub const LEAST_GENE: f32 = 1.0 / (1_u64 << 40) as f32;

/// Records that the traces of a batch may have in all: 2.4 GB.
pub const GREATEST_TRACE: u64 = 1 << 25;

/// Words of a group's key, before its genes.
const KEY_WORDS: usize = 2;

/// One genome's life in one world from one key.
#[derive(Clone, Copy, Debug)]
pub struct Rollout<'a> {
    /// Index of its world.
    pub world: usize,
    /// As many as its world's controller takes, at most [`GREATEST_GENE`] in size.
    pub genes: &'a [f32],
    /// The key of its random numbers.
    pub key: Key,
}

/// Asks for a trace of each rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceRequest {
    /// A record each so many cycles, from 1; the first is of cycle 0.
    pub every: u32,
}

/// Worlds packed as the kernels read them, once for any number of batches. Cheap to clone.
///
/// The worlds of a batch have one kernel, so all must have the same kind of controller.
#[derive(Clone, Debug)]
pub struct Worlds(Arc<PackedWorlds>);

#[derive(Debug)]
struct PackedWorlds {
    kernel: &'static Kernel,
    /// Genes of a controller that lives in each.
    genes: Vec<usize>,
    packed: Packed,
}

impl Worlds {
    /// Packs worlds.
    ///
    /// # Errors
    /// No world, or worlds of different controllers.
    pub fn new(worlds: &[World]) -> Result<Self, Invalid> {
        Ok(Self(Arc::new(PackedWorlds {
            kernel: one_kernel(worlds)?,
            genes: worlds.iter().map(World::genes).collect(),
            packed: Packed::new(worlds),
        })))
    }

    /// Checks and packs on-board simulators of foragers, whose rollouts have two genes.
    ///
    /// # Errors
    /// No simulator; the first value that is not allowed.
    pub fn of_foragers(foragers: &[Foraging]) -> Result<Self, Invalid> {
        if foragers.is_empty() {
            return Err(Invalid::new("worlds", "there is none; allowed: one and more"));
        }
        let mut packed = Packed::default();
        let mut places = BTreeMap::new();
        for (index, forager) in foragers.iter().enumerate() {
            forager
                .check()
                .map_err(|invalid| Invalid::new(format!("foragers[{index}].{}", invalid.field), invalid.problem))?;
            let numbers = *places.entry(forager.cells()).or_insert_with_key(|cells| {
                let first = packed.tables.len() as u32;
                packed.tables.extend(cells);
                first
            });
            packed.worlds.push(life::World {
                numbers,
                ..forager.world()
            });
        }
        // The kernel has no objects, and a buffer is never empty.
        packed.shapes.push(life::Shape::default());
        Ok(Self(Arc::new(PackedWorlds {
            kernel: &oneiro_shaders::FORAGER,
            genes: vec![foraging::GENES; foragers.len()],
            packed,
        })))
    }

    /// Checks and packs rollouts in these worlds.
    ///
    /// # Errors
    /// No rollout, or too many; a rollout's world that is none; a rollout's genes that are too many, too few, not
    /// finite or beyond [`GREATEST_GENE`]; a trace with more than [`GREATEST_TRACE`] records.
    pub fn batch(&self, rollouts: &[Rollout<'_>], trace: Option<TraceRequest>) -> Result<Batch, Invalid> {
        let PackedWorlds { genes, packed, .. } = &*self.0;
        let layout = Layout::new(genes, rollouts)?;
        let inputs = layout.inputs(genes, rollouts)?;
        let cycles_of = |world: usize| packed.worlds[world].steps;
        let cycles = layout
            .groups
            .iter()
            .map(|group| cycles_of(group.world as usize))
            .max()
            .unwrap_or(0);
        let steps = rollouts.iter().map(|rollout| u64::from(cycles_of(rollout.world))).sum();
        let batch = Batch {
            worlds: self.clone(),
            groups: layout.groups,
            inputs,
            slots: layout.slots,
            trace_every: trace.map_or(0, |trace| trace.every),
            cycles,
            steps,
        };
        if trace.is_some_and(|trace| trace.every == 0) {
            return Err(Invalid::new("trace.every", "is 0; allowed: 1 and more cycles"));
        }
        let records = u64::from(batch.trace_records()) * batch.groups.len() as u64 * LANES as u64;
        if records > GREATEST_TRACE {
            let problem = format!(
                "{records} records in all; allowed: up to {GREATEST_TRACE}: trace fewer rollouts, or less often"
            );
            return Err(Invalid::new("trace", problem));
        }
        Ok(batch)
    }

    /// The kernel that simulates them.
    pub fn kernel(&self) -> &'static Kernel {
        self.0.kernel
    }

    /// For each world, genes of a controller that lives in it.
    pub fn genes(&self) -> &[usize] {
        &self.0.genes
    }
}

/// Checked rollouts, packed as the kernels read them: in groups of 64 slots that share a world. Rollouts keep their
/// order within a world; a world's last group may have idle slots.
///
/// See [`Worlds`] for what its worlds have in common.
#[derive(Debug)]
pub struct Batch {
    worlds: Worlds,
    groups: Vec<life::Group>,
    inputs: Vec<u32>,
    /// The slot of each rollout.
    slots: Vec<u32>,
    trace_every: u32,
    cycles: u32,
    steps: u64,
}

impl Batch {
    /// Checks and packs rollouts. Whoever makes many batches packs their worlds once, with [`Worlds::new`].
    ///
    /// # Errors
    /// As [`Worlds::new`] and [`Worlds::batch`].
    pub fn new(worlds: &[World], rollouts: &[Rollout<'_>], trace: Option<TraceRequest>) -> Result<Self, Invalid> {
        Worlds::new(worlds)?.batch(rollouts, trace)
    }

    /// How many rollouts it has.
    pub fn rollouts(&self) -> usize {
        self.slots.len()
    }

    /// Robot-steps in all: a step is one robot for one cycle.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.worlds.kernel()
    }

    /// How many groups it has.
    pub fn groups(&self) -> u32 {
        self.groups.len() as u32
    }

    /// Cycles of its longest life.
    pub fn cycles(&self) -> u32 {
        self.cycles
    }

    /// Cycles from one record of a trace to the next; 0 without a trace.
    pub fn trace_every(&self) -> u32 {
        self.trace_every
    }

    /// Records that each slot has room for; 0 without a trace.
    pub fn trace_records(&self) -> u32 {
        if self.trace_every == 0 {
            0
        } else {
            self.cycles.div_ceil(self.trace_every)
        }
    }

    /// The slot of a rollout: its lane is `slot % 64` of the group `slot / 64`.
    pub fn slot(&self, rollout: usize) -> Option<usize> {
        self.slots.get(rollout).map(|&slot| slot as usize)
    }

    /// The rollout in a slot.
    pub fn rollout(&self, slot: usize) -> Option<usize> {
        self.slots.iter().position(|&own| own as usize == slot)
    }

    /// The whole batch.
    pub fn all(&self) -> Part<'_> {
        self.part(0..self.groups())
    }

    /// Some of its groups. A range that goes too far ends where the batch does.
    pub fn part(&self, groups: Range<u32>) -> Part<'_> {
        let end = groups.end.min(self.groups());
        Part {
            batch: self,
            groups: groups.start.min(end)..end,
        }
    }

    /// The evaluation of [`Batch::all`], by rollout.
    ///
    /// # Panics
    /// If the result is not one of the whole batch.
    pub fn outcome(&self, result: PartResult) -> Outcome {
        let PartResult { fitness, trace } = result;
        let records = self.trace_records() as usize;
        assert_eq!(fitness.len(), self.groups.len() * LANES, "a fitness for each slot");
        assert_eq!(trace.len(), fitness.len() * records, "a trace for each slot");
        let own_trace = |&slot: &u32| {
            let world = self.groups[slot as usize / LANES].world;
            let own = self.worlds.0.packed.worlds[world as usize]
                .steps
                .div_ceil(self.trace_every);
            trace[slot as usize * records..][..own as usize].to_vec()
        };
        Outcome {
            fitness: self.slots.iter().map(|&slot| fitness[slot as usize]).collect(),
            traces: if records == 0 {
                Vec::new()
            } else {
                self.slots.iter().map(own_trace).collect()
            },
        }
    }
}

/// What a batch's evaluation gave, by rollout, in the order in which they were given.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Fitness; more is better.
    pub fitness: Vec<f32>,
    /// Traces, each as long as its life; none if none were asked for.
    pub traces: Vec<Vec<Record>>,
}

/// Some neighbouring groups of a batch: what evaluators share out. Groups, inputs and results are counted within it.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    batch: &'a Batch,
    groups: Range<u32>,
}

impl<'a> Part<'a> {
    /// The batch.
    pub fn batch(&self) -> &'a Batch {
        self.batch
    }

    /// Which of the batch's groups these are.
    pub fn groups(&self) -> Range<u32> {
        self.groups.clone()
    }

    /// A part of this part, its groups counted within this one.
    #[must_use]
    pub fn part(&self, groups: Range<u32>) -> Part<'a> {
        let end = self.groups.start.saturating_add(groups.end).min(self.groups.end);
        self.batch.part(self.groups.start.saturating_add(groups.start)..end)
    }

    /// The kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.batch.kernel()
    }

    /// All the batch's worlds.
    pub fn worlds(&self) -> &'a [life::World] {
        &self.batch.worlds.0.packed.worlds
    }

    /// All the batch's objects; at least one, so that the buffer is not empty.
    pub fn shapes(&self) -> &'a [life::Shape] {
        &self.batch.worlds.0.packed.shapes
    }

    /// All the batch's tables.
    pub fn tables(&self) -> &'a [[u32; 4]] {
        &self.batch.worlds.0.packed.tables
    }

    /// This part's groups. Their `inputs` count from the start of the batch's.
    pub fn group_table(&self) -> &'a [life::Group] {
        &self.batch.groups[self.groups.start as usize..self.groups.end as usize]
    }

    /// This part's inputs.
    pub fn inputs(&self) -> &'a [u32] {
        &self.batch.inputs[self.inputs_before(self.groups.start)..self.inputs_before(self.groups.end)]
    }

    /// Where this part's inputs start in the batch's: `Dispatch::first_input`.
    pub fn first_input(&self) -> u32 {
        self.inputs_before(self.groups.start) as u32
    }

    fn inputs_before(&self, group: u32) -> usize {
        self.batch
            .groups
            .get(group as usize)
            .map_or(self.batch.inputs.len(), |group| group.inputs as usize)
    }

    /// Slots: 64 a group.
    pub fn slots(&self) -> usize {
        self.groups.len() * LANES
    }

    /// Rollouts, idle slots not counted.
    pub fn rollouts(&self) -> usize {
        self.group_table().iter().map(|group| group.rollouts as usize).sum()
    }

    /// Robot-steps in all.
    pub fn steps(&self) -> u64 {
        let steps =
            |group: &life::Group| u64::from(group.rollouts) * u64::from(self.worlds()[group.world as usize].steps);
        self.group_table().iter().map(steps).sum()
    }

    /// Cycles of its longest life.
    pub fn cycles(&self) -> u32 {
        self.group_table()
            .iter()
            .map(|group| self.worlds()[group.world as usize].steps)
            .max()
            .unwrap_or(0)
    }

    /// The most iterations that a kernel's loops make together in one cycle of one life, at least 1. The draws of a
    /// random start come on top, once.
    pub fn loops(&self) -> u32 {
        let most = |group: &life::Group| loops(self.kernel(), &self.worlds()[group.world as usize]);
        self.group_table().iter().map(most).max().unwrap_or(1)
    }

    /// Cycles from one record of a trace to the next; 0 without a trace.
    pub fn trace_every(&self) -> u32 {
        self.batch.trace_every()
    }

    /// Records that each slot has room for; 0 without a trace. The same in each part of a batch.
    pub fn trace_records(&self) -> u32 {
        self.batch.trace_records()
    }
}

/// The most iterations of the loops of one cycle, by the loops that the kernels have; the last look at a loop's
/// condition counts.
fn loops(kernel: &Kernel, world: &life::World) -> u32 {
    let shapes = world.shapes + 1;
    let cycle = 1 + world.hidden + 1;
    if kernel.name == "forager" {
        // Where food appears anew, and the sensors' two halves.
        return cycle + 65 + 3;
    }
    if !kernel.name.starts_with("surrogate") {
        // What is sensed, and what is touched.
        return cycle + 2 * shapes;
    }
    // Rays on both sides of eight sensors against all that is in reach, of which each may be a block of two faces, and
    // against each one's turn; the waves of light; two rides of five steps each, of which one slides, and what is
    // touched.
    let sides = 9 + 8 * 3;
    let faces = 8 * 2 * 3;
    let rays = shapes + sides + 8 * 2 * shapes + faces * shapes + shapes * (shapes + sides + faces);
    let ride = 3 + 2 * 6 + 5 * 3 * shapes + 2 * shapes;
    cycle + rays + 5 + ride
}

/// The kernel of all worlds.
fn one_kernel(worlds: &[World]) -> Result<&'static Kernel, Invalid> {
    let Some(first) = worlds.first() else {
        return Err(Invalid::new("worlds", "there is none; allowed: one and more"));
    };
    for (index, world) in worlds.iter().enumerate() {
        if world.kernel().name != first.kernel().name {
            let problem = format!(
                "is of the kernel {}, the first world of {}; allowed: one kind of controller in a batch",
                world.kernel().name,
                first.kernel().name
            );
            return Err(Invalid::new(format!("worlds[{index}].controller"), problem));
        }
    }
    Ok(first.kernel())
}

/// Which rollout goes where.
struct Layout {
    groups: Vec<life::Group>,
    slots: Vec<u32>,
    /// Words of all inputs.
    words: usize,
}

impl Layout {
    /// `genes` are how many a rollout of each world has.
    fn new(genes: &[usize], rollouts: &[Rollout<'_>]) -> Result<Self, Invalid> {
        const GREATEST: usize = 1 << 28;
        if rollouts.is_empty() || rollouts.len() > GREATEST {
            let problem = format!("there are {}; allowed: 1 to {GREATEST}", rollouts.len());
            return Err(Invalid::new("rollouts", problem));
        }
        let mut counts = vec![0_usize; genes.len()];
        for (index, rollout) in rollouts.iter().enumerate() {
            let Some(count) = counts.get_mut(rollout.world) else {
                let problem = format!("is {}; allowed: 0 to {}", rollout.world, genes.len() - 1);
                return Err(Invalid::new(format!("rollouts[{index}].world"), problem));
            };
            *count += 1;
        }
        let mut groups = Vec::new();
        let mut words = 0_usize;
        // The next free slot of each world.
        let mut next = Vec::with_capacity(genes.len());
        for (world, count) in counts.into_iter().enumerate() {
            next.push(groups.len() * LANES);
            for first in (0..count).step_by(LANES) {
                let rollouts = (count - first).min(LANES) as u32;
                groups.push(life::Group {
                    world: world as u32,
                    rollouts,
                    inputs: words as u32,
                });
                words += (KEY_WORDS + genes[world]) * LANES;
            }
        }
        if words > u32::MAX as usize {
            let problem = format!(
                "their genes and keys fill {words} words; allowed: up to {}: evaluate several batches",
                u32::MAX
            );
            return Err(Invalid::new("rollouts", problem));
        }
        let slots = rollouts
            .iter()
            .map(|rollout| {
                let slot = &mut next[rollout.world];
                *slot += 1;
                (*slot - 1) as u32
            })
            .collect();
        Ok(Self { groups, slots, words })
    }

    /// The groups' inputs: field by field 64 values, first the keys' two words, then the genes.
    fn inputs(&self, genes: &[usize], rollouts: &[Rollout<'_>]) -> Result<Vec<u32>, Invalid> {
        let mut inputs = vec![0_u32; self.words];
        for (index, (rollout, &slot)) in rollouts.iter().zip(&self.slots).enumerate() {
            let genes = genes[rollout.world];
            check_genes(index, rollout.genes, genes)?;
            let slot = slot as usize;
            let first = self.groups[slot / LANES].inputs as usize + slot % LANES;
            // A group's strided writes stay within a few kilobytes.
            let lane = &mut inputs[first..=first + (KEY_WORDS + genes - 1) * LANES];
            lane[0] = rollout.key.0[0];
            lane[LANES] = rollout.key.0[1];
            for (value, &gene) in lane[KEY_WORDS * LANES..].iter_mut().step_by(LANES).zip(rollout.genes) {
                *value = canonical(gene).to_bits();
            }
        }
        Ok(inputs)
    }
}

/// A gene as the kernels get it.
fn canonical(gene: f32) -> f32 {
    if gene.abs() < LEAST_GENE { 0.0 } else { gene }
}

fn check_genes(rollout: usize, genes: &[f32], count: usize) -> Result<(), Invalid> {
    if genes.len() != count {
        let problem = format!(
            "there are {}; allowed: {count}, as its world's controller takes",
            genes.len()
        );
        return Err(Invalid::new(format!("rollouts[{rollout}].genes"), problem));
    }
    // NaN is not within.
    let within = |gene: &f32| gene.abs() <= GREATEST_GENE;
    // One pass without branches; where the fault is, is asked later.
    if genes.iter().fold(true, |good, gene| good & within(gene)) {
        return Ok(());
    }
    let bad = genes.iter().position(|gene| !within(gene)).unwrap_or_default();
    let problem = format!("is {}; allowed: -{GREATEST_GENE} to {GREATEST_GENE}", genes[bad]);
    Err(Invalid::new(format!("rollouts[{rollout}].genes[{bad}]"), problem))
}

/// The buffers that rollouts share: worlds with their places in them, objects, and each different table once.
#[derive(Debug, Default)]
struct Packed {
    worlds: Vec<life::World>,
    shapes: Vec<life::Shape>,
    tables: Vec<[u32; 4]>,
}

impl Packed {
    fn new(worlds: &[World]) -> Self {
        let mut packed = Self::default();
        let mut sensors = Seen::default();
        let mut motors = Seen::default();
        let mut surrogates = Seen::default();
        for world in worlds {
            let robot = &world.spec().robot;
            let first_shape = packed.shapes.len() as u32;
            for shape in world.shapes() {
                let class = shape.table as usize;
                let table = sensors.place(
                    (Arc::as_ptr(&robot.sensors), class),
                    || sensor_cells(&robot.sensors.classes[class]),
                    &mut packed.tables,
                );
                packed.shapes.push(life::Shape { table, ..*shape });
            }
            let motor_table = motors.place(
                (Arc::as_ptr(&robot.motors), 0),
                || motor_cells(&robot.motors),
                &mut packed.tables,
            );
            let numbers = world.spec().surrogate.as_ref().map_or(0, |surrogate| {
                surrogates.place(
                    (Arc::as_ptr(surrogate), robot.body_radius.to_bits() as usize),
                    || surrogate.cells(robot.body_radius),
                    &mut packed.tables,
                )
            });
            packed.worlds.push(life::World {
                first_shape,
                motor_table,
                numbers,
                ..*world.packed()
            });
        }
        if packed.shapes.is_empty() {
            packed.shapes.push(life::Shape::default());
        }
        packed
    }
}

/// Where tables were put: by identity, which is quick, and by content.
struct Seen<T> {
    identities: HashMap<(*const T, usize), u32>,
    contents: BTreeMap<Vec<[u32; 4]>, u32>,
}

impl<T> Default for Seen<T> {
    fn default() -> Self {
        Self {
            identities: HashMap::new(),
            contents: BTreeMap::new(),
        }
    }
}

impl<T> Seen<T> {
    /// The first cell of a table, which is added if no equal one is there.
    fn place(
        &mut self,
        identity: (*const T, usize),
        cells: impl Fn() -> Vec<[u32; 4]>,
        tables: &mut Vec<[u32; 4]>,
    ) -> u32 {
        *self.identities.entry(identity).or_insert_with(|| {
            *self.contents.entry(cells()).or_insert_with_key(|cells| {
                let first = tables.len() as u32;
                tables.extend(cells);
                first
            })
        })
    }
}

/// A cell's eight readings in four words, the even sensors in the low halves.
fn sensor_cells(table: &SensorTable) -> Vec<[u32; 4]> {
    let pack = |readings: &[u16; 8]| {
        std::array::from_fn(|pair| u32::from(readings[2 * pair]) | u32::from(readings[2 * pair + 1]) << 16)
    };
    table.readings.iter().map(pack).collect()
}

fn motor_cells(table: &MotorTable) -> Vec<[u32; 4]> {
    // Zero has one sign.
    let word = |x: f32| if x == 0.0 { 0 } else { x.to_bits() };
    table
        .cells
        .iter()
        .map(|cell| [cell.displacement, cell.turn, cell.left, cell.right].map(word))
        .collect()
}
