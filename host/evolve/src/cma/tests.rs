//! Compares with the Python package `cma` 4.5.0. Its results are in `oracles/`; `tests/optimisers.sh` computes them
//! anew with more genes, and sets `ONEIRO_OPTIMISERS` to their folder.

use std::path::PathBuf;

use super::*;

fn oracles() -> PathBuf {
    let committed = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/cma/oracles");
    std::env::var_os("ONEIRO_OPTIMISERS").map_or_else(committed, PathBuf::from)
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(' ').map(|word| word.parse().unwrap()).collect()
}

/// The maximum difference as a fraction of the maximum number.
fn difference(ours: &[f64], other: &[f64]) -> f64 {
    assert_eq!(ours.len(), other.len());
    let greatest = other.iter().fold(0.0_f64, |most, number| most.max(number.abs()));
    let differences = ours.iter().zip(other).map(|(a, other)| (a - other).abs());
    differences.fold(0.0, f64::max) / greatest
}

/// Follows a file's steps with constants changed by `change`, and returns the maximum difference.
fn followed(text: &str, change: fn(&mut Constants)) -> f64 {
    let mut lines = text.lines();
    let mut next = || numbers(lines.next().expect("a line"));
    let [genes, population, active, steps] = next()[..] else {
        panic!("four numbers")
    };
    let genes = genes as usize;
    let mut constants = Constants::new(genes, population as usize, true, active != 0.0);
    change(&mut constants);
    let mut distribution = Distribution::new(next(), next()[0], true);
    distribution.covariances = next();
    let mut worst = 0.0_f64;
    for _ in 0..steps as usize {
        let (places, values) = (next(), next());
        let fitness: Vec<f64> = values.iter().map(|value| -value).collect();
        let mut ranking: Vec<usize> = (0..fitness.len()).collect();
        ranking.sort_by(|&a, &b| fitness[b].total_cmp(&fitness[a]));
        let deviation = |index: usize| (places[index] - distribution.mean[index % genes]) / distribution.sigma;
        let deviations: Vec<f64> = (0..places.len()).map(deviation).collect();
        let samples: Vec<&[f64]> = ranking
            .iter()
            .map(|&index| &deviations[index * genes..][..genes])
            .collect();
        let axes = distribution.axes();
        distribution.update(&constants, &axes, &samples);
        worst = worst
            .max(difference(&distribution.mean, &next()))
            .max(difference(&[distribution.sigma], &next()))
            .max(difference(&distribution.covariances, &next()));
    }
    worst
}

/// Step by step, to the last digits. A rate that is wrong in its tenth digit is noticed.
#[test]
fn steps_are_those_of_cma() {
    const ALLOWED: f64 = 1e-12;
    let mut files = 0;
    for entry in std::fs::read_dir(oracles()).unwrap() {
        let path = entry.unwrap().path();
        if !path.file_name().unwrap().to_string_lossy().starts_with("steps-") {
            continue;
        }
        files += 1;
        let text = std::fs::read_to_string(&path).unwrap();
        let worst = followed(&text, |_| ());
        println!("{}: {worst:e}", path.display());
        assert!(worst < ALLOWED, "{}: {worst:e}", path.display());
        let off = followed(&text, |constants| constants.rank_mu *= 1.0 + 1e-9);
        assert!(off > ALLOWED, "CONTROL: {}: {off:e}", path.display());
    }
    assert!(files >= 2);
}

/// Evaluations up to the first value of 1e-9, of 10 genes from (1, .., 1) with the step size 0.5.
fn evaluations(kind: Kind, seed: u64, value: fn(usize, f64) -> f64) -> u32 {
    const GENES: usize = 10;
    let mut settings = Settings {
        kind,
        initial: [0.0, 2.0],
        ..Settings::default()
    };
    settings.complete(GENES, 1, false);
    let mut cma = Cma::new(&settings, seed, &vec![None; GENES], None);
    assert_eq!(cma.ask().len(), 10);
    for generation in 0..10_000 {
        let values: Vec<f64> = cma
            .ask()
            .genomes()
            .map(|genes| genes.iter().enumerate().map(|(at, &gene)| value(at, gene.into())).sum())
            .collect();
        if let Some(found) = values.iter().position(|value| *value <= 1e-9) {
            return generation * 10 + found as u32 + 1;
        }
        cma.tell(values.iter().map(|value| -*value as f32).collect(), &[])
            .unwrap();
    }
    panic!("{kind:?}, seed {seed}: not found");
}

fn sphere(_: usize, gene: f64) -> f64 {
    gene * gene
}

fn ellipsoid(at: usize, gene: f64) -> f64 {
    1e6_f64.powf(at as f64 / 9.0) * gene * gene
}

