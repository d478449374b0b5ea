//! Robots that live by their own programs, against the batched study; and intervals that are missed.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro::cpu::Cpu;
use oneiro::evaluator::Control;
use oneiro::random::Key;
use oneiro::swarm::{Arena, Order, Simulated, World};
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::swarm::live;
use oneiro_lab::swarm::record::{Case, Credit, Kind, RobotInterval};
use oneiro_lab::swarm::settings::{Says, Settings};

use super::*;
use crate::daemon::evolution::simulate;

fn plan(change: impl Fn(&mut Settings)) -> Plan {
    let mut settings = Settings {
        case: Case::OverThenOpposite,
        minutes: 4,
        light_moves_minute: 2,
        ..Settings::default()
    };
    settings.world.robots = 5;
    // Most are then heard.
    settings.world.range = 600.0;
    change(&mut settings);
    Plan {
        settings,
        kind: Kind::Evolved,
        number: 0,
        seed: 5,
    }
}

/// What each robot's intervals were where each has a program of its own, in the study's arena. A robot does not live in the
/// cycles in which it `sleeps`.
fn lived(plan: &Plan, sleeps: impl Fn(usize, u32) -> bool) -> Vec<Vec<Ended>> {
    let robots = plan.settings.world.robots as usize;
    let control = Control::new();
    let [mut device, mut on_board] = [(); 2].map(|()| Cpu::new(Some(1)).unwrap());
    let world = World {
        swarm: 0,
        lamp: plan.lamp(),
        key: Key::rollout(plan.seed, 0, 0, 0),
    };
    let mut arena = Simulated::new(&mut device, &control, &[plan.settings.swarm()], &[world]).unwrap();
    let mut members: Vec<Member> = (0..robots)
        .map(|robot| Member::new(plan.clone(), robot, Contact::Tracker))
        .collect();
    let mut sightings = vec![Sighted::default(); robots];
    let mut ended = vec![Vec::new(); robots];
    for cycle in 0..SECOND * plan.settings.seconds() {
        let mut said = Vec::new();
        let mut orders = Vec::new();
        for (robot, own) in members.iter_mut().enumerate() {
            let mut deeds = Deeds::default();
            if sleeps(robot, cycle) {
                *own = Member::at(plan.clone(), robot, Contact::Tracker, own.state().clone());
            } else {
                if own.evolution().is_to_simulate() {
                    let result = simulate(plan, robot, own.evolution(), &mut on_board, 1.0).unwrap();
                    own.take_simulated(result.interval, &result.fitness);
                }
                deeds = own.cycle(cycle, Some(sightings[robot]));
            }
            said.extend(deeds.say);
            ended[robot].extend(deeds.ended);
            let evolution = own.evolution();
            let begins = SECOND * evolution.clock.seconds_of(evolution.interval()).start == cycle;
            orders.push(Order {
                before: deeds.controller,
                after: [0.0; 2],
                at: SECOND * plan.settings.seconds(),
                begins: begins.then_some(cycle),
            });
        }
        for (robot, own) in members.iter_mut().enumerate() {
            for (second, message) in said.iter().filter(|(_, message)| message.sender != robot) {
                own.hear(*second, *message);
            }
        }
        let lines = arena.live(cycle + 1, &[orders], 1).unwrap();
        for (robot, seen) in lines[0][0].robots.iter().enumerate() {
            members[robot].meet(cycle / SECOND, seen.heard);
            sightings[robot] = Sighted {
                carries: seen.carries,
                brought: sightings[robot].brought + seen.brought,
            };
        }
    }
    ended
}

/// Each robot's intervals in the batched study.
fn batched(plan: &Plan) -> Vec<Vec<RobotInterval>> {
    let engine = Engine::new(Box::new(Cpu::new(Some(1)).unwrap()), Arc::new(AtomicBool::new(false)));
    live(std::slice::from_ref(plan), &engine).unwrap().remove(0).intervals
}

