//! Packing of rollouts into batches.

use std::sync::Arc;

use oneiro::batch::{Batch, GREATEST_GENE, LANES, LEAST_GENE, PartResult, Record, Rollout, TraceRequest, Worlds};
use oneiro::random::Key;
use oneiro::world::{Controller, Robot, World, WorldSpec};

fn world(change: impl Fn(&mut WorldSpec)) -> World {
    let mut spec = WorldSpec::miglino1995();
    change(&mut spec);
    World::new(spec).unwrap()
}

/// Rollouts in the given worlds, with genes and keys that identify them.
struct Crowd {
    worlds: Vec<usize>,
    genes: Vec<Vec<f32>>,
}

impl Crowd {
    fn new(all: &[World], worlds: Vec<usize>) -> Self {
        let genes = worlds.iter().enumerate();
        let genes = genes
            .map(|(index, &world)| vec![index as f32; all[world].genes()])
            .collect();
        Self { worlds, genes }
    }

    fn rollouts(&self) -> Vec<Rollout<'_>> {
        let all = self.worlds.iter().zip(&self.genes).enumerate();
        all.map(|(index, (&world, genes))| Rollout {
            world,
            genes,
            key: Key::of_words([index as u32, 7]),
        })
        .collect()
    }
}

fn batch(worlds: &[World], of: impl Iterator<Item = usize>, trace: Option<TraceRequest>) -> Batch {
    Batch::new(worlds, &Crowd::new(worlds, of.collect()).rollouts(), trace).unwrap()
}

#[test]
fn rollouts_are_grouped_by_world_in_their_order() {
    let worlds = [
        world(|spec| spec.cycles = 10),
        world(|spec| spec.cycles = 30),
        world(|spec| spec.cycles = 20),
    ];
    // World 1 gets none; 0 and 2 take turns, 100 each.
    let batch = batch(&worlds, (0..200).map(|index| 2 * (index % 2)), None);
    assert_eq!((batch.rollouts(), batch.groups(), batch.cycles()), (200, 4, 0..20));
    assert_eq!(batch.steps(), 100 * 10 + 100 * 20);
    let groups: Vec<_> = batch
        .all()
        .group_table()
        .iter()
        .map(|group| (group.world, group.rollouts))
        .collect();
    assert_eq!(groups, [(0, 64), (0, 36), (2, 64), (2, 36)]);

    for rollout in 0..200 {
        let slot = batch.slot(rollout).unwrap();
        assert_eq!(batch.rollout(slot), Some(rollout));
        assert_eq!(slot, (rollout % 2) * 2 * LANES + rollout / 2);
        // The key's two words and the trial, then 18 genes, each 64 lanes wide.
        let group = batch.all().group_table()[slot / LANES];
        let input = |field: usize| batch.all().inputs()[group.inputs as usize + field * LANES + slot % LANES];
        assert_eq!((input(0), input(1)), (rollout as u32, 7));
        assert_eq!(input(2), 0);
        assert!((3..21).all(|field| input(field) == (rollout as f32).to_bits()));
    }
    assert_eq!(batch.slot(200), None);
    assert_eq!(batch.rollout(100), None, "an idle slot");
    assert_eq!(batch.all().inputs().len(), 4 * 21 * LANES);
}

#[test]
fn parts_are_the_whole_cut_up() {
    let hidden = |units| world(|spec| spec.controller = Controller::Hidden { units });
    let worlds = [hidden(1), hidden(32)];
    let batch = batch(&worlds, (0..300).map(|index| index / 150), None);
    let whole = batch.all();
    for cut in 0..=batch.groups() {
        let (left, right) = (whole.part(0..cut), whole.part(cut..u32::MAX));
        assert_eq!([left.inputs(), right.inputs()].concat(), whole.inputs());
        assert_eq!([left.group_table(), right.group_table()].concat(), whole.group_table());
        assert_eq!(left.first_input(), 0);
        assert_eq!(right.first_input() as usize, left.inputs().len());
        assert_eq!(left.slots() + right.slots(), whole.slots());
        assert_eq!(left.rollouts() + right.rollouts(), 300);
        assert_eq!(left.steps() + right.steps(), batch.steps());
        assert_eq!(right.part(0..1).groups(), cut..(cut + 1).min(batch.groups()));
    }
    assert_eq!(batch.part(7..99).slots(), 0);
}

