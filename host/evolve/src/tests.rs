//! Properties of every optimiser, and of an evolution with any.

use std::fs;
use std::path::Path;

use oneiro::parameter::Choice;
use oneiro::world::GeneKind;

use super::map_elites::Acceptance;
use super::settings::{CrossoverKind, Descriptor, Feature, MutationKind, SelectionKind};
use super::*;
use crate::pinned::{self, Rows};

const GENES: usize = 18;

/// Every optimiser, of a population of 20, from a seed.
fn all(seed: u64) -> Vec<Box<dyn Optimizer>> {
    let all = Kind::CHOICES.iter().map(|&(_, kind, _)| kind);
    let bred = SelectionKind::CHOICES.iter().map(|&(_, kind, _)| selecting(kind, seed));
    all.map(|kind| of(kind, seed)).chain(bred).collect()
}

/// Tells an optimiser scores, and, as behaviour, the first genes of its genomes.
fn tell(optimizer: &mut dyn Optimizer, fitness: Vec<f32>) -> Result<Generation> {
    let count = optimizer.descriptors();
    let genomes = optimizer.ask().genomes();
    let behaviour: Vec<f64> = genomes
        .flat_map(|genome| &genome[..count])
        .copied()
        .map(f64::from)
        .collect();
    optimizer.tell(fitness, &behaviour)
}

/// An optimiser of a population of 20.
fn of(kind: Kind, seed: u64) -> Box<dyn Optimizer> {
    made(
        Settings {
            kind,
            ..Settings::default()
        },
        seed,
    )
}

/// A gene that is a number, always in effect.
pub(super) fn number(range: Option<[f32; 2]>) -> Gene {
    Gene {
        name: String::new(),
        range,
        kind: GeneKind::Number,
        only: None,
    }
}

fn made(settings: Settings, seed: u64) -> Box<dyn Optimizer> {
    let mut settings = Settings {
        population: 20,
        parents: 4,
        descriptors: ["a", "b"].map(|name| Descriptor::named(name, [-1.0, 1.0], 5)).into(),
        ..settings
    };
    if settings.kind == Kind::Coevolution {
        (
            settings.population,
            settings.parents,
            settings.tables.opponents.contests,
        ) = (5, 1, 2);
    }
    if settings.kind == Kind::OpenEs {
        // Genomes are pinned with these.
        (settings.strategy.sigma, settings.strategy.learning_rate) = (Some(0.02), Some(0.01));
    }
    settings.tables.archive.reevaluated = 3;
    settings.tables.archive.acceptance = Acceptance::Mean;
    settings.complete(GENES, 1, true);
    optimizer(&settings, seed, &vec![number(None); GENES], None)
}

/// Random genes fill their fraction of the initial range, around its middle, and no more; nothing else is drawn
/// differently. With mirrored samples that is true of their mean.
#[test]
fn random_genes_begin_in_their_shares() {
    let shares: Vec<f64> = (0..GENES).map(|gene| [0.0, 0.25, 2.0][gene % 3]).collect();
    let drawn = |kind: Kind, shares: &[f64]| -> Vec<Vec<f64>> {
        let mut settings = Settings {
            kind,
            initial: [1.0, 5.0],
            ..Settings::default()
        };
        settings.initial_shares.0 = shares.to_vec();
        let optimizer = made(settings, 3);
        let genomes = optimizer.ask().genomes();
        let genomes: Vec<Vec<f64>> = genomes
            .map(|genome| genome.iter().copied().map(f64::from).collect())
            .collect();
        if kind != Kind::OpenEs {
            return genomes;
        }
        let mean = |gene: usize| genomes.iter().map(|genome| genome[gene]).sum::<f64>() / genomes.len() as f64;
        vec![(0..GENES).map(mean).collect()]
    };
    for &(_, kind, _) in Kind::CHOICES {
        // Each population of two has its part of the shares.
        if kind.entry().features.contains(&Feature::SetsFirstGenes) || kind == Kind::Coevolution {
            continue;
        }
        for (ours, whole) in drawn(kind, &shares).iter().zip(drawn(kind, &[])) {
            for (gene, (ours, whole)) in ours.iter().zip(whole).enumerate() {
                let expected = 3.0 + shares[gene] * (whole - 3.0);
                assert!((ours - expected).abs() < 1e-5, "{kind:?}: {ours}, {expected}");
            }
        }
    }
}

