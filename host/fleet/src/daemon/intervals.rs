//! What is saved of a member of a swarm, and the table of its intervals.

use std::fmt::Write;

use oneiro_base::contents::{Column, head};
use oneiro_lab::exchange::radio::Windows;
use oneiro_lab::swarm::tables::{CHOSEN_UNDER, HEARD, ROBOT, SIMULATOR, TAKEN, WITH_FOOD, WITHOUT_FOOD};
use serde::{Deserialize, Serialize};

use super::keeper::Kept;
use super::member::{Ended, State};

/// The table of intervals: its file, and its columns.
pub const INTERVALS: &str = "intervals.csv";
pub static INTERVALS_COLUMNS: [Column; 12] = [
    Column::whole("interval", "", "its number, from 0, by the robot's own clock"),
    ROBOT,
    SIMULATOR,
    CHOSEN_UNDER,
    WITH_FOOD,
    WITHOUT_FOOD,
    Column::number("real", "", "its fitness during this interval"),
    Column::whole(
        "brought",
        "items",
        "food that it brought during this interval, as far as the tracker told",
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
        "1 if the daemon did not live through all of it, so that nothing evolved, else 0",
    ),
];

/// What is saved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Saved {
    /// Times that the daemon has been started.
    pub boots: u32,
    /// The robot between two intervals.
    pub state: State,
    /// Its intervals so far.
    pub ended: Vec<Ended>,
    /// The datagrams that were taken.
    pub windows: Windows,
}

impl Saved {
    /// A robot that is started for the first time.
    pub fn new(state: State) -> Self {
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
        for own in &self.ended {
            let simulated = own.simulated.map(|fitness| fitness.to_string()).unwrap_or_default();
            let [g0, g1] = own.controller;
            let (taken, missed) = (u8::from(own.taken), u8::from(own.missed));
            // Writing to a string can't fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{g0},{g1},{},{},{simulated},{},{taken},{missed}",
                own.interval, own.robot, own.simulator, own.chosen_under, own.real, own.brought, own.heard
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
