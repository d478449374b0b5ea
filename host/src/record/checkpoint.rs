//! Checkpoints: all that a run needs to go on, in a file that never loads when a bit of it is wrong.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::disk;
use super::log::Extent;
use crate::evolve::{Champion, Population};
use crate::exit::{Failure, Result};

/// A run between two generations.
///
/// The file is a line of JSON (the header), then as little-endian f32 the genes of the population and those of the
/// champion, then the BLAKE3 hash of all that goes before it. What changes from one generation to the next and is not
/// here is a function of the seed and the generation's number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Checkpoint {
    /// What decides the run's results.
    pub(super) identity: blake3::Hash,
    /// The generation that lives next.
    pub(crate) generation: u32,
    /// Who lives then.
    pub(crate) population: Population,
    /// The best so far.
    pub(crate) champion: Option<Champion>,
    /// How much there was of the table of generations.
    pub(super) rows: Extent,
    /// And of the individuals, if they are recorded.
    pub(super) individuals: Option<Extent>,
}

const FORMAT: &str = "oneiro checkpoint";
const VERSION: u32 = 1;
const PREFIX: &str = "checkpoint-";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    version: u32,
    experiment: String,
    generation: u32,
    individuals: usize,
    genes: usize,
    champion: Option<ChampionHeader>,
    generations_csv: Extent,
    individuals_npy: Option<Extent>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChampionHeader {
    generation: u32,
    individual: u32,
    fitness_bits: u32,
}

impl Checkpoint {
    fn encode(&self) -> Vec<u8> {
        let header = Header {
            format: FORMAT.into(),
            version: VERSION,
            experiment: self.identity.to_hex().to_string(),
            generation: self.generation,
            individuals: self.population.len(),
            genes: self.population.genes(),
            champion: self.champion.as_ref().map(|champion| ChampionHeader {
                generation: champion.generation,
                individual: champion.individual,
                fitness_bits: champion.fitness.to_bits(),
            }),
            generations_csv: self.rows.clone(),
            individuals_npy: self.individuals.clone(),
        };
        let mut bytes = serde_json::to_vec(&header).expect("a header is numbers and words");
        bytes.push(b'\n');
        let champion = self.champion.iter().flat_map(|champion| &champion.genome);
        bytes.extend(
            self.population
                .values()
                .iter()
                .chain(champion)
                .flat_map(|gene| gene.to_le_bytes()),
        );
        let hash = blake3::hash(&bytes);
        bytes.extend_from_slice(hash.as_bytes());
        bytes
    }

    /// Reads a checkpoint, or says what is wrong with it.
    fn decode(bytes: &[u8]) -> std::result::Result<Self, String> {
        let damaged = || "is cut off or damaged".to_owned();
        let (content, hash) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>().ok_or_else(damaged)?;
        if blake3::hash(content) != blake3::Hash::from_bytes(*hash) {
            return Err(damaged());
        }
        let end = content.iter().position(|&byte| byte == b'\n').ok_or_else(damaged)?;
        let header: Header =
            serde_json::from_slice(&content[..end]).map_err(|error| format!("is of another kind: {error}"))?;
        if header.format != FORMAT || header.version != VERSION {
            return Err(format!(
                "is of version {} of \"{}\"; allowed: {VERSION}",
                header.version, header.format
            ));
        }
        let values = super::floats(&content[end + 1..]);
        let genomes = header
            .individuals
            .saturating_add(usize::from(header.champion.is_some()));
        let is_whole = content[end + 1..].len().is_multiple_of(size_of::<f32>());
        if header.genes == 0 || !is_whole || values.len() != genomes.saturating_mul(header.genes) {
            return Err(format!(
                "has {} genes, but its header means another number",
                values.len()
            ));
        }
        let (population, genome) = values.split_at(header.individuals * header.genes);
        Ok(Self {
            identity: blake3::Hash::from_hex(&header.experiment).map_err(|_| damaged())?,
            generation: header.generation,
            population: Population::new(header.genes, population.to_vec()),
            champion: header.champion.map(|champion| Champion {
                generation: champion.generation,
                individual: champion.individual,
                fitness: f32::from_bits(champion.fitness_bits),
                genome: genome.to_vec(),
            }),
            rows: header.generations_csv,
            individuals: header.individuals_npy,
        })
    }

