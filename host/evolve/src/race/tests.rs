//! A race on problems whose solution is known, and what a candidate's genes may be.

use oneiro::world::GeneKind;

use super::super::settings::Kind;
use super::super::tests::{fitness, number};
use super::*;

const RANGES: [[f32; 2]; 4] = [[0.0, 3.0], [1.0, 5.0], [-2.0, 2.0], [0.0, 1.0]];

/// A choice of three, a whole number from 1 to 4 that has an effect with the first two choices, a number that has one
/// with the number's maximum, and a number.
fn genes() -> [Gene; 4] {
    let [mut choice, mut whole, mut conditional, other] = RANGES.map(|range| number(Some(range)));
    choice.kind = GeneKind::Choice;
    (whole.kind, whole.only) = (GeneKind::Whole, Some((0, &[0, 1][..])));
    conditional.only = Some((1, &[4]));
    [choice, whole, conditional, other]
}

fn race(lives: u64, seed: u64) -> Race {
    let mut settings = Settings {
        kind: Kind::Race,
        ..Settings::default()
    };
    settings.tables.race.lives = lives;
    settings.complete(RANGES.len(), 1, false);
    Race::new(&settings, seed, &genes(), None)
}

/// The finalists besides the luckiest, which has this genome.
fn finalists(race: &Race, genome: Vec<f32>) -> Vec<Champion> {
    let luckiest = Champion {
        generation: 0,
        individual: 0,
        fitness: 0.0,
        genome,
    };
    race.finalists(&luckiest, &[], &[]).collect()
}

/// Best are the choice 1, the number 4 and 1.5 and 0.25; noise that is common to a generation, and of each.
fn scores(race: &Race, noise: f32) -> Vec<f32> {
    let mut random = stream(7, Stream::Mutation, race.generation());
    let each = race.ask().genomes().map(|genome| {
        let [choice, whole] = [genome[0], genome[1]].map(f32::floor);
        let mut score = -(genome[3] - 0.25).abs();
        score += if choice == 1.0 { 2.0 } else { 0.0 };
        score += if choice < 2.0 { 0.3 * whole } else { 0.0 };
        score -= if choice < 2.0 && whole == 4.0 {
            (genome[2] - 1.5).abs()
        } else {
            2.0
        };
        score + noise * super::super::random::unit(&mut random) as f32
    });
    each.collect()
}

#[test]
fn a_race_finds_choices_and_numbers_within_its_budget() {
    let mut found = [0.0; 2];
    for seed in 0..5 {
        let mut race = race(4000, seed);
        let (mut used, mut generations, mut most) = (0, 0, 0);
        while !race.is_over() {
            most = most.max(race.ask().len());
            used += race.ask().len() as u64;
            generations += 1;
            let scores = scores(&race, 0.5);
            race.tell(scores, &[]).unwrap();
        }
        assert!((3500..=4000).contains(&used), "{used}");
        assert!(generations > 30 && most > 50, "{generations} {most}");
        let all = finalists(&race, Vec::new());
        let best = &all[0].genome;
        assert_eq!([best[0], best[1]], [1.5, 4.5]);
        // The luckiest is not among them, in whichever generation it was.
        let others = finalists(&race, best.clone());
        assert!(all.len() > 1 && others == all[1..]);
        found[0] += (best[2] - 1.5).abs() / 5.0;
        found[1] += (best[3] - 0.25).abs() / 5.0;
    }
    // Random candidates are 1.6 and 0.3 off on average.
    assert!(found[0] < 0.15 && found[1] < 0.15, "{found:?}");
}

#[test]
fn candidates_drop_out_after_the_first_test_and_are_asked_as_they_were() {
    let mut race = race(4000, 3);
    let first = race.ask().clone();
    for _ in 0..4 {
        let scores = scores(&race, 0.0);
        race.tell(scores, &[]).unwrap();
        assert_eq!(race.ask(), &first);
    }
    let scores = scores(&race, 0.0);
    race.tell(scores, &[]).unwrap();
    assert!(race.ask().len() < first.len());
    // Whole numbers and choices are between whole numbers.
    for genome in first.genomes() {
        assert_eq!([genome[0], genome[1]].map(|gene| gene - gene.floor()), [0.5; 2]);
        for (gene, [low, high]) in genome.iter().zip(RANGES) {
            assert!((low..=high).contains(gene));
        }
    }
}

