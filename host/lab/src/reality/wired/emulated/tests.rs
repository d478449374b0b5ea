//! Episodes on an emulated Khepera, byte by byte on a virtual clock, whose body is a surrogate: the same as that surrogate's
//! simulated episodes.
//!
//! What differs between them, and what does not:
//!
//! - Commands: a sampled robot's motor states are -10 to 10. Ten are 80 mm/s, of which the driver makes units of 8.2 mm/s. No
//!   rounding changes a state: the farthest from its unit is 10, at 9.76.
//! - Readings: a surrogate's are integers from 0 to 1023, as on the serial line. None is rounded, so none may differ.
//! - Poses: those of the odometers, which do not measure slip, lag and collisions. The task does not use them.
//! - Collisions: nobody reports them. The task gives nothing for a cycle with one, but the connected robot's cycle counts as any
//!   other.
//! - Time: the robot is read first, and its wheels respond when their command has arrived, later by the two looks and the command
//!   on the line. In that part of a cycle the wheels still have their last speeds. A line of 2 ns a byte leaves 0.1 us of it,
//!   which no speed shows; lines as slow as real ones leave 5 to 90 ms, which changes the episodes.

use std::ops::Range;
use std::sync::Arc;
use std::thread;

use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::Start;

use super::super::tests::{Place, opened};
use super::super::*;
use super::{INSTANT, SEED, Watched, connected};

const CYCLES: u32 = 30;
/// Directories of episodes written at the same time: the disk takes most of the time.
const SHELVES: u64 = 20;

/// The world of simulated episodes.
fn surrogate(start: Start) -> World {
    World::new(WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(SEED, Differences::all(1.0)))),
        start,
        ..spec()
    })
    .unwrap()
}

