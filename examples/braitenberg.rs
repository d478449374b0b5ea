//! Compares evolved champions with a Braitenberg vehicle made by hand: do they drive better, without pushing walls, and do
//! they explore?
//!
//! ```sh
//! cargo run --release -- run experiments/khepera-avoidance.toml --seeds 1..20 --out runs/twenty
//! cargo run --release --example braitenberg runs/twenty
//! ```

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use oneiro::backend::{Options, open};
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::{World, WorldSpec};

/// Starts that a vehicle is chosen on, and others that all are compared on; no run has either of these seeds.
const CHOOSING: (u64, u64) = (1_000_001, 100);
const COMPARING: (u64, u64) = (1_000_002, 200);
/// Side of the cells in which the arena's exploration is counted, mm.
const CELL: f32 = 50.0;

/// Genes of a perceptron that drives forward and turns away: each wheel has a bias, is braked by the sensors of
/// the other side and driven by those of its own. The front sensors count `ahead` times the outer ones.
fn vehicle(bias: f32, brake: f32, drive: f32, ahead: f32) -> Vec<f32> {
    // Left 90, 45, 10, right 10, 45, 90; the two at the back are not used.
    let near = [1.0, ahead, ahead * ahead];
    let [own, other] = [drive, -brake].map(|gain| near.map(|share| gain * share));
    let left = [own[0], own[1], own[2], other[2], other[1], other[0], 0.0, 0.0, bias];
    let right = [other[0], other[1], other[2], own[2], own[1], own[0], 0.0, 0.0, bias];
    [left, right].concat()
}

/// The grid of gains and biases: 6 x 7 x 5 x 4 vehicles.
fn vehicles() -> Vec<Vec<f32>> {
    let mut all = Vec::new();
    for bias in [0.5, 1.0, 2.0, 3.0, 5.0, 8.0] {
        for brake in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
            for drive in [0.0, 0.25, 0.5, 1.0, 2.0] {
                for ahead in [0.5, 1.0, 1.5, 2.0] {
                    all.push(vehicle(bias, brake, drive * brake, ahead));
                }
            }
        }
    }
    all
}

/// Averages over a genome's lives from the same starts.
struct Lives {
    fitness: f32,
    /// Share of cycles that end in a collision.
    colliding: f32,
    /// Share of cycles in which the robot drives forwards.
    forwards: f32,
    /// Share of the arena's cells that one life visits.
    explored: f32,
}

fn lives(
    evaluator: &mut dyn Evaluator,
    world: &World,
    genomes: &[Vec<f32>],
    (seed, starts): (u64, u64),
) -> Result<Vec<Lives>, Box<dyn Error>> {
    let field = world.spec().arena.field;
    let cells = (field.width / CELL).ceil() * (field.height / CELL).ceil();
    let mut all = Vec::new();
    for genes in genomes {
        let rollouts: Vec<_> = (0..starts)
            .map(|start| Rollout {
                world: 0,
                genes,
                key: Key::rollout(seed, 0, start, 0),
            })
            .collect();
        let batch = Batch::new(std::slice::from_ref(world), &rollouts, Some(TraceRequest { every: 1 }))?;
        let outcome = evaluator.evaluate(&batch, &Control::new())?;
        let cycles = (starts * u64::from(world.cycles())) as f32;
        let records = || outcome.traces.iter().flatten();
        let visited: usize = outcome
            .traces
            .iter()
            .map(|trace| {
                let cell = |at: f32, from: f32| ((at - from) / CELL) as i32;
                trace
                    .iter()
                    .map(|r| (cell(r.x, field.x), cell(r.y, field.y)))
                    .collect::<BTreeSet<_>>()
                    .len()
            })
            .sum();
        all.push(Lives {
            fitness: outcome.fitness.iter().sum::<f32>() / starts as f32,
            colliding: records().filter(|record| record.collided != 0.0).count() as f32 / cycles,
            forwards: records()
                .filter(|record| record.speed_left + record.speed_right > 0.0)
                .count() as f32
                / cycles,
            explored: visited as f32 / (starts as f32 * cells),
        });
    }
    Ok(all)
}

