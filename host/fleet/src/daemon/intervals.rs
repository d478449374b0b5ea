//! What is saved of a member of a swarm, and the table of its intervals.

use std::fmt::Write;

use oneiro_base::contents::{Column, head};
use oneiro_lab::exchange::radio::Windows;
use oneiro_lab::swarm::tables::{CHOSEN_UNDER, HEARD, ROBOT, SIMULATOR, TAKEN, WITH_FOOD, WITHOUT_FOOD};
use serde::{Deserialize, Serialize};

use super::keeper::Kept;
use super::member::{Ended, MemberState};

/// The table of intervals: its file, and its columns.
pub(crate) const INTERVALS: &str = "intervals.csv";
pub(crate) static INTERVALS_COLUMNS: [Column; 12] = [
    Column::whole("interval", "", "its number, from 0, by the robot's clock"),
    ROBOT,
    SIMULATOR,
    CHOSEN_UNDER,
    WITH_FOOD,
    WITHOUT_FOOD,
    Column::number("real", "", "its fitness during this interval"),
    Column::whole(
        "brought",
        "items",
        "food that it brought during this interval, by the tracker",
    ),
    Column::number(
        "simulated",
        "",
        "the same controller's fitness in the simulator in which it was chosen; empty if there is none",
    ),
    HEARD,
    TAKEN,
    Column::whole(
        "missed",
        "",
        "1 if the daemon missed a part of it, so that nothing evolved, else 0",
    ),
];

/// What is saved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Saved {
    /// Times that the daemon has been started.
    pub boots: u32,
    /// The robot between two intervals.
    pub state: MemberState,
    /// Its intervals so far.
    pub ended: Vec<Ended>,
    /// The received datagrams.
    pub windows: Windows,
}

impl Saved {
    /// A robot that is started for the first time.
    pub(crate) fn new(state: MemberState) -> Self {
        Self {
            boots: 1,
            state,
            ended: Vec::new(),
            windows: Windows::default(),
        }
    }

    /// The table of intervals.
    fn table(&self) -> String {
        let mut text = head(&INTERVALS_COLUMNS);
        for interval in &self.ended {
            let simulated = interval
                .simulated
                .map(|fitness| fitness.to_string())
                .unwrap_or_default();
            let [g0, g1] = interval.controller;
            let (taken, missed) = (u8::from(interval.taken), u8::from(interval.missed));
            // Writing to a string can't fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{g0},{g1},{},{},{simulated},{},{taken},{missed}",
                interval.interval,
                interval.robot,
                interval.simulator,
                interval.chosen_under,
                interval.real,
                interval.brought,
                interval.heard
            );
        }
        text
    }
}

impl Kept for Saved {
    const NAME: &'static str = "daemon";

    fn notes(&self) -> Vec<(&'static str, Vec<u8>)> {
        vec![(INTERVALS, self.table().into_bytes())]
    }
}
