//! Swarms of a few robots for a few minutes.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use oneiro::batch::{Rollout, TraceRequest, WorldKind, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::Light;
use oneiro::swarm::Line;
use oneiro_robots::script::Random;
use oneiro_robots::tracker::Seen;

use super::clock::Clock;
use super::job::reached;
use super::memory::{Memory, Second, Seconds};
use super::on_board::OnBoard;
use super::*;
use crate::engine::job::{Job, Request, Results};
use crate::exchange::contact::{Contact, Heard};
use crate::exchange::links::{Links, Topology};
use crate::exchange::radio::key::Key;
use crate::exchange::radio::{Packet, Radio, Received, Refusal};
use crate::exchange::{Exchange, Message};
use crate::swarm::record::{Credit, RobotInterval};
use crate::swarm::settings::Says;

fn small(case: Case) -> Settings {
    Settings {
        case,
        world: oneiro::swarm::Swarm {
            robots: 5,
            ..Settings::default().world
        },
        minutes: 5,
        light_moves_minute: 3,
        ..Settings::default()
    }
}

fn plan(case: Case, kind: Kind) -> Plan {
    let mut settings = small(case);
    if !kind.has_simulators() || kind == Kind::Central {
        settings.clock.offset_s = 0;
    }
    Plan {
        settings,
        kind,
        number: 0,
        seed: 5,
    }
}

fn engine() -> Engine {
    Engine::new(Box::new(Cpu::new(Some(2)).unwrap()), Arc::new(AtomicBool::new(false)))
}

fn runs(plans: &[Plan]) -> Vec<Run> {
    live(plans, &engine()).unwrap()
}

/// A run and its lines.
fn run_traced(plan: Plan) -> (Run, Vec<Line>) {
    let jobs = engine().finished(vec![SwarmJob::new(plan).keeping_lines()], &mut ());
    let job = jobs.unwrap().remove(0);
    (job.run(), job.lines().to_vec())
}

/// Lets a swarm take its next step only. Returns whether there was one.
fn step(job: &mut SwarmJob, engine: &Engine) -> bool {
    let Some(Request {
        stage, worlds, states, ..
    }) = job.ask()
    else {
        return false;
    };
    let worlds: Vec<&dyn WorldKind> = worlds.iter().map(|place| &*place.world as _).collect();
    let worlds = Worlds::new(&worlds).unwrap();
    let mut rollouts = Vec::new();
    job.rollouts(&mut rollouts);
    let batch = match stage.cycles {
        None => worlds.batch(&rollouts, None),
        Some([first, end]) => {
            let trace = stage.trace_every.map(|every| TraceRequest { every });
            worlds.stretch(&rollouts, first..end, states, trace)
        }
    };
    let batch = batch.unwrap();
    let log_words = batch.record_words();
    let outcome = engine.evaluate(&batch).unwrap();
    let results = Results {
        fitness: &outcome.fitness,
        traces: &outcome.traces,
        logs: &outcome.logs,
        log_words,
        states: &outcome.states,
    };
    job.tell(&results).unwrap();
    true
}

fn run_alone(plan: Plan) -> Run {
    runs(&[plan]).remove(0)
}

#[test]
fn a_swarm_is_the_same_in_any_batch() {
    let plans: Vec<Plan> = Case::ALL.map(|case| plan(case, Kind::Evolved)).into();
    let together = runs(&plans);
    for (plan, run) in plans.iter().zip(&together) {
        assert_eq!(run_alone(plan.clone()), *run, "{:?}", plan.settings.case);
    }
    let other = run_alone(Plan {
        seed: 6,
        ..plans[1].clone()
    });
    assert_ne!(other.intervals, together[1].intervals);
    let random = &together[5];
    assert!(random.intervals.is_empty() && random.brought.len() == 300);
    for run in &together[..5] {
        assert_eq!(run.intervals.len(), 5);
        assert!(run.intervals.iter().all(|robots| robots.len() == 5));
        assert!(run.intervals[0].iter().all(|own| own.simulated.is_none()));
        assert!(run.intervals[1..].iter().flatten().all(|own| own.simulated.is_some()));
    }
}

/// Plans of every case and every kind of intervention, and of settings that a saved swarm could forget.
fn all_kinds() -> Vec<Plan> {
    let mut plans: Vec<Plan> = Case::ALL.map(|case| plan(case, Kind::Evolved)).into();
    let kinds = Kind::OF_STUDY.into_iter().chain(Kind::RIVALS);
    plans.extend(kinds.map(|kind| plan(Case::OverThenOpposite, kind)));
    let changes: [fn(&mut Settings); 6] = [
        |own| own.controllers.guests = 2,
        |own| own.clock.installed_s = 34,
        |own| own.clock.offset_s = 0,
        |own| own.clock.interval_s = 50,
        |own| own.simulators.says = Says::LastWhole,
        |own| own.simulators.credit = Credit::Matched,
    ];
    for change in changes {
        let mut plan = plan(Case::Over, Kind::Evolved);
        change(&mut plan.settings);
        plans.push(plan);
    }
    for plan in &mut plans {
        // Most messages are then received.
        plan.settings.world.range = 600.0;
        plan.settings.minutes = 4;
        plan.settings.light_moves_minute = 2;
    }
    plans
}