/// Medians of 21 seeds are within 10 % of those of `cma`.
#[test]
fn it_needs_as_many_evaluations_as_cma() {
    let text = std::fs::read_to_string(oracles().join("evaluations.txt")).unwrap();
    assert_eq!(text.lines().count(), 4);
    for line in text.lines() {
        let [function, kind, expected] = line.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let value = if function == "sphere" { sphere } else { ellipsoid };
        let kind = if kind == FULL.name { Kind::CmaEs } else { Kind::SepCmaEs };
        let mut counts: Vec<u32> = (1..=21).map(|seed| evaluations(kind, seed, value)).collect();
        counts.sort_unstable();
        let (median, expected) = (f64::from(counts[10]), expected.parse::<f64>().unwrap());
        println!("{line}: {median}");
        assert!((median / expected - 1.0).abs() < 0.1, "{line}: {median}");
    }
}

/// Ten lines of the formulas for a diagonal, compared with one update.
#[test]
fn a_diagonal_is_updated_as_the_formulas_say() {
    let constants = Constants::new(2, 4, false, false);
    let mut distribution = Distribution::new(vec![0.5, -0.25], 0.3, false);
    distribution.covariances = vec![4.0, 0.25];
    let samples: [&[f64]; 4] = [&[1.0, 0.2], &[-0.5, 0.4], &[3.0, -1.0], &[0.0, 0.1]];
    let axes = distribution.axes();
    distribution.update(&constants, &axes, &samples);
    let half = 2.5_f64.ln();
    let (one, two) = (half, half - 2.0_f64.ln());
    let [one, two] = [one / (one + two), two / (one + two)];
    let mass = 1.0 / (one * one + two * two);
    assert!((constants.mass - mass).abs() < 1e-14);
    let root = 2.0_f64.sqrt();
    let cc = (1.5 + mass / 2.0) / (root + 0.5 + mass);
    let c1 = 1.0 / (2.0 + 2.0 * root + mass / 2.0);
    let cmu = (1.0 - c1).min((mass + 1.0 / mass - 1.75) / (2.0 + 4.0 * root + mass / 2.0));
    let cs = ((mass + 2.0) / (mass + 5.0)).min(0.5);
    for gene in 0..2 {
        let step = one * samples[0][gene] + two * samples[1][gene];
        let before = [4.0, 0.25][gene];
        let path = (cc * (2.0 - cc) * mass).sqrt() * step;
        let expected = (1.0 - c1 - cmu) * before
            + c1 * path * path
            + cmu * (one * samples[0][gene].powi(2) + two * samples[1][gene].powi(2));
        assert!((distribution.covariances[gene] - expected).abs() < 1e-14, "{gene}");
        let white = (cs * (2.0 - cs) * mass).sqrt() * step / before.sqrt();
        assert!((distribution.path_sigma[gene] - white).abs() < 1e-14);
        assert!((distribution.mean[gene] - [0.5, -0.25][gene] - 0.3 * step).abs() < 1e-15);
    }
}

/// A strategy whose fitness never rises begins again elsewhere, unless restarts are off, and continues as after a
/// pause.
#[test]
fn it_begins_again_where_it_can_not_go_on() {
    for (restarts, kind) in [(true, Kind::CmaEs), (true, Kind::SepCmaEs), (false, Kind::CmaEs)] {
        let mut settings = Settings {
            kind,
            ..Settings::default()
        };
        settings.strategy.restarts = restarts;
        settings.complete(3, 1, false);
        let mut cma = Cma::new(&settings, 1, &vec![None; 3], None);
        let recent = 10 + 90_usize.div_ceil(cma.size);
        for generation in 1..=recent {
            cma.tell(vec![1.0; cma.size], &[]).unwrap();
            let is_new = cma.state.bests.is_empty();
            assert_eq!(is_new, restarts && generation == recent, "{kind:?} {generation}");
        }
        if restarts {
            assert_eq!(cma.state.distribution.sigma, 0.5);
            assert!(cma.state.distribution.mean.iter().all(|mean| *mean != 0.0));
        }
    }
}

/// Samples have the covariances that they are drawn with.
#[test]
fn samples_have_their_covariances() {
    const COUNT: usize = 40_000;
    let mut distribution = Distribution::new(vec![0.0; 2], 1.0, true);
    distribution.covariances = vec![2.0, 1.2, 1.2, 1.0];
    let axes = distribution.axes();
    let mut random = stream(1, Stream::Sampling, 0);
    let normal = Normal { deviation: 1.0 };
    let mut sums = [0.0; 3];
    for _ in 0..COUNT {
        let white = [normal.sample(&mut random), normal.sample(&mut random)];
        let drawn = axes.coloured(&white);
        for (sum, product) in sums
            .iter_mut()
            .zip([drawn[0] * drawn[0], drawn[0] * drawn[1], drawn[1] * drawn[1]])
        {
            *sum += product / COUNT as f64;
        }
        // A deviation whitened by the inverse root has its original length.
        let again = axes.whitened(&drawn);
        assert!((dot(&again, &again) - dot(&white, &white)).abs() < 1e-12 * (1.0 + dot(&white, &white)));
    }
    for (sum, expected) in sums.iter().zip([2.0, 1.2, 1.0]) {
        assert!((sum - expected).abs() < 0.06, "{sums:?}");
    }
}
