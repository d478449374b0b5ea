//! Pucks as their kernel has them.

/// Checked pucks of a swarm.
#[derive(Clone, Debug)]
pub(crate) struct Discs {
    pub(crate) count: u32,
    pub(crate) radius: f32,
    pub(crate) yields: f32,
    pub(crate) grip: f32,
    /// `None`: at random places.
    pub(crate) places: Option<Vec<[f32; 2]>>,
}

impl Discs {
    /// Where each is at the start, if that is given.
    pub(crate) fn places(&self) -> &[[f32; 2]] {
        self.places.as_deref().unwrap_or_default()
    }

    /// The kernel's cells: `PucksCell`, and a cell for each place that is given.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [f32; 4]> {
        let shared = [self.count as f32, self.radius, self.yields, self.grip];
        let places = self.places().iter().map(|&[x, y]| [x, y, 0.0, 0.0]);
        std::iter::once(shared).chain(places)
    }
}