/// Swarms of different clocks and lengths, each saved and restored before each of its steps.
#[test]
fn a_swarm_saved_and_restored_at_every_step_is_the_same() {
    let plans = all_kinds();
    let straight = runs(&plans);
    assert!(
        straight
            .iter()
            .any(|run| run.intervals.iter().flatten().any(|own| own.taken))
    );
    let mut jobs: Vec<SwarmJob> = plans.iter().cloned().map(SwarmJob::new).collect();
    let engine = engine();
    for (job, plan) in jobs.iter_mut().zip(&plans) {
        let mut steps = 0;
        loop {
            let saved = job.save();
            *job = SwarmJob::restore(plan.clone(), &saved).unwrap();
            assert!(job.save() == saved);
            if !step(job, &engine) {
                break;
            }
            steps += 1;
        }
        assert!(steps > 2, "{steps}");
    }
    for ((job, run), plan) in jobs.iter().zip(straight).zip(&plans) {
        assert_eq!(job.run(), run, "{:?}, {:?}", plan.kind, plan.settings);
    }
}

#[test]
fn damaged_states_and_those_of_other_swarms_are_refused() {
    let own = plan(Case::Over, Kind::Evolved);
    let mut jobs = [SwarmJob::new(own.clone())];
    let engine = engine();
    for _ in 0..4 {
        assert!(step(&mut jobs[0], &engine));
    }
    let saved = jobs[0].save();
    let problem = |plan: &Plan, saved: &[u8]| {
        let restored = SwarmJob::restore(plan.clone(), saved);
        restored.err().expect("it is refused").to_string()
    };
    for length in (0..saved.len()).step_by(31) {
        assert!(problem(&own, &saved[..length]).contains("is cut off or damaged"));
    }
    for place in (0..8 * saved.len()).step_by(101) {
        let mut bad = saved.clone();
        bad[place / 8] ^= 1 << (place % 8);
        problem(&own, &bad);
    }
    let mut others = [
        own.clone(),
        own.clone(),
        own.clone(),
        plan(Case::NoLight, Kind::Evolved),
    ];
    others[0].seed += 1;
    others[1].kind = Kind::FitnessShuffled;
    others[2].settings.world.differences.slip *= 0.5;
    for other in others {
        assert!(problem(&other, &saved).contains("belongs to other settings"));
    }
}

/// Results of another shape are refused, and the swarm continues as if they had not come.
#[test]
fn results_that_do_not_fit_are_refused_without_a_change() {
    let nothing = Results {
        fitness: &[],
        traces: &[],
        logs: &[],
        log_words: 1,
        states: &[],
    };
    let mut jobs = [SwarmJob::new(plan(Case::Over, Kind::Evolved))];
    let engine = engine();
    for _ in 0..4 {
        let before = jobs[0].save();
        let (short, words) = (vec![vec![0]], vec![vec![0; 10_000]]);
        let wrong = [
            Results {
                fitness: &[0.0; 49],
                ..nothing
            },
            Results {
                logs: &short,
                states: &words,
                ..nothing
            },
            Results {
                logs: &words,
                states: &short,
                ..nothing
            },
            nothing,
        ];
        for results in wrong {
            assert!(jobs[0].tell(&results).is_err());
            assert!(jobs[0].save() == before);
        }
        assert!(step(&mut jobs[0], &engine));
    }
}

/// Two cases that differ in the light's second place are the same until the light moves.
#[test]
fn cases_are_the_same_until_the_light_moves() {
    let runs = runs(&[
        plan(Case::Opposite, Kind::Evolved),
        plan(Case::OppositeThenOver, Kind::Evolved),
    ]);
    assert_eq!(runs[0].brought[..180], runs[1].brought[..180]);
    assert_eq!(runs[0].intervals[..2], runs[1].intervals[..2]);
    assert_ne!(runs[0].intervals[4], runs[1].intervals[4]);
}

/// The controller of an interval is the best of the simulations of the one before.
#[test]
fn controllers_come_from_the_interval_before() {
    let run = run_alone(plan(Case::Over, Kind::Evolved));
    for pair in run.intervals.windows(2) {
        for (before, now) in pair[0].iter().zip(&pair[1]) {
            assert_eq!(now.chosen_under, before.s0);
        }
    }
    // After 34 s it acts in the same interval.
    let mut early = plan(Case::Over, Kind::Evolved);
    early.settings.clock.installed_s = 34;
    let run = run_alone(early);
    assert!(
        run.intervals
            .iter()
            .flatten()
            .all(|own| own.chosen_under == own.s0 && own.simulated.is_some())
    );
}

