//! Pictures of a finished run: each is a file in the folder `pictures/` and a line of the list.

pub(super) mod archive;
mod learning_curve;
mod path;
mod race;

use oneiro::batch::Trace;
use oneiro::random::Key;
use oneiro_base::contents::Entry;
use oneiro_evolve::Champion;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_evolve::map_elites::Archive;
use oneiro_evolve::race::Round;

use super::Single;
use super::job::keys;
use super::rows::Row;
use crate::experiment::Experiment;

/// All pictures, in the order of a directory's description.
const PICTURES: &[Picture] = &[path::PICTURE, learning_curve::PICTURE, race::PICTURE, archive::PICTURE];

/// A picture of a finished run.
pub(super) struct Picture {
    /// Its file.
    pub(super) name: &'static str,
    /// What it shows, for a directory's description.
    about: &'static str,
    /// Its caption on the run's page, and whether it shows the champion or else the evolution.
    pub(super) caption: &'static str,
    pub(super) is_of_champion: bool,
    /// Whether a run has it.
    is_drawn: fn(&Single) -> bool,
    /// Draws it as SVG, unless the run lacks what it shows.
    draw: fn(&Drawn<'_>) -> Option<String>,
}

/// A finished run, whose pictures are drawn.
pub(super) struct Drawn<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) seed: u64,
    pub(super) champion: &'a Champion,
    /// Those that were re-evaluated at the end, the luckiest first, and the mean of each.
    pub(super) finalists: &'a [Champion],
    pub(super) appraisals: &'a [Appraisal],
    /// The champion's mean; none without finalists.
    pub(super) appraisal: Option<Appraisal>,
    /// The champion's first episode.
    pub(super) trace: Option<&'a Trace>,
    /// The table of generations.
    pub(super) rows: &'a [Row],
    /// Episodes spent after each generation.
    pub(super) spent: &'a [u64],
    /// Generations of a race.
    pub(super) rounds: &'a [Round],
    /// The elites, if the optimiser keeps some.
    pub(super) archive: Option<&'a Archive>,
}

impl Drawn<'_> {
    /// The key of the champion's first episode.
    pub(super) fn first_key(&self) -> Key {
        let Champion {
            generation, individual, ..
        } = *self.champion;
        let mut keys = keys(self.experiment.settings(), self.seed, generation, individual);
        keys.next().unwrap_or_default()
    }
}

impl Drawn<'_> {
    /// The finalists with their means.
    pub(super) fn appraised(&self) -> impl Iterator<Item = (&Champion, Appraisal)> {
        self.finalists.iter().zip(self.appraisals.iter().copied())
    }
}

/// All pictures of a run, as SVG.
pub(super) fn all(run: &Drawn<'_>) -> Vec<(&'static Picture, String)> {
    let draw = |picture: &'static Picture| Some((picture, (picture.draw)(run)?));
    PICTURES.iter().filter_map(draw).collect()
}

/// Their description in a run's directory; all pictures without a run.
pub(super) fn entries(single: Option<&Single>) -> impl Iterator<Item = Entry> {
    let is_drawn = move |picture: &&Picture| single.is_none_or(|single| (picture.is_drawn)(single));
    let pictures = PICTURES.iter().filter(is_drawn);
    pictures.map(|picture| Entry::file(picture.name, picture.about))
}
