//! Traces of episodes.

use std::ops::Deref;

use super::Record;

/// Takes a line of words apart: its record, and its details.
///
/// # Panics
/// If there are fewer words than a record has.
pub fn parts_of(line: &[u32]) -> (&Record, &[u32]) {
    let (record, details) = line.split_at(WORDS);
    (bytemuck::from_bytes(bytemuck::cast_slice(record)), details)
}

/// Words of a record.
const WORDS: usize = size_of::<Record>() / size_of::<u32>();

/// A traced episode: a record of each traced cycle, as a slice, and the details that go with it, which depend on the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    records: Vec<Record>,
    details: Vec<u32>,
}

impl Trace {
    /// Reads lines of `width` words each: a record, and its details.
    pub fn read(words: &[u32], width: usize) -> Self {
        let mut trace = Self::default();
        for line in words.chunks_exact(width) {
            let (record, details) = line.split_at(WORDS);
            trace
                .records
                .push(bytemuck::pod_read_unaligned(bytemuck::cast_slice(record)));
            trace.details.extend(details);
        }
        trace
    }

    /// Details of a record, as words: those that [`World::details`](crate::world::World::details) names, or a forager's
    /// [`Details`](crate::foraging::Details).
    pub fn details(&self, record: usize) -> &[u32] {
        let width = self.width();
        &self.details[record * width..][..width]
    }

    /// Details of a record as a struct.
    ///
    /// # Panics
    /// If the struct has another size.
    pub fn details_as<T: bytemuck::AnyBitPattern>(&self, record: usize) -> T {
        bytemuck::pod_read_unaligned(bytemuck::cast_slice(self.details(record)))
    }

    /// Each record with its details.
    pub fn lines(&self) -> impl Iterator<Item = (&Record, &[u32])> {
        (0..self.records.len()).map(|line| (&self.records[line], self.details(line)))
    }

    /// Perceived activations, 0 to 1, of a robot with eight sampled sensors of proximity.
    ///
    /// # Panics
    /// If there are fewer details.
    pub fn activations(&self, record: usize) -> [f32; 8] {
        let details = self.details(record);
        std::array::from_fn(|sensor| f32::from_bits(details[sensor]))
    }

    /// All words, line by line.
    pub fn words(&self) -> impl Iterator<Item = u32> {
        let line =
            |(record, details): (&Record, &[u32])| [bytemuck::cast_slice(bytemuck::bytes_of(record)), details].concat();
        self.lines().flat_map(line)
    }

    /// Takes the trace of an observed world apart: the trace of each robot.
    ///
    /// # Panics
    /// If the world has another number of robots.
    pub fn by_robot(&self, robots: u32) -> Vec<Self> {
        let mut traces = vec![Self::default(); robots as usize];
        for line in 0..self.len() {
            let words = [
                bytemuck::cast_slice(bytemuck::bytes_of(&self[line])),
                self.details(line),
            ]
            .concat();
            assert_eq!(words.len() % traces.len(), 0, "a line for each robot");
            let width = words.len() / traces.len();
            for (trace, words) in traces.iter_mut().zip(words.chunks_exact(width)) {
                trace.append(&Self::read(words, width));
            }
        }
        traces
    }

    /// Every `every`th record from `first` on.
    #[must_use]
    pub fn thinned(&self, first: usize, every: usize) -> Self {
        let kept = || (first..self.len()).step_by(every);
        Self {
            records: kept().map(|line| self[line]).collect(),
            details: kept().flat_map(|line| self.details(line)).copied().collect(),
        }
    }

    /// Appends the next stretch of the same episode.
    pub fn append(&mut self, next: &Self) {
        self.records.extend(&next.records);
        self.details.extend(&next.details);
    }

    fn width(&self) -> usize {
        self.details.len() / self.records.len().max(1)
    }
}

impl<'a> IntoIterator for &'a Trace {
    type Item = &'a Record;
    type IntoIter = std::slice::Iter<'a, Record>;

    fn into_iter(self) -> Self::IntoIter {
        self.records.iter()
    }
}

impl Deref for Trace {
    type Target = [Record];

    fn deref(&self) -> &[Record] {
        &self.records
    }
}
