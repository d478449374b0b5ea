//! A run's table of steps while it grows. However long the run, it takes the same memory: neighbouring generations are merged.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use oneiro_base::plain;

/// Points of a curve.
const POINTS: usize = 1024;
/// Bytes that are read at a time.
const PIECE: u64 = 8 << 20;

/// A column that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Value {
    pub(crate) column: &'static str,
    /// Its name for readers.
    pub(crate) label: &'static str,
    /// Whether merged rows have the maximum of it, or the mean.
    pub(crate) is_maximum: bool,
}

/// Rows of the table that are one point: their number, and the maximum or the sum of each value.
#[derive(Clone, Debug)]
struct Point {
    rows: u32,
    values: Vec<f64>,
}

/// A table, read so far.
#[derive(Debug)]
pub(crate) struct Curve {
    path: PathBuf,
    time: &'static str,
    values: Vec<Value>,
    /// Places of the time and of the values in a row.
    places: Vec<usize>,
    /// Bytes that were read, and the beginning of a row among them.
    read: u64,
    rest: Vec<u8>,
    /// Steps of a point.
    stride: u32,
    points: Vec<Point>,
}

impl Curve {
    pub(crate) fn new(directory: &Path, file: &str, time: &'static str, values: Vec<Value>) -> Self {
        Self {
            path: directory.join(file),
            time,
            values,
            places: Vec::new(),
            read: 0,
            rest: Vec::new(),
            stride: 1,
            points: Vec::new(),
        }
    }

    pub(crate) fn values(&self) -> &[Value] {
        &self.values
    }

    pub(crate) fn stride(&self) -> u32 {
        self.stride
    }

    /// Steps so far.
    pub(crate) fn steps(&self) -> u32 {
        self.points.len() as u32 * self.stride
    }

    /// Reads what was added. Returns whether there was anything. A run that was resumed may have cut its table: it is read again.
    pub(crate) fn update(&mut self) -> bool {
        self.try_update().unwrap_or(false)
    }

    fn try_update(&mut self) -> io::Result<bool> {
        let mut file = plain::open_table(&self.path)?;
        let length = file.metadata()?.len();
        if length < self.read {
            *self = Self {
                places: Vec::new(),
                read: 0,
                rest: Vec::new(),
                stride: 1,
                points: Vec::new(),
                path: std::mem::take(&mut self.path),
                values: std::mem::take(&mut self.values),
                time: self.time,
            };
        }
        if length == self.read {
            return Ok(false);
        }
        file.seek(SeekFrom::Start(self.read))?;
        let mut bytes = std::mem::take(&mut self.rest);
        self.read += file.take(PIECE).read_to_end(&mut bytes)? as u64;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        self.rest = bytes.split_off(whole);
        for line in String::from_utf8_lossy(&bytes).lines() {
            self.row(line);
        }
        Ok(true)
    }

    /// Takes a row; the first has the columns' names. A row that isn't one is left out.
    fn row(&mut self, line: &str) {
        let cells: Vec<&str> = line.split(',').collect();
        if self.places.is_empty() {
            let columns = std::iter::once(self.time).chain(self.values.iter().map(|value| value.column));
            let place = |name| cells.iter().position(|cell| *cell == name);
            self.places = columns.map_while(place).collect();
            return;
        }
        let mut numbers = self
            .places
            .iter()
            .map(|place| cells.get(*place).copied().unwrap_or_default());
        let Some(time) = numbers.next().and_then(|time| time.parse::<u32>().ok()) else {
            return;
        };
        let values: Vec<f64> = numbers.map(|value| value.parse().unwrap_or(f64::NAN)).collect();
        if values.len() == self.values.len() {
            self.add(time, &values);
        }
    }

    fn add(&mut self, time: u32, values: &[f64]) {
        while time / self.stride >= POINTS as u32 {
            self.coarsen();
        }
        let place = (time / self.stride) as usize;
        let none = Point {
            rows: 0,
            values: self
                .values
                .iter()
                .map(|value| if value.is_maximum { f64::NAN } else { 0.0 })
                .collect(),
        };
        if self.points.len() <= place {
            self.points.resize(place + 1, none);
        }
        let point = Point {
            rows: 1,
            values: values.to_vec(),
        };
        merge(&mut self.points[place], &point, &self.values);
    }

    /// Merges each two points.
    fn coarsen(&mut self) {
        self.points = merged(&self.points, 2, &self.values);
        self.stride *= 2;
    }

