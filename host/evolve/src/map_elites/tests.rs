//! Compares with the Python package `ribs` 0.12.0, whose archive is in `oracle.txt`. `tests/optimisers.sh` computes it
//! anew.

use std::path::PathBuf;

use super::super::settings::Kind as Optimiser;
use super::*;

fn settings(acceptance: Acceptance, reevaluated: u32) -> Settings {
    let mut settings = Settings {
        kind: Optimiser::MapElites,
        population: 16,
        descriptors: vec![
            Descriptor::named("x", [-1.0, 1.0], 7),
            Descriptor::named("y", [0.0, 10.0], 5),
        ],
        ..Settings::default()
    };
    (settings.tables.archive.acceptance, settings.tables.archive.reevaluated) = (acceptance, reevaluated);
    settings
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(' ').map(|word| word.parse().unwrap()).collect()
}

/// Every elite, status, coverage and QD score: exactly, but that sums may end in another digit.
#[test]
fn its_archive_is_that_of_ribs() {
    let committed = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/map_elites/oracle.txt");
    let path = std::env::var_os("ONEIRO_OPTIMISERS")
        .map_or_else(committed, |folder| PathBuf::from(folder).join("archive.txt"));
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let [batch, batches, offset] = numbers(lines.next().unwrap())[..] else {
        panic!("three numbers")
    };
    let mut map_elites = MapElites::new(&settings(Acceptance::Optimistic, 0), 1, &vec![None; 1], None);
    for _ in 0..batches as usize {
        let scores: Vec<f32> = numbers(lines.next().unwrap())
            .iter()
            .map(|score| *score as f32)
            .collect();
        let behaviour = numbers(lines.next().unwrap());
        let status = numbers(lines.next().unwrap());
        let before = map_elites.archive.clone();
        let cells: Vec<u32> = behaviour
            .chunks_exact(2)
            .map(|place| map_elites.archive.cells.of(place).unwrap())
            .collect();
        map_elites.tell(scores.clone(), &behaviour).unwrap();
        for (individual, (&cell, status)) in cells.iter().zip(status).enumerate() {
            // 0: not added, 1: better than the elite before the batch, 2: the first of its cell.
            let expected = match before.elites.get(&cell) {
                None => 2.0,
                Some(elite) if f64::from(scores[individual]) > elite.fitness => 1.0,
                Some(_) => 0.0,
            };
            assert_eq!(
                status,
                expected,
                "generation {}, individual {individual}",
                map_elites.generation - 1
            );
        }
        let [elites, coverage, quality] = numbers(lines.next().unwrap())[..] else {
            panic!("three numbers")
        };
        assert_eq!(map_elites.archive.elites.len() as f64, elites);
        assert_eq!(elites / map_elites.archive.cells() as f64, coverage);
        assert!((map_elites.archive.quality(offset) - quality).abs() < 1e-11 * quality.abs());
    }
    let mut left = 0;
    for line in lines {
        let [cell, fitness, solution] = numbers(line)[..] else {
            panic!("three numbers")
        };
        let elite = &map_elites.archive.elites[&(cell as u32)];
        assert_eq!(elite.fitness, fitness);
        assert_eq!(
            f64::from(elite.generation) * batch + f64::from(elite.individual),
            solution,
            "{cell}"
        );
        left += 1;
    }
    assert_eq!(left, map_elites.archive.elites.len());
}

/// Cells at the ends hold what is outside, and NaN belongs to none.
#[test]
fn grids_count_the_last_descriptor_first() {
    let cells = Cells::new(&settings(Acceptance::Optimistic, 0));
    assert_eq!(cells.count(), 35);
    assert_eq!(cells.of(&[-1.0, 0.0]), Some(0));
    assert_eq!(cells.of(&[-1.0, 9.9]), Some(4));
    assert_eq!(cells.of(&[-0.7, 0.0]), Some(5));
    assert_eq!(cells.of(&[1.0, 10.0]), Some(34));
    assert_eq!(cells.of(&[f64::INFINITY, f64::NEG_INFINITY]), Some(30));
    assert_eq!(cells.of(&[0.0, f64::NAN]), None);
}

/// Regions around centroids are of more equal size than those around random places, each place is in that of the nearest, and no
/// seed moves them.
#[test]
fn centroids_divide_evenly() {
    let mut settings = settings(Acceptance::Optimistic, 0);
    (settings.tables.archive.cells, settings.tables.archive.centroids) = (Kind::Centroidal, 50);
    let cells = Cells::new(&settings);
    // The standard deviation of the regions' sizes, as a fraction of their mean.
    let unevenness = |cells: &Cells| {
        let mut counts = [0.0_f64; 50];
        let mut random = stream(9, Stream::Sampling, 0);
        for _ in 0..20_000 {
            let behaviour = [2.0 * unit(&mut random) - 1.0, 10.0 * unit(&mut random)];
            counts[cells.of(&behaviour).unwrap() as usize] += 1.0;
        }
        let squares: f64 = counts.iter().map(|count| (count - 400.0) * (count - 400.0)).sum();
        (squares / 50.0).sqrt() / 400.0
    };
    let mut random = stream(8, Stream::Sampling, 0);
    let places = (0..100).map(|_| unit(&mut random)).collect();
    let at_random = Cells::Centroids(settings.descriptors.clone(), places);
    let [evenly, other] = [&cells, &at_random].map(unevenness);
    println!("{evenly} and {other}");
    assert!(evenly < 0.35 && other > 0.4, "{evenly} and {other}");
    let Cells::Centroids(_, centroids) = &cells else {
        panic!("centroids")
    };
    for (index, centroid) in centroids.chunks_exact(2).enumerate() {
        let behaviour = [2.0 * centroid[0] - 1.0, 10.0 * centroid[1]];
        assert_eq!(cells.of(&behaviour), Some(index as u32));
    }
    assert_eq!(*centroids, super::centroids(2, 50));
}

