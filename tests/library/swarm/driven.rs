//! Robots that are driven from outside: with the behaviours of the study as their minds, they live as those of a batch do.

use oneiro::acting::{Acting, Deed, Mind, Readings};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Drive, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::swarm::{
    Arena, Behaviour, Command, Differences, Driven, GREATEST_DRIVEN, Lamp, Line, Order, Simulated, Swarm, Trouble,
    World, robot_key,
};

use super::{apart, distance};

const ROBOTS: u32 = 10;
/// Cycles between new orders.
const STRETCH: u32 = 300;

fn key() -> Key {
    Key::rollout(5, 0, 0, 0)
}

fn lamp() -> Lamp {
    Lamp {
        first: Light::OverNest,
        then: Light::OppositeNest,
        moves: 400,
    }
}

fn swarm(differences: Differences) -> Swarm {
    Swarm {
        differences,
        ..Swarm::odowd2014(ROBOTS)
    }
}

/// A robot's orders in a stretch: it is switched on late in the first one, or has other genes than before from some cycle on.
fn order(robot: u32, stretch: u32) -> Order {
    let genes = |stretch: u32| {
        let words = pcg4d([robot, stretch, 0, 0x6472_6976]);
        [words[0], words[1]].map(|word| [0.0, 0.5, 0.99][word as usize % 3])
    };
    let [.., at, begins] = pcg4d([robot, stretch, 1, 0x6472_6976]);
    let is_late = stretch == 0 && robot % 4 == 3;
    Order {
        before: (!is_late).then(|| genes(stretch)),
        after: genes(stretch + 1),
        at: STRETCH * stretch + at % STRETCH,
        begins: robot.is_multiple_of(2).then_some(STRETCH * stretch + begins % STRETCH),
    }
}

fn orders(stretch: u32) -> Vec<Order> {
    (0..ROBOTS).map(|robot| order(robot, stretch)).collect()
}

/// Every cycle of a world in the kernel of swarms, with its own behaviours.
fn simulated(swarm: Swarm, stretches: u32) -> Vec<Line> {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let control = Control::new();
    let world = World {
        swarm: 0,
        lamp: lamp(),
        key: key(),
    };
    let mut arena = Simulated::new(&mut cpu, &control, &[swarm], &[world]).unwrap();
    let mut live = |stretch| {
        let until = STRETCH * (stretch + 1);
        arena.live(until, &[orders(stretch)], 1).unwrap().remove(0)
    };
    (0..stretches).flat_map(&mut live).collect()
}

/// What may go wrong between the arena and a mind.
type Fault<'a> = &'a dyn Fn(u32, usize, &mut Readings, &mut Option<Drive>);

const NO_FAULT: Fault<'static> = &|_, _, _, _| ();

/// The same world, driven by a mind for each robot. Between stretches everything is saved and restored.
fn driven(swarm: Swarm, stretches: u32, fault: Fault<'_>) -> Vec<Line> {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let acting = Acting::new(&swarm.forager).unwrap();
    let mut minds: Vec<Mind> = (0..ROBOTS)
        .map(|robot| Acting::begin(robot_key(key(), robot)))
        .collect();
    let begin = |cpu: &mut Cpu| Driven::new(cpu, &swarm, lamp(), key()).unwrap();
    let mut world = begin(&mut cpu);
    let mut carries = [false; ROBOTS as usize];
    let mut lines = Vec::new();
    for stretch in 0..stretches {
        let orders = orders(stretch);
        for cycle in STRETCH * stretch..STRETCH * (stretch + 1) {
            let mut behaviours = [Behaviour::Off; ROBOTS as usize];
            let mut command = |(robot, order): (usize, &Order)| {
                let genes = if cycle >= order.at {
                    Some(order.after)
                } else {
                    order.before
                };
                let mut readings = world.readings()[robot];
                fault(cycle, robot, &mut readings, &mut None);
                let mind = &mut minds[robot];
                mind.skip_to(cycle);
                let mut act = |genes| acting.cycle(mind, &mut cpu, genes, &readings, carries[robot]).unwrap();
                let mut drive = genes.map(|genes| {
                    let deed = act(genes);
                    behaviours[robot] = deed.behaviour;
                    deed.drive()
                });
                fault(cycle, robot, &mut readings, &mut drive);
                let begins = order.begins == Some(cycle);
                Command { drive, begins }
            };
            let commands: Vec<Command> = orders.iter().enumerate().map(&mut command).collect();
            let mut line = world.cycle(&mut cpu, &commands).unwrap();
            for (robot, seen) in line.robots.iter_mut().enumerate() {
                let is_on = commands[robot].drive.is_some();
                assert_eq!(seen.behaviour, if is_on { Behaviour::Search } else { Behaviour::Off });
                seen.behaviour = behaviours[robot];
                carries[robot] = seen.carries;
            }
            lines.push(line);
        }
        let (now, state) = world.state();
        let state = state.to_vec();
        world = begin(&mut cpu).at(now, state).unwrap();
        for mind in &mut minds {
            *mind = Mind::restored(mind.key(), mind.cycle(), mind.memory()).unwrap();
        }
    }
    lines
}

