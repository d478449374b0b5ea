//! `champion.json` and `champion.npy`.

use std::path::Path;

use oneiro::random::Key;
use oneiro::world::Controller;
use serde::{Deserialize, Serialize};

use super::{CHAMPION, CHAMPION_GENES};
use crate::engine::disk;
use crate::evolve::Champion;
use crate::exit::{Failure, Result};
use crate::genomes;
use crate::npy::npy;

/// The best individual of a run, for people and programs to read.
#[derive(Serialize, Deserialize)]
struct ChampionFile {
    /// Its score; null if it is NaN.
    fitness: Option<f32>,
    /// The score's 32 bits in hex.
    fitness_bits: String,
    generation: u32,
    individual: u32,
    /// The run's.
    seed: u64,
    /// The keys of its lives' random numbers, both words in hex.
    keys: Vec<String>,
    genome: Vec<f32>,
}

/// The files' names and contents.
pub(super) fn files(champion: &Champion, seed: u64, keys: &[Key]) -> [(&'static str, Vec<u8>); 2] {
    let file = ChampionFile {
        fitness: Some(champion.fitness).filter(|fitness| fitness.is_finite()),
        fitness_bits: format!("{:08x}", champion.fitness.to_bits()),
        generation: champion.generation,
        individual: champion.individual,
        seed,
        keys: keys.iter().map(|Key([a, b])| format!("{a:08x}{b:08x}")).collect(),
        genome: champion.genome.clone(),
    };
    let mut text = serde_json::to_vec_pretty(&file).expect("numbers and words");
    text.push(b'\n');
    [
        (CHAMPION, text),
        (CHAMPION_GENES, npy(&[champion.genome.len()], &champion.genome)),
    ]
}

/// Reads the champion of a finished run.
///
/// # Errors
/// Exit 5 when the files are not what was written.
pub(super) fn read(directory: &Path, controller: Controller) -> Result<Champion> {
    let path = directory.join(CHAMPION);
    let corrupt = |problem: &dyn std::fmt::Display| Failure::corrupt(format_args!("{}: {problem}", path.display()));
    let file: ChampionFile = serde_json::from_str(&disk::read_text(&path)?).map_err(|error| corrupt(&error))?;
    let bits =
        u32::from_str_radix(&file.fitness_bits, 16).map_err(|error| corrupt(&format_args!("fitness_bits: {error}")))?;
    let genomes = genomes::read(&directory.join(CHAMPION_GENES), controller).map_err(Failure::corrupt)?;
    Ok(Champion {
        generation: file.generation,
        individual: file.individual,
        fitness: f32::from_bits(bits),
        genome: genomes.genomes().next().unwrap_or_default().to_vec(),
    })
}
