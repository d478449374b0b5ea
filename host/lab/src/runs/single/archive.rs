//! The files of an archive of elites: tables of its cells and of its growth, its genomes, and a picture.

use std::fmt::Write;

use oneiro_base::contents::{Column, head};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::npy::npy;
use oneiro_evolve::Champion;
use oneiro_evolve::map_elites::{Archive, Elite};

use super::{ARCHIVE, ARCHIVE_GENES, Recorded};
use crate::experiment::Experiment;
use crate::genomes;

/// Columns of the table of the archive's growth.
pub(super) static GROWTH: [Column; 5] = [
    Column::whole("generation", "", "its number, from 0"),
    Column::whole("elites", "", "cells that have one after it"),
    Column::number("coverage", "", "the fraction of all cells that have one"),
    Column::number(
        "qd_score",
        "",
        "the sum over all elites of what their fitness is above `evolution.archive.offset`",
    ),
    Column::number("best", "", "the best elite's fitness"),
];

/// Columns of the table of elites, before those of their behaviour.
pub(super) static ELITES: [Column; 6] = [
    Column::whole(
        "cell",
        "",
        "its number: of a grid, cells are counted along the last descriptor first",
    ),
    Column::number(
        "fitness",
        "",
        "by which the elite is compared: its best score, or the mean of all, as `evolution.archive.acceptance` says",
    ),
    Column::whole("evaluations", "", "how often it was evaluated"),
    Column::whole(
        "generation",
        "",
        "the generation of the evaluation that `oneiro replay --elite CELL` repeats",
    ),
    Column::whole("individual", "", "its index in that generation"),
    Column::text("score_bits", "its score in that evaluation as 32 bits, in hex"),
];

/// All columns of the table of elites.
pub(super) fn columns(experiment: &Experiment) -> Vec<Column> {
    let behaviour = experiment.settings().evolution.descriptors.iter().map(|own| {
        Column::number(
            "",
            "",
            "the elite's behaviour by this measure (docs/measures.md), in its unit",
        )
        .named(own.measure.clone())
    });
    ELITES.iter().cloned().chain(behaviour).collect()
}

/// A line of the table of growth.
pub(super) fn line(generation: u32, archive: &Archive, offset: f64) -> String {
    let count = archive.elites().count();
    let coverage = archive.coverage();
    let best = archive
        .elites()
        .map(|(_, elite)| elite.fitness)
        .fold(f64::NAN, f64::max);
    format!("{generation},{count},{coverage},{},{best}\n", archive.quality(offset))
}

/// The table of a finished run's elites, and their genes.
pub(super) fn files(archive: &Archive, experiment: &Experiment) -> [(&'static str, Vec<u8>); 2] {
    let mut table = head(&columns(experiment));
    let mut genes = Vec::new();
    for (cell, elite) in archive.elites() {
        let Elite {
            fitness,
            evaluations,
            generation,
            individual,
            score,
            ..
        } = elite;
        // Writing to a string can't fail.
        let _ = write!(
            table,
            "{cell},{fitness},{evaluations},{generation},{individual},{:08x}",
            score.to_bits()
        );
        for value in &elite.behaviour {
            let _ = write!(table, ",{value}");
        }
        table.push('\n');
        genes.extend_from_slice(&elite.genome);
    }
    let shape = [archive.elites().count(), experiment.world().genes()];
    [(ARCHIVE, table.into_bytes()), (ARCHIVE_GENES, npy(&shape, &genes))]
}

/// An elite of a finished run.
#[derive(Clone, Debug)]
pub(super) struct RecordedElite {
    pub(super) cell: u32,
    /// The score that it is compared by.
    pub(super) fitness: f64,
    pub(super) evaluations: u32,
    pub(super) behaviour: Vec<f64>,
    /// As an individual of its generation.
    pub(super) lived: Champion,
}

impl RecordedElite {
    /// An elite of a run that still evolves.
    pub(super) fn of(cell: u32, elite: &Elite) -> Self {
        Self {
            cell,
            fitness: elite.fitness,
            evaluations: elite.evaluations,
            behaviour: elite.behaviour.clone(),
            lived: Champion {
                generation: elite.generation,
                individual: elite.individual,
                fitness: elite.score,
                genome: elite.genome.clone(),
            },
        }
    }
}

/// All elites of a finished run; `asked` is the option that requests them.
///
/// # Errors
/// Exit 3 for a run without an archive; exit 5 if the files aren't what was written.
pub(super) fn elites(run: &Recorded<'_>, experiment: &Experiment, asked: &str) -> Result<Vec<RecordedElite>> {
    if !experiment.settings().evolution.has_archive() {
        return Err(Failure::input(format_args!(
            "{asked}: {} has no archive; allowed: runs with evolution.kind = \"map-elites\"",
            run.directory.display()
        )));
    }
    let path = run.directory.join(ARCHIVE);
    let table = disk::read_text(&path)?;
    let layout = experiment.world().gene_layout();
    let genomes = genomes::recorded(&run.directory.join(ARCHIVE_GENES), layout)?;
    let descriptors = experiment.settings().evolution.descriptors.len();
    let read = |place: usize, line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let [cell, fitness, evaluations, generation, individual, bits, behaviour @ ..] = &fields[..] else {
            return None;
        };
        let behaviour: Vec<f64> = behaviour.iter().map(|own| own.parse().ok()).collect::<Option<_>>()?;
        (behaviour.len() == descriptors && place < genomes.len()).then_some(())?;
        Some(RecordedElite {
            cell: cell.parse().ok()?,
            fitness: fitness.parse().ok()?,
            evaluations: evaluations.parse().ok()?,
            behaviour,
            lived: Champion {
                generation: generation.parse().ok()?,
                individual: individual.parse().ok()?,
                fitness: f32::from_bits(u32::from_str_radix(bits, 16).ok()?),
                genome: genomes.genome(place).to_vec(),
            },
        })
    };
    let columns = head(&columns(experiment));
    let lines = table
        .strip_prefix(&columns)
        .ok_or_else(|| Failure::corrupt(format_args!("{}:1: is not {}", path.display(), columns.trim_end())))?;
    let lines = lines.lines().enumerate();
    lines
        .map(|(place, line)| {
            let corrupt = || Failure::corrupt(format_args!("{}:{}: is not an elite", path.display(), place + 2));
            read(place, line).ok_or_else(corrupt)
        })
        .collect()
}

/// The elite of a cell of a finished run, as an individual of its generation.
///
/// # Errors
/// As [`elites`], and exit 3 for a cell without an elite.
pub(super) fn elite(run: &Recorded<'_>, experiment: &Experiment, cell: u32) -> Result<Champion> {
    let mut all = elites(run, experiment, &format!("--elite {cell}"))?;
    if let Some(place) = all.iter().position(|own| own.cell == cell) {
        return Ok(all.swap_remove(place).lived);
    }
    let near = all.iter().map(|own| own.cell).min_by_key(|own| own.abs_diff(cell));
    let near = near.map_or_else(String::new, |near| format!(", the nearest is {near}"));
    Err(Failure::input(format_args!(
        "--elite {cell}: that cell has no elite; allowed: one of the {} in {}{near}",
        all.len(),
        run.directory.join(ARCHIVE).display()
    )))
}