/// The first cycle in which two lives differ.
fn difference(one: &[Line], other: &[Line]) -> Option<usize> {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).position(|(one, other)| one != other)
}

#[test]
fn minds_outside_live_as_the_swarm_does() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let stretches = if is_long { 10 } else { 3 };
    for differences in [Differences::ODOWD2014, Differences::NONE] {
        for latency in [false, true] {
            let swarm = swarm(Differences { latency, ..differences });
            let expected = simulated(swarm, stretches);
            let found = driven(swarm, stretches, NO_FAULT);
            assert_eq!(
                difference(&found, &expected),
                None,
                "{differences:?}, latency {latency}"
            );
            // Everything happens in these lives.
            let seen = || expected.iter().flat_map(|line| &line.robots);
            let count = |happens: fn(&oneiro::swarm::Seen) -> bool| seen().filter(|robot| happens(robot)).count();
            let brought = count(|own| own.brought > 0);
            let heard = count(|own| own.heard > 0);
            let earned = count(|own| own.earned > 0.0);
            println!("{brought} brought, {heard} heard, {earned} with fitness");
            assert!(
                brought > 3 && heard > 300 && earned > 300,
                "{brought} brought, {heard} heard, {earned} with fitness"
            );
            for behaviour in [
                Behaviour::Off,
                Behaviour::Avoid,
                Behaviour::Search,
                Behaviour::SeekLight,
                Behaviour::FleeLight,
            ] {
                assert!(seen().any(|own| own.behaviour == behaviour), "{behaviour:?}");
            }
        }
    }
}

/// A world on every device that kernels composed at run time run on.
#[test]
fn driven_worlds_are_the_same_on_every_device() {
    let lived = |device: &mut dyn Evaluator| -> (Vec<Line>, Vec<Readings>) {
        let mut world = Driven::new(device, &swarm(Differences::ODOWD2014), lamp(), key()).unwrap();
        let command = |robot: u32, cycle: u32| {
            let turn = [-0.02, 0.0, 0.03][(robot + cycle) as usize % 3];
            let drive = (cycle >= robot).then_some(Drive { forward: 8.0, turn });
            let begins = cycle == 2 * robot;
            Command { drive, begins }
        };
        let commands = |cycle| (0..ROBOTS).map(|robot| command(robot, cycle)).collect::<Vec<_>>();
        let lines = (0..30).map(|cycle| world.cycle(device, &commands(cycle)).unwrap());
        (lines.collect(), world.readings().to_vec())
    };
    let expected = lived(&mut Cpu::new(Some(1)).unwrap());
    let mut interpreted = Cpu::new(Some(1)).unwrap().with_variant("interpretedx1").unwrap();
    assert!(lived(&mut interpreted) == expected, "interpreted");
    #[cfg(feature = "gpu")]
    {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        assert!(lived(&mut gpu) == expected, "gpu");
    }
}

