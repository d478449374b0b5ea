//! Values that only some kernels read, as cells of four words.

use bytemuck::NoUninit;

/// A world's cells, laid out as in the kernel's own struct.
#[derive(Debug)]
pub(crate) struct Cells(Vec<[u32; 4]>);

impl Cells {
    /// Makes `count` cells of zeros.
    pub(crate) fn new(count: u32) -> Self {
        Self(vec![[0; 4]; count as usize])
    }

    /// Fills a cell.
    pub(crate) fn put(&mut self, cell: u32, content: impl NoUninit) {
        self.0[cell as usize] = bytemuck::cast(content);
    }

    /// Adds a cell.
    pub(crate) fn push(&mut self, content: impl NoUninit) {
        self.0.push(bytemuck::cast(content));
    }

    pub(crate) fn into_table(self) -> Vec<[u32; 4]> {
        self.0
    }
}
