//! The text formats of sampled tables: Evorobot's `.sam` and evorobotpy2's `.sample`.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::str::FromStr;

use super::{Error, GREATEST_READING, GREATEST_SENSORS, Import, MotorSamples, SensorTable};

/// Format of a sensor table's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.sam`: integers from 0 to 1023.
    Sam,
    /// `.sample`: the same integers divided by 1023, with six decimals.
    Sample,
}

impl Format {
    /// Format named by a path's extension.
    ///
    /// # Errors
    /// Another extension.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some(sam) if sam.eq_ignore_ascii_case("sam") => Ok(Self::Sam),
            Some(sample) if sample.eq_ignore_ascii_case("sample") => Ok(Self::Sample),
            _ => Err(fault(
                path,
                None,
                "the extension names no table format; allowed: .sam, .sample",
            )),
        }
    }
}

fn fault(path: &Path, line: Option<usize>, problem: impl Into<String>) -> Error {
    Error {
        path: path.to_owned(),
        line,
        problem: problem.into(),
    }
}

pub(super) fn load(path: &Path) -> Result<String, Error> {
    /// Largest file, bytes: the largest table has about 230 million numbers of up to five characters.
    const LARGEST: u64 = 2 << 30;
    let refused = |problem: String| fault(path, None, format!("can't be read: {problem}"));
    let metadata = std::fs::metadata(path).map_err(|error| refused(error.to_string()))?;
    // A pipe or a device may have no end.
    if !metadata.is_file() || metadata.len() > LARGEST {
        return Err(refused(format!("allowed: a file of up to {LARGEST} bytes")));
    }
    std::fs::read_to_string(path).map_err(|error| refused(error.to_string()))
}

/// Writes a file that must not exist yet.
pub(super) fn save(path: &Path, text: &str) -> Result<(), Error> {
    std::fs::File::create_new(path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| fault(path, None, format!("can't be written: {error}")))
}

/// The non-empty lines of a file, with their numbers.
struct Lines<'a> {
    path: &'a Path,
    numbered: std::iter::Enumerate<std::str::Lines<'a>>,
    last: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, path: &'a Path) -> Self {
        Self {
            path,
            numbered: text.lines().enumerate(),
            last: 0,
        }
    }

    fn next(&mut self) -> Option<&'a str> {
        for (index, line) in &mut self.numbered {
            let line = line.trim();
            if !line.is_empty() {
                self.last = index + 1;
                return Some(line);
            }
        }
        None
    }

    /// Next line; `what` describes the expected line for the error.
    fn expect(&mut self, what: impl Fn() -> String) -> Result<&'a str, Error> {
        self.next()
            .ok_or_else(|| fault(self.path, None, format!("ends early; missing: {}", what())))
    }

    fn fault(&self, problem: impl Into<String>) -> Error {
        fault(self.path, Some(self.last), problem)
    }

    /// Parses and checks a line of as many numbers; `allowed` describes the whole line for the error.
    fn numbers<T: FromStr>(
        &self,
        line: &str,
        count: usize,
        allowed: &str,
        good: impl Fn(&T) -> bool,
    ) -> Result<Vec<T>, Error> {
        let numbers = self.all_numbers(line, allowed, good)?;
        if numbers.len() != count {
            return Err(self.fault(format!("{} numbers; allowed: {allowed}", numbers.len())));
        }
        Ok(numbers)
    }

    fn all_numbers<T: FromStr>(&self, line: &str, allowed: &str, good: impl Fn(&T) -> bool) -> Result<Vec<T>, Error> {
        line.split_ascii_whitespace()
            .map(|word| {
                word.parse().ok().filter(&good).ok_or_else(|| {
                    let shown: String = word.chars().take(24).collect();
                    self.fault(format!("`{shown}`; allowed: {allowed}"))
                })
            })
            .collect()
    }
}