#[test]
fn equal_tables_are_packed_once() {
    let own_tables = |spec: &mut WorldSpec| {
        let Robot { sensors, motors, .. } = &spec.robot;
        let robot = Robot {
            sensors: Arc::new((**sensors).clone()),
            motors: Arc::new((**motors).clone()),
            ..spec.robot.clone()
        };
        spec.robot = robot;
    };
    let one = batch(&[world(|_| ())], std::iter::once(0), None);
    assert_eq!(one.all().tables().len(), 2 * 3600 + 400);
    let worlds = [world(|_| ()), world(own_tables), world(|spec| spec.arena.walls.clear())];
    let three = batch(&worlds, 0..3, None);
    assert_eq!(three.all().tables(), one.all().tables());
    assert_eq!(three.all().shapes().len(), 7 + 7 + 3);
    let first_shapes: Vec<_> = three.all().worlds().iter().map(|world| world.first_shape).collect();
    assert_eq!(first_shapes, [0, 7, 14]);
    // A different cell makes a different table.
    let mut scaled = (*WorldSpec::miglino1995().robot.motors).clone();
    scaled.cells[0].turn = 0.25;
    let other = world(|spec| spec.robot.motors = Arc::new(scaled.clone()));
    assert_eq!(
        batch(&[world(|_| ()), other], 0..2, None).all().tables().len(),
        2 * 3600 + 2 * 400
    );
}

#[test]
fn no_buffer_is_empty() {
    let empty = world(|spec| {
        spec.arena.walls.clear();
        spec.arena.obstacles.clear();
    });
    let batch = batch(&[empty], std::iter::once(0), None);
    assert!(!batch.all().shapes().is_empty());
    assert_eq!(batch.all().worlds()[0].shapes, 0);
}

#[test]
fn genes_near_zero_count_as_zero() {
    let worlds = [world(|_| ())];
    let mut genes = [1.0_f32; 18];
    genes[..6].copy_from_slice(&[
        -0.0,
        f32::MIN_POSITIVE / 2.0,
        -1e-30,
        LEAST_GENE,
        -LEAST_GENE,
        GREATEST_GENE,
    ]);
    let batch = Batch::new(
        &worlds,
        &[Rollout {
            world: 0,
            genes: &genes,
            key: Key::of_words([0, 0]),
        }],
        None,
    )
    .unwrap();
    let packed = |gene: usize| batch.all().inputs()[(3 + gene) * LANES];
    assert_eq!([packed(0), packed(1), packed(2)], [0, 0, 0]);
    assert_eq!(
        [packed(3), packed(4), packed(5)],
        [LEAST_GENE, -LEAST_GENE, GREATEST_GENE].map(f32::to_bits)
    );
}

#[test]
fn bad_rollouts_are_refused_by_index() {
    let worlds = [world(|_| ()), world(|spec| spec.cycles = 7)];
    let good = [0.5_f32; 18];
    for bad in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1.01 * GREATEST_GENE,
        -2.0 * GREATEST_GENE,
    ] {
        let mut genes = good;
        genes[17] = bad;
        let of = |genes| Rollout {
            world: 0,
            genes,
            key: Key::of_words([0, 0]),
        };
        let invalid = Batch::new(&worlds, &[of(&good[..]), of(&genes[..])], None).unwrap_err();
        assert_eq!(invalid.field, "rollouts[1].genes[17]");
        assert_eq!(invalid.problem, format!("is {bad}; allowed: -1000000 to 1000000"));
    }
    let one = |world, genes: &[f32], trace| {
        Batch::new(
            &worlds,
            &[Rollout {
                world,
                genes,
                key: Key::of_words([0, 0]),
            }],
            trace,
        )
        .unwrap_err()
        .to_string()
    };
    assert_eq!(one(2, &good, None), "rollouts[0].world: is 2; allowed: 0 to 1");
    let problem = "rollouts[0].genes: there are 17; allowed: 18, for its world's controller";
    assert_eq!(one(1, &good[..17], None), problem);
    assert_eq!(
        one(1, &good, Some(TraceRequest { every: 0 })),
        "trace.every: is 0; allowed: at least 1 cycle"
    );
    let none = Batch::new(&worlds, &[], None).unwrap_err().to_string();
    assert!(none.starts_with("rollouts: there are 0; allowed: 1 to"), "{none}");
    assert!(
        Batch::new::<World>(&[], &[], None)
            .unwrap_err()
            .to_string()
            .starts_with("worlds: is empty")
    );
}