#[test]
fn interventions_set_what_they_say() {
    let bins = |run: &Run| -> Vec<Vec<Light>> {
        let of = |robots: &Vec<RobotInterval>| robots.iter().map(|own| Light::of_gene(own.s0)).collect();
        run.intervals.iter().map(of).collect()
    };
    let moved = Case::OverThenOpposite;
    let right = bins(&run_alone(plan(moved, Kind::SimulatorRight)));
    let wrong = bins(&run_alone(plan(moved, Kind::SimulatorWrong)));
    for interval in 0..5 {
        let light = moved.light_in(interval, 3);
        assert!(right[interval].iter().all(|own| *own == light), "interval {interval}");
        assert!(wrong[interval].iter().all(|own| *own != light), "interval {interval}");
    }
    let drawn = run_alone(plan(Case::Over, Kind::SimulatorRandom));
    let mut genes: Vec<f32> = drawn.intervals.iter().flatten().map(|own| own.s0).collect();
    genes.sort_by(f32::total_cmp);
    genes.dedup();
    assert_eq!(genes.len(), 25, "all are drawn anew");
    // Each shuffled gene is a robot's.
    let evolved = run_alone(plan(Case::Over, Kind::Evolved));
    let shuffled = run_alone(plan(Case::Over, Kind::SimulatorShuffled));
    let sorted = |robots: &[RobotInterval]| {
        let mut genes: Vec<f32> = robots.iter().map(|own| own.s0).collect();
        genes.sort_by(f32::total_cmp);
        genes
    };
    assert_ne!(evolved.intervals[0], shuffled.intervals[0]);
    assert_eq!(sorted(&evolved.intervals[0]), sorted(&shuffled.intervals[0]));
}

/// Without mutations, every controller without simulators is one of the interval before.
#[test]
fn controllers_without_simulators_are_those_of_other_robots() {
    for kind in [Kind::Embodied, Kind::EmbodiedRandom] {
        let mut plan = plan(Case::Over, kind);
        plan.settings.controllers.mutation_rate = 0.0;
        plan.settings.minutes = 12;
        let run = run_alone(plan.clone());
        let genome = |own: &RobotInterval| [own.g0, own.g1];
        let (mut taken, mut from_worse) = (0, 0);
        for pair in run.intervals.windows(2) {
            for (robot, (before, now)) in pair[0].iter().zip(&pair[1]).enumerate() {
                assert!(now.simulated.is_none() && now.s0 == before.s0);
                if !before.taken {
                    assert_eq!(genome(now), genome(before));
                    assert!(before.heard == 0 || kind == Kind::Embodied);
                    continue;
                }
                let mut others = pair[0].iter().enumerate().filter(|(other, _)| *other != robot);
                let donor = others
                    .find(|(_, own)| genome(own) == genome(now))
                    .expect("it is another's")
                    .1;
                assert!(before.heard > 0);
                taken += 1;
                from_worse += u32::from(donor.real <= before.real);
            }
        }
        assert!(taken > 3, "{kind:?}: {taken}");
        assert_eq!(from_worse > 0, kind == Kind::EmbodiedRandom, "{kind:?}");
        // With mutations there are new ones.
        plan.settings.controllers.mutation_rate = 1.0;
        let mutated = run_alone(plan);
        let first: Vec<[f32; 2]> = mutated.intervals[0].iter().map(genome).collect();
        assert!(mutated.intervals[1].iter().all(|own| !first.contains(&genome(own))));
    }
}

/// Of 30 controllers that a robot hears, each of which may be taken over at random, none is lost for its fitness.
#[test]
fn at_random_nothing_is_lost_by_its_fitness() {
    let mut settings = exact();
    settings.controllers.mutation_rate = 0.0;
    let heard: Vec<Message> = (0..30)
        .map(|sender| Message {
            sender: sender + 1,
            controller: [0.03 * sender as f32; 2],
            ..said(0.5, sender as f32)
        })
        .collect();
    let clock = Clock {
        offset: 0,
        interval: 60,
        installed: 60,
    };
    let taken_by = |seed, is_random| {
        let mut robot = OnBoard::new(&settings, clock, seed);
        robot.begin_without_simulator();
        let ended = robot.end_interval_without_simulator(&settings, 7.0, &heard, is_random);
        assert_eq!(ended.pairs.len(), if is_random { 30 } else { 10 });
        robot.acts(60)[0]
    };
    let at_random: Vec<f32> = (0..200).map(|seed| taken_by(seed, true)).collect();
    let low = at_random.iter().filter(|gene| **gene < 0.03 * 15.0).count();
    assert!((70..130).contains(&low), "{low} of 200 are of the lower half");
    assert!((0..200).all(|seed| taken_by(seed, false) == 0.03 * 29.0));
}

