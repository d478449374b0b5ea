//! State machines: each cycle beside a second program, written from `docs/controllers.md`; genomes and texts; the same bits
//! everywhere; refusals.

use std::path::Path;

use oneiro::arena::Arena;
use oneiro::batch::{Batch, Outcome, Rollout, Trace, TraceRequest};
use oneiro::compose::{DetailKind, Kind};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::state_machine::{self, Behaviour, Condition, Machine, State, StateMachine, Transition};
use oneiro::world::{Controller, GeneKind, World, WorldSpec};

#[allow(dead_code, reason = "other tests use the rest")]
mod epucks;
mod pinned;
use epucks::{disc, epucks, lamp};

/// Twenty e-pucks on a floor of three greys, with a lamp.
fn spec(count: u32) -> WorldSpec {
    let corner = |side: f32| [side, -side];
    let [a, b] = corner(900.0);
    let mut arena = Arena::polygon(&[[b, b], [a, b], [a, a], [b, a]], None);
    arena.floor = Some(0.498);
    arena.wall_height = Some(80.0);
    arena.patches = vec![disc(-500.0, 0.0, 350.0, 0.0), disc(500.0, 0.0, 350.0, 1.0)];
    arena.lights = vec![lamp(0.0, -1000.0, 750.0, 5.0)];
    let reference = Reference {
        signal_loss: Some(0.7),
        ..Reference::DEFAULT
    };
    WorldSpec {
        robot: epucks(Model::Vectors, reference, count),
        arena,
        controller: Controller::StateMachine(StateMachine::DEFAULT),
        cycles: 100,
        ..WorldSpec::miglino1995()
    }
}

/// A genome whose genes are uniform in their ranges.
fn genome(world: &World, life: u32) -> Vec<f32> {
    let gene = |(index, range): (usize, Option<[f32; 2]>)| {
        let [least, greatest] = range.unwrap();
        let share = (pcg4d([life, index as u32, 0, 2029])[0] >> 8) as f32 / 16_777_216.0;
        least + share * (greatest - least)
    };
    world.gene_layout().ranges().into_iter().enumerate().map(gene).collect()
}

fn batch(world: &World, genomes: &[Vec<f32>], every: u32) -> Batch {
    let lives: Vec<_> = (0_u64..)
        .zip(genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    Batch::new(std::slice::from_ref(world), &lives, Some(TraceRequest { every })).unwrap()
}

fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Outcome {
    evaluator.evaluate(batch, &Control::new()).unwrap()
}

/// The numbers, from 0 to less than 1, that a robot draws in a cycle: four of each block.
fn drawn(key: [u32; 2], step: u32, block: u32) -> [f64; 4] {
    let [a, b] = key;
    pcg4d([a, b, step, 6 << 16 | block]).map(|word| f64::from(word >> 8) / 16_777_216.0)
}

/// A robot as the second program has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory {
    state: usize,
    age: u32,
    turning: i32,
}

/// The wheels' speeds, as shares of the greatest, along a vector.
fn along([ahead, left]: [f64; 2]) -> [f64; 2] {
    if ahead.hypot(left) < 0.1 {
        return [1.0, 1.0];
    }
    let inner = left.atan2(ahead).cos().max(-0.5);
    if left > 0.0 { [inner, 1.0] } else { [1.0, inner] }
}