/// Robots with programs of their own live as those of the batched study: the same genes, fitness and messages in every interval
/// that ends, to the last bit.
#[test]
fn robots_by_themselves_live_as_in_the_batched_study() {
    let changes: [fn(&mut Settings); 4] = [
        |_| (),
        |own| (own.controllers.guests, own.clock.offset_s) = (2, 20),
        |own| (own.clock.installed_s, own.simulators.credit) = (34, Credit::Matched),
        |own| own.simulators.says = Says::LastWhole,
    ];
    let (mut heard, mut taken) = (0, 0);
    for change in changes {
        let plan = plan(change);
        let expected = batched(&plan);
        for (robot, ended) in lived(&plan, |_, _| false).iter().enumerate() {
            assert!(ended.len() >= 3, "robot {robot}: {}", ended.len());
            for own in ended {
                let expected = expected[own.interval as usize][robot];
                let RobotInterval {
                    s0,
                    chosen_under,
                    g0,
                    g1,
                    real,
                    simulated,
                    ..
                } = expected;
                let numbers = (own.simulator, own.chosen_under, own.controller, own.real, own.simulated);
                assert_eq!(numbers, (s0, chosen_under, [g0, g1], real, simulated), "{own:?}");
                assert_eq!(own.taken, expected.taken, "{own:?}");
                // Whoever has no interval behind it has nothing to say of one, though it can be heard.
                if plan.settings.simulators.says == Says::SoFar {
                    assert_eq!(own.heard, u32::from(expected.heard), "{own:?}");
                }
                assert!(!own.missed);
                heard += own.heard;
                taken += u32::from(own.taken);
            }
        }
    }
    assert!(heard > 50 && taken > 3, "{heard} heard, {taken} taken");
}

/// Of food that a robot can't have brought nothing is taken, and an interval earns no more than it can, whenever its food is seen.
#[test]
fn food_is_taken_within_what_is_possible() {
    let plan = plan(|own| own.clock.offset_s = 0);
    let most = plan.settings.limits().fitness;
    let seen = |brought| Some(Sighted { carries: true, brought });
    let mut own = Member::new(plan.clone(), 1, Contact::Tracker);
    own.cycle(0, seen(0));
    for items in [0, 1, 50, 51, u32::MAX] {
        // One every other cycle.
        assert_eq!(own.can_have_brought(items, 100), items <= 50, "{items}");
    }
    own.cycle(100, seen(u32::MAX));
    assert_eq!((own.earned(), own.state().brought), (0.0, Some(0)));
    own.cycle(101, seen(3));
    let worth = own.earned() / 3.0;
    assert!(
        own.state().brought == Some(3) && (49.0..50.0).contains(&worth),
        "{worth}"
    );
    // Since the last sighting.
    assert!(own.can_have_brought(4, 102) && !own.can_have_brought(5, 102));
    assert!(own.can_have_brought(7, 108) && !own.can_have_brought(8, 108));
    // A tracker that has begun anew counts from 0.
    own.cycle(110, seen(0));
    assert_eq!((own.state().brought, own.earned()), (Some(0), 3.0 * worth));
    // Its program has begun in the middle of the experiment, and takes what there may be at once.
    for (cycle, brought) in [(601, 301), (601, 150), (1199, 600)] {
        let mut own = Member::new(plan.clone(), 1, Contact::Tracker);
        own.cycle(cycle - 1, None);
        own.cycle(cycle, seen(brought));
        assert!(
            (0.0..=most).contains(&own.earned()),
            "{cycle} {brought}: {}",
            own.earned()
        );
        assert_eq!(own.state().brought, Some(brought));
    }
}

/// A robot whose program is killed goes on from what it saved: the intervals that it did not live through are missed, the one in
/// which it comes back is too, and all others are lived through.
#[test]
fn a_robot_that_comes_back_misses_what_it_did_not_live_through() {
    let plan = plan(|own| own.clock.offset_s = 0);
    let away = |robot, cycle| robot == 2 && (900..1300).contains(&cycle);
    let ended = lived(&plan, away);
    for (robot, ended) in ended.iter().enumerate() {
        let missed: Vec<bool> = ended.iter().map(|own| own.missed).collect();
        let expected = [false, robot == 2, robot == 2, false];
        assert_eq!(missed, expected[..missed.len()], "robot {robot}");
        assert_eq!(ended.iter().map(|own| own.interval).collect::<Vec<_>>(), [0, 1, 2]);
    }
    let own = &ended[2];
    assert_eq!((own[1].simulator, own[1].taken), (own[2].simulator, false));
}