/// A genetic algorithm with a selection, and with one of the crossovers and mutations that goes with no other.
fn selecting(kind: SelectionKind, seed: u64) -> Box<dyn Optimizer> {
    let (crossover, mutation) = match kind {
        SelectionKind::Truncation => (CrossoverKind::Uniform, MutationKind::Replace),
        SelectionKind::Uniform => (CrossoverKind::None, MutationKind::EvoStick),
        SelectionKind::Rank => (CrossoverKind::TwoPoint, MutationKind::AddVector),
        SelectionKind::Roulette => (CrossoverKind::OnePoint, MutationKind::AddUniform),
        SelectionKind::Tournament => (CrossoverKind::None, MutationKind::AddNormal),
    };
    let mut settings = Settings {
        elite: 2,
        ..Settings::default()
    };
    settings.selection.kind = kind;
    settings.crossover.kind = crossover;
    settings.mutation.kind = mutation;
    made(settings, seed)
}

fn genetic(seed: u64) -> Box<dyn Optimizer> {
    of(Kind::Genetic, seed)
}

/// A mock evaluator: prefers genes near one half.
pub(super) fn fitness(population: &Population) -> Vec<f32> {
    population
        .genomes()
        .map(|genome| -genome.iter().map(|gene| (gene - 0.5) * (gene - 0.5)).sum::<f32>())
        .collect()
}

fn bits(population: &Population) -> Vec<u32> {
    population.values().iter().map(|gene| gene.to_bits()).collect()
}

#[test]
fn asked_again_the_same() {
    const GENERATIONS: u32 = 8;
    for mut optimizer in all(1) {
        let mut changes = 0;
        for generation in 0..GENERATIONS {
            assert_eq!(optimizer.generation(), generation);
            assert_eq!(
                bits(&optimizer.ask().clone()),
                bits(optimizer.ask()),
                "{}",
                optimizer.name()
            );
            let asked = optimizer.ask().clone();
            let generated = tell(&mut *optimizer, fitness(&asked)).unwrap();
            assert_eq!(
                (generated.number, bits(&generated.population)),
                (generation, bits(&asked))
            );
            changes += u32::from(bits(&asked) != bits(optimizer.ask()));
        }
        // In a race the same candidates live on until some drop out.
        let expected = if optimizer.name() == "race" { 1 } else { GENERATIONS };
        assert!(changes >= expected, "{}: {changes}", optimizer.name());
    }
}

#[test]
fn another_number_of_scores_is_refused_without_a_change() {
    for (mut optimizer, mut other) in all(2).into_iter().zip(all(2)) {
        for scores in [0, 1, 19, 21, 40] {
            let before = optimizer.save();
            let failure = tell(&mut *optimizer, vec![0.0; scores]).unwrap_err().to_string();
            assert!(
                failure.contains(&format!("{scores} scores for 20 individuals")),
                "{failure}"
            );
            assert_eq!(optimizer.save(), before);
        }
        // The right ones are taken after that.
        for optimizer in [&mut optimizer, &mut other] {
            let scores = fitness(optimizer.ask());
            tell(&mut **optimizer, scores).unwrap();
        }
        assert_eq!(optimizer.save(), other.save());
    }
}