/// Without mutations, a robot takes over a simulator that predicted its sender's last interval better than the robot's own did this one.
#[test]
fn simulators_that_predict_best_are_taken_over() {
    let mut plan = plan(Case::Over, Kind::Disparity);
    // A robot's messages are then all of one interval of the sender.
    plan.settings.clock.offset_s = 0;
    plan.settings.simulators.mutation_scale = 0.0;
    plan.settings.minutes = 12;
    let run = run_alone(plan);
    let difference = |own: &RobotInterval| own.simulated.map(|simulated| (simulated - own.real).abs());
    let mut taken = 0;
    for three in run.intervals.windows(3) {
        for (robot, (own, next)) in three[1].iter().zip(&three[2]).enumerate() {
            if !own.taken {
                assert_eq!(next.s0, own.chosen_under);
                continue;
            }
            let others = three[0].iter().enumerate().filter(|(other, _)| *other != robot);
            let is_donor = |other: &RobotInterval| {
                other.chosen_under == next.s0
                    && difference(other).is_some_and(|theirs| difference(own).is_none_or(|ours| theirs < ours))
            };
            assert!(others.into_iter().any(|(_, other)| is_donor(other)), "{own:?}");
            taken += 1;
        }
    }
    assert!(taken > 5, "{taken}");
}

/// Who is heard changes nothing where the experimenter sets all simulators.
#[test]
fn simulators_that_are_set_come_from_nobody() {
    let taken = |kind| {
        let run = run_alone(plan(Case::Over, kind));
        run.intervals.iter().flatten().filter(|own| own.taken).count()
    };
    for kind in [Kind::SimulatorRight, Kind::SimulatorWrong, Kind::SimulatorRandom] {
        assert_eq!(taken(kind), 0, "{kind:?}");
    }
    for kind in [Kind::Evolved, Kind::SimulatorShuffled] {
        assert!(taken(kind) > 0, "{kind:?}");
    }
}

#[test]
fn all_hear_all_wherever_they_are() {
    let far = |kind| {
        let mut plan = plan(Case::Over, kind);
        plan.settings.world.range = 1.0;
        run_alone(plan)
    };
    let taken = |run: &Run| run.intervals.iter().flatten().filter(|own| own.taken).count();
    let (alone, together) = (far(Kind::Evolved), far(Kind::HeardByAll));
    assert!(alone.intervals.iter().flatten().all(|own| own.heard == 0) && taken(&alone) == 0);
    assert!(taken(&together) > 5);
    assert!(
        together
            .intervals
            .iter()
            .flatten()
            .all(|own| (own.heard, own.reached) == (4, 5))
    );
    for robots in &together.intervals[..4] {
        let most = robots.iter().map(|own| own.real).fold(0.0, f32::max);
        // Who has brought nothing, where others have, has taken over theirs.
        assert!(
            robots
                .iter()
                .all(|own| own.taken == (own.real < most) || own.real > 0.0)
        );
    }
}

/// Simulators that don't change are those of their founders.
#[test]
fn lineages_are_those_of_simulators() {
    for (kind, credit) in [
        (Kind::Evolved, Credit::Lagged),
        (Kind::Evolved, Credit::Matched),
        (Kind::FitnessShuffled, Credit::Matched),
        (Kind::Disparity, Credit::Lagged),
    ] {
        let mut plan = plan(Case::Over, kind);
        plan.settings.simulators.credit = credit;
        plan.settings.simulators.mutation_scale = 0.0;
        plan.settings.minutes = 12;
        let run = run_alone(plan);
        let all: Vec<&RobotInterval> = run.intervals.iter().flatten().collect();
        for own in &all {
            assert_eq!(
                own.s0,
                run.intervals[0][usize::from(own.founder)].s0,
                "{kind:?}, {credit:?}"
            );
        }
        assert!(all.iter().filter(|own| own.taken).count() > 5, "{kind:?}, {credit:?}");
    }
}

/// The time of a takeover, and the lineages that are left.
#[test]
fn takeovers_are_those_worked_out_by_hand() {
    let plan = plan(Case::Over, Kind::Evolved);
    let mut run = run_alone(plan.clone());
    let outcome = |run: &Run, name: &str| -> f64 {
        let all = run.outcomes(&plan.settings);
        let (_, value) = all.iter().find(|(own, _)| **own == *name).unwrap();
        value.parse().unwrap()
    };
    let founders = [[0, 1, 2, 3, 4], [0, 1, 1, 3, 3], [1, 1, 1, 1, 1], [1, 1, 1, 1, 1]];
    run.intervals.truncate(founders.len());
    for (robots, founders) in run.intervals.iter_mut().zip(founders) {
        for (own, founder) in robots.iter_mut().zip(founders) {
            own.founder = founder;
        }
    }
    assert_eq!((outcome(&run, "takeover_min"), outcome(&run, "lineages")), (2.0, 1.0));
    run.intervals.truncate(2);
    assert_eq!((outcome(&run, "takeover_min"), outcome(&run, "lineages")), (5.0, 3.0));
    run.kind = Kind::SimulatorShuffled;
    assert!(outcome(&run, "takeover_min").is_nan() && outcome(&run, "lineages").is_nan());
}