/// A re-evaluated elite: its best score, or its mean in the cell of its mean behaviour.
#[test]
fn elites_that_live_again_are_accepted_as_asked() {
    for acceptance in [Acceptance::Optimistic, Acceptance::Mean] {
        let mut map_elites = MapElites::new(&settings(acceptance, 1), 1, &vec![None; 2], None);
        let nowhere = [f64::NAN; 2];
        let told = |map_elites: &mut MapElites, score: f32, place: [f64; 2]| {
            let mut fitness = vec![f32::NAN; 16];
            let mut behaviour = nowhere.repeat(16);
            fitness[0] = score;
            behaviour[..2].copy_from_slice(&place);
            map_elites.tell(fitness, &behaviour).unwrap();
        };
        told(&mut map_elites, 4.0, [-0.9, 1.0]);
        let genome = map_elites.archive.elites[&0].genome.clone();
        assert_eq!(
            (map_elites.again.clone(), map_elites.ask().genome(0)),
            (vec![0], &genome[..])
        );
        told(&mut map_elites, 1.0, [0.9, 1.0]);
        let (&cell, elite) = map_elites.archive.elites.first_key_value().unwrap();
        assert_eq!(
            (map_elites.archive.elites.len(), elite.evaluations, elite.score),
            (1, 2, 4.0)
        );
        assert_eq!((elite.generation, elite.individual, &elite.genome), (0, 0, &genome));
        match acceptance {
            Acceptance::Optimistic => assert_eq!((cell, elite.fitness), (0, 4.0)),
            // The middle of the third descriptor's range.
            Acceptance::Mean => assert_eq!((cell, elite.fitness, elite.behaviour[0]), (15, 2.5, 0.0)),
        }
        told(&mut map_elites, 7.0, [0.9, 1.0]);
        let (&cell, elite) = map_elites.archive.elites.first_key_value().unwrap();
        match acceptance {
            Acceptance::Optimistic => assert_eq!((cell, elite.fitness, elite.generation), (30, 7.0, 2)),
            Acceptance::Mean => assert!((elite.fitness - 4.0).abs() < 1e-12 && elite.score == 4.0),
        }
    }
}

/// Children are their first parent, plus normal numbers, plus a part of the way to the second that is the same for all
/// genes.
#[test]
fn children_vary_along_lines() {
    let mut settings = settings(Acceptance::Optimistic, 0);
    settings.population = 2000;
    for (iso, line) in [(0.0, 0.5), (0.25, 0.0)] {
        (settings.tables.archive.iso, settings.tables.archive.line) = (iso, line);
        let mut map_elites = MapElites::new(&settings, 3, &vec![None; 3], None);
        let first = map_elites.ask().clone();
        let mut fitness = vec![f32::NAN; 2000];
        let mut behaviour = vec![f64::NAN; 4000];
        for individual in 0..2_u8 {
            fitness[usize::from(individual)] = 1.0;
            behaviour[2 * usize::from(individual)..][..2].copy_from_slice(&[f64::from(individual), 0.0]);
        }
        map_elites.tell(fitness, &behaviour).unwrap();
        let parents = [0, 1].map(|parent| first.genome(parent));
        let mut squares = 0.0;
        for child in map_elites.ask().genomes() {
            let share = |gene: usize| (child[gene] - parents[0][gene]) / (parents[1][gene] - parents[0][gene]);
            if line > 0.0 {
                assert!((share(0) - share(1)).abs() < 1e-3 && (share(1) - share(2)).abs() < 1e-3);
                let near = f64::from(share(0)).min((1.0 - f64::from(share(0))).abs()).abs();
                squares += near * near;
            } else {
                let from =
                    |parent: &[f32]| -> f64 { child.iter().zip(parent).map(|(a, b)| f64::from(a - b).powi(2)).sum() };
                squares += from(parents[0]).min(from(parents[1]));
            }
        }
        let mean = squares / 2000.0;
        if line > 0.0 {
            // Half have one parent twice, and stay. Of the others the nearer parent is less far than 0.25 on average.
            assert!((0.02..0.125).contains(&mean), "{mean}");
        } else {
            assert!((mean - 3.0 * 0.0625).abs() < 0.02, "{mean}");
        }
    }
}