fn spec() -> WorldSpec {
    WorldSpec {
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

fn rolled(world: World, genes: &[f32], key: Key) -> (f32, Trace) {
    let rollout = Rollout { world: 0, genes, key };
    let batch = Batch::new(&[world], &[rollout], Some(TraceRequest { every: 1 })).unwrap();
    let mut outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    (outcome.fitness[0], outcome.traces.remove(0))
}

/// Weights and biases U(-10, 10).
fn genes(life: u64) -> Vec<f32> {
    let gene = |gene: u32| {
        let [word, ..] = pcg4d([life as u32, (life >> 32) as u32, gene, 20]);
        20.0 * ((word >> 8) as f32 / (1 << 24) as f32) - 10.0
    };
    (0..18).map(gene).collect()
}

/// An episode over the line and the simulated one: the first cycle in which they differ, if there is one.
struct Compared {
    /// By the body's pose at the cycle's beginning, by the readings there, and by the command that follows.
    poses: Option<usize>,
    readings: Option<usize>,
    commands: Option<usize>,
    /// By the reward, except for cycles in which the surrogate collides and gets none.
    rewards: Option<usize>,
    has_collided: bool,
    /// Over the line, and simulated.
    fitness: [f32; 2],
}

impl Compared {
    fn new(robot: &Watched, lived: &Lived, (fitness, trace): &(f32, Trace)) -> Self {
        // The first command is to stand, and the last look is at the end of the last cycle.
        assert_eq!(
            (robot.units.len(), robot.readings.len()),
            (trace.len() + 1, trace.len() + 1)
        );
        let first = |is_same: &dyn Fn(usize) -> bool| (0..trace.len()).find(|cycle| !is_same(*cycle));
        Self {
            poses: first(&|cycle| {
                let own = trace[cycle];
                robot.poses[cycle].map(f32::to_bits) == [own.x, own.y, own.heading].map(f32::to_bits)
            }),
            readings: first(&|cycle| {
                let own: [f32; 8] = trace.activations(cycle);
                let own = own.map(|activation| f64::from((1023.0 * activation).round()));
                robot.readings[cycle] == own
            }),
            commands: first(&|cycle| {
                let own = [trace[cycle].speed_left, trace[cycle].speed_right];
                robot.units[cycle + 1] == own.map(|share| (10.0 * share).round() as i32)
            }),
            rewards: first(&|cycle| {
                let (own, reward) = (trace[cycle], lived.trace[cycle].reward);
                if own.collided > 0.0 {
                    own.reward == 0.0
                } else {
                    own.reward.to_bits() == reward.to_bits()
                }
            }),
            has_collided: trace.iter().any(|record| record.collided > 0.0),
            fitness: [lived.fitness, *fitness],
        }
    }
}

/// Runs some episodes over a line, recorded in a directory, and simulates the same ones.
fn shelf(baud: u32, numbers: Range<u64>) -> Vec<Compared> {
    let place = Place::new(&format!("emulated-{baud}-{}", numbers.start));
    let mut robot = connected(baud);
    let mut lives = opened(&spec(), &place.0, 0);
    let mut life = |number| {
        let (genes, key) = (genes(number), Key::rollout(SEED, 0, number, 0));
        let (_, trace) = rolled(surrogate(Start::Random), &genes, key);
        let start @ [x, y, heading] = [trace[0].x, trace[0].y, trace[0].heading];
        robot.next = (start, key);
        (robot.readings, robot.units, robot.poses) = Default::default();
        let life = Life {
            genes: &genes,
            key,
            start: Some(start),
        };
        let lived = lives.live(&mut robot, &[life], true).unwrap();
        let rolled = rolled(surrogate(Start::At { x, y, heading }), &genes, key);
        Compared::new(&robot, &lived[0], &rolled)
    };
    numbers.map(&mut life).collect()
}

fn compared(baud: u32, lives: u64) -> Vec<Compared> {
    let bound = |shelf: u64| shelf * lives / SHELVES;
    thread::scope(|scope| {
        let shelves = (0..SHELVES).map(|own| scope.spawn(move || shelf(baud, bound(own)..bound(own + 1))));
        let shelves: Vec<_> = shelves.collect();
        shelves.into_iter().flat_map(|shelf| shelf.join().unwrap()).collect()
    })
}

fn count(all: &[Compared], is_it: impl Fn(&Compared) -> bool) -> usize {
    all.iter().filter(|own| is_it(own)).count()
}

/// Every pose, reading, command and reward is the same. Without a collision the fitness is also bit-identical.
#[test]
fn lives_over_the_wire_are_those_of_the_surrogate() {
    let lives = if std::env::var_os("ONEIRO_LONG").is_some() {
        20_000
    } else {
        1000
    };
    let all = compared(INSTANT, lives);
    assert_eq!(all.len() as u64, lives);
    for (number, own) in all.iter().enumerate() {
        let differences = [own.poses, own.readings, own.commands, own.rewards];
        assert_eq!(differences, [None; 4], "life {number}");
        let [wired, rolled] = own.fitness;
        let is_same = wired.to_bits() == rolled.to_bits();
        assert!(
            is_same || own.has_collided && wired > rolled,
            "life {number}: {wired} {rolled}"
        );
    }
    let collided = count(&all, |own| own.has_collided);
    let moved = count(&all, |own| own.fitness[1] > 0.0);
    eprintln!("{lives} lives, {collided} with a collision, {moved} with a fitness above 0");
    // They are not all alike.
    let share = |count: usize| count as f64 / lives as f64;
    assert!(
        (0.2..0.8).contains(&share(collided)) && share(moved) > 0.8,
        "{collided} {moved}"
    );
}

/// Where commands come later than in the surrogate, first poses differ, then readings, then commands: never in another order.
#[test]
fn on_a_slow_line_lives_differ_because_commands_come_late() {
    const LIVES: u64 = 50;
    for baud in [115_200, 38_400, 9600] {
        let all = compared(baud, LIVES);
        let follows = |cause: Option<usize>, effect: Option<usize>| {
            effect.is_none_or(|effect| cause.is_some_and(|cause| cause <= effect))
        };
        for own in &all {
            // In the first cycle the robot stands where it was put.
            assert!(own.poses.is_none_or(|cycle| cycle > 0));
            assert!(follows(own.poses, own.readings));
            assert!(follows(own.readings, own.commands) && follows(own.readings, own.rewards));
        }
        let [readings, commands] = [
            count(&all, |own| own.readings.is_some()),
            count(&all, |own| own.commands.is_some()),
        ];
        let free = all.iter().filter(|own| !own.has_collided);
        let sums = free.fold([0.0; 2], |sums, own| {
            [0, 1].map(|side| sums[side] + f64::from(own.fitness[side]))
        });
        eprintln!(
            "{baud} baud: of {LIVES} lives {readings} read and {commands} command something else; without collisions their \
             fitness is {:.3} of the surrogate's",
            sums[0] / sums[1]
        );
        assert!(readings > 0);
    }
}
