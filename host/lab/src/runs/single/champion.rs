//! `champion.json` and `champion.npy`, `champion.txt` of a state machine, and the same files for the luckiest individual.

use std::path::Path;

use oneiro::automode::Form;
use oneiro::random::Key;
use oneiro::world::GeneLayout;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::npy::npy;
use oneiro_evolve::Champion;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_report::numbers::to_six_places;
use serde::{Deserialize, Serialize};

use super::CHAMPION;
use crate::genomes;

/// An individual of a run, for humans and programs to read.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct IndividualFile {
    /// Score in its generation; null if it is NaN.
    pub(super) fitness: Option<f32>,
    /// The score's 32 bits in hex.
    pub(super) fitness_bits: String,
    /// Mean of new episodes, its 95 % confidence interval (Student's t), and the number of episodes. Those of a champion were simulated
    /// after it had been chosen among finalists. Missing if there were no finalists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) mean: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) interval: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) lives: Option<u32>,
    pub(super) generation: u32,
    pub(super) individual: u32,
    /// Seed of the run.
    seed: u64,
    /// Random number keys of its episodes in its generation, both words in hex.
    keys: Vec<String>,
    /// Name of each gene; missing if there were no finalists.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    gene_names: Vec<String>,
    genome: Vec<f32>,
}

/// One of a run's individuals, for its files.
pub(super) struct Individual<'a> {
    pub(super) own: &'a Champion,
    /// Mean of its new episodes.
    pub(super) appraisal: Option<Appraisal>,
    pub(super) seed: u64,
    /// Keys of its episodes in its generation.
    pub(super) keys: Vec<Key>,
    pub(super) layout: &'a GeneLayout,
}

impl Individual<'_> {
    /// Its files with their contents, such as `champion.json` and `champion.npy`, and its text, if it has one.
    pub(super) fn files(&self, [file, genes, text]: [&'static str; 3]) -> Vec<(&'static str, Vec<u8>)> {
        let genome = &self.own.genome;
        let mut files = vec![(file, self.json()), (genes, npy(&[genome.len()], genome))];
        if let Some(form) = Form::of(self.layout) {
            files.push((text, format!("{}\n", form.text(genome)).into_bytes()));
        }
        files
    }

    fn json(&self) -> Vec<u8> {
        let Champion {
            generation,
            individual,
            fitness,
            genome,
        } = self.own;
        let known = self.appraisal.filter(|appraisal| appraisal.mean.is_finite());
        disk::json(&IndividualFile {
            fitness: Some(*fitness).filter(|fitness| fitness.is_finite()),
            fitness_bits: format!("{:08x}", fitness.to_bits()),
            mean: known.map(|appraisal| to_six_places(appraisal.mean)),
            interval: known.map(|appraisal| appraisal.interval().map(to_six_places)),
            lives: self.appraisal.map(|appraisal| appraisal.lives),
            generation: *generation,
            individual: *individual,
            seed: self.seed,
            keys: self
                .keys
                .iter()
                .map(|key| key.words)
                .map(|[a, b]| format!("{a:08x}{b:08x}"))
                .collect(),
            gene_names: self.appraisal.map_or_else(Vec::new, |_| self.layout.names()),
            genome: genome.clone(),
        })
    }
}

/// Reads `champion.json` or `luckiest.json`.
///
/// # Errors
/// Exit 5 if the file isn't what was written.
pub(super) fn read_file(directory: &Path, file: &str) -> Result<IndividualFile> {
    let path = directory.join(file);
    disk::parsed(&path, disk::read_text(&path)?.as_bytes())
}

impl IndividualFile {
    /// Score in its generation.
    ///
    /// # Errors
    /// Exit 5 if the file isn't what was written.
    pub(super) fn score(&self, directory: &Path) -> Result<f32> {
        let bits = u32::from_str_radix(&self.fitness_bits, 16);
        let bits = bits.map_err(|error| {
            let path = directory.join(CHAMPION);
            Failure::corrupt(format_args!("{}: fitness_bits: {error}", path.display()))
        })?;
        Ok(f32::from_bits(bits))
    }
}

/// Reads an individual of a finished run from its [two files](Individual::files).
///
/// # Errors
/// Exit 5 if the files aren't what was written.
pub(super) fn read(directory: &Path, [file, genes]: [&str; 2], layout: &GeneLayout) -> Result<Champion> {
    let own = read_file(directory, file)?;
    let genomes = genomes::recorded(&directory.join(genes), layout)?;
    Ok(Champion {
        generation: own.generation,
        individual: own.individual,
        fitness: own.score(directory)?,
        genome: genomes.genomes().next().unwrap_or_default().to_vec(),
    })
}
