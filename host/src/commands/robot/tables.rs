//! `oneiro robot tables`: shows, converts and exports sampled sensor and motor tables.

use std::path::Path;

use oneiro::tables::{self, Format, GREATEST_READING, MotorSamples, SensorTable, SensorTables};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_report::figures;
use oneiro_report::numbers::fixed;
use serde::Serialize;
use serde_json::json;

use crate::cli::RobotTables;

/// Runs the subcommand.
pub(crate) fn run(command: &RobotTables, console: Console) -> Result {
    match command {
        RobotTables::Show { table, out } => show(table, out.as_deref(), console),
        RobotTables::Convert { from, to } => write(&read(from, console)?, to, console),
        RobotTables::Export { builtin, to } => {
            let table = built_in(builtin).ok_or_else(|| {
                Failure::input(format_args!(
                    "--builtin {builtin}: no such table; allowed: {}",
                    built_in_names()
                ))
            })?;
            write(&table, to, console)
        }
    }
}

/// A table of either kind.
enum Table {
    Sensors(SensorTable),
    Motors(MotorSamples),
}

/// Looks up a compiled-in table.
fn built_in(name: &str) -> Option<Table> {
    if name == "motor" {
        return Some(Table::Motors(MotorSamples::khepera()));
    }
    let tables = SensorTables::khepera();
    let class = tables.class(name)?;
    Some(Table::Sensors(tables.classes[class].clone()))
}

fn built_in_names() -> String {
    let mut names: Vec<String> = SensorTables::khepera()
        .classes
        .iter()
        .map(|table| table.class.clone())
        .collect();
    names.push("motor".to_owned());
    names.join(", ")
}

/// Reads a table. A file with `TURN` lines holds sensors, one without holds motors.
fn read(path: &Path, console: Console) -> Result<Table> {
    let is_motors = files::as_text(path, files::bytes(path)?)?
        .lines()
        .all(|line| !line.trim_start().starts_with("TURN"));
    if is_motors && Format::of(path).map_err(refused)? == Format::Sam {
        return MotorSamples::read(path).map(Table::Motors).map_err(refused);
    }
    let import = SensorTable::read(path).map_err(refused)?;
    console.warn(import.warnings);
    Ok(Table::Sensors(import.table))
}

/// Exit 3, for a table that can't be read or an unknown extension.
fn refused(error: tables::Error) -> Failure {
    Failure::input(error)
}

/// Writes a table to a new file.
fn write(table: &Table, to: &Path, console: Console) -> Result {
    let format = Format::of(to).map_err(refused)?;
    let text = match table {
        Table::Sensors(table) => table.text_in(format),
        Table::Motors(_) if format != Format::Sam => {
            return Err(Failure::input(format_args!(
                "{}: motor samples have only one format; allowed: .sam",
                to.display()
            )));
        }
        Table::Motors(samples) => samples.text(),
    };
    files::write_new(to, text.as_bytes())?;
    console.say(format!("wrote {}", to.display()));
    Ok(())
}

fn show(name: &Path, out: Option<&Path>, console: Console) -> Result {
    let built_in = if name.exists() {
        None
    } else {
        name.to_str().and_then(built_in)
    };
    let table = match built_in {
        Some(table) => table,
        None if !name.exists() => {
            let allowed = built_in_names();
            return Err(Failure::input(format_args!(
                "{}: no such file or built-in table; allowed: a .sam or .sample file, {allowed}",
                name.display()
            )));
        }
        None => read(name, console)?,
    };
    match table {
        Table::Sensors(table) => console.print_answer(&show_sensors(&table, out)?),
        Table::Motors(_) if out.is_some() => Err(Failure::input(
            "--out: only sensor tables have a picture; show motors without it",
        )),
        Table::Motors(samples) => console.print_answer(&show_motors(&samples)),
    }
}