/// Minds on every device: what is near comes and goes, so that they remember all that there is.
#[test]
fn minds_are_the_same_on_every_device() {
    let acting = Acting::new(&swarm(Differences::NONE).forager).unwrap();
    let lived = |device: &mut dyn Evaluator| -> Vec<(Deed, Mind)> {
        let mut mind = Acting::begin(key());
        let deed = |cycle: u32| {
            let unit = |word: u32| (pcg4d([cycle, word, 0, 0])[0] >> 8) as f32 / 16_777_216.0;
            let is_near = cycle % 30 < 3;
            let readings = Readings {
                near: std::array::from_fn(|sensor| if is_near { unit(sensor as u32) } else { 0.0 }),
                light: std::array::from_fn(|sensor| unit(4 + sensor as u32)),
            };
            let genes = [0.99, [0.5, 0.0][cycle as usize / 60]];
            let deed = acting
                .cycle(&mut mind, device, genes, &readings, cycle.is_multiple_of(7))
                .unwrap();
            (deed, mind)
        };
        (0..120).map(deed).collect()
    };
    let expected = lived(&mut Cpu::new(Some(1)).unwrap().with_variant("scalarx1").unwrap());
    let remembers = |word: usize| expected.iter().any(|(_, mind)| mind.memory()[word] != 0);
    assert!((0..4).all(remembers));
    for variant in Cpu::variants() {
        let mut cpu = Cpu::new(Some(1)).unwrap().with_variant(variant).unwrap();
        assert!(lived(&mut cpu) == expected, "{variant}");
    }
    #[cfg(feature = "gpu")]
    {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        assert!(lived(&mut gpu) == expected, "gpu");
    }
}

/// Negative controls: one reading that is a little off, one command that comes a cycle late, and one that is lost.
#[test]
fn one_reading_or_command_that_is_wrong_shows() {
    let expected = simulated(swarm(Differences::ODOWD2014), 1);
    let first = |fault: Fault<'_>| difference(&driven(swarm(Differences::ODOWD2014), 1, fault), &expected);
    assert_eq!(first(NO_FAULT), None);
    // Robot 0 flees the light or seeks it in this cycle, and its wheels obey a cycle later.
    let is_at = |cycle, robot| (cycle, robot) == (244, 0);
    assert!(matches!(
        expected[244].robots[0].behaviour,
        Behaviour::SeekLight | Behaviour::FleeLight
    ));
    let reading = first(&|cycle, robot, readings, _| {
        if is_at(cycle, robot) {
            readings.light[0] += 1e-6;
        }
    });
    assert_eq!(reading, Some(245));
    let before = std::cell::Cell::new(None);
    let late = first(&|cycle, robot, _, drive| {
        let own = *drive;
        if is_at(cycle, robot) && own.is_some() {
            *drive = before.get();
        }
        if robot == 0 && own.is_some() {
            before.set(own);
        }
    });
    assert_eq!(late, Some(245));
    let lost = first(&|cycle, robot, _, drive| {
        if is_at(cycle, robot) {
            *drive = None;
        }
    });
    assert_eq!(lost, Some(244));
}