const HEADER: &str = "sensors 1 to 64, bearings 4 to 3600, rows 1 to 1000, nearest 0 to 10000 mm, spacing 0.01 to 1000 mm, \
                      and of an object that was sampled from several points of view their number, 2 to 64";

pub(super) fn parse_sensors(text: &str, path: &Path, format: Format) -> Result<Import<SensorTable>, Error> {
    let mut lines = Lines::new(text, path);
    let mut warnings = Vec::new();
    let mut warn = |line: usize, warning: String| warnings.push(format!("{}, line {line}: {warning}", path.display()));

    let header = lines.expect(|| format!("a first line with {HEADER}"))?;
    let mut numbers = lines.all_numbers::<f32>(header, HEADER, |n| n.is_finite())?;
    if numbers.len() == 5 {
        numbers.push(1.0);
    }
    let [sensors, bearings, rows, nearest, spacing, views] = numbers[..] else {
        return Err(lines.fault(format!("{} numbers; allowed: {HEADER}", numbers.len())));
    };
    let whole = |n: f32, least: f32, most: f32| n.fract() == 0.0 && (least..=most).contains(&n);
    if !whole(sensors, 1.0, GREATEST_SENSORS as f32)
        || !whole(bearings, 4.0, 3600.0)
        || !whole(rows, 1.0, 1000.0)
        || !(0.0..=10_000.0).contains(&nearest)
        || !(0.01..=1000.0).contains(&spacing)
        || !whole(views, 1.0, 64.0)
    {
        return Err(lines.fault(format!("`{header}`; allowed: {HEADER}")));
    }
    let (bearings, rows, views) = (bearings as u32, rows as u32, views as u32);
    let count = sensors as usize;
    let allowed = match format {
        Format::Sam => format!("{count} integers from 0 to {GREATEST_READING}"),
        Format::Sample => format!("{count} numbers from 0 to 1"),
    };

    let mut readings = Vec::new();
    let mut rounded = 0_usize;
    let all_rows = views * rows;
    for row in 0..all_rows {
        let heading = lines.expect(|| format!("`TURN {row}`, the first line of row {row} of {all_rows}"))?;
        let number = heading.strip_prefix("TURN").map(str::trim);
        match number {
            None => {
                return Err(lines.fault(format!(
                    "`{heading}`; allowed: `TURN {row}`, since row {row} begins here"
                )));
            }
            Some(number) if number.parse() == Ok(row) => {}
            Some(number) => warn(lines.last, format!("`TURN {number}` heads row {row}; read as that row")),
        }
        for bearing in 0..bearings {
            let line = lines.expect(|| format!("bearing {bearing} of {bearings} in row {row} of {all_rows}"))?;
            match format {
                Format::Sam => readings.extend(lines.numbers(line, count, &allowed, |n: &u16| *n <= GREATEST_READING)?),
                Format::Sample => {
                    let shares = lines.numbers::<f64>(line, count, &allowed, |n| (0.0..=1.0).contains(n))?;
                    readings.extend(shares.into_iter().map(|share| {
                        let exact = share * f64::from(GREATEST_READING);
                        let reading = (exact + 0.5).floor();
                        // Six decimals determine a reading to within 0.0005.
                        rounded += usize::from((exact - reading).abs() > 0.001);
                        reading as u16
                    }));
                }
            }
        }
    }
    match lines.next() {
        Some("END") => {
            if let Some(line) = lines.next() {
                return Err(lines.fault(format!(
                    "`{}` after END; allowed: nothing",
                    line.chars().take(24).collect::<String>()
                )));
            }
        }
        Some(line) => {
            let shown: String = line.chars().take(24).collect();
            return Err(lines.fault(format!("`{shown}` after the last of {all_rows} rows; allowed: END")));
        }
        None => return Err(fault(path, None, "ends early; missing: END")),
    }
    if rounded > 0 {
        warnings.push(format!(
            "{}: {rounded} readings are no multiples of 1/1023; they are rounded",
            path.display()
        ));
    }
    let class = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default();
    Ok(Import {
        table: SensorTable {
            class,
            sensors: count as u32,
            rows,
            bearings,
            nearest,
            spacing,
            views,
            readings,
        },
        warnings,
    })
}