/// The common simulator has the light where an interval of all robots was best predicted, by simulations that the test makes itself.
#[test]
fn a_central_simulator_predicts_best() {
    const LIGHTS: [Light; 3] = [Light::OppositeNest, Light::Nowhere, Light::OverNest];
    let mut plan = plan(Case::OverThenOpposite, Kind::Central);
    plan.settings.minutes = 12;
    plan.settings.light_moves_minute = 6;
    let run = run_alone(plan.clone());
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut chosen = Vec::new();
    for (interval, both) in run.intervals.windows(2).enumerate() {
        let mut differences = [0.0; 3];
        for (light, sum) in LIGHTS.into_iter().zip(&mut differences) {
            let world = plan.settings.simulator(light);
            for (robot, own) in both[0].iter().enumerate() {
                let rollout = Rollout {
                    world: 0,
                    genes: &[own.g0, own.g1],
                    key: oneiro::random::Key::rollout(plan.seed, interval as u64 + 1, robot as u64, 0),
                };
                let worlds: [&dyn WorldKind; 1] = [&world];
                let worlds = Worlds::new(&worlds).unwrap();
                let batch = worlds.batch(std::slice::from_ref(&rollout), None).unwrap();
                let said = cpu.evaluate(&batch, &Control::new()).unwrap().fitness[0];
                *sum += f64::from((said - own.real).abs());
            }
        }
        let next = Light::of_gene(both[1][0].s0);
        assert!(both[1].iter().all(|own| Light::of_gene(own.s0) == next && !own.taken));
        let best = (0..3).find(|&at| LIGHTS[at] == next).unwrap();
        assert!(
            differences.iter().all(|other| differences[best] <= *other),
            "{interval}: {differences:?}, {next:?}"
        );
        chosen.push(best);
    }
    assert!(chosen.contains(&0) && chosen.contains(&2), "{chosen:?}");
}

#[test]
fn what_is_about_simulators_is_no_number_without_them() {
    let outcomes = |kind| {
        let plan = plan(Case::Over, kind);
        let named = run_alone(plan.clone()).outcomes(&plan.settings);
        let missing = named
            .into_iter()
            .filter(|(_, value)| value == "NaN")
            .map(|(name, _)| name);
        missing.collect::<Vec<_>>()
    };
    let missing = outcomes(Kind::Embodied);
    // Controllers' genes and food are known.
    let is_about = |name: &str| {
        ["right", "later", "s0", "area", "matched", "takeover", "lineages"]
            .iter()
            .any(|word| name.contains(word))
    };
    let mut expected: Vec<_> = tables::outcomes()
        .into_iter()
        .map(|column| column.name)
        .filter(|name| is_about(name))
        .collect();
    expected.sort();
    assert_eq!(missing, expected);
    assert!(outcomes(Kind::Evolved).iter().all(|name| name == "chosen_area"));
}

#[test]
fn islands_hear_their_neighbours_while_links_are_open() {
    let run = |topology, migration, range| {
        let mut plan = plan(Case::Over, Kind::Evolved);
        plan.settings.links = Links { topology, migration };
        plan.settings.world.range = range;
        plan.settings.minutes = 12;
        run_alone(plan)
    };
    let of = |run: &Run, value: fn(&RobotInterval) -> usize| run.intervals.iter().flatten().map(value).sum::<usize>();
    let heard = |run: &Run| of(run, |own| usize::from(own.heard));
    let ring = run(Topology::Ring, 1.0, 1.0);
    assert!(
        ring.intervals
            .iter()
            .flatten()
            .all(|own| (own.heard, own.reached) == (2, 5))
    );
    // A lineage goes one robot a minute each way.
    let beside = |robot: usize, founder: usize| [0, 1, 4].contains(&((robot + 5 - founder) % 5));
    for (robot, own) in ring.intervals[1].iter().enumerate() {
        assert!(beside(robot, own.founder.into()), "{robot}: {}", own.founder);
    }
    assert!(of(&ring, |own| own.taken.into()) > 5);
    let closed = run(Topology::Ring, 0.0, 1.0);
    assert_eq!((heard(&closed), of(&closed, |own| own.taken.into())), (0, 0));
    // Of 120 links of a ring, and of encounters.
    assert!((35..=85).contains(&heard(&run(Topology::Ring, 0.5, 1.0))));
    let [few, many] = [0.2, 1.0].map(|migration| heard(&run(Topology::Encounters, migration, 250.0)));
    assert!(few > 0 && few < many / 2, "{few} of {many}");
}

/// Simulators match when half of them are right over five intervals; if they never do, the whole time counts.
#[test]
fn the_time_to_a_match_is_that_worked_out_by_hand() {
    let plan_of = |kind| plan(Case::Over, kind);
    let minutes = |run: &Run| -> f64 {
        let all = run.outcomes(&plan_of(Kind::Evolved).settings);
        let found = all.iter().find(|(name, _)| **name == *"matched_min");
        found.unwrap().1.parse().unwrap()
    };
    let right = run_alone(plan_of(Kind::SimulatorRight));
    let mut run = run_alone(plan_of(Kind::SimulatorWrong));
    assert_eq!((minutes(&right), minutes(&run)), (5.0, 5.0));
    let (wrong, right) = (run.intervals[0].clone(), &right.intervals[0]);
    // Two of five intervals and half of the robots in a third.
    let mut half = wrong.clone();
    half[..3].clone_from_slice(&right[..3]);
    run.intervals = [vec![wrong; 4], vec![right.clone(); 2], vec![half; 2]].concat();
    run.brought.resize(8 * 60, 0);
    assert_eq!(minutes(&run), 7.0);
    run.intervals.truncate(6);
    assert_eq!(minutes(&run), 8.0);
    // Exactly half, of which fractions have a sum below 2.5.
    let with = |count: usize| {
        let mut robots = [run.intervals[0].clone(), run.intervals[0].clone()].concat();
        for (own, other) in robots.iter_mut().zip(right.iter().cycle()).take(count) {
            own.clone_from(other);
        }
        robots
    };
    run.intervals = [4, 6, 4, 7, 4, 0].map(with).to_vec();
    assert_eq!(minutes(&run), 5.0);
}