    /// Times and one value, in points of `stride` steps, which is a multiple of the curve's own.
    pub(crate) fn line(&self, value: usize, stride: u32) -> Vec<(f64, f64)> {
        let points = merged(&self.points, (stride / self.stride).max(1) as usize, &self.values);
        let middle = 0.5 * f64::from(stride - 1);
        let at = |(place, point): (usize, &Point)| {
            let own = point.values[value];
            let shown = if self.values[value].is_maximum {
                own
            } else {
                own / f64::from(point.rows)
            };
            (place as f64 * f64::from(stride) + middle, shown)
        };
        points
            .iter()
            .enumerate()
            .filter(|(_, point)| point.rows > 0)
            .map(at)
            .collect()
    }

    /// The maximum of the first value, or the last of its means.
    pub(crate) fn best(&self) -> Option<f64> {
        let line = self.line(0, self.stride);
        let numbers = line.iter().map(|(_, value)| *value).filter(|value| value.is_finite());
        if self.values[0].is_maximum {
            numbers.reduce(f64::max)
        } else {
            numbers.reduce(|_, last| last)
        }
    }
}

fn merged(points: &[Point], count: usize, values: &[Value]) -> Vec<Point> {
    let one = |points: &[Point]| {
        let (first, rest) = points.split_first()?;
        let mut first = first.clone();
        for point in rest {
            merge(&mut first, point, values);
        }
        Some(first)
    };
    points.chunks(count).filter_map(one).collect()
}

fn merge(into: &mut Point, point: &Point, values: &[Value]) {
    into.rows += point.rows;
    for ((own, other), value) in into.values.iter_mut().zip(&point.values).zip(values) {
        // The maximum of a number and NaN is the number.
        *own = if value.is_maximum {
            own.max(*other)
        } else {
            *own + other
        };
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const VALUES: [Value; 2] = [
        Value {
            column: "best",
            label: "best",
            is_maximum: true,
        },
        Value {
            column: "mean",
            label: "mean",
            is_maximum: false,
        },
    ];

    fn written(name: &str, text: &str) -> (PathBuf, Curve) {
        let folder = std::env::temp_dir().join(format!("oneiro-curve-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("generations.csv"), text).unwrap();
        let curve = Curve::new(&folder, "generations.csv", "generation", VALUES.to_vec());
        (folder, curve)
    }

    #[test]
    fn rows_are_read_as_they_come() {
        let (folder, mut curve) = written("rows", "generation,other,best,mean\n0,x,1.5,1\n1,x,NaN,0.");
        assert!(curve.update());
        assert_eq!(curve.line(0, 1), [(0.0, 1.5)]);
        fs::write(
            folder.join("generations.csv"),
            "generation,other,best,mean\n0,x,1.5,1\n1,x,NaN,0.5\n2,x,3,2\n",
        )
        .unwrap();
        assert!(curve.update());
        assert!(!curve.update(), "nothing was added");
        assert_eq!(curve.line(1, 1), [(0.0, 1.0), (1.0, 0.5), (2.0, 2.0)]);
        assert_eq!(curve.best(), Some(3.0));
        // A resumed run begins at its checkpoint.
        fs::write(
            folder.join("generations.csv"),
            "generation,other,best,mean\n0,x,1.5,1\n",
        )
        .unwrap();
        assert!(curve.update());
        assert_eq!(curve.line(0, 1), [(0.0, 1.5)]);
        fs::remove_dir_all(folder).unwrap();
    }

    /// A million generations are as many points as a thousand, with the maximum and the mean of those that are merged.
    #[test]
    fn a_long_run_takes_bounded_memory() {
        let (folder, mut curve) = written("long", "");
        curve.places = vec![0, 1, 2];
        for generation in 0..1_000_000 {
            curve.add(generation, &[f64::from(generation), 2.0]);
        }
        assert!(curve.points.len() <= POINTS && curve.points.len() > POINTS / 4);
        assert_eq!(curve.best(), Some(999_999.0));
        let means = curve.line(1, curve.stride());
        assert!(means.iter().all(|(_, mean)| *mean == 2.0));
        let (_, first) = curve.line(0, 2 * curve.stride())[0];
        assert_eq!(first, f64::from(2 * curve.stride() - 1));
        fs::remove_dir_all(folder).unwrap();
    }
}