pub(super) fn print_sensors(table: &SensorTable, format: Format) -> String {
    let mut text = format!(
        "{} {} {} {} {}",
        table.sensors, table.bearings, table.rows, table.nearest, table.spacing
    );
    // Writing to a string can't fail.
    if table.views > 1 {
        let _ = write!(text, " {}", table.views);
    }
    text.push('\n');
    let sensors = table.sensors.max(1) as usize;
    let bearings = table.bearings.max(1) as usize;
    for (row, cells) in table.readings.chunks(bearings * sensors).enumerate() {
        let _ = writeln!(text, "TURN {row}");
        for cell in cells.chunks(sensors) {
            for (sensor, reading) in cell.iter().enumerate() {
                let space = if sensor == 0 { "" } else { " " };
                let _ = match format {
                    Format::Sam => write!(text, "{space}{reading}"),
                    Format::Sample => write!(text, "{space}{:.6}", f64::from(*reading) / f64::from(GREATEST_READING)),
                };
            }
            text.push('\n');
        }
    }
    text.push_str("END\n");
    text
}

/// Speeds of a motor file with `count` of them.
pub(super) fn speeds(count: usize) -> Vec<i32> {
    let greatest = (count / 2) as i32;
    (-greatest..=greatest)
        .filter(|&speed| speed != 0 || count % 2 == 1)
        .collect()
}

pub(super) fn parse_motors(text: &str, path: &Path) -> Result<MotorSamples, Error> {
    const ALLOWED: &str = "2 to 255 numbers, the same count on each line: changes of heading from -180 to 180 degrees, \
                           then displacements from -100 to 100 cm, each with a line per speed of the left wheel";
    let mut lines = Lines::new(text, path);
    let first = lines.expect(|| ALLOWED.to_owned())?;
    let count = lines
        .all_numbers::<f32>(first, ALLOWED, |number| number.is_finite())?
        .len();
    if !(2..=255).contains(&count) {
        return Err(lines.fault(format!("{count} numbers; allowed: {ALLOWED}")));
    }
    let speeds = speeds(count);
    let mut line = Some(first);
    let mut table = |what: &str, most: f32| {
        let mut cells = Vec::with_capacity(count * count);
        for left in &speeds {
            let numbers = match line.take() {
                Some(line) => line,
                None => lines.expect(|| format!("the {what} for the left wheel's speed {left}, of {count} speeds"))?,
            };
            let row = lines.all_numbers(numbers, ALLOWED, |n: &f32| n.abs() <= most)?;
            if row.len() != count {
                return Err(lines.fault(format!(
                    "{} numbers where the first line has {count}; allowed: {ALLOWED}",
                    row.len()
                )));
            }
            // Zero has one sign.
            cells.extend(row.into_iter().map(|n| if n == 0.0 { 0.0 } else { n }));
        }
        Ok(cells)
    };
    let degrees = table("changes of heading", 180.0)?;
    let centimetres = table("displacements", 100.0)?;
    match lines.next() {
        None => Ok(MotorSamples {
            speeds,
            degrees,
            centimetres,
        }),
        Some(_) => Err(lines.fault(format!(
            "a line after the {} of {count} speeds; allowed: {ALLOWED}",
            2 * count
        ))),
    }
}

pub(super) fn print_motors(samples: &MotorSamples) -> String {
    let mut text = String::new();
    let count = samples.speeds.len().max(1);
    for row in samples.degrees.chunks(count).chain(samples.centimetres.chunks(count)) {
        let row: Vec<String> = row.iter().map(f32::to_string).collect();
        text.push_str(&row.join("\t"));
        text.push('\n');
    }
    text
}