fn holds(condition: Condition, ground: f64, neighbours: f64) -> f64 {
    let more_than = |crowd: state_machine::Crowd| {
        1.0 / (1.0 + (f64::from(crowd.steepness) * (f64::from(crowd.neighbours) - neighbours)).exp())
    };
    match condition {
        Condition::BlackFloor(p) => {
            if ground == 0.0 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::GreyFloor(p) => {
            if ground == 0.5 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::WhiteFloor(p) => {
            if ground == 1.0 {
                p.into()
            } else {
                0.0
            }
        }
        Condition::NeighbourCount(crowd) => more_than(crowd),
        Condition::InvertedNeighbourCount(crowd) => 1.0 - more_than(crowd),
        Condition::FixedProbability(p) => p.into(),
    }
}

/// What a robot does in a cycle, and its memory afterwards; `readings` in the order of the model's.
fn cycle(machine: &Machine, before: Memory, readings: &[f64], key: [u32; 2], step: u32) -> ([f64; 2], Memory) {
    let [near, light, others] = [0, 2, 6].map(|first| [readings[first], readings[first + 1]]);
    let State { behaviour, transitions } = &machine.states[before.state];
    let plus = |a: f64, v: [f64; 2], b: f64, w: [f64; 2]| [a * v[0] + b * w[0], a * v[1] + b * w[1]];
    let mut after = before;
    if before.age == 0 {
        after.turning = 0;
    }
    let wheels = match *behaviour {
        Behaviour::Exploration { .. } if after.turning > 0 => {
            after.turning -= 1;
            [-1.0, 1.0]
        }
        Behaviour::Exploration { .. } if after.turning < 0 => {
            after.turning += 1;
            [1.0, -1.0]
        }
        Behaviour::Exploration { turning } => {
            if near[0].hypot(near[1]) >= 0.1 && near[1].atan2(near[0]).abs() <= std::f64::consts::FRAC_PI_2 {
                let cycles = ((drawn(key, step, 2)[0] * f64::from(turning + 1)) as i32).max(1);
                after.turning = if near[1] < 0.0 { cycles } else { -cycles };
            }
            [1.0, 1.0]
        }
        Behaviour::Stop => [0.0, 0.0],
        Behaviour::Phototaxis => along(plus(1.0, light, -5.0, near)),
        Behaviour::AntiPhototaxis => along(plus(-1.0, light, -5.0, near)),
        Behaviour::Attraction { strength } => along(plus(strength.into(), others, -6.0, near)),
        Behaviour::Repulsion { strength } => along(plus((-strength).into(), others, -5.0, near)),
    };
    after.age += 1;
    if before.age > 0 {
        let (chances, order) = (drawn(key, step, 0), drawn(key, step, 1));
        let mut shuffled: Vec<usize> = (0..transitions.len()).collect();
        shuffled.sort_by(|&a, &b| order[a].total_cmp(&order[b]));
        let first = shuffled
            .into_iter()
            .find(|&nth| chances[nth] < holds(transitions[nth].condition, readings[4], readings[5]));
        if let Some(nth) = first {
            let others: Vec<_> = (0..machine.states.len()).filter(|own| *own != before.state).collect();
            after.state = others[transitions[nth].to];
            after.age = 0;
        }
    }
    (wheels, after)
}

/// Cycles whose outputs or memory are not those of the second program, of all, and which behaviours and conditions occurred.
fn off(change: impl Fn(&mut Machine)) -> (usize, usize, [usize; 6]) {
    let world = World::new(spec(20)).unwrap();
    let genomes: Vec<_> = (0..90).map(|life| genome(&world, life)).collect();
    let outcome = evaluated(&mut Cpu::new(Some(2)).unwrap(), &batch(&world, &genomes, 1));
    let place = |kind: DetailKind| {
        let all = (0..).zip(world.details());
        all.filter(|(_, own)| own.kind == kind)
            .map(|(index, _)| index)
            .collect::<Vec<usize>>()
    };
    let (perceived, memory) = (
        place(DetailKind::Perceived),
        place(DetailKind::Memory(Kind::Controller)),
    );
    let (mut wrong, mut all, mut seen) = (0, 0, [0; 6]);
    for ((genome, trace), life) in genomes.iter().zip(&outcome.traces).zip(0..) {
        let mut machine = Machine::of(genome);
        change(&mut machine);
        let Key([a, b]) = Key::rollout(1, 0, life, 0);
        // The first robot's key.
        let [a, b, ..] = pcg4d([a, b, 0, 0xff00]);
        let mut own = Memory {
            state: 0,
            age: 0,
            turning: 0,
        };
        for (step, (record, details)) in (0..).zip(trace.lines()) {
            let readings: Vec<_> = perceived
                .iter()
                .map(|&place| f64::from(f32::from_bits(details[place])))
                .collect();
            seen[match machine.states[own.state].behaviour {
                Behaviour::Exploration { .. } => 0,
                Behaviour::Stop => 1,
                Behaviour::Phototaxis => 2,
                Behaviour::AntiPhototaxis => 3,
                Behaviour::Attraction { .. } => 4,
                Behaviour::Repulsion { .. } => 5,
            }] += 1;
            let (wheels, after) = cycle(&machine, own, &readings, [a, b], step);
            let found = Memory {
                state: details[memory[0]] as usize,
                age: details[memory[1]],
                turning: details[memory[2]].cast_signed(),
            };
            let is_off = |(wheel, output): (f64, f32)| (0.5 + 0.5 * wheel - f64::from(output)).abs() > 1e-5;
            all += 1;
            wrong += usize::from(found != after || wheels.into_iter().zip([record.left, record.right]).any(is_off));
            own = Memory {
                state: found.state.min(machine.states.len() - 1),
                ..found
            };
        }
    }
    (wrong, all, seen)
}

#[test]
fn cycles_are_those_of_the_second_program() {
    let (wrong, all, seen) = off(|_| ());
    assert_eq!((wrong, all), (0, 90 * 100));
    assert!(seen.iter().all(|cycles| *cycles > 100), "{seen:?}");
    // A machine that is another in one value is seen at once.
    let (wrong, ..) = off(|machine| {
        for transition in machine.states.iter_mut().flat_map(|state| &mut state.transitions) {
            if let Condition::FixedProbability(p) = &mut transition.condition {
                *p *= 0.9;
            }
        }
    });
    assert!(wrong > 10, "{wrong}");
}

/// Selects a value of a state machine.
type Field = fn(&mut StateMachine) -> &mut Option<f32>;

/// Each value changes lives, and its default changes none.
#[test]
fn values_reach_the_kernel() {
    let lived = |machine: StateMachine| {
        let controller = Controller::StateMachine(machine);
        let world = World::new(WorldSpec { controller, ..spec(20) }).unwrap();
        let genomes: Vec<_> = (0..40).map(|life| genome(&world, life)).collect();
        let outcome = evaluated(&mut Cpu::new(Some(2)).unwrap(), &batch(&world, &genomes, 1));
        outcome.traces.iter().flat_map(Trace::words).collect::<Vec<u32>>()
    };
    let set: [(f32, f32, Field); 5] = [
        (0.1, 0.5, |own| &mut own.obstacle),
        (5.0, 2.0, |own| &mut own.avoidance),
        (6.0, 2.0, |own| &mut own.attraction_avoidance),
        (0.1, 0.5, |own| &mut own.least_vector),
        (-0.5, 0.5, |own| &mut own.slowest_wheel),
    ];
    let usual = lived(StateMachine::DEFAULT);
    for (number, (default, other, field)) in set.into_iter().enumerate() {
        let with = |value| {
            let mut machine = StateMachine::DEFAULT;
            *field(&mut machine) = Some(value);
            lived(machine)
        };
        assert!(with(default) == usual && with(other) != usual, "value {number}");
    }
}

#[test]
fn the_same_bits_everywhere() {
    let mut rows = pinned::Rows::default();
    let world = World::new(spec(10)).unwrap();
    let genomes: Vec<_> = (0..70).map(|life| genome(&world, life)).collect();
    let whole = batch(&world, &genomes, 7);
    let expected = evaluated(&mut Cpu::new(Some(2)).unwrap(), &whole);
    let bits = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    let words = |outcome: &Outcome| outcome.traces.iter().flat_map(Trace::words).collect::<Vec<u32>>();
    let check = |device: &str, evaluator: &mut dyn Evaluator| {
        let found = evaluated(evaluator, &whole);
        assert_eq!(bits(&found.fitness), bits(&expected.fitness), "{device}");
        assert!(words(&found) == words(&expected), "{device}");
    };
    check("cut lives", &mut Cpu::new(Some(1)).unwrap().with_chunk(7));
    #[cfg(feature = "gpu")]
    check(
        "gpu",
        &mut oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter"),
    );
    let few = batch(&world, &genomes[..2], 7);
    let interpreted = Cpu::new(Some(2)).unwrap().with_variant("interpretedx1");
    let found = evaluated(&mut interpreted.unwrap(), &few);
    assert_eq!(bits(&found.fitness), bits(&expected.fitness[..2]));
    rows.numbers("fitness", "state machines", &expected.fitness);
    rows.words("trace", "state machines", &words(&expected));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("goldens/composed/state-machines.rows");
    if let Some(problem) = pinned::problem(&path, &rows.to_string()) {
        panic!("{problem}");
    }
}

/// Genome to machine to text and back, for machines of all kinds.
#[test]
fn genomes_and_texts_are_the_same_machines() {
    let world = World::new(spec(1)).unwrap();
    let layout = world.gene_layout();
    assert_eq!(layout.genes(), 97);
    assert!(state_machine::is_layout_of(layout));
    let [mut states, mut transitions] = [[0; 5]; 2];
    for life in 0..2000 {
        let genes = genome(&world, life);
        let machine = Machine::of(&genes);
        states[machine.states.len()] += 1;
        for state in &machine.states {
            transitions[state.transitions.len()] += 1;
        }
        let text = machine.to_string();
        assert_eq!(state_machine::parse(&text).unwrap(), machine, "{text}");
        assert_eq!(Machine::of(&machine.genome()), machine, "{text}");
        // Genes without an effect are those that the layout says.
        let genome = machine.genome();
        let is_active = |mut gene: usize| loop {
            match layout.all()[gene].only {
                None => return true,
                Some((of, values)) if values.contains(&(genes[of] as u32)) => gene = of,
                Some(_) => return false,
            }
        };
        for (gene, own) in layout.all().iter().enumerate() {
            let mut other = genome.clone();
            let [least, greatest] = own.range.unwrap();
            other[gene] = if genome[gene] < f32::midpoint(least, greatest) {
                greatest
            } else {
                least
            };
            let changes = Machine::of(&other) != machine;
            // All that differs between two states' shares of one is nothing.
            if own.name.ends_with("_to") && machine.states.len() == 2 {
                assert!(!changes);
            } else {
                assert_eq!(changes, is_active(gene), "{}: {text}", own.name);
            }
        }
    }
    assert!(
        states[0] == 0 && states[1..].iter().all(|count| *count > 400),
        "{states:?}"
    );
    assert!(transitions[1..].iter().all(|count| *count > 400), "{transitions:?}");
    let kinds = layout.all().iter().filter(|gene| gene.kind == GeneKind::Choice).count();
    assert_eq!(kinds, 4 + 16);
}

#[test]
fn a_text_is_read_as_automode_does() {
    let text = "--fsm-config --nstates 3 --s0 0 --rwm0 50 --n0 2 --n0x0 1 --c0x0 3 --p0x0 8 --w0x0 18.64 --n0x1 0 --c0x1 5 --p0x1 0.08 \
                --s1 4 --att1 3.84 --n1 1 --n1x0 0 --c1x0 1 --p1x0 0.61 --s2 1";
    let machine = state_machine::parse(text).unwrap();
    assert_eq!(machine.states[0].behaviour, Behaviour::Exploration { turning: 50 });
    // From state 0 the others are 1 and 2.
    assert_eq!(machine.states[0].transitions[0].to, 1);
    assert_eq!(
        machine.states[1],
        State {
            behaviour: Behaviour::Attraction { strength: 3.84 },
            transitions: vec![Transition {
                to: 0,
                condition: Condition::GreyFloor(0.61)
            }],
        }
    );
    assert!(machine.states[2].transitions.is_empty());
    assert_eq!(format!("--fsm-config {machine}"), format!("{text} --n2 0"));
    assert_eq!(Machine::of(&machine.genome()), machine);
}

#[test]
fn texts_with_mistakes_are_refused_at_their_word() {
    let refusal = |text: &str| state_machine::parse(text).unwrap_err().to_string();
    for (text, expected) in [
        ("", "word 1: `--nstates` is missing; allowed: given with its value"),
        ("--nstates 5", "word 2: `--nstates` is `5`; allowed: 1 to 4, whole"),
        ("--nstates", "word 2: `--nstates` has no value; allowed: one number"),
        (
            "--nstates 1 7",
            "word 3: `7` is no option; allowed: --nstates, --s0, .., each with its value",
        ),
        ("--nstates 1 --s0 6", "word 4: `--s0` is `6`; allowed: 0 to 5, whole"),
        (
            "--nstates 1 --s0 0",
            "word 5: `--rwm0` is missing; allowed: given with its value",
        ),
        (
            "--nstates 1 --s0 0 --rwm0 2.5",
            "word 6: `--rwm0` is `2.5`; allowed: 1 to 100, whole",
        ),
        (
            "--nstates 1 --s0 4 --att0 nan",
            "word 6: `--att0` is `nan`; allowed: 1 to 5",
        ),
        (
            "--nstates 1 --s0 1 --s0 1",
            "word 5: `--s0` is given twice; allowed: once",
        ),
        (
            "--nstates 1 --s0 1 --att0 2",
            "word 5: `--att0` is not of this machine; allowed: options of its states, their behaviours, transitions and conditions",
        ),
        (
            "--nstates 2 --s0 1 --n0 1 --n0x0 1 --c0x0 5 --p0x0 0.5 --s1 1 --n1 0",
            "word 8: `--n0x0` is `1`; allowed: 0 to 0, whole",
        ),
        (
            "--nstates 2 --s0 1 --n0 1 --n0x0 0 --c0x0 4 --p0x0 11 --w0x0 1 --s1 1 --n1 0",
            "word 12: `--p0x0` is `11`; allowed: 0 to 10, whole",
        ),
    ] {
        assert_eq!(refusal(text), expected, "{text}");
    }
}

#[test]
fn robots_without_the_readings_are_refused() {
    let mut other = spec(3);
    if let Build::Differential(own) = &mut other.robot.build {
        own.model = Some(Model::Rm11);
    }
    for spec in [
        other,
        WorldSpec {
            controller: Controller::StateMachine(StateMachine::DEFAULT),
            ..WorldSpec::miglino1995()
        },
    ] {
        assert_eq!(
            World::new(spec).unwrap_err().to_string(),
            "controller.kind: is `state-machine`; allowed: only with robot.model = \"rm1.1-vectors\""
        );
    }
}
