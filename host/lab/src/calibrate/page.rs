//! The page of a calibration.

use oneiro_base::console::counted;
use oneiro_report::figures::{Band, Panel, Spread, escaped, grid};
use oneiro_report::numbers::{Digits, in_figure, shown};
use oneiro_report::page::{Cell, Head, Row, Section, document, facts, figure, paragraph, table};
use oneiro_statistics::{mean, quantile};

use super::Calibration;
use super::readings::{Errors, RANGES, SensorErrors};

/// Bins of predicted activations in the figure.
const BINS: usize = 10;
/// Panels of the figure side by side.
const ABREAST: usize = 4;
const COLOUR: &str = "#2b3a8f";
/// Colour and dashes of the line of readings that are as predicted.
const SOFT: &str = "#6b6e76";
const EQUAL: &str = "4 4";

/// The page as HTML. `settings` is the text of [`Calibration::settings`].
pub fn page(name: &str, calibration: &Calibration, settings: &str) -> String {
    let Calibration {
        readings,
        lives,
        cycles,
        ..
    } = calibration;
    let lead = paragraph(&format!(
        "How well the simulator of {name} predicts the robot, by {cycles} cycles of {}. Errors are what the robot read, \
         as an activation from 0 to 1, minus what the simulator reads at the same place.",
        counted(*lives, "recorded episode", "recorded episodes")
    ));
    let age = facts(&[
        ("cycles compared", readings.compared.to_string()),
        (
            "cycles left out: at the recorded pose the body would touch something",
            readings.left_out.to_string(),
        ),
        ("age of readings", format!("{:.0} ms", 1000.0 * readings.age)),
    ]);
    let sensors = figure(
        "Figure 1",
        "Activation of each sensor (up) by what the simulator predicts (across): the mean, and the range of 90 % of readings.",
        &panels(&readings.sensors),
    );
    let errors = table(
        "Table 1",
        "Size of the error (root of the mean square) by the free distance to the nearest object, and mean and standard deviation of all.",
        &heads(),
        &readings.sensors.iter().map(row).collect::<Vec<_>>(),
    );
    let lines = settings.lines().map(|line| escaped(line) + "\n").collect::<String>();
    let settings = format!(
        "{}<pre>{lines}</pre>\n",
        paragraph("With these settings, the simulator's errors spread as the robot's do. Nothing has been changed."),
    );
    let sections = [
        Section::new("readings", "Readings", age + &sensors + &errors),
        Section::new("moves", "Moves", moves(calibration)),
        Section::new("settings", "Settings that follow", settings),
    ];
    document(&format!("Calibration of {name}"), &lead, &sections)
}

fn moves(calibration: &Calibration) -> String {
    let Some(moves) = &calibration.moves else {
        return paragraph("The robot has no odometers, or nothing moved: its moves can't be compared.");
    };
    let [left, right] = moves.gains;
    let [left_deviation, right_deviation] = moves.deviation;
    facts(&[
        (
            "speed of the left wheel, as a fraction of the commanded one",
            in_figure(left, Digits::Four),
        ),
        (
            "speed of the right wheel, as a fraction of the commanded one",
            in_figure(right, Digits::Four),
        ),
        ("right over left", in_figure(right / left, Digits::Four)),
        (
            "time from a command to its effect",
            format!("{:.0} ms", 1000.0 * moves.latency),
        ),
        (
            "standard deviation of the left wheel's travel in a cycle",
            format!("{} mm", in_figure(left_deviation, Digits::Three)),
        ),
        (
            "standard deviation of the right wheel's travel in a cycle",
            format!("{} mm", in_figure(right_deviation, Digits::Three)),
        ),
        (
            "standard deviation of a moving wheel's travel, as a fraction of the expected travel",
            in_figure(moves.relative, Digits::Three),
        ),
    ])
}

fn heads() -> Vec<Head<'static>> {
    let ranges = RANGES.iter().map(|(_, name)| Head::Number(name));
    let all = ["mean of all", "deviation of all"].map(Head::Number);
    [Head::Text("sensor")].into_iter().chain(ranges).chain(all).collect()
}

fn row(sensor: &SensorErrors) -> Row {
    let number = |x: f64| Cell::number(shown(x, Digits::Three));
    let (all, ranges) = sensor.at.split_last().expect("all is the last");
    let size = |errors: &Errors| number(if errors.count < 2 { f64::NAN } else { errors.size() });
    let cells = [Cell::name(&sensor.name)].into_iter().chain(ranges.iter().map(size));
    cells
        .chain([number(all.mean), number(all.deviation)])
        .collect::<Vec<_>>()
        .into()
}

/// A panel for each sensor.
fn panels(sensors: &[SensorErrors]) -> String {
    let most_of = |own: &[f64]| Spread {
        low: quantile(own, 0.05),
        mean: mean(own),
        high: quantile(own, 0.95),
    };
    let panel = |sensor: &SensorErrors| -> Vec<(f64, Spread)> {
        let mut bins = vec![Vec::new(); BINS];
        for [predicted, read] in &sensor.pairs {
            bins[((predicted * BINS as f64) as usize).min(BINS - 1)].push(*read);
        }
        let middle = |bin: usize| (bin as f64 + 0.5) / BINS as f64;
        let filled = bins.into_iter().enumerate().filter(|(_, own)| !own.is_empty());
        filled.map(|(bin, own)| (middle(bin), most_of(&own))).collect()
    };
    let panels: Vec<Panel<'_>> = sensors
        .iter()
        .map(|sensor| Panel {
            title: &sensor.name,
            across: "predicted",
            up: "read",
            key: &[(EQUAL, "equal")],
            bands: vec![
                Band {
                    label: "",
                    colour: SOFT,
                    dash: EQUAL,
                    values: [0.0, 1.0]
                        .map(|value| {
                            (
                                value,
                                Spread {
                                    low: value,
                                    mean: value,
                                    high: value,
                                },
                            )
                        })
                        .into(),
                },
                Band {
                    label: "",
                    colour: COLOUR,
                    dash: "",
                    values: panel(sensor),
                },
            ],
            ..Panel::default()
        })
        .collect();
    grid(
        "Readings by what was predicted",
        &panels.chunks(ABREAST).collect::<Vec<_>>(),
    )
}