/// Where simulators are set by the experimenter, no credit is compared. Where they evolve, credit matters, unless controllers act
/// in the interval in which they were chosen.
#[test]
fn credit_makes_no_difference_where_the_study_says_so() {
    let lived = |kind: Kind, credit: Credit, installed_s: u32| {
        let mut plan = plan(Case::Over, kind);
        plan.settings.simulators.credit = credit;
        plan.settings.clock.installed_s = installed_s;
        run_alone(plan)
    };
    for (kind, installed_s, is_same) in [
        (Kind::SimulatorRight, 60, true),
        (Kind::SimulatorRandom, 60, true),
        (Kind::Evolved, 34, true),
        (Kind::FitnessShuffled, 34, true),
        (Kind::Evolved, 60, false),
    ] {
        let [lagged, matched] = [Credit::Lagged, Credit::Matched].map(|credit| lived(kind, credit, installed_s));
        assert_eq!(lagged == matched, is_same, "{kind:?}, installed after {installed_s} s");
    }
}

/// A single robot's simulator drifts at random, wherever the light is.
#[test]
fn nothing_selects_the_simulator_of_one_robot() {
    let alone = |case| {
        let mut plan = plan(case, Kind::Alone);
        plan.settings.world.robots = 1;
        let run = run_alone(plan);
        assert!(
            run.intervals
                .iter()
                .flatten()
                .all(|own| !own.taken && own.heard == 0 && own.reached == 1)
        );
        run.intervals.iter().map(|robots| robots[0].s0).collect::<Vec<_>>()
    };
    let over = alone(Case::Over);
    assert_eq!(over, alone(Case::NoLight));
    assert!(over.windows(2).all(|pair| pair[0] != pair[1]), "it always changes");
}

/// Food is collected in the seconds of the trace that say so, and an interval's fitness is what it earned.
#[test]
fn records_agree_with_the_trace() {
    let mut settings = small(Case::Over);
    settings.clock.offset_s = 0;
    let plan = Plan {
        settings,
        ..plan(Case::Over, Kind::SimulatorRight)
    };
    let (run, seen) = run_traced(plan);
    assert_eq!(seen.len(), 300);
    let brought: Vec<u16> = seen
        .iter()
        .map(|line| line.robots.iter().map(|own| own.brought as u16).sum())
        .collect();
    assert_eq!(run.brought, brought);
    assert!(brought.iter().sum::<u16>() > 0);
    for (interval, robots) in run.intervals.iter().enumerate() {
        for (robot, own) in robots.iter().enumerate() {
            assert_eq!(own.real, seen[60 * interval + 59].robots[robot].earned);
            let heard = seen[60 * interval..60 * (interval + 1)]
                .iter()
                .fold(0, |mask, line| mask | line.robots[robot].heard);
            assert_eq!(u32::from(own.heard), heard.count_ones());
        }
    }
}

fn robot(settings: &Settings, offset: u32) -> OnBoard {
    let clock = Clock {
        offset,
        interval: 60,
        installed: 60,
    };
    let mut robot = OnBoard::new(settings, clock, 9);
    robot.take_simulated(&[0.0; 10]);
    robot
}

fn said(simulator: f32, fitness: f32) -> Message {
    Message {
        sender: 1,
        interval: 0,
        simulator,
        fitness,
        controller: [0.25, 0.75],
    }
}

/// Mutations so small that a simulator's origin can be recognised.
fn exact() -> Settings {
    let mut settings = Settings::default();
    settings.simulators.mutation_scale = 1e-6;
    settings
}

#[test]
fn the_better_simulator_is_taken_over_and_changed() {
    let settings = exact();
    let go_on = |real, heard: &[Message]| {
        let mut robot = robot(&settings, 0);
        let own = robot.simulator();
        let taken = robot.end_interval(&settings, real, heard).from.is_some();
        assert_eq!(robot.interval(), 1);
        assert_ne!(robot.simulator(), own, "a gene always changes");
        (taken, own, robot.simulator())
    };
    let (taken, own, next) = go_on(10.0, &[said(0.123, 10.0)]);
    assert!(!taken && (next - own).abs() < 1e-4, "ties keep one's own");
    let other = Message {
        sender: 2,
        ..said(0.456, 5.0)
    };
    let (taken, _, next) = go_on(10.0, &[said(0.123, 11.0), other]);
    assert!(taken && (next - 0.123).abs() < 1e-4);
    let (taken, own, next) = go_on(0.0, &[]);
    assert!(!taken && (next - own).abs() < 1e-4);
}