/// Key figures of one sensor in a table.
#[derive(Debug, Serialize)]
struct Moments {
    /// Point of view, if the object was sampled from several.
    view: usize,
    sensor: usize,
    /// Centre of the bearings that it sees, degrees clockwise.
    bearing_degrees: f64,
    /// Distance at which its highest reading falls below half of the maximum.
    half_mm: Option<f64>,
    /// Distance at which its highest reading falls below a twentieth of the maximum.
    twentieth_mm: Option<f64>,
    /// Width of the bearings that read at least a half, at three distances.
    width_degrees: [f64; 3],
}

/// The distances of [`Moments::width_degrees`], mm.
const WIDTHS_AT: [f32; 3] = [9.0, 15.0, 21.0];

fn moments(table: &SensorTable, view: usize, sensor: usize) -> Moments {
    let (rows, bearings) = (table.rows as usize, table.bearings as usize);
    let reading = |row: usize, bearing: usize| f64::from(table.cell((view * rows + row) * bearings + bearing)[sensor]);
    let degrees = 360.0 / bearings as f64;
    let half = 0.5 * f64::from(GREATEST_READING);

    // The mean bearing is relative to the strongest one, so the start of the turn doesn't matter.
    let profile: Vec<f64> = (0..bearings)
        .map(|bearing| (0..rows).map(|row| reading(row, bearing)).sum())
        .collect();
    let strongest = (0..bearings).fold(0, |best, bearing| {
        if profile[bearing] > profile[best] {
            bearing
        } else {
            best
        }
    });
    let offset =
        |bearing: usize| ((bearing + bearings + bearings / 2 - strongest) % bearings) as f64 - (bearings / 2) as f64;
    let total: f64 = profile.iter().sum();
    let weighed: f64 = (0..bearings).map(|bearing| profile[bearing] * offset(bearing)).sum();
    let mean = strongest as f64 + if total > 0.0 { weighed / total } else { 0.0 };
    let clockwise = mean * degrees;
    let bearing_degrees = clockwise - 360.0 * ((clockwise + 180.0) / 360.0).floor();

    let highest: Vec<f64> = (0..rows)
        .map(|row| (0..bearings).map(|bearing| reading(row, bearing)).fold(0.0, f64::max))
        .collect();
    let falls_below = |level: f64| {
        let row = highest
            .windows(2)
            .position(|pair| pair[0] >= level && level > pair[1])?;
        let part = (highest[row] - level) / (highest[row] - highest[row + 1]);
        Some(f64::from(table.nearest) + f64::from(table.spacing) * (row as f64 + part))
    };
    let width = |at: f32| {
        let row = ((at - table.nearest) / table.spacing).max(0.0) as usize;
        if row >= rows {
            return 0.0;
        }
        (0..bearings).filter(|&bearing| reading(row, bearing) >= half).count() as f64 * degrees
    };
    Moments {
        view,
        sensor,
        bearing_degrees,
        half_mm: falls_below(half),
        twentieth_mm: falls_below(0.1 * half),
        width_degrees: WIDTHS_AT.map(width),
    }
}