    /// Writes it to a run's directory and waits until it is on the disk. All but the newest two are removed.
    pub(super) fn save(&self, directory: &Path) -> Result {
        disk::write(&directory.join(format!("{PREFIX}{}", self.generation)), &self.encode())?;
        disk::sync_directory(directory)?;
        for (_, path) in Self::list(directory)?.into_iter().skip(2) {
            fs::remove_file(&path).map_err(|error| Failure::storage(&path, &error))?;
        }
        Ok(())
    }

    /// Reads one.
    pub(super) fn load(path: &Path) -> std::result::Result<Self, String> {
        let bytes = fs::read(path).map_err(|error| error.to_string())?;
        Self::decode(&bytes)
    }

    /// The checkpoints of a run's directory and their generations, the newest first.
    pub(super) fn list(directory: &Path) -> Result<Vec<(u32, PathBuf)>> {
        let failed = |error| Failure::storage(directory, &error);
        let mut checkpoints = Vec::new();
        for entry in fs::read_dir(directory).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name();
            let generation = name
                .to_str()
                .and_then(|name| name.strip_prefix(PREFIX))
                .and_then(|end| end.parse().ok());
            checkpoints.extend(generation.map(|generation| (generation, entry.path())));
        }
        checkpoints.sort_unstable_by(|a, b| b.cmp(a));
        Ok(checkpoints)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let extent = |bytes: u64| serde_json::from_str(&format!("{{\"bytes\":{bytes},\"blake3\":\"ab\"}}")).unwrap();
        Checkpoint {
            identity: blake3::hash(b"an experiment"),
            generation: 3,
            population: Population::new(2, vec![1.0, -2.5, 0.0, 1e-30]),
            champion: Some(Champion {
                generation: 2,
                individual: 1,
                fitness: 0.1,
                genome: vec![3.0, 4.0],
            }),
            rows: extent(100),
            individuals: Some(extent(200)),
        }
    }

    #[test]
    fn a_checkpoint_loads_as_it_was_saved() {
        assert_eq!(Checkpoint::decode(&checkpoint().encode()), Ok(checkpoint()));
        let first = Checkpoint {
            champion: None,
            individuals: None,
            ..checkpoint()
        };
        assert_eq!(Checkpoint::decode(&first.encode()), Ok(first));
    }

    /// Every bit flipped, every length cut, and bytes added: none loads.
    #[test]
    fn a_damaged_checkpoint_never_loads() {
        let good = checkpoint().encode();
        for length in 0..good.len() {
            Checkpoint::decode(&good[..length]).unwrap_err();
        }
        for place in 0..good.len() {
            for bit in 0..8 {
                let mut bad = good.clone();
                bad[place] ^= 1 << bit;
                Checkpoint::decode(&bad).unwrap_err();
            }
        }
        Checkpoint::decode(&[&good[..], &[0]].concat()).unwrap_err();
    }

    /// A header that lies is refused even where the hash is right.
    #[test]
    fn a_header_that_does_not_fit_is_refused() {
        let good = checkpoint().encode();
        for (from, to) in [
            ("\"individuals\":2", "\"individuals\":3"),
            ("\"individuals\":2", "\"individuals\":18446744073709551615"),
            ("\"genes\":2", "\"genes\":0"),
            ("\"version\":1", "\"version\":2"),
            ("\"format\":\"oneiro", "\"format\":\"another"),
            (
                "\"champion\":{\"generation\":2,\"individual\":1,\"fitness_bits\":1036831949}",
                "\"champion\":null",
            ),
        ] {
            let end = good.iter().position(|&byte| byte == b'\n').unwrap();
            let header = String::from_utf8(good[..end].to_vec()).unwrap();
            assert!(header.contains(from), "{header}");
            let mut bad = header.replace(from, to).into_bytes();
            bad.extend_from_slice(&good[end..good.len() - 32]);
            let hash = blake3::hash(&bad);
            bad.extend_from_slice(hash.as_bytes());
            Checkpoint::decode(&bad).unwrap_err();
        }
    }

    #[test]
    fn the_two_newest_are_kept() {
        let directory = std::env::temp_dir().join(format!("oneiro-checkpoints-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        for generation in [8, 9, 10, 100] {
            Checkpoint {
                generation,
                ..checkpoint()
            }
            .save(&directory)
            .unwrap();
        }
        let list: Vec<u32> = Checkpoint::list(&directory)
            .unwrap()
            .into_iter()
            .map(|(number, _)| number)
            .collect();
        assert_eq!(list, [100, 10]);
        fs::remove_dir_all(&directory).unwrap();
    }
}
