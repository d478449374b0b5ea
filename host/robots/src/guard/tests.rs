//! The guard's whole table, and its limits.

use super::*;

const TICK: Duration = Duration::from_millis(10);
const GREATEST: f64 = 150.0;

fn values() -> Values {
    Values::default()
}

/// A step in which nothing happens.
fn nothing() -> Inputs {
    Inputs {
        passed: TICK,
        ..Inputs::default()
    }
}

fn command(speeds: [f64; 2]) -> Inputs {
    Inputs {
        command: Some(speeds),
        ..nothing()
    }
}

fn with(conditions: &[Condition]) -> Conditions {
    conditions.iter().copied().collect()
}

/// A guard whose robot stands still.
fn standing() -> Guard {
    let mut guard = Guard::new(values(), GREATEST);
    assert_eq!(guard.step(&nothing()), Order::Stop(1));
    confirm(&mut guard);
    assert_eq!(guard.state(), State::Standing);
    guard
}

fn confirm(guard: &mut Guard) {
    let confirmed = guard.stop;
    guard.step(&Inputs { confirmed, ..nothing() });
}

/// A guard whose robot has got a command for some steps.
fn moving(speeds: [f64; 2], steps: u32) -> Guard {
    let mut guard = standing();
    for _ in 0..steps {
        guard.step(&command(speeds));
    }
    assert_eq!(guard.state(), State::Moving);
    guard
}

/// Every way to move, and the state in which the wheels may turn because a stop has not arrived.
fn states_that_can_move() -> Vec<(&'static str, Guard)> {
    let mut slowing = moving([100.0, 100.0], 50);
    slowing.step(&command([20.0, 20.0]));
    let mut reversing = moving([100.0, 100.0], 50);
    reversing.step(&command([-100.0, -100.0]));
    let mut stale = moving([100.0, 100.0], 50);
    for _ in 0..29 {
        stale.step(&nothing());
    }
    assert_eq!(stale.state(), State::Moving);
    let mut stopping = moving([100.0, 100.0], 50);
    stopping.step(&command([0.0, 0.0]));
    assert_eq!(stopping.state(), State::Stopping);
    let mut overdue = stopping.clone();
    for _ in 0..100 {
        overdue.step(&command([0.0, 0.0]));
    }
    assert!(overdue.cannot_stop());
    vec![
        ("speeding up", moving([100.0, 100.0], 1)),
        ("at speed", moving([100.0, 100.0], 50)),
        ("at the limit", moving([1e9, 1e9], 100)),
        ("backwards", moving([-100.0, -100.0], 50)),
        ("turning", moving([-40.0, 40.0], 50)),
        ("on one wheel", moving([0.0, 60.0], 50)),
        ("slowing down", slowing),
        ("reversing", reversing),
        ("about to expire", stale),
        ("after a resume", {
            let mut guard = moving([50.0, 50.0], 5);
            guard.step(&Inputs {
                conditions: with(&[Condition::Operator]),
                ..nothing()
            });
            confirm(&mut guard);
            let resume = true;
            guard.step(&Inputs { resume, ..nothing() });
            guard.step(&command([80.0, 80.0]));
            assert_eq!(guard.state(), State::Moving);
            guard
        }),
        ("not yet stopped", stopping),
        ("not to be stopped", overdue),
        ("just started", Guard::new(values(), GREATEST)),
    ]
}

/// Conditions that come from outside; the others follow from times.
const SENSED: [Condition; 9] = [
    Condition::Closed,
    Condition::Terminated,
    Condition::Operator,
    Condition::Tracker,
    Condition::Battery,
    Condition::Lifted,
    Condition::Messages,
    Condition::Answers,
    Condition::Restarted,
];