/// A NaN counts as the worst, whatever its sign: an optimiser continues as if that individual had the worst score of
/// all. A roulette wheel is by scores, not by ranks: there a NaN has no chance.
#[test]
fn nan_is_the_worst_and_is_counted() {
    let is_by_ranks = |(kind, _): &(usize, _)| *kind != Kind::CHOICES.len() + 3;
    let pairs = all(3).into_iter().zip(all(3)).enumerate().filter(is_by_ranks);
    for (_, (mut with, mut without)) in pairs {
        let mut scores: Vec<f32> = (0..20_u8).map(f32::from).collect();
        let mut nan = scores.clone();
        (nan[7], scores[7]) = (-f32::NAN, -1.0);
        let generation = tell(&mut *with, nan).unwrap();
        assert_eq!((generation.nan(), generation.ranking[19]), (1, 7));
        assert_eq!(tell(&mut *without, scores).unwrap().nan(), 0);
        // Some keep scores in their states.
        for _ in 0..3 {
            assert_eq!(bits(with.ask()), bits(without.ask()), "{}", with.name());
            for optimizer in [&mut with, &mut without] {
                tell(&mut **optimizer, (0..20_u8).map(f32::from).collect()).unwrap();
            }
        }
        // All of them.
        let all = tell(&mut *with, vec![f32::NAN; 20]).unwrap();
        assert_eq!(all.nan(), 20);
        assert!(with.ask().values().iter().all(|gene| gene.is_finite()));
    }
}

#[test]
fn saved_and_restored_between_any_two_calls_nothing_changes() {
    for ((mut straight, mut saved), mut fresh) in all(4).into_iter().zip(all(4)).zip(all(4)) {
        for _ in 0..5 {
            let state = saved.save();
            std::mem::swap(&mut saved, &mut fresh);
            saved.restore(&state).unwrap();
            assert_eq!(saved.generation(), straight.generation());
            assert_eq!(bits(saved.ask()), bits(straight.ask()), "{}", saved.name());
            for optimizer in [&mut saved, &mut straight] {
                let scores = fitness(optimizer.ask());
                tell(&mut **optimizer, scores).unwrap();
            }
        }
        assert_eq!(saved.save(), straight.save());
    }
}

