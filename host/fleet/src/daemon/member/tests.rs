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

/// Each robot's intervals if each runs its program, in the study's arena. A robot skips the cycles in which it
/// `sleeps`.
fn run_members(plan: &Plan, sleeps: impl Fn(usize, u32) -> bool) -> Vec<Vec<Ended>> {
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
        for (robot, member) in members.iter_mut().enumerate() {
            let mut deeds = Deeds::default();
            if sleeps(robot, cycle) {
                *member = Member::at(plan.clone(), robot, Contact::Tracker, member.state().clone());
            } else {
                if member.evolution().is_to_simulate() {
                    let result = simulate(plan, robot, member.evolution(), &mut on_board, 1.0).unwrap();
                    member.take_simulated(result.interval, &result.fitness);
                }
                deeds = member.cycle(cycle, Some(sightings[robot]));
            }
            said.extend(deeds.say);
            ended[robot].extend(deeds.ended);
            let evolution = member.evolution();
            let begins = SECOND * evolution.clock.seconds_of(evolution.interval()).start == cycle;
            orders.push(Order {
                before: deeds.controller,
                after: [0.0; 2],
                at: SECOND * plan.settings.seconds(),
                begins: begins.then_some(cycle),
            });
        }
        for (robot, member) in members.iter_mut().enumerate() {
            for (second, message) in said.iter().filter(|(_, message)| message.sender != robot) {
                member.hear(*second, *message);
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

/// Robots that run separate programs have the batched study's genes, fitness and messages in every interval, to the
/// last bit.
#[test]
fn robots_by_themselves_live_as_in_the_batched_study() {
    let changes: [fn(&mut Settings); 4] = [
        |_| (),
        |settings| (settings.controllers.guests, settings.clock.offset_s) = (2, 20),
        |settings| (settings.clock.installed_s, settings.simulators.credit) = (34, Credit::Matched),
        |settings| settings.simulators.says = Says::LastWhole,
    ];
    let (mut heard, mut taken) = (0, 0);
    for change in changes {
        let plan = plan(change);
        let expected = batched(&plan);
        for (robot, ended) in run_members(&plan, |_, _| false).iter().enumerate() {
            assert!(ended.len() >= 3, "robot {robot}: {}", ended.len());
            for interval in ended {
                let expected = expected[interval.interval as usize][robot];
                let RobotInterval {
                    s0,
                    chosen_under,
                    g0,
                    g1,
                    real,
                    simulated,
                    ..
                } = expected;
                let numbers = (
                    interval.simulator,
                    interval.chosen_under,
                    interval.controller,
                    interval.real,
                    interval.simulated,
                );
                assert_eq!(numbers, (s0, chosen_under, [g0, g1], real, simulated), "{interval:?}");
                assert_eq!(interval.taken, expected.taken, "{interval:?}");
                // A robot without a finished interval can't report one, though others can receive it.
                if plan.settings.simulators.says == Says::SoFar {
                    assert_eq!(interval.heard, u32::from(expected.heard), "{interval:?}");
                }
                assert!(!interval.missed);
                heard += interval.heard;
                taken += u32::from(interval.taken);
            }
        }
    }
    assert!(heard > 50 && taken > 3, "{heard} heard, {taken} taken");
}

/// Impossible sightings of food are ignored, and an interval's earnings are limited, whenever its food is seen.
#[test]
fn food_is_taken_within_what_is_possible() {
    let plan = plan(|settings| settings.clock.offset_s = 0);
    let most = plan.settings.limits().fitness;
    let seen = |brought| Some(Sighted { carries: true, brought });
    let mut member = Member::new(plan.clone(), 1, Contact::Tracker);
    member.cycle(0, seen(0));
    for items in [0, 1, 50, 51, u32::MAX] {
        // One every other cycle.
        assert_eq!(member.can_have_brought(items, 100), items <= 50, "{items}");
    }
    member.cycle(100, seen(u32::MAX));
    assert_eq!((member.earned(), member.state().brought), (0.0, Some(0)));
    member.cycle(101, seen(3));
    let worth = member.earned() / 3.0;
    assert!(
        member.state().brought == Some(3) && (49.0..50.0).contains(&worth),
        "{worth}"
    );
    // Since the last sighting.
    assert!(member.can_have_brought(4, 102) && !member.can_have_brought(5, 102));
    assert!(member.can_have_brought(7, 108) && !member.can_have_brought(8, 108));
    // A restarted tracker counts from 0.
    member.cycle(110, seen(0));
    assert_eq!((member.state().brought, member.earned()), (Some(0), 3.0 * worth));
    // Its program has begun in the middle of the experiment, and takes what there may be at once.
    for (cycle, brought) in [(601, 301), (601, 150), (1199, 600)] {
        let mut member = Member::new(plan.clone(), 1, Contact::Tracker);
        member.cycle(cycle - 1, None);
        member.cycle(cycle, seen(brought));
        assert!(
            (0.0..=most).contains(&member.earned()),
            "{cycle} {brought}: {}",
            member.earned()
        );
        assert_eq!(member.state().brought, Some(brought));
    }
}

/// A robot whose program is killed continues from its saved state: it misses the intervals in which it was off, also
/// the one in which it comes back, and no others.
#[test]
fn a_robot_that_comes_back_misses_what_it_did_not_live_through() {
    let plan = plan(|settings| settings.clock.offset_s = 0);
    let away = |robot, cycle| robot == 2 && (900..1300).contains(&cycle);
    let ended = run_members(&plan, away);
    for (robot, ended) in ended.iter().enumerate() {
        let missed: Vec<bool> = ended.iter().map(|interval| interval.missed).collect();
        let expected = [false, robot == 2, robot == 2, false];
        assert_eq!(missed, expected[..missed.len()], "robot {robot}");
        assert_eq!(
            ended.iter().map(|interval| interval.interval).collect::<Vec<_>>(),
            [0, 1, 2]
        );
    }
    let third = &ended[2];
    assert_eq!((third[1].simulator, third[1].taken), (third[2].simulator, false));
}