/// All sets of conditions, as inputs of one step, with the set that they are.
fn every_set() -> impl Iterator<Item = (Inputs, Conditions)> {
    let times = [TICK, values().expiry(), values().silence()];
    let quiets = [Duration::ZERO, values().link(), values().unconfirmed()];
    (0..1_u16 << SENSED.len()).flat_map(move |bits| {
        let sensed = SENSED.iter().enumerate().filter(move |(at, _)| bits >> at & 1 == 1);
        let conditions: Conditions = sensed.map(|(_, condition)| *condition).collect();
        times.into_iter().flat_map(move |passed| {
            quiets.into_iter().map(move |quiet| {
                let inputs = Inputs {
                    passed,
                    conditions,
                    quiet,
                    ..Inputs::default()
                };
                let mut all = conditions;
                all.add(Condition::Expired, passed >= values().expiry());
                all.add(Condition::Silent, passed >= values().silence());
                all.add(Condition::Late, quiet >= values().link());
                (inputs, all)
            })
        })
    })
}

/// From every state that can move, each stop condition, by itself or with others, gives zero in one step, whatever else
/// comes with it.
#[test]
fn every_condition_stops_every_state_in_one_step() {
    let commands = [
        None,
        Some([120.0, 120.0]),
        Some([-120.0, 30.0]),
        Some([0.0, 0.0]),
        Some([f64::NAN, 50.0]),
    ];
    let mut cases = 0;
    for (name, before) in states_that_can_move() {
        for (inputs, set) in every_set().filter(|(_, set)| !set.is_empty()) {
            for command in commands {
                // A command in time is the end of having expired.
                let ends = command.is_some() && inputs.passed < values().expiry();
                if ends && set.filter(|condition| condition != Condition::Expired).is_empty() {
                    continue;
                }
                for (resume, confirmed) in [(false, 0), (true, 0), (false, before.stop), (true, before.stop)] {
                    let mut guard = before.clone();
                    let order = guard.step(&Inputs {
                        command,
                        resume,
                        confirmed,
                        ..inputs
                    });
                    let case = format!("{name}, {:?}, {command:?}", set.iter().collect::<Vec<_>>());
                    assert_eq!(order, Order::Stop(guard.stop), "{case}");
                    assert_eq!(guard.speeds(), [0.0; 2], "{case}");
                    assert_ne!(guard.state(), State::Moving, "{case}");
                    for condition in set.iter() {
                        assert!(guard.reasons().has(condition), "{case}");
                    }
                    if before.state() == State::Moving {
                        // The stop is a new one: earlier confirmations do not count for it.
                        assert_eq!(
                            (guard.state(), guard.stop),
                            (State::Stopping, before.stop + 1),
                            "{case}"
                        );
                    }
                    cases += 1;
                }
            }
        }
    }
    // 13 states, 4608 sets but the empty one, 5 commands, 4 companions.
    assert_eq!(cases, 13 * 4607 * 5 * 4);
}

/// The negative control of the table: with no condition, moving states keep moving, and standing ones may start.
#[test]
fn without_a_condition_they_move() {
    for (name, mut guard) in states_that_can_move() {
        if guard.state() == State::Moving {
            assert!(
                matches!(guard.step(&nothing()), Order::Drive(speeds) if speeds != [0.0; 2])
                    || name == "about to expire"
            );
        }
        confirm(&mut guard);
        let order = guard.step(&command([50.0, 50.0]));
        assert!(
            matches!(order, Order::Drive(speeds) if speeds != [0.0; 2]),
            "{name}: {order:?}"
        );
    }
}

