//! A run's directory: what is in it, how it gets there, and how it is read again.
//!
//! | file | what |
//! |---|---|
//! | `config.toml` | the experiment with every default written out, and the seed |
//! | `inputs/` | copies of the files that the experiment names |
//! | `generations.csv` | a line for each generation, see [`Row`] |
//! | `individuals.npy` | every individual, f32 of the shape (generations, individuals, genes + 1): its genes, then its fitness; longer than what is there until the run is done |
//! | `checkpoint-N` | the two newest, see [`Checkpoint`] |
//! | `champion.npy`, `champion.json` | the best individual's genes; what it scored, when, and the keys of its lives |
//! | `population.npy`, `fitness.npy` | the last generation |
//! | `trace.csv`, `path.svg`, `learning-curve.svg` | the champion's life again; the run in a picture |
//! | `intervals.csv`, `food.csv` | of a swarm's run, in place of the above: each robot in each interval; food in each second |
//! | `meta.json` | what is no result: program, device, times, status, see [`Meta`] |
//! | `lock` | held by the one process that writes |
//! | `DONE` | written last: the files' hashes and the result's, see [`Done`] |

mod champion;
mod checkpoint;
pub(crate) mod disk;
mod done;
mod log;
mod meta;
mod recorder;
mod rows;
mod saved;
mod swarm;
mod trace;

pub(crate) use checkpoint::Checkpoint;
pub(crate) use disk::write as write_whole;
pub(crate) use done::{Done, verify};
pub(crate) use meta::{Meta, Session, Status, now};
pub(crate) use recorder::{Ended, Recorder, Standing, result, standing, try_lock};
pub(crate) use rows::Row;
pub(crate) use saved::{Individuals, SavedRun, State, is_locked, is_run, rows};
pub(crate) use swarm::{SavedSwarm, SwarmRecorder, is_swarm_run, swarm_result};
pub(crate) use trace::trace_csv;

const CONFIG: &str = "config.toml";
const GENERATIONS: &str = "generations.csv";
const INDIVIDUALS: &str = "individuals.npy";
const CHAMPION: &str = "champion.json";
const CHAMPION_GENES: &str = "champion.npy";
const POPULATION: &str = "population.npy";
const FITNESS: &str = "fitness.npy";
const TRACE: &str = "trace.csv";
const PATH: &str = "path.svg";
const LEARNING_CURVE: &str = "learning-curve.svg";
const META: &str = "meta.json";
const LOCK: &str = "lock";
const DONE: &str = "DONE";

/// The start of a `.npy` file (format 1.0) of little-endian f32, rows first.
fn npy_header(shape: &[usize]) -> Vec<u8> {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    // A single length keeps its comma.
    let lengths = lengths.join(", ") + if shape.len() == 1 { "," } else { "" };
    let mut text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({lengths}), }}");
    // The format wants the numbers to start at a multiple of 64 bytes, after a line end.
    let padding = (64 - (MAGIC.len() + 2 + text.len() + 1) % 64) % 64;
    text.extend(std::iter::repeat_n(' ', padding));
    text.push('\n');
    [MAGIC, &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat()
}

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// A `.npy` file.
pub(crate) fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let mut bytes = npy_header(shape);
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Little-endian f32 from bytes, as many as are whole.
fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn npy_is_what_its_readers_expect() {
        let bytes = npy(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, -6.5]);
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(file.shape(), [2, 3]);
        assert_eq!(file.into_vec::<f32>().unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, -6.5]);
        assert_eq!((bytes.len() - 24) % 64, 0);
        let one = npy(&[4], &[0.0; 4]);
        assert_eq!(npyz::NpyFile::new(&one[..]).unwrap().shape(), [4]);
        assert_eq!(floats(&bytes[bytes.len() - 8..]), [5.0, -6.5]);
    }
}
