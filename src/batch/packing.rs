//! The interface between batches and kinds of worlds, and the buffers that worlds are packed into.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use oneiro_shaders::{Kernel, episode};

use super::Variants;
use crate::parameter::Invalid;

/// A kind of world: [`World`](crate::world::World), [`Foraging`](crate::foraging::Foraging),
/// [`Swarm`](crate::swarm::Swarm), or any other that a kernel simulates.
///
/// Batches know worlds only by this trait. To add a kind of world, write its kernel and implement this trait; nothing
/// else in this module changes.
pub trait WorldKind {
    /// Checks every value.
    ///
    /// # Errors
    /// The first invalid value.
    fn check(&self) -> Result<(), Invalid>;

    /// Kernel that simulates it.
    fn kernel(&self) -> &'static Kernel;

    /// Number of genes of an episode.
    fn genes(&self) -> usize;

    /// Number of robots of an episode.
    fn robots(&self) -> u32 {
        1
    }

    /// Whether its task may end an episode before its last cycle.
    fn may_end_early(&self) -> bool {
        false
    }

    /// How an episode chooses one of its variants; by default there is one.
    fn variants(&self) -> Variants {
        Variants::default()
    }

    /// Converts a variant of the world, by its number from 0, to the kernel's form. Its objects and tables go into the buffers of
    /// its batch, and their positions become part of the world.
    fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World;

    /// Words that a slot keeps between dispatches. By default, the size of the struct that the kernel declares for its
    /// state.
    fn state_words(&self) -> u32 {
        words(self.kernel(), "state")
    }

    /// Words per record of a trace. By default, the size of the struct that the kernel declares for its records.
    fn record_words(&self) -> u32 {
        words(self.kernel(), "trace")
    }
}

/// Words per element of a kernel's buffer.
fn words(kernel: &Kernel, buffer: &str) -> u32 {
    (kernel.stride(buffer) / size_of::<u32>()) as u32
}

impl<W: WorldKind + ?Sized> WorldKind for &W {
    fn check(&self) -> Result<(), Invalid> {
        (**self).check()
    }

    fn kernel(&self) -> &'static Kernel {
        (**self).kernel()
    }

    fn genes(&self) -> usize {
        (**self).genes()
    }

    fn robots(&self) -> u32 {
        (**self).robots()
    }

    fn may_end_early(&self) -> bool {
        (**self).may_end_early()
    }

    fn variants(&self) -> Variants {
        (**self).variants()
    }

    fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World {
        (**self).pack(variant, buffers)
    }

    fn state_words(&self) -> u32 {
        (**self).state_words()
    }

    fn record_words(&self) -> u32 {
        (**self).record_words()
    }
}

/// Data that the episodes of a batch share, in the kernel's form.
#[derive(Debug, Default)]
pub(crate) struct Packed {
    pub(crate) worlds: Vec<episode::World>,
    pub(crate) shapes: Vec<episode::Shape>,
    pub(crate) tables: Vec<[u32; 4]>,
}

impl Packed {
    /// Whether both have the same words.
    #[cfg(all(
        feature = "compose",
        any(feature = "gpu", feature = "native"),
        not(target_family = "wasm")
    ))]
    pub(super) fn is_same(&self, other: &Self) -> bool {
        fn words(packed: &Packed) -> ([&[u32]; 2], &[[u32; 4]]) {
            let of_lists = [
                bytemuck::cast_slice(&packed.worlds),
                bytemuck::cast_slice(&packed.shapes),
            ];
            (of_lists, &packed.tables)
        }
        words(self) == words(other)
    }

    pub(super) fn new(worlds: &[impl WorldKind]) -> Self {
        let mut buffers = Buffers::default();
        for world in worlds {
            for variant in 0..world.variants().count() {
                let packed = world.pack(variant, &mut buffers);
                buffers.packed.worlds.push(packed);
            }
        }
        let mut packed = buffers.packed;
        // Buffers can't be empty.
        if packed.shapes.is_empty() {
            packed.shapes.push(episode::Shape::default());
        }
        packed
    }

    /// Most iterations of a kernel's loops in the last `cycles` cycles of an episode in a world, including its beginning: a loop that
    /// counts up to the cycle's number turns most often there.
    pub(super) fn turns(&self, kernel: &Kernel, world: usize, cycles: u32) -> u32 {
        u32::try_from((kernel.turns.0)(&self.words_of(world, cycles))).unwrap_or(u32::MAX)
    }

    /// Words of buffers by which loops are bounded in the last `cycles` cycles of an episode in a world.
    pub(crate) fn words_of(&self, world: usize, cycles: u32) -> impl Fn(&str, Option<u64>, u32) -> u32 + '_ {
        let steps = self.worlds[world].steps;
        let dispatch = episode::Dispatch {
            step_begin: steps.saturating_sub(cycles),
            step_end: steps,
            ..episode::Dispatch::default()
        };
        move |buffer, element, word| {
            let words: &[u32] = match (buffer, element) {
                ("dispatch", None) => bytemuck::cast_slice(std::slice::from_ref(&dispatch)),
                ("worlds", None) => bytemuck::cast_slice(std::slice::from_ref(&self.worlds[world])),
                // A kernel clamps an index that is too large.
                ("tables", Some(cell)) => &self.tables[(cell as usize).min(self.tables.len() - 1)],
                // An episode's own values are unbounded.
                _ => return u32::MAX,
            };
            words[word as usize]
        }
    }
}

/// Buffers that worlds are packed into: objects, and each distinct table once.
#[derive(Debug, Default)]
pub struct Buffers {
    packed: Packed,
    /// Positions of tables by owner, for speed, and by content.
    owners: HashMap<(*const (), usize), u32>,
    contents: BTreeMap<Vec<[u32; 4]>, u32>,
}

impl Buffers {
    /// Adds objects and returns the index of the first.
    pub fn add_shapes(&mut self, shapes: impl IntoIterator<Item = episode::Shape>) -> u32 {
        let first = self.packed.shapes.len() as u32;
        self.packed.shapes.extend(shapes);
        first
    }

    /// Adds a table, unless there is an equal one, and returns the index of its first cell.
    pub fn add_table(&mut self, cells: Vec<[u32; 4]>) -> u32 {
        *self.contents.entry(cells).or_insert_with_key(|cells| {
            let first = self.packed.tables.len() as u32;
            self.packed.tables.extend(cells);
            first
        })
    }

    /// Adds table `number` of a value that worlds share; its cells are made only once. The value must outlive the
    /// packing.
    pub fn add_shared_table<T>(&mut self, owner: &Arc<T>, number: usize, cells: impl FnOnce() -> Vec<[u32; 4]>) -> u32 {
        let owner = (Arc::as_ptr(owner).cast(), number);
        if let Some(first) = self.owners.get(&owner) {
            return *first;
        }
        let first = self.add_table(cells());
        self.owners.insert(owner, first);
        first
    }
}