/// After a stop the wheels stand still until the condition has ended, the robot has confirmed the stop, somebody has
/// resumed if needed, and then a fresh command has come: in this order.
#[test]
fn there_is_no_other_way_back() {
    for (inputs, set) in every_set().filter(|(_, set)| !set.is_empty()) {
        let latches = !set.filter(Condition::latches).is_empty();
        let is_final = set.iter().any(Condition::is_final);
        let mut guard = moving([100.0, 100.0], 50);
        guard.step(&inputs);
        let stands = |guard: &mut Guard, inputs: &Inputs, when: &str| {
            let order = guard.step(inputs);
            assert_eq!(
                order,
                Order::Stop(guard.stop),
                "{when}: {:?}",
                set.iter().collect::<Vec<_>>()
            );
        };
        let go = command([100.0, 100.0]);
        // While it lasts, confirmed or not, resumed or not.
        for resume in [false, true] {
            for confirmed in [0, guard.stop] {
                let lasting = Inputs {
                    resume,
                    confirmed,
                    ..inputs
                };
                stands(&mut guard, &lasting, "while it lasts");
                let sensed = !inputs.conditions.is_empty() || inputs.quiet >= values().link();
                if sensed {
                    let lasting = Inputs {
                        command: go.command,
                        passed: TICK,
                        ..lasting
                    };
                    stands(&mut guard, &lasting, "while it lasts, commanded");
                }
            }
        }
        // It has ended, but the robot has not confirmed the stop.
        let mut unconfirmed = moving([100.0, 100.0], 50);
        unconfirmed.step(&inputs);
        for _ in 0..20 {
            stands(&mut unconfirmed, &go, "unconfirmed");
            stands(&mut unconfirmed, &Inputs { resume: true, ..go }, "unconfirmed, resumed");
        }
        // Confirmed; if nothing latches, commands suffice, and earlier ones don't.
        let mut guard = moving([100.0, 100.0], 50);
        guard.step(&inputs);
        let confirmed = guard.stop;
        stands(&mut guard, &Inputs { confirmed, ..go }, "with the confirmation");
        for _ in 0..20 {
            stands(&mut guard, &nothing(), "without a command");
        }
        let mut resumed = guard.clone();
        for _ in 0..20 {
            let order = guard.step(&go);
            assert_eq!(
                matches!(order, Order::Drive(_)),
                !latches,
                "{:?}",
                set.iter().collect::<Vec<_>>()
            );
        }
        // A resume does it where nobody is gone, and not together with a command.
        stands(&mut resumed, &Inputs { resume: true, ..go }, "with the resume");
        stands(&mut resumed, &nothing(), "resumed");
        let order = resumed.step(&go);
        assert_eq!(
            matches!(order, Order::Drive(_)),
            !is_final,
            "{:?}",
            set.iter().collect::<Vec<_>>()
        );
    }
}

#[test]
fn a_command_counts_until_it_expires() {
    let mut guard = moving([100.0, 100.0], 50);
    for _ in 0..29 {
        assert!(matches!(guard.step(&nothing()), Order::Drive(_)));
    }
    assert!(matches!(guard.step(&nothing()), Order::Stop(_)));
    assert_eq!(guard.reasons(), with(&[Condition::Expired]));
    assert!(!guard.needs_resume());
    // After a longer silence, a fresh command is not enough.
    for _ in 0..170 {
        guard.step(&nothing());
    }
    assert!(guard.needs_resume());
    assert!(guard.reasons().has(Condition::Silent));
    confirm(&mut guard);
    assert!(matches!(guard.step(&command([50.0, 50.0])), Order::Stop(_)));
}

/// Commands that have waited because the guard did not run are of unknown age.
#[test]
fn commands_that_waited_for_the_guard_do_not_count() {
    let mut guard = standing();
    let late = Inputs {
        passed: values().expiry(),
        ..command([100.0, 100.0])
    };
    assert!(matches!(guard.step(&late), Order::Stop(_)));
    assert!(matches!(guard.step(&command([100.0, 100.0])), Order::Drive(_)));
}

#[test]
fn a_robot_that_stands_and_falls_silent_must_confirm_again() {
    let mut guard = standing();
    let first = guard.stop;
    let quiet = values().link();
    guard.step(&Inputs {
        quiet,
        confirmed: first,
        ..nothing()
    });
    assert_eq!((guard.state(), guard.stop), (State::Stopping, first + 1));
    // The old confirmation is none for the new stop.
    for _ in 0..3 {
        guard.step(&Inputs {
            confirmed: first,
            ..nothing()
        });
        assert_eq!(guard.state(), State::Stopping);
    }
}