/// As in the paper, fitness is credited to the simulator of the same interval; when matched, to that of the interval
/// before, in which the controller was chosen.
#[test]
fn credit_follows_the_rule() {
    for (credit, back) in [(Credit::Lagged, 0), (Credit::Matched, 1)] {
        let mut settings = exact();
        settings.simulators.credit = credit;
        let mut robot = robot(&settings, 0);
        robot.end_interval(&settings, 0.0, &[said(0.2, 1.0)]);
        robot.take_simulated(&[0.0; 10]);
        robot.end_interval(&settings, 0.0, &[said(0.8, 1.0)]);
        robot.take_simulated(&[0.0; 10]);
        // In interval 2 it has 0.8, and acts by what was chosen under 0.2.
        let expected = [0.8, 0.2][back];
        assert!((robot.credited(2, credit) - expected).abs() < 1e-4, "{credit:?}");
        robot.end_interval(&settings, 100.0, &[]);
        assert!((robot.simulator() - expected).abs() < 1e-4, "{credit:?}");
    }
}

#[test]
fn guests_are_tested_in_the_robots_own_simulator() {
    let mut settings = exact();
    settings.controllers.guests = 2;
    let mut robot = robot(&settings, 0);
    robot.end_interval(&settings, 50.0, &[said(0.1, 1.0)]);
    assert_eq!(robot.controllers()[9], [0.25, 0.75]);
    assert_ne!(robot.controllers()[8], [0.25, 0.75]);
}

/// A message has the fitness at the beginning of the second, in the sender's interval; under the null another robot's.
#[test]
fn messages_are_looked_up_by_the_senders_clock() {
    let settings = exact();
    let mut robots = vec![robot(&settings, 0), robot(&settings, 2)];
    for robot in &mut robots {
        robot.end_interval(&settings, 30.0, &[said(0.7, 40.0)]);
        robot.take_simulated(&[0.0; 10]);
    }
    let mut seconds = Seconds::new(70);
    for second in 0..70_u8 {
        seconds.push(Second {
            heard: vec![0b10, u128::from(second == 61)],
            earned: vec![f32::from(second), 100.0 + f32::from(second)],
            earned_after: vec![0.0; 2],
        });
    }
    let memory = |says, whose| Memory {
        kind: Kind::Evolved,
        seconds: &seconds,
        robots: &robots,
        says,
        credit: Credit::Lagged,
        whose,
    };
    let own = memory(Says::SoFar, &[0, 1]);
    let heard = own.heard(0, 0..64);
    // The other is switched on at 2, and in its second interval from 62 on.
    assert_eq!(heard.len(), 62);
    assert_eq!((heard[0].interval, heard[0].fitness), (0, 102.0));
    assert_eq!((heard[61].interval, heard[61].fitness), (1, 163.0));
    assert!((heard[61].simulator - 0.7).abs() < 1e-4 && heard[0].simulator == robots[1].simulators[0]);
    let back = own.heard(1, 60..64);
    assert_eq!(
        (back.len(), back[0].sender, back[0].interval, back[0].fitness),
        (1, 0, 1, 61.0)
    );
    assert_eq!(memory(Says::SoFar, &[1, 0]).heard(1, 60..64)[0].fitness, 161.0);
    let whole = memory(Says::LastWhole, &[0, 1]).heard(0, 0..64);
    assert_eq!(whole.len(), 2);
    assert_eq!(
        (whole[0].interval, whole[0].fitness, whole[0].simulator),
        (0, 30.0, robots[1].simulators[0])
    );
}