/// A robot that was on and is switched off stands, takes no food, hears nothing, and isn't heard.
#[test]
fn a_robot_that_is_switched_off_stands_and_is_silent() {
    let swarm = Swarm {
        heard: 1.0,
        line_of_sight: false,
        range: 2_000.0,
        ..swarm(Differences::ODOWD2014)
    };
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut world = Driven::new(&mut cpu, &swarm, lamp(), key()).unwrap();
    let ahead = Command {
        drive: Some(Drive {
            forward: 8.0,
            turn: 0.01,
        }),
        begins: false,
    };
    let mut commands = [ahead; ROBOTS as usize];
    let mut lines = Vec::new();
    for cycle in 0..200 {
        commands[4].drive = (!(50..150).contains(&cycle)).then_some(ahead.drive.unwrap());
        lines.push(world.cycle(&mut cpu, &commands).unwrap());
    }
    let heard = |from: usize, robot: usize| lines[from..from + 50].iter().any(|line| line.robots[robot].heard != 0);
    let is_heard = |from: usize| {
        let others = lines[from..from + 50].iter().flat_map(|line| &line.robots);
        others.into_iter().any(|other| other.heard >> 4 & 1 == 1)
    };
    for (from, expected) in [(0, true), (50, false), (100, false), (150, true)] {
        assert_eq!(
            (heard(from, 4), is_heard(from)),
            (expected, expected),
            "from cycle {from}"
        );
        assert!(heard(from, 5));
    }
    for cycle in 50..150 {
        let [before, after] = [cycle - 1, cycle].map(|cycle| &lines[cycle].robots[4]);
        assert_eq!((after.behaviour, after.heading), (Behaviour::Off, before.heading));
        assert_eq!(after.carries, before.carries);
        let pushed = lines[cycle - 1].robots.iter().enumerate();
        let is_free = pushed
            .filter(|(robot, _)| *robot != 4)
            .all(|(_, other)| apart(before, other) > 90.0);
        if is_free {
            assert_eq!([after.x, after.y], [before.x, before.y]);
        }
    }
    // Wheels that obey a cycle late have forgotten what they were told before.
    let [off, first, second] = [149, 150, 151].map(|cycle| &lines[cycle].robots[4]);
    assert!(distance(first, [off.x, off.y]) < 1e-3);
    assert!(distance(second, [first.x, first.y]) > 5.0);
}

#[test]
fn what_is_no_command_is_refused_and_changes_nothing() {
    let swarm = swarm(Differences::NONE);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let begin = |cpu: &mut Cpu, swarm: &Swarm| Driven::new(cpu, swarm, lamp(), key());
    let mut world = begin(&mut cpu, &swarm).unwrap();
    let state = world.state().1.to_vec();
    let readings = world.readings().to_vec();
    let mut refused = |commands: &[Command]| match world.cycle(&mut cpu, commands) {
        Err(Trouble::Invalid(invalid)) => invalid.to_string(),
        other => panic!("{other:?}"),
    };
    let with = |forward, turn| {
        let mut commands = [Command::default(); ROBOTS as usize];
        commands[3].drive = Some(Drive { forward, turn });
        commands
    };
    assert_eq!(
        refused(&with(1.0, 0.0)[1..]),
        "commands: are 9; allowed: 10, one for each robot"
    );
    assert_eq!(
        refused(&with(f32::NAN, 0.0)),
        "commands[3].drive.forward: is NaN; allowed: up to 1000000 either way"
    );
    assert!(refused(&with(0.0, -2e6)).starts_with("commands[3].drive.turn: is -2000000; allowed"));
    assert_eq!(world.state(), (0, &state[..]));
    assert_eq!(world.readings(), readings);
    assert!(world.clone().at(0, state[1..].to_vec()).is_err());
    // The life of a world has an end.
    let mut short = swarm;
    short.forager.cycles = 1;
    let mut short = begin(&mut cpu, &short).unwrap();
    short.cycle(&mut cpu, &with(1.0, 0.0)).unwrap();
    assert!(matches!(
        short.cycle(&mut cpu, &with(1.0, 0.0)),
        Err(Trouble::Invalid(_))
    ));
    for (robots, is_allowed) in [(GREATEST_DRIVEN, true), (GREATEST_DRIVEN + 1, false)] {
        let found = begin(&mut cpu, &Swarm { robots, ..swarm }).map_err(|trouble| trouble.to_string());
        let expected = Err(format!("robots: is {robots}; allowed: 1 to 80"));
        assert!(if is_allowed {
            found.is_ok()
        } else {
            found.map(|_| ()) == expected
        });
    }
    let mut wrong = swarm;
    wrong.heard = 2.0;
    let invalid = begin(&mut cpu, &wrong).unwrap_err().to_string();
    assert!(invalid.starts_with("messages.heard: is 2; allowed"), "{invalid}");
}