#[test]
fn kinds_of_controllers_do_not_mix() {
    let worlds = [world(|_| ()), world(|spec| spec.controller = Controller::Recurrent)];
    let invalid = Batch::new(&worlds, &[], None).unwrap_err();
    assert_eq!(invalid.field, "worlds[1].kernel");
    assert!(invalid.problem.contains("allowed: one kernel per batch"), "{invalid}");
}

#[test]
fn traces_that_fill_the_memory_are_refused() {
    let worlds = [world(|spec| spec.cycles = 1_000_000)];
    let invalid = Batch::new(
        &worlds,
        &Crowd::new(&worlds, vec![0; 65]).rollouts(),
        Some(TraceRequest { every: 1 }),
    );
    let invalid = invalid.unwrap_err();
    let words = 128 * 1_000_000 * (Record::FIELDS.len() + 16);
    assert!(
        invalid.field == "trace" && invalid.problem.contains(&format!("{words} words in all; allowed:")),
        "{invalid}"
    );
}

/// Batches share packed worlds, whichever of them they use; the rest is their own.
#[test]
fn worlds_serve_many_batches() {
    let worlds = [world(|spec| spec.cycles = 10), world(|spec| spec.cycles = 25)];
    let packed = Worlds::new(&worlds).unwrap();
    let both = batch(&worlds, 0..2, None);
    for (world, cycles, rollouts) in [(1, 25, 1), (0, 10, 100), (1, 25, 130)] {
        let crowd = Crowd::new(&worlds, vec![world; rollouts]);
        let one = packed.batch(&crowd.rollouts(), None).unwrap();
        assert_eq!(
            (one.steps(), one.cycles()),
            (rollouts as u64 * u64::from(cycles), 0..cycles)
        );
        assert_eq!(one.all().worlds(), both.all().worlds());
        assert_eq!(one.all().shapes(), both.all().shapes());
        assert_eq!(one.all().tables(), both.all().tables());
        let groups = one.all().group_table();
        assert!(groups.iter().all(|group| group.world as usize == world));
        assert_eq!(groups.len(), rollouts.div_ceil(LANES));
        assert_eq!(one.all().inputs().len(), groups.len() * 21 * LANES);
    }
}

/// The first cycles of lives, without the states that a stretch keeps.
#[test]
fn beginnings_keep_no_states() {
    let worlds = [world(|spec| spec.cycles = 10), world(|spec| spec.cycles = 25)];
    let packed = Worlds::new(&worlds).unwrap();
    let crowd = Crowd::new(&worlds, vec![0, 1, 1]);
    let beginnings = packed.beginnings(&crowd.rollouts(), 20).unwrap();
    let stretch = packed.stretch(&crowd.rollouts(), 0..20, &[], None).unwrap();
    assert!(!beginnings.keeps_states() && stretch.keeps_states());
    assert_eq!(beginnings.steps(), 10 + 20 + 20);
    assert_eq!(
        (beginnings.cycles(), beginnings.steps()),
        (stretch.cycles(), stretch.steps())
    );
    assert_eq!(beginnings.all().inputs(), stretch.all().inputs());
    let refused = packed.beginnings(&crowd.rollouts(), 0).unwrap_err();
    assert_eq!(refused.to_string(), "cycles: are 0; allowed: at least 1");
}

