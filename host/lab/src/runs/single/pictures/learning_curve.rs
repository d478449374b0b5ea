//! Fitness over the generations.

use oneiro_report::figures::{self, Series};

use super::super::rows::Row;
use super::Picture;

pub(super) const PICTURE: Picture = Picture {
    name: "learning-curve.svg",
    about: "a picture of the evolution",
    caption: "Scores in each generation; those of the best are too high by luck.",
    is_of_champion: false,
    is_drawn: |_| true,
    draw: |run| {
        let series = |label, value: fn(&Row) -> f64| Series {
            label,
            values: run.rows.iter().map(value).collect(),
        };
        let title = format!("{}, seed {}", run.experiment.name(), run.seed);
        let peak = format!("mean of the best {}", run.experiment.settings().evolution.best());
        let lines = [
            series("best", |row| f64::from(row.best)),
            series(&peak, |row| row.peak),
            series("mean", |row| row.mean),
        ];
        Some(figures::learning_curve(&title, "fitness", &lines, Some(run.spent)))
    },
};