/// Each optimiser has pinned genomes, also if it is saved and restored between any two generations. `tests/aarch64.sh` repeats this on
/// 64-bit ARM.
#[test]
fn optimisers_are_as_pinned() {
    let kinds = Kind::CHOICES.iter().map(|&(name, ..)| name);
    let names = kinds.chain(SelectionKind::CHOICES.iter().map(|&(name, ..)| name));
    let mut rows = Rows::default();
    for (index, name) in names.enumerate() {
        let start = || all(9).swap_remove(index);
        let (mut straight, mut resumed) = (start(), start());
        let mut genomes = Vec::new();
        for _ in 0..12 {
            let state = resumed.save();
            resumed = start();
            resumed.restore(&state).unwrap();
            for optimizer in [&mut straight, &mut resumed] {
                let scores = fitness(optimizer.ask());
                tell(&mut **optimizer, scores).unwrap();
            }
            genomes.extend_from_slice(straight.ask().values());
        }
        assert_eq!(straight.save(), resumed.save(), "{name}");
        rows.numbers("genomes", name, &genomes);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/goldens/optimisers");
    pinned::check(&folder.join("genomes.rows"), &rows.to_string());
    pinned::check_folder(&folder, &["genomes.rows".to_owned()]);
}

#[test]
fn damaged_states_and_those_of_others_are_refused_without_a_change() {
    for ((mut optimizer, mut ahead), other) in all(5).into_iter().zip(all(5)).zip(all(6)) {
        let scores = fitness(ahead.ask());
        tell(&mut *ahead, scores).unwrap();
        let (before, good) = (optimizer.save(), ahead.save());
        let mut damaged = good.clone();
        damaged[good.len() / 2] ^= 1;
        for bad in [&[][..], &good[..good.len() - 1], &damaged, &other.save()] {
            optimizer.restore(bad).unwrap_err();
            assert_eq!(optimizer.save(), before, "{}", optimizer.name());
        }
        optimizer.restore(&good).unwrap();
        assert_eq!(optimizer.save(), good);
    }
}

/// The page's table is the registry.
#[test]
fn the_page_lists_all_optimisers() {
    const HEAD: &str = "| `kind` | what it is | use it |\n|---|---|---|\n";
    const GIVEN: &str = "| `kind` | what it makes of given genomes |\n|---|---|\n";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/optimisers.md");
    let page = fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(HEAD).expect("the table's head");
    let (_, after) = rest.split_once("\n\n").expect("the table's end");
    let rows = Kind::entries().map(|Entry { name, about, suits, .. }| {
        let default = if *name == Kind::default().word() {
            " (default)"
        } else {
            ""
        };
        format!("| `\"{name}\"`{default} | {about} | {suits} |\n")
    });
    let written = format!("{before}{HEAD}{}\n{after}", rows.collect::<String>());
    let (before, rest) = written.split_once(GIVEN).expect("the table's head");
    let after = &rest[rest.find("\n- ").expect("the table's end") + 1..];
    let rows = Kind::entries().map(|Entry { name, start, .. }| {
        let words = match start {
            GivenGenomes::None(reason) => format!("refused: {reason}"),
            GivenGenomes::Mean => "its first samples are drawn around their mean".to_owned(),
            GivenGenomes::First(others) => format!("they are the first individuals; the others are {others}"),
        };
        format!("| `\"{name}\"` | {words} |\n")
    });
    let written = format!("{before}{GIVEN}{}\n{after}", rows.collect::<String>());
    if page != written {
        let new = path.with_extension("md.new");
        fs::write(&new, written).unwrap();
        panic!("{} differs from the registry: read {}", path.display(), new.display());
    }
}

/// Of an optimiser that uses behaviour, that of each individual is needed.
#[test]
fn missing_behaviour_is_refused_without_a_change() {
    let kinds = Kind::CHOICES.iter().map(|&(_, kind, _)| kind);
    for kind in kinds.filter(|kind| kind.entry().features.contains(&Feature::Behaviour)) {
        let mut optimizer = of(kind, 2);
        let before = optimizer.save();
        for count in [0, 39, 41] {
            let failure = optimizer
                .tell(vec![0.0; 20], &vec![0.0; count])
                .unwrap_err()
                .to_string();
            assert!(failure.contains("20 individuals; allowed: 40"), "{failure}");
            assert_eq!(optimizer.save(), before);
        }
        optimizer.tell(vec![0.0; 20], &[0.0; 40]).unwrap();
    }
}

/// Two exact optimisers differ only by their seeds, but a grid has no use for one.
#[test]
fn exact_optimisers_are_functions_of_their_seed() {
    for (one, (same, other)) in all(7).iter().zip(all(7).iter().zip(all(8))) {
        assert!(!one.is_exact() || bits(one.ask()) == bits(same.ask()));
        let is_grid = one.name() == "grid";
        assert_eq!(bits(one.ask()) == bits(other.ask()), is_grid, "{}", one.name());
    }
}

#[test]
fn the_better_rank_first_and_of_equals_the_first() {
    assert_eq!(ranked(&[1.0, 3.0, -0.0, 3.0, 0.0]), [1, 3, 0, 2, 4]);
    assert_eq!(
        ranked(&[f32::NAN, -1.0, -f32::NAN, f32::NEG_INFINITY, 2.0]),
        [4, 1, 3, 0, 2]
    );
}

#[test]
fn fitness_is_maximised_and_rises() {
    let mut evolution = Evolution::new(genetic(2), 100, None);
    let mut bests = Vec::new();
    while !evolution.is_finished() {
        let generation = evolution.tell(fitness(evolution.ask()), &[]).unwrap();
        bests.push(generation.fitness[generation.ranking[0] as usize]);
    }
    assert_eq!(bests.len(), 100);
    assert!(bests[99] > bests[0] + 3.0, "{} to {}", bests[0], bests[99]);
    let champion = evolution.champion().expect("a champion");
    assert_eq!(champion.fitness, bests.iter().copied().fold(f32::MIN, f32::max));
    assert_eq!(
        fitness(&Population::new(GENES, champion.genome.clone())),
        [champion.fitness]
    );
}

#[test]
fn nan_is_no_champion_where_there_is_a_number() {
    let mut evolution = Evolution::new(genetic(3), 10, None);
    let mut scores = vec![f32::NAN; 20];
    evolution.tell(scores.clone(), &[]).unwrap();
    assert!(evolution.champion().is_some_and(|champion| champion.fitness.is_nan()));
    scores[7] = -5.0;
    evolution.tell(scores, &[]).unwrap();
    assert!(
        evolution
            .champion()
            .is_some_and(|champion| champion.fitness == -5.0 && champion.individual == 7)
    );
    evolution.tell(vec![f32::NAN; 20], &[]).unwrap();
    assert!(evolution.champion().is_some_and(|champion| champion.generation == 1));
}

#[test]
fn an_evolution_continues_from_where_it_was_saved() {
    let mut whole = Evolution::new(genetic(8), 10, None);
    for _ in 0..3 {
        whole.tell(fitness(whole.ask()), &[]).unwrap();
    }
    let mut restored = Evolution::new(genetic(8), 10, None);
    restored.restore(whole.save()).unwrap();
    for evolution in [&mut whole, &mut restored] {
        evolution.tell(fitness(evolution.ask()), &[]).unwrap();
    }
    assert_eq!(whole.save(), restored.save());
    assert_eq!((whole.generation(), restored.generation()), (4, 4));
    Evolution::new(genetic(9), 10, None).restore(whole.save()).unwrap_err();
}

/// The settings of [`of`], once they are complete.
fn settings_of(kind: Kind) -> Settings {
    let mut settings = Settings {
        kind,
        population: 20,
        parents: 4,
        descriptors: ["a", "b"].map(|name| Descriptor::named(name, [-1.0, 1.0], 5)).into(),
        ..Settings::default()
    };
    if kind == Kind::Coevolution {
        settings.tables.opponents.first_gene = "second".into();
    }
    settings.complete(GENES, 1, true);
    settings
}

/// Genes of which the tenth is the first of a second population.
fn genes() -> Vec<Gene> {
    let mut genes = vec![number(None); GENES];
    genes[9].name = "second".into();
    genes
}

/// This many genomes, all different.
fn some(count: usize) -> Population {
    let values = (0..count * GENES).map(|gene| (gene % 37) as f32 / 64.0 - 0.25);
    Population::new(GENES, values.collect())
}

/// The individuals of a first generation: of two populations, each with that of the other.
fn individuals(kind: Kind, optimizer: &dyn Optimizer) -> Population {
    let asked = optimizer.ask();
    if kind != Kind::Coevolution {
        return asked.clone();
    }
    let contests = asked.len() / 40;
    let pairs = (0..20).flat_map(|individual| {
        let [first, second] = [individual, 20 + individual].map(|own| asked.genome(own * contests));
        [&first[..9], &second[9..]].concat()
    });
    Population::new(GENES, pairs.collect())
}

/// What each kind makes of one genome, of several and of as many as it takes is what its entry says, and without any it begins as ever.
#[test]
fn given_genomes_begin_every_kind_as_its_entry_says() {
    for &(name, kind, _) in Kind::CHOICES {
        let (settings, genes) = (settings_of(kind), genes());
        let begun = |init: Option<Population>| optimizer(&settings, 7, &genes, init);
        let most = most_given(&settings, &genes);
        let random = individuals(kind, &*begun(None));
        for count in [1, 3, most.unwrap_or(50)] {
            let given = some(count);
            let optimizer = match given_genomes(&settings) {
                GivenGenomes::None(_) => {
                    assert_eq!(most, Some(0), "{name}");
                    continue;
                }
                _ => begun(Some(given.clone())),
            };
            let first = individuals(kind, &*optimizer);
            assert_eq!(
                bits(&first),
                bits(&individuals(kind, &*begun(Some(given.clone())))),
                "{name}"
            );
            assert_ne!(bits(&first), bits(&random), "{name}");
            let distance = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>();
            match given_genomes(&settings) {
                GivenGenomes::Mean => {
                    // The samples of the same numbers, moved to the mean.
                    let middle = begun(Some(Population::new(GENES, vec![0.0; GENES])));
                    for (sample, unmoved) in first.genomes().zip(middle.ask().genomes()) {
                        for gene in 0..GENES {
                            let mean =
                                given.genomes().map(|genome| f64::from(genome[gene])).sum::<f64>() / count as f64;
                            let moved = f64::from(sample[gene]) - f64::from(unmoved[gene]);
                            assert!((moved - mean).abs() < 1e-5, "{name}: {moved}, {mean}");
                        }
                    }
                }
                GivenGenomes::First(others) => {
                    for (index, genome) in given.genomes().enumerate() {
                        assert_eq!(first.genome(index), genome, "{name}");
                    }
                    for index in count..first.len() {
                        if others == "random" {
                            assert_eq!(first.genome(index), random.genome(index), "{name}");
                            continue;
                        }
                        let nearest = given.genomes().map(|genome| distance(genome, first.genome(index)));
                        let from_random = distance(random.genome(index), first.genome(index));
                        assert!(nearest.fold(f32::MAX, f32::min) < from_random, "{name}");
                    }
                    let rest: Vec<_> = first.genomes().skip(count).map(<[f32]>::to_vec).collect();
                    assert!(
                        rest.windows(2).any(|pair| pair[0] != pair[1]) || rest.len() < 2,
                        "{name}: no variety"
                    );
                }
                GivenGenomes::None(_) => unreachable!(),
            }
        }
    }
}

/// A state that was saved for fewer generations continues with more, as one that had them from the start.
#[test]
fn open_ended_optimisers_go_on_for_more_generations() {
    for &(name, kind, _) in Kind::CHOICES {
        let (settings, genes) = (settings_of(kind), genes());
        if !settings.is_open_ended() {
            assert!([Kind::Grid, Kind::Race].contains(&kind), "{name}");
            continue;
        }
        let with = |generations: u32| {
            let settings = Settings {
                generations,
                ..settings.clone()
            };
            Evolution::new(
                optimizer(&settings, 7, &genes, Some(some(2)).filter(|_| kind != Kind::Random)),
                generations,
                None,
            )
        };
        let told = |evolution: &mut Evolution| {
            while !evolution.is_finished() {
                let asked = evolution.ask().clone();
                let count = evolution.optimizer().descriptors();
                let behaviour: Vec<f64> = asked
                    .genomes()
                    .flat_map(|genome| &genome[..count])
                    .map(|gene| f64::from(*gene))
                    .collect();
                evolution.tell(fitness(&asked), &behaviour).unwrap();
            }
        };
        let (mut short, mut long) = (with(4), with(9));
        told(&mut short);
        with(9).restore(short.save()).unwrap_err();
        let mut extended = with(4);
        extended.restore(short.save()).unwrap();
        extended.set_generations(9);
        let mut continued = with(9);
        continued.restore(extended.save()).unwrap();
        for evolution in [&mut extended, &mut continued, &mut long] {
            told(evolution);
        }
        assert_eq!(extended.save(), long.save(), "{name}");
        assert_eq!(continued.save(), long.save(), "{name}");
    }
}

/// What was a valid default stays, and others follow from the population.
#[test]
fn the_default_number_of_parents_divides_the_population() {
    for population in 1..500 {
        let parents = Settings::parents_of(population);
        assert!(
            parents >= 1 && population.is_multiple_of(parents),
            "{population}: {parents}"
        );
        assert!(
            !population.is_multiple_of(20) || parents == 20,
            "{population}: {parents}"
        );
    }
    assert_eq!([10, 50, 30, 7, 64].map(Settings::parents_of), [2, 10, 6, 1, 8]);
}
