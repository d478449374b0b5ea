//! Floors of grey cells, such as pictures give; `lib/picture.wgsl` reads them.

use std::fmt;
use std::sync::Arc;

use crate::exact::zero;
use crate::parameter::Invalid;

/// Most cells of a picture on the floor.
pub const GREATEST_CELLS: u32 = 1 << 20;
/// Most pixels of a picture that cells are averaged from.
pub const GREATEST_PIXELS: u32 = 1 << 24;

/// Cells that the head of a picture has in a kernel's tables.
pub(crate) const HEAD: usize = 2;
/// Greys in a cell of the tables.
const PACKED: usize = 16;

/// A rectangle of the floor that consists of grey cells. Robots read a cell's grey anywhere in it, its left and lower edge included.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    low: [f32; 2],
    sides: [f32; 2],
    columns: u32,
    rows: u32,
    greys: Arc<Greys>,
}

/// Greys from 0 for black to 255 for white, row after row from the lower left cell.
#[derive(PartialEq)]
pub(crate) struct Greys(Vec<u8>);

impl fmt::Debug for Greys {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} greys", self.0.len())
    }
}

impl Picture {
    /// A picture of `columns` times `rows` cells, each from 0 for black to 255 for white, row after row from the lower left one, given its
    /// lower left corner and its sides in mm, -100,000 to 100,000 and 1 to 100,000, which a world checks.
    ///
    /// # Errors
    /// A number of cells out of range; another number of greys.
    pub fn new(low: [f32; 2], sides: [f32; 2], [columns, rows]: [u32; 2], greys: Vec<u8>) -> Result<Self, Invalid> {
        let cells = u64::from(columns) * u64::from(rows);
        if !(1..=u64::from(GREATEST_CELLS)).contains(&cells) {
            let problem = format!("has {columns} x {rows} cells; allowed: 1 to {GREATEST_CELLS} in all");
            return Err(Invalid::new("arena.picture", problem));
        }
        if greys.len() as u64 != cells {
            let problem = format!("has {} greys; allowed: {cells}, one for each cell", greys.len());
            return Err(Invalid::new("arena.picture", problem));
        }
        Ok(Self {
            low,
            sides,
            columns,
            rows,
            greys: Arc::new(Greys(greys)),
        })
    }

    /// Its lower left corner, mm.
    pub fn low(&self) -> [f32; 2] {
        self.low
    }

    /// Its width and its height, mm.
    pub fn sides(&self) -> [f32; 2] {
        self.sides
    }

    /// Number of cells from left to right.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Number of cells from bottom to top.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Greys of all cells from 0 for black to 255 for white, row after row from the lower left cell.
    pub fn greys(&self) -> &[u8] {
        &self.greys.0
    }

    /// The same picture of at most so many cells along each side, by the mean of their greys.
    #[must_use]
    pub fn coarser(&self, most: u32) -> Self {
        let size = [self.columns, self.rows];
        let fewer = size.map(|cells| cells.min(most.max(1)));
        if fewer == size {
            return self.clone();
        }
        let rows = self.greys.0.chunks(self.columns as usize).rev();
        let pixels: Vec<u16> = rows.flatten().map(|&grey| u16::from(grey) * 257).collect();
        Self {
            columns: fewer[0],
            rows: fewer[1],
            greys: Arc::new(Greys(averaged(&pixels, size, fewer))),
            ..*self
        }
    }

    /// What owns its cells in a batch's tables.
    pub(crate) fn owner(&self) -> &Arc<Greys> {
        &self.greys
    }

    /// Its greys as cells of a batch's tables.
    pub(crate) fn cells(&self) -> Vec<[u32; 4]> {
        let packed = self.greys.0.chunks(PACKED).map(|greys| {
            let mut bytes = [0; PACKED];
            bytes[..greys.len()].copy_from_slice(greys);
            let words = bytes.as_chunks().0;
            std::array::from_fn(|word| u32::from_le_bytes(words[word]))
        });
        packed.collect()
    }

    /// What a kernel has of it besides: the lower left corner and the cells per mm; the numbers of cells, the first of the tables'
    /// cells with greys, and the reading of a grey of 1, given the reading of white.
    pub(crate) fn head(&self, first: u32, white: f32) -> [[u32; 4]; HEAD] {
        let ([x, y], [width, height]) = (self.low, self.sides);
        let per_mm = [self.columns as f32 / width, self.rows as f32 / height];
        [
            [x, y, per_mm[0], per_mm[1]].map(|number| zero(number).to_bits()),
            [self.columns, self.rows, first, (white / 255.0).to_bits()],
        ]
    }
}