#[test]
fn what_can_not_be_stopped_is_said_in_time() {
    // The robot answers to other things, but does not confirm.
    let mut guard = moving([100.0, 100.0], 10);
    let operator = with(&[Condition::Operator]);
    guard.step(&Inputs {
        conditions: operator,
        ..nothing()
    });
    for _ in 0..39 {
        guard.step(&nothing());
        assert!(!guard.cannot_stop());
    }
    guard.step(&nothing());
    assert!(guard.cannot_stop());
    confirm(&mut guard);
    assert!(!guard.cannot_stop());

    // The link is silent: the stop begins when that is noticed, and the silence counts from its beginning.
    let mut guard = moving([100.0, 100.0], 10);
    for tick in 1..=50 {
        let quiet = tick * TICK;
        guard.step(&Inputs {
            quiet,
            ..command([100.0, 100.0])
        });
        assert_eq!(guard.state() == State::Moving, quiet < values().link());
        assert_eq!(guard.cannot_stop(), quiet >= values().unconfirmed(), "{quiet:?}");
    }
}

#[test]
fn speeds_and_accelerations_are_limited() {
    // 400 mm/s^2 are 4 mm/s in a step.
    let mut guard = standing();
    assert_eq!(guard.step(&command([100.0, 2.0])), Order::Drive([4.0, 2.0]));
    assert_eq!(guard.step(&nothing()), Order::Drive([8.0, 2.0]));
    for _ in 0..50 {
        guard.step(&command([100.0, 2.0]));
    }
    assert_eq!(guard.speeds(), [100.0, 2.0]);
    // It may slow down at once, and turns the other way from zero.
    assert_eq!(guard.step(&command([10.0, -30.0])), Order::Drive([10.0, -4.0]));
    // Both wheels are limited alike, which keeps the curve.
    for _ in 0..100 {
        guard.step(&command([-600.0, 300.0]));
    }
    assert_eq!(guard.speeds(), [-GREATEST, GREATEST / 2.0]);
    for wish in [[1e300, 1e300], [f64::MAX, -f64::MAX]] {
        for _ in 0..100 {
            guard.step(&command(wish));
            assert!(guard.speeds().iter().all(|speed| speed.abs() <= GREATEST));
        }
    }
    // The guard's own limit is lower than this robot's.
    let fast = Guard::new(values(), 1041.0);
    assert_eq!(fast.greatest, 200.0);
}

#[test]
fn a_guard_ends_when_the_wheels_stand_or_it_has_tried_for_long() {
    let mut guard = moving([100.0, 100.0], 10);
    let closed = Inputs {
        conditions: with(&[Condition::Closed]),
        ..nothing()
    };
    guard.step(&closed);
    assert!(!guard.is_over());
    let mut hopeless = guard.clone();
    guard.step(&Inputs {
        confirmed: guard.stop,
        ..closed
    });
    assert!(guard.is_over() && guard.state() == State::Standing);

    let quiet = values().unconfirmed();
    for _ in 0..5999 {
        hopeless.step(&Inputs { quiet, ..closed });
        assert!(!hopeless.is_over());
    }
    hopeless.step(&Inputs { quiet, ..closed });
    assert!(hopeless.is_over() && hopeless.cannot_stop());
}

#[test]
fn sets_of_conditions_hold_what_was_added() {
    for (at, condition) in Condition::ALL.into_iter().enumerate() {
        let set = with(&[condition]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [condition]);
        assert_eq!(condition as usize, at);
        let mut all: Conditions = Condition::ALL.into_iter().collect();
        all.set(condition, false);
        assert_eq!(
            (set.is_empty(), all.has(condition), all.iter().count()),
            (false, false, 11)
        );
    }
    assert_eq!(Condition::ALL.into_iter().collect::<Conditions>().iter().count(), 12);
}
