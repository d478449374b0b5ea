//! State machines: each cycle beside a second program, written from `docs/controllers.md`; genomes and texts; the same bits
//! everywhere; refusals.

use oneiro::automode::{Behaviour, Condition, Form, Machine, MachineState, Modules, Transition};
use oneiro::batch::Trace;
use oneiro::cpu::Cpu;
use oneiro::world::{Controller, GeneKind, World, WorldSpec};

use crate::composed::Subject;
use crate::modules::{
    act, batch, check_refusal, drawn, evaluated, genome, holds, is_off, key_of, places, spec, subject,
};

const MACHINES: Controller = Controller::StateMachine(Modules::DEFAULT);

/// A robot as the second program has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory {
    state: usize,
    age: u32,
    turning: i32,
}

/// What a robot does in a cycle, and its memory afterwards; `readings` in the order of the model's.
fn cycle(machine: &Machine, before: Memory, readings: &[f64], key: [u32; 2], step: u32) -> ([f64; 2], Memory) {
    let MachineState { behaviour, transitions } = &machine.states[before.state];
    let mut after = before;
    if before.age == 0 {
        after.turning = 0;
    }
    let wheels;
    (wheels, after.turning) = act(*behaviour, readings, after.turning, key, step);
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
    let world = World::new(spec(MACHINES, 20)).unwrap();
    let genomes: Vec<_> = (0..90).map(|life| genome(&world, life)).collect();
    let outcome = evaluated(&mut Cpu::new(Some(2)).unwrap(), &batch(&world, &genomes, 1));
    let [perceived, memory] = places(&world);
    let (mut wrong, mut all, mut seen) = (0, 0, [0; 6]);
    for ((genome, trace), life) in genomes.iter().zip(&outcome.traces).zip(0..) {
        let mut machine = Machine::of(genome);
        change(&mut machine);
        let key = key_of(life);
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
            let (wheels, after) = cycle(&machine, own, &readings, key, step);
            let found = Memory {
                state: details[memory[0]] as usize,
                age: details[memory[1]],
                turning: details[memory[2]].cast_signed(),
            };
            all += 1;
            wrong += usize::from(found != after || is_off(wheels, [record.left, record.right]));
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
type Field = fn(&mut Modules) -> &mut Option<f32>;

/// Each value changes lives, and its default changes none.
#[test]
fn values_reach_the_kernel() {
    let lived = |machine: Modules| {
        let controller = Controller::StateMachine(machine);
        let world = World::new(WorldSpec {
            controller,
            ..spec(MACHINES, 20)
        })
        .unwrap();
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
    let usual = lived(Modules::DEFAULT);
    for (number, (default, other, field)) in set.into_iter().enumerate() {
        let with = |value| {
            let mut machine = Modules::DEFAULT;
            *field(&mut machine) = Some(value);
            lived(machine)
        };
        assert!(with(default) == usual && with(other) != usual, "value {number}");
    }
}

/// Genome to machine to text and back, for machines of all kinds.
#[test]
fn genomes_and_texts_are_the_same_machines() {
    let world = World::new(spec(MACHINES, 1)).unwrap();
    let layout = world.gene_layout();
    assert_eq!(layout.genes(), 97);
    assert_eq!(Form::of(layout), Some(Form::StateMachine));
    let [mut states, mut transitions] = [[0; 5]; 2];
    for life in 0..2000 {
        let genes = genome(&world, life);
        let machine = Machine::of(&genes);
        states[machine.states.len()] += 1;
        for state in &machine.states {
            transitions[state.transitions.len()] += 1;
        }
        let text = machine.to_string();
        assert_eq!(Machine::parse(&text).unwrap(), machine, "{text}");
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
    let machine = Machine::parse(text).unwrap();
    assert_eq!(machine.states[0].behaviour, Behaviour::Exploration { turning: 50 });
    // From state 0 the others are 1 and 2.
    assert_eq!(machine.states[0].transitions[0].to, 1);
    assert_eq!(
        machine.states[1],
        MachineState {
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

/// As published machines are written.
#[test]
fn the_only_state_may_say_that_it_has_no_transitions() {
    let machine = Machine::parse("--nstates 1 --s0 4 --att0 5 --n0 0").unwrap();
    assert_eq!(machine.to_string(), "--nstates 1 --s0 4 --att0 5");
}

#[test]
fn texts_with_mistakes_are_refused_at_their_word() {
    let refusal = |text: &str| Machine::parse(text).unwrap_err().to_string();
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
            "--nstates 1 --s0 0 --cle0 4",
            "word 5: `--cle0` is not of this machine; allowed: options of its states, their behaviours, transitions and conditions",
        ),
        ("--nstates 1 --s0 1 --n0 1", "word 6: `--n0` is `1`; allowed: 0"),
        (
            "--nstates 2 --s0 1 --n0 1 --n0x0 1 --c0x0 5 --p0x0 0.5 --s1 1 --n1 0",
            "word 8: `--n0x0` is `1`; allowed: 0",
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
    check_refusal(&MACHINES);
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let world = World::new(spec(MACHINES, 10)).unwrap();
    vec![subject("state machines", &world)]
}