fn show_sensors(table: &SensorTable, out: Option<&Path>) -> Result<Answer> {
    let mut messages = Vec::new();
    if let Some(path) = out {
        files::must_be_svg("--out", path)?;
        files::write_new(path, figures::sensor_table(table).as_bytes())?;
        messages.push(format!("drew {}", path.display()));
    }
    let moments: Vec<Moments> = (0..table.views as usize)
        .flat_map(|view| (0..table.sensors as usize).map(move |sensor| moments(table, view, sensor)))
        .collect();
    let value = json!({
        "class": table.class,
        "sensor_count": table.sensors,
        "rows": table.rows,
        "bearings": table.bearings,
        "nearest_mm": table.nearest,
        "spacing_mm": table.spacing,
        "views": table.views,
        "widths_at_mm": WIDTHS_AT,
        "sensors": moments,
    });
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| fixed(value, 1));
    let rows: Vec<Vec<String>> = moments
        .iter()
        .map(|moments| {
            let mut row = vec![
                moments.view.to_string(),
                moments.sensor.to_string(),
                fixed(moments.bearing_degrees, 0),
                number(moments.half_mm),
                number(moments.twentieth_mm),
            ];
            row.extend(moments.width_degrees.iter().map(|width| fixed(*width, 0)));
            row
        })
        .collect();
    let head = [
        "view",
        "sensor",
        "bearing deg",
        "50 % mm",
        "5 % mm",
        "width at 9 mm",
        "15 mm",
        "21 mm",
    ];
    let text = format!(
        "{}: {}, {} distances from {} mm in steps of {} mm, {} bearings, {}\n\n{}",
        table.class,
        counted(table.sensors, "sensor", "sensors"),
        table.rows,
        table.nearest,
        table.spacing,
        table.bearings,
        counted(table.views, "point of view", "points of view"),
        columns(&head, &rows)
    );
    Ok(Answer {
        messages,
        ..Answer::new(text, value)
    })
}

fn show_motors(samples: &MotorSamples) -> Answer {
    let count = samples.speeds.len();
    let greatest = |values: &[f32]| values.iter().fold(0.0_f32, |greatest, value| greatest.max(value.abs()));
    let (first, last) = (
        samples.speeds.first().copied().unwrap_or(0),
        samples.speeds.last().copied().unwrap_or(0),
    );
    let (degrees, centimetres) = (greatest(&samples.degrees), greatest(&samples.centimetres));
    let text = format!(
        "motor: {count} x {count} pairs of speeds from {first} to {last}\n\
         in one cycle at most {:.2} mm and {degrees:.2} degrees\n",
        10.0 * centimetres
    );
    let value = json!({
        "speeds": samples.speeds,
        "degrees": samples.degrees,
        "centimetres": samples.centimetres,
    });
    Answer::new(text, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three sensors, of which the last sees from 80 to 100 degrees, fully at the nearest distance and half of it at the next.
    fn table() -> SensorTable {
        let mut readings = vec![0; 3 * 3 * 36];
        for bearing in 8..=10 {
            readings[3 * bearing + 2] = 1000;
            readings[3 * (36 + bearing) + 2] = 500;
        }
        SensorTable {
            class: "wall".into(),
            sensors: 3,
            rows: 3,
            bearings: 36,
            nearest: 5.0,
            spacing: 2.0,
            views: 1,
            readings,
        }
    }

    #[test]
    fn moments_are_those_of_the_readings() {
        let moments = moments(&table(), 0, 2);
        assert!((moments.bearing_degrees - 90.0).abs() < 1e-9, "{moments:?}");
        let half = 5.0 + 2.0 * (1000.0 - 511.5) / 500.0;
        assert!((moments.half_mm.unwrap() - half).abs() < 1e-9, "{moments:?}");
        assert!((moments.twentieth_mm.unwrap() - (7.0 + 2.0 * (500.0 - 51.15) / 500.0)).abs() < 1e-9);
        assert_eq!(moments.width_degrees, [0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_blind_sensor_has_no_distances() {
        let moments = moments(&table(), 0, 0);
        assert_eq!((moments.half_mm, moments.twentieth_mm), (None, None));
        assert!(moments.bearing_degrees.is_finite());
    }

    #[test]
    fn bearings_across_the_back_have_their_mean_there() {
        let mut table = table();
        table.readings.fill(0);
        for bearing in [17, 18, 19] {
            table.readings[3 * bearing + 1] = 900;
        }
        let moments = moments(&table, 0, 1);
        assert!((moments.bearing_degrees.abs() - 180.0).abs() < 1e-9, "{moments:?}");
    }

    #[test]
    fn built_in_tables_have_names() {
        assert_eq!(built_in_names(), "wall, round, motor");
        assert!(built_in("wall").is_some() && built_in("motor").is_some() && built_in("lamp").is_none());
    }
}