/// Rounds say who drops out: the next generation of the same race has the survivors, and the last leaves a few.
#[test]
fn rounds_count_candidates_and_survivors() {
    let mut race = race(4000, 3);
    assert_eq!(race.round(), None);
    let mut rounds: Vec<Round> = Vec::new();
    while !race.is_over() {
        let candidates = race.ask().len() as u32;
        let scores = scores(&race, 0.5);
        race.tell(scores, &[]).unwrap();
        let round = race.round().unwrap();
        assert_eq!(round.candidates, candidates);
        rounds.push(round);
    }
    let races: Vec<&[Round]> = rounds.chunk_by(|a, b| a.race == b.race).collect();
    assert!(races.iter().map(|own| own[0].race).eq(1..=races.len() as u32) && races.len() >= 4);
    for own in races {
        assert!(own.windows(2).all(|pair| pair[0].survivors == pair[1].candidates));
        let last = own[own.len() - 1];
        assert!(
            (1..=few(4) as u32).contains(&last.survivors) && last.survivors < own[0].candidates,
            "{last:?}"
        );
    }
}

/// New candidates come closer to the survivors from race to race.
#[test]
fn the_spread_shrinks() {
    let mut race = race(4000, 1);
    let mut spreads = Vec::new();
    while !race.is_over() {
        spreads.push(race.state.spread);
        let scores = scores(&race, 0.1);
        race.tell(scores, &[]).unwrap();
    }
    spreads.dedup();
    assert!(
        spreads.len() >= 4 && spreads.windows(2).all(|pair| pair[1] < pair[0]),
        "{spreads:?}"
    );
}

/// A budget that is too small for a race still gives a generation.
#[test]
fn a_small_budget_ends_soon() {
    for (lives, generations) in [(1, 1), (10, 2), (13, 2)] {
        let mut race = race(lives, 1);
        for _ in 0..generations {
            assert!(!race.is_over());
            // One more than may survive.
            assert_eq!(race.ask().len(), 5);
            let scores = fitness(race.ask());
            race.tell(scores, &[]).unwrap();
        }
        assert!(race.is_over() && !finalists(&race, Vec::new()).is_empty());
    }
}

#[test]
fn parents_are_drawn_by_their_place() {
    let mut random = stream(1, Stream::Selection, 0);
    let mut counts = [0_u32; 3];
    for _ in 0..60_000 {
        counts[parent(3, &mut random)] += 1;
    }
    for (count, expected) in counts.into_iter().zip([30_000.0, 20_000.0, 10_000.0]) {
        assert!((f64::from(count) - expected).abs() < 500.0, "{counts:?}");
    }
}

/// Children of a candidate: choices follow its chances, numbers with an effect stay close to its numbers, those that
/// had none are drawn again, and those that have none are unchanged.
#[test]
fn children_are_sampled_around_their_parent() {
    let model = Model::new(&Settings::default(), &genes());
    let mut random = stream(3, Stream::Sampling, 0);
    let mut parent = model.first(&mut random);
    let children = |parent: &Candidate, random: &mut _| -> Vec<Vec<f32>> {
        (0..300).map(|_| model.around(parent, 0.01, random).genome).collect()
    };
    let shares = |children: &[Vec<f32>], gene: usize, value: f32| {
        children.iter().filter(|genome| genome[gene] == value).count() as f64 / children.len() as f64
    };
    // Chances are even at first. The whole number has no effect in this parent.
    parent.genome = vec![2.5, 2.5, 1.0, 0.5];
    let all = children(&parent, &mut random);
    for choice in [0.5, 1.5, 2.5] {
        assert!((shares(&all, 0, choice) - 1.0 / 3.0).abs() < 0.1, "{choice}");
    }
    let (same, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|genome| genome[0] == 2.5);
    assert!(same.iter().all(|genome| genome[1..3] == [2.5, 1.0]));
    for whole in [1.5, 2.5, 3.5, 4.5] {
        assert!((shares(&others, 1, whole) - 0.25).abs() < 0.12, "{whole}");
    }
    // With all chances on the parent's choice, the whole number is close to the parent's, and so is the last.
    parent.genome = vec![1.5, 2.5, 1.0, 0.5];
    let all = children(&model.sharpened(&parent, 1.0), &mut random);
    assert!(all.iter().all(|genome| genome[..3] == [1.5, 2.5, 1.0]));
    assert!(
        all.iter()
            .all(|genome| (genome[3] - 0.5).abs() < 0.05 && genome[3] != 0.5)
    );
    // With half of the chances, a third of the other half also has the parent's choice.
    let all = children(&model.sharpened(&parent, 0.5), &mut random);
    assert!((shares(&all, 0, 1.5) - 2.0 / 3.0).abs() < 0.1);
}