/// Lists that are packed at the same time make the batch of one list, and its errors.
#[test]
fn lists_are_packed_as_one() {
    let worlds = [world(|spec| spec.cycles = 10), world(|spec| spec.cycles = 25)];
    let packed = Worlds::new(&worlds).unwrap();
    // More than one thread packs of one list, too.
    let crowd = Crowd::new(&worlds, (0..10_000).map(|index| usize::from(index % 7 > 2)).collect());
    let rollouts = crowd.rollouts();
    let one = packed.batch(&rollouts, None).unwrap();
    let words = |batch: &Batch| {
        let part = batch.all();
        let groups: Vec<_> = part
            .group_table()
            .iter()
            .map(|group| (group.world, group.rollouts, group.inputs))
            .collect();
        let slots: Vec<_> = (0..batch.rollouts()).map(|rollout| batch.slot(rollout)).collect();
        (groups, slots, part.inputs().to_vec())
    };
    // Idle slots are clear, of both worlds.
    let (groups, _, inputs) = words(&one);
    let idle: Vec<_> = groups
        .iter()
        .filter(|(_, rollouts, _)| *rollouts < LANES as u32)
        .collect();
    assert_eq!(idle.len(), 2);
    for (_, rollouts, first) in idle {
        let fields = inputs[*first as usize..].chunks_exact(LANES).take(21);
        assert!(
            fields
                .flat_map(|field| &field[*rollouts as usize..])
                .all(|&word| word == 0)
        );
    }
    for sizes in [&[10_000][..], &[0, 1, 63, 64, 65, 0, 9807], &[5000, 5000]] {
        let mut rest = rollouts.iter().copied();
        let lists: Vec<Vec<Rollout<'_>>> = sizes.iter().map(|&size| rest.by_ref().take(size).collect()).collect();
        let several = packed.batch_of(&lists, None).unwrap();
        assert!(words(&several) == words(&one), "{sizes:?}");
        let mut bad = lists.clone();
        let last = bad.last_mut().unwrap();
        last.last_mut().unwrap().genes = &[f32::NAN; 18];
        let invalid = packed.batch_of(&bad, None).unwrap_err();
        assert_eq!(invalid.field, "rollouts[9999].genes[0]", "{sizes:?}");
        let first = bad.iter().position(|list| !list.is_empty()).unwrap();
        bad[first][0].genes = &[];
        let invalid = packed.batch_of(&bad, None).unwrap_err();
        assert_eq!(invalid.field, "rollouts[0].genes", "{sizes:?}");
        bad[first][0].world = 2;
        let invalid = packed.batch_of(&bad, None).unwrap_err();
        assert_eq!(invalid.field, "rollouts[0].world", "{sizes:?}");
    }
    assert_eq!(packed.batch_of(&[Vec::new()], None).unwrap_err().field, "rollouts");
}

#[test]
fn outcomes_are_in_the_order_of_the_rollouts() {
    let worlds = [world(|spec| spec.cycles = 10), world(|spec| spec.cycles = 25)];
    let batch = batch(
        &worlds,
        (0..130).map(|index| index % 2),
        Some(TraceRequest { every: 10 }),
    );
    assert_eq!((batch.trace_every(), batch.trace_records()), (10, 3));
    let slots = batch.all().slots();
    let record = |slot: usize, index: usize| Record {
        x: slot as f32,
        y: index as f32,
        ..Record::default()
    };
    let result = PartResult {
        fitness: (0..slots).map(|slot| slot as f32).collect(),
        trace: (0..slots * 3)
            .flat_map(|at| {
                let words: [u32; Record::FIELDS.len()] = bytemuck::cast(record(at / 3, at % 3));
                words.into_iter().chain([at as u32; 16])
            })
            .collect(),
        states: Vec::new(),
    };
    let outcome = batch.outcome(result);
    for rollout in 0..130 {
        let slot = batch.slot(rollout).unwrap();
        assert_eq!(outcome.fitness[rollout], slot as f32);
        let own = if rollout % 2 == 0 { 1 } else { 3 };
        let expected: Vec<Record> = (0..own).map(|index| record(slot, index)).collect();
        let trace = &outcome.traces[rollout];
        assert_eq!(trace[..], expected);
        for index in 0..own {
            assert_eq!(trace.details(index), [(slot * 3 + index) as u32; 16]);
        }
    }
}