/// The genomes in an `.npy` file of floats: what follows a header whose length it states.
fn genomes(file: &Path, genes: usize) -> Result<Vec<Vec<f32>>, Box<dyn Error>> {
    let bytes = fs::read(file)?;
    let length = bytes
        .get(8..10)
        .ok_or_else(|| format!("{}: not an .npy file", file.display()))?;
    let header = 10 + usize::from(u16::from_le_bytes([length[0], length[1]]));
    let floats = bytes.get(header..).unwrap_or_default().chunks_exact(4);
    let floats: Vec<f32> = floats.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    Ok(floats.chunks_exact(genes).map(<[f32]>::to_vec).collect())
}

/// The runs below a directory.
fn runs(directory: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let all: Vec<_> = fs::read_dir(directory)?
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    let mut runs: Vec<_> = all
        .into_iter()
        .filter(|run| run.join("champion.npy").exists())
        .collect();
    runs.sort();
    if runs.is_empty() {
        return Err(format!("{}: no run with a champion.npy", directory.display()).into());
    }
    Ok(runs)
}

/// Prints the least, the median and the best of several champions, and how many beat the vehicle.
fn print_all(name: &str, mut lives: Vec<Lives>, vehicle: &Lives) {
    lives.sort_by(|a, b| a.fitness.total_cmp(&b.fitness));
    for (place, index) in [("least", 0), ("median", lives.len() / 2), ("best", lives.len() - 1)] {
        print(&format!("{place} of {} {name}", lives.len()), &lives[index]);
    }
    let beaten = lives.iter().filter(|lives| lives.fitness > vehicle.fitness).count();
    println!("{beaten} of {} {name} beat the vehicle", lives.len());
}

fn print(name: &str, lives: &Lives) {
    println!(
        "{name:58} {:7.1}  {:8.2} %  {:6.1} %  {:6.1} %",
        lives.fitness,
        100.0 * lives.colliding,
        100.0 * lives.forwards,
        100.0 * lives.explored
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let directory = env::args().nth(1).ok_or("usage: braitenberg DIRECTORY_OF_RUNS")?;
    let runs = runs(Path::new(&directory))?;
    let world = World::new(WorldSpec::miglino1995())?;
    let mut evaluator = open("cpu", Options::default())?;
    let evaluator = &mut *evaluator;

    let grid = vehicles();
    let best = best(&lives(evaluator, &world, &grid, CHOOSING)?);
    let vehicle = lives(evaluator, &world, &grid[best..=best], COMPARING)?.remove(0);
    println!("of {} vehicles the best has the genes {:?}", grid.len(), grid[best]);
    let title = format!("{} starts of {} cycles each", COMPARING.1, world.cycles());
    println!("{title:58} fitness   colliding  forwards  explored");
    print("the best Braitenberg vehicle", &vehicle);

    // As the runs name them: the individual with the best single life.
    let mut champions = Vec::new();
    // The individual of the last generation with the best mean over the lives that the vehicle was chosen on.
    let mut steady = Vec::new();
    for run in &runs {
        champions.extend(genomes(&run.join("champion.npy"), world.genes())?);
        let mut population = genomes(&run.join("population.npy"), world.genes())?;
        steady.push(population.swap_remove(self::best(&lives(evaluator, &world, &population, CHOOSING)?)));
    }
    print_all(
        "champions by their best life",
        lives(evaluator, &world, &champions, COMPARING)?,
        &vehicle,
    );
    print_all(
        "champions by their mean of 100 lives",
        lives(evaluator, &world, &steady, COMPARING)?,
        &vehicle,
    );
    Ok(())
}

/// The index of the best; of equal ones the first.
fn best(lives: &[Lives]) -> usize {
    (0..lives.len())
        .rev()
        .max_by(|a, b| lives[*a].fitness.total_cmp(&lives[*b].fitness))
        .unwrap_or(0)
}