/// Averages pixels over the cells of an even grid, in whole numbers. Pixels go from 0 for black to 65,535 for white, row after row from
/// the upper left one, at most [`GREATEST_PIXELS`]; cells from 0 to 255, row after row from the lower left one. A pixel that several
/// cells share counts for each by the area in it; halves are rounded up.
///
/// # Panics
/// With another number of pixels than `width` times `height`, too many of them, or no cells.
pub fn averaged(pixels: &[u16], [width, height]: [u32; 2], [columns, rows]: [u32; 2]) -> Vec<u8> {
    let count = u64::from(width) * u64::from(height);
    assert!(count == pixels.len() as u64 && (1..=u64::from(GREATEST_PIXELS)).contains(&count) && columns * rows > 0);
    let mut sums = vec![0_u64; columns as usize * rows as usize];
    let mut of_row = vec![0; columns as usize];
    for (index, line) in (0..).zip(pixels.chunks(width as usize)) {
        of_row.fill(0);
        for (pixel, &grey) in (0..).zip(line) {
            for (column, overlap) in overlaps(pixel, width, columns) {
                of_row[column] += overlap * u64::from(grey);
            }
        }
        for (row, overlap) in overlaps(index, height, rows) {
            let first = (rows as usize - 1 - row) * columns as usize;
            for (sum, grey) in sums[first..].iter_mut().zip(&of_row) {
                *sum += overlap * grey;
            }
        }
    }
    // A cell's parts of pixels are this many in all.
    let white = u64::from(u16::MAX) * count;
    sums.iter()
        .map(|sum| ((2 * 255 * sum + white) / (2 * white)) as u8)
        .collect()
}

/// The cells along a side that a pixel has parts in, and how large each part is, if a pixel has as many parts as there are cells.
fn overlaps(pixel: u32, pixels: u32, cells: u32) -> impl Iterator<Item = (usize, u64)> {
    let (pixels, cells) = (u64::from(pixels), u64::from(cells));
    let (from, to) = (u64::from(pixel) * cells, (u64::from(pixel) + 1) * cells);
    (from / pixels..=(to - 1) / pixels).map(move |cell| {
        let overlap = to.min((cell + 1) * pixels) - from.max(cell * pixels);
        (cell as usize, overlap)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell's grey by its definition: the mean over points of a grid that is fine enough for all edges.
    fn by_points(pixels: &[u16], [width, height]: [u32; 2], [columns, rows]: [u32; 2]) -> Vec<u8> {
        let mut greys = Vec::new();
        for row in (0..rows).rev() {
            for column in 0..columns {
                let mut sum = 0_u64;
                for y in row * height..(row + 1) * height {
                    for x in column * width..(column + 1) * width {
                        sum += u64::from(pixels[((y / rows) * width + x / columns) as usize]);
                    }
                }
                let count = u64::from(width * height);
                greys.push(((2 * 255 * sum + 65535 * count) / (2 * 65535 * count)) as u8);
            }
        }
        greys
    }

    #[test]
    fn cells_have_the_mean_of_their_pixels() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16
        };
        for size in [[1, 1], [7, 5], [3, 11], [16, 4]] {
            let pixels: Vec<u16> = (0..size[0] * size[1]).map(|_| next()).collect();
            for grid in [[1, 1], [7, 5], [2, 3], [5, 9], [20, 1], [4, 4]] {
                assert_eq!(
                    averaged(&pixels, size, grid),
                    by_points(&pixels, size, grid),
                    "{size:?} {grid:?}"
                );
            }
        }
    }

    #[test]
    fn white_and_black_stay() {
        for grey in [0, 255_u8] {
            let pixels = vec![u16::from(grey) * 257; 6 * 35];
            assert_eq!(averaged(&pixels, [6, 35], [4, 9]), vec![grey; 36]);
        }
        assert_eq!(255.0 * (1.0_f32 / 255.0), 1.0);
    }

    #[test]
    fn a_coarser_picture_has_the_same_mean() {
        let greys: Vec<u8> = vec![0, 100, 200, 200, 50, 50, 50, 250];
        let picture = Picture::new([0.0; 2], [40.0, 20.0], [4, 2], greys).expect("a picture");
        let coarser = picture.coarser(2);
        assert_eq!((coarser.columns(), coarser.rows()), (2, 2));
        assert_eq!(coarser.greys(), [50, 200, 50, 150]);
        assert_eq!(picture.coarser(9), picture);
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        let of = |cells, greys| Picture::new([0.0; 2], [10.0; 2], cells, greys);
        for (picture, problem) in [
            (of([0, 1], vec![]), "has 0 x 1 cells; allowed: 1 to 1048576 in all"),
            (of([2000, 2000], vec![0; 4_000_000]), "has 2000 x 2000 cells"),
            (of([2, 2], vec![0]), "has 1 greys; allowed: 4"),
        ] {
            let text = picture.expect_err("a refusal").to_string();
            assert!(text.contains(problem), "{text}");
        }
    }
}