/// Robots receive the same messages as in the study if radio messages and a tracker's lines come in any order and more than once.
#[test]
fn by_radio_robots_hear_what_they_hear_in_the_study() {
    const ROBOTS: usize = 5;
    let settings = exact();
    let mut random = Random(3);
    let mut robots: Vec<OnBoard> = [0, 2, 5, 3, 1].map(|offset| robot(&settings, offset)).into();
    for (own, number) in robots.iter_mut().zip(1_u8..) {
        own.end_interval(&settings, 30.0, &[said(f32::from(number) / 10.0, 40.0)]);
        own.take_simulated(&[0.0; 10]);
    }
    let (mut seconds, mut whole) = (Seconds::new(130), Seconds::new(130));
    for _ in 0..130 {
        let second = Second {
            heard: (0..ROBOTS)
                .map(|own| (u128::from(random.next()) % 32) & !(1 << own))
                .collect(),
            earned: (0..ROBOTS).map(|_| random.below(9000) as f32).collect(),
            earned_after: vec![0.0; ROBOTS],
        };
        whole.push(Second {
            heard: (0..ROBOTS).map(|own| 31 & !(1 << own)).collect(),
            ..second.clone()
        });
        seconds.push(second);
    }
    let memory = |seconds| Memory {
        kind: Kind::Evolved,
        seconds,
        robots: &robots,
        says: Says::SoFar,
        credit: Credit::Matched,
        whose: &[0, 1, 2, 3, 4],
    };
    let mut radios: Vec<Radio> = (0..ROBOTS as u16)
        .map(|own| Radio::new(own, settings.limits(), &Key::of(1), [7; 32], 0))
        .collect();
    for (receiver, own) in robots.iter().enumerate() {
        let interval = own.clock.seconds_of(1);
        let mut heard = [Contact::Tracker, Contact::Range].map(|contact| Heard::new(contact, 70));
        for heard in &mut heard {
            heard.forget_before(interval.start);
        }
        let mut seen = Seen::new(receiver as u64, 200.0, Duration::from_millis(300));
        let mut coming: Vec<(u32, Vec<u8>)> = Vec::new();
        for at in interval.start - 3..interval.end {
            // All messages of the others, some of them late or twice, and some among the tracker's lines.
            for message in memory(&whole).heard(receiver, at..at + 1) {
                let datagram = radios[message.sender].seal(&Packet::Pair { second: at, message });
                for _ in 0..=random.below(2) {
                    let late = u32::from(at + 1 < interval.end && random.below(4) == 0);
                    coming.push((at + late, datagram.clone()));
                }
            }
            // Five lines a second, each with one robot more or less.
            for line in 0..ROBOTS {
                let time = f64::from(at) + line as f64 / 5.0;
                let now = Duration::from_secs_f64(time);
                let mask = seconds.get(at).unwrap().heard[receiver];
                let list = if mask >> line & 1 == 1 { vec![line] } else { Vec::new() };
                let text =
                    format!("{{\"id\":{receiver},\"t\":{time},\"x\":1,\"y\":2,\"heading\":0,\"heard\":{list:?}}}");
                let robots = seen.take(text.as_bytes(), now).and_then(|sighting| sighting.heard);
                for heard in &mut heard {
                    heard.meet(at, robots.unwrap_or(0));
                }
                let is_last = line == ROBOTS - 1;
                let has_come = |(second, _): &mut (u32, Vec<u8>)| *second <= at && (is_last || random.below(3) == 0);
                for (_, datagram) in coming.extract_if(.., has_come) {
                    let opened = radios[receiver].open(&datagram, now, Some(at));
                    let Ok(Received {
                        packet: Packet::Pair { second, message },
                        ..
                    }) = opened
                    else {
                        assert_eq!(opened, Err(Refusal::Replayed));
                        continue;
                    };
                    for heard in &mut heard {
                        heard.hear(second, message);
                    }
                }
            }
        }
        let [by_tracker, by_range] = heard.map(|heard| heard.heard(receiver, interval.clone()));
        assert!(by_tracker.len() > 60 && by_range.len() > by_tracker.len());
        assert_eq!(by_tracker, memory(&seconds).heard(receiver, interval.clone()));
        assert_eq!(by_range, memory(&whole).heard(receiver, interval));
    }
}

/// The null gives each robot's fitness to one robot.
#[test]
fn shuffled_fitness_is_all_there() {
    let run = |kind| run_alone(plan(Case::Over, kind));
    let (own, null) = (run(Kind::Evolved), run(Kind::FitnessShuffled));
    // Nothing has been compared before the first interval ends.
    assert_eq!(own.brought[..60], null.brought[..60]);
    for (one, other) in own.intervals[0].iter().zip(&null.intervals[0]) {
        assert_eq!((one.s0, one.g0, one.real), (other.s0, other.g0, other.real));
    }
    assert_ne!(own.intervals[1..], null.intervals[1..]);
}

#[test]
fn encounters_link_over_others() {
    // 0 receives from 1, 2 from 1, 3 from none, 4 and 5 from each other.
    assert_eq!(reached(&[0b10, 0, 0b10, 0, 1 << 5, 1 << 4]), [3, 3, 3, 1, 2, 2]);
    let all: Vec<u128> = (0..128)
        .map(|robot| if robot == 127 { 0 } else { 1 << (robot + 1) })
        .collect();
    assert_eq!(reached(&all), [128; 128]);
}

/// Robots that are switched on a whole interval apart still have all messages of their interval.
#[test]
fn messages_of_a_whole_interval_are_kept() {
    let mut settings = small(Case::Over);
    settings.minutes = 12;
    settings.world.robots = 12;
    settings.clock.interval_s = 180;
    settings.clock.offset_s = 180;
    settings.clock.installed_s = 180;
    let plan = Plan {
        settings,
        ..plan(Case::Over, Kind::Evolved)
    };
    let (run, seen) = run_traced(plan);
    assert!(run.switched_on.iter().any(|&on| on < 60) && run.switched_on.iter().any(|&on| on > 120));
    for (interval, robots) in run.intervals.iter().enumerate().take(2) {
        for (robot, own) in robots.iter().enumerate() {
            let first = run.switched_on[robot] as usize + 180 * interval;
            let heard = seen[first..first + 180]
                .iter()
                .fold(0, |mask, line| mask | line.robots[robot].heard);
            assert_eq!(
                u32::from(own.heard),
                heard.count_ones(),
                "robot {robot}, interval {interval}"
            );
        }
    }
}
