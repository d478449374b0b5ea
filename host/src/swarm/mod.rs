//! Swarms whose on-board simulators evolve with their controllers: the loop of O'Dowd, Studley and Winfield (2014). Many
//! swarms go in lockstep, a minute at a time: all arenas live in one batch, then each robot ends its interval, and the
//! controllers of all robots of all swarms live in their simulators in another.

pub(crate) mod clock;
pub(crate) mod lived;
mod memory;
pub(crate) mod mind;
pub(crate) mod settings;

use std::ops::Range;

use oneiro::batch::{Batch, Outcome, Rollout, Worlds};
use oneiro::evaluator;
use oneiro::foraging::{Foraging, Light};
use oneiro::random::Key;
use oneiro::swarm::{Arena, Line, Order, SECOND, Simulated, Swarm, World};

use crate::evolve::encapsulated::{Genome, any_gene};
use crate::evolve::random::{Stream, below, shuffled, stream};
use crate::exchange::Exchange;
use crate::exit::{Failure, Result};
use crate::swarm::lived::{Case, Kind, RobotInterval, Run};
use clock::Clock;
use memory::{Memory, Second, Seconds};
use mind::Mind;
use settings::Settings;

/// Behaves as its random search does, with and without food.
const RANDOM: Genome = [0.495; 2];
/// The scenarios in the order of the simulators' worlds.
const SCENARIOS: [Light; 3] = [Light::OppositeNest, Light::Nowhere, Light::OverNest];

/// A swarm that is to live.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    /// What it is.
    pub(crate) settings: Settings,
    /// What of its evolution is left as it is.
    pub(crate) kind: Kind,
    /// Its number among those of its kind and case.
    pub(crate) number: u32,
    /// Everything random follows from it, but how robots differ.
    pub(crate) seed: u64,
}

/// Robot-steps of a swarm, in the arena and on board.
pub(crate) fn steps(plan: &Plan) -> u64 {
    let own = &plan.settings;
    let real = u64::from(own.robots) * u64::from(SECOND * own.seconds());
    let lives = u64::from(own.robots) * u64::from(own.controllers.population);
    let dreamt = lives * u64::from(SECOND * own.clock.interval_s) * u64::from(own.seconds() / own.clock.interval_s);
    real + if own.case == Case::Random { 0 } else { dreamt }
}

/// What is seen of swarms while they live.
pub(crate) trait Spectator {
    /// Called with what a stretch of seconds showed of a swarm, line by line.
    fn saw(&mut self, swarm: usize, lines: &[Line]);
}

/// Nobody looks.
impl Spectator for () {
    fn saw(&mut self, _: usize, _: &[Line]) {}
}

/// Lets swarms live from beginning to end. All last equally long, and their clocks are alike.
///
/// # Errors
/// Exit 3 for a value that a world does not allow, exit 75 when it was stopped, and as the evaluator's errors.
pub(crate) fn live(
    plans: &[Plan],
    evaluate: &dyn Fn(&Batch) -> std::result::Result<Outcome, evaluator::Error>,
    spectator: &mut dyn Spectator,
) -> Result<Vec<Run>> {
    let Some(first) = plans.first() else {
        return Ok(Vec::new());
    };
    let clock = &first.settings.clock;
    let seconds = first.settings.seconds();
    let simulators = Simulators::new(plans)?;
    let (swarms, worlds) = arenas(plans);
    let mut arena = Simulated::with(evaluate, &swarms, &worlds)?;
    let mut colonies: Vec<Colony<'_>> = plans.iter().map(Colony::new).collect();
    simulators.dream(&mut colonies, evaluate)?;
    // Stretches end when all robots have ended an interval.
    let ends = (0..).map(|stretch| clock.offset_s + stretch * clock.interval_s);
    let mut now = 0;
    for end in ends {
        let until = end.min(seconds);
        if until > now {
            let orders: Vec<Vec<Order>> = colonies.iter().map(|colony| colony.orders(now..until)).collect();
            let lines = arena.live(SECOND * until, &orders, SECOND).map_err(trouble)?;
            for (index, (colony, lines)) in colonies.iter_mut().zip(&lines).enumerate() {
                colony.see(lines);
                spectator.saw(index, lines);
            }
            now = until;
        }
        if now == seconds {
            break;
        }
        if now > clock.offset_s {
            for colony in &mut colonies {
                colony.wake();
            }
            simulators.dream(&mut colonies, evaluate)?;
        }
    }
    Ok(colonies.into_iter().map(Colony::finish).collect())
}

fn trouble(trouble: oneiro::swarm::Trouble) -> Failure {
    match trouble {
        oneiro::swarm::Trouble::Evaluation(error) => error.into(),
        oneiro::swarm::Trouble::Invalid(invalid) => invalid.into(),
    }
}

/// The swarms of some plans, each different one once, and their worlds.
fn arenas(plans: &[Plan]) -> (Vec<Swarm>, Vec<World>) {
    let mut swarms: Vec<Swarm> = Vec::new();
    let worlds = plans
        .iter()
        .map(|plan| {
            let own = plan.settings.swarm();
            let swarm = swarms.iter().position(|known| *known == own).unwrap_or_else(|| {
                swarms.push(own);
                swarms.len() - 1
            });
            World {
                swarm,
                lamp: plan.settings.case.lamp(SECOND * plan.settings.light_moves()),
                key: Key::rollout(plan.seed, 0, 0, 0),
            }
        })
        .collect();
    (swarms, worlds)
}

/// The worlds of all robots' simulators.
struct Simulators {
    worlds: Worlds,
    /// Of each plan the first of its three worlds.
    first: Vec<usize>,
}

impl Simulators {
    fn new(plans: &[Plan]) -> Result<Self> {
        let mut known: Vec<Foraging> = Vec::new();
        let first = plans
            .iter()
            .map(|plan| {
                let own = SCENARIOS.map(|light| plan.settings.simulator(light));
                let place = known.chunks_exact(3).position(|known| *known == own);
                place.map_or_else(
                    || {
                        known.extend(own);
                        known.len() - 3
                    },
                    |place| 3 * place,
                )
            })
            .collect();
        Ok(Self {
            worlds: Worlds::new(&known)?,
            first,
        })
    }

    /// All controllers of all robots live in their robots' simulators.
    fn dream(
        &self,
        colonies: &mut [Colony<'_>],
        evaluate: &dyn Fn(&Batch) -> std::result::Result<Outcome, evaluator::Error>,
    ) -> Result {
        let mut rollouts = Vec::new();
        for (colony, first) in colonies.iter().zip(&self.first) {
            for (mind, robot) in colony.minds.iter().zip(0..) {
                let scenario = SCENARIOS
                    .iter()
                    .position(|light| *light == mind.scenario())
                    .unwrap_or(0);
                rollouts.extend(mind.population().iter().zip(0..).map(|(genes, index)| Rollout {
                    world: first + scenario,
                    genes,
                    key: Key::rollout(colony.plan.seed, u64::from(mind.interval()) + 1, robot, index),
                }));
            }
        }
        if rollouts.is_empty() {
            return Ok(());
        }
        let fitness = evaluate(&self.worlds.batch(&rollouts, None)?)?.fitness;
        let mut rest = &fitness[..];
        for mind in colonies.iter_mut().flat_map(|colony| &mut colony.minds) {
            let (own, others) = rest.split_at(mind.population().len());
            mind.dream(own);
            rest = others;
        }
        Ok(())
    }
}

/// One swarm under way.
struct Colony<'a> {
    plan: &'a Plan,
    clocks: Vec<Clock>,
    /// None where nobody evolves.
    minds: Vec<Mind>,
    seconds: Seconds,
    now: u32,
    /// What each robot had earned in its interval by now.
    earned: Vec<f32>,
    brought: Vec<u16>,
    intervals: Vec<Vec<RobotInterval>>,
}

impl<'a> Colony<'a> {
    fn new(plan: &'a Plan) -> Self {
        let settings = &plan.settings;
        let robots = settings.robots as usize;
        let mut schedule = stream(plan.seed, Stream::Schedule, 0);
        let clocks: Vec<Clock> = (0..robots)
            .map(|_| Clock {
                offset: below(settings.clock.offset_s as usize + 1, &mut schedule) as u32,
                interval: settings.clock.interval_s,
                installed: settings.clock.installed_s,
            })
            .collect();
        let mind = |(robot, clock): (usize, &Clock)| Mind::new(settings, *clock, robot_seed(plan.seed, robot));
        let minds = if settings.case == Case::Random {
            Vec::new()
        } else {
            clocks.iter().enumerate().map(mind).collect()
        };
        let mut colony = Self {
            plan,
            clocks,
            minds,
            seconds: Seconds::new(settings.clock.interval_s + settings.clock.offset_s),
            now: 0,
            earned: vec![0.0; robots],
            brought: Vec::new(),
            intervals: Vec::new(),
        };
        colony.intervene();
        colony
    }

    /// What its robots are to do in some seconds.
    fn orders(&self, seconds: Range<u32>) -> Vec<Order> {
        let order = |(robot, clock): (usize, &Clock)| {
            if let Some(mind) = self.minds.get(robot) {
                return clock.order(seconds.clone(), mind.first, &mind.found);
            }
            let never = Clock {
                installed: u32::MAX - clock.offset,
                ..*clock
            };
            never.order(seconds.clone(), RANDOM, &[])
        };
        self.clocks.iter().enumerate().map(order).collect()
    }

    /// Takes in what was seen second by second.
    fn see(&mut self, lines: &[Line]) {
        for line in lines {
            let begins = |clock: &Clock| {
                let since = self.now.checked_sub(clock.offset);
                since.is_some_and(|since| since.is_multiple_of(clock.interval))
            };
            let earned = self
                .clocks
                .iter()
                .zip(&self.earned)
                .map(|(clock, &earned)| if begins(clock) { 0.0 } else { earned })
                .collect();
            self.seconds.push(Second {
                heard: line.robots.iter().map(|robot| robot.heard).collect(),
                earned,
                earned_after: line.robots.iter().map(|robot| robot.earned).collect(),
            });
            self.earned.clear();
            self.earned.extend(line.robots.iter().map(|robot| robot.earned));
            self.brought
                .push(line.robots.iter().map(|robot| robot.brought as u16).sum());
            self.now += 1;
        }
    }

    /// What a robot had earned at the end of an interval, or by now if that has not ended.
    fn real(&self, robot: usize, interval: u32) -> f32 {
        let last = self.clocks[robot].seconds_of(interval).end.min(self.now) - 1;
        self.seconds.get(last).map_or(0.0, |second| second.earned_after[robot])
    }

    /// All robots end an interval, in the order of their clocks: what one says in its next interval, others hear in
    /// this one of theirs.
    fn wake(&mut self) {
        let Some(interval) = self.minds.first().map(Mind::interval) else {
            return;
        };
        let settings = &self.plan.settings;
        let robots = self.minds.len();
        let whose = match self.plan.kind {
            Kind::FitnessShuffled => shuffled(robots, &mut stream(self.plan.seed, Stream::Intervention, interval)),
            _ => (0..robots).collect(),
        };
        let mut order: Vec<usize> = (0..robots).collect();
        order.sort_by_key(|&robot| self.clocks[robot].offset);
        let mut taken = vec![false; robots];
        for robot in order {
            let memory = Memory {
                seconds: &self.seconds,
                minds: &self.minds,
                says: settings.simulators.says,
                credit: settings.simulators.credit,
                whose: &whose,
            };
            let heard = memory.heard(robot, self.clocks[robot].seconds_of(interval));
            let real = self.real(whose[robot], interval);
            taken[robot] = self.minds[robot].wake(settings, real, &heard);
        }
        self.record(interval, &taken);
        self.intervene();
    }

    /// What the experimenter does to simulators when an interval begins.
    fn intervene(&mut self) {
        let Some(interval) = self.minds.first().map(Mind::interval) else {
            return;
        };
        let mut random = stream(self.plan.seed, Stream::Intervention, interval);
        let moves = self.plan.settings.light_moves();
        let [first, then] = self.plan.settings.case.lights();
        let now = |mind: &Mind| {
            if mind.clock.seconds_of(interval).start < moves {
                first
            } else {
                then
            }
        };
        match self.plan.kind {
            Kind::Evolved | Kind::FitnessShuffled | Kind::Alone => (),
            Kind::SimulatorShuffled => {
                let genes: Vec<f32> = self.minds.iter().map(Mind::simulator).collect();
                for (mind, from) in self.minds.iter_mut().zip(shuffled(genes.len(), &mut random)) {
                    mind.set_simulator(genes[from]);
                }
            }
            Kind::SimulatorRight => {
                for mind in &mut self.minds {
                    mind.set_simulator(middle(now(mind)));
                }
            }
            Kind::SimulatorWrong => {
                for mind in &mut self.minds {
                    mind.set_simulator(middle(other(now(mind))));
                }
            }
            Kind::SimulatorRandom => {
                for mind in &mut self.minds {
                    mind.set_simulator(any_gene(&mut random));
                }
            }
        }
    }

    /// Keeps what an interval was.
    fn record(&mut self, interval: u32, taken: &[bool]) {
        let heard: Vec<u128> = (0..self.minds.len())
            .map(|robot| {
                let seconds = self.clocks[robot].seconds_of(interval);
                seconds
                    .filter_map(|at| self.seconds.get(at))
                    .fold(0, |mask, second| mask | second.heard[robot])
            })
            .collect();
        let reached = reached(&heard);
        let own = self.minds.iter().enumerate().map(|(robot, mind)| {
            let last = mind.clock.seconds_of(interval).end - 1;
            let [g0, g1] = mind.acts(last);
            RobotInterval {
                s0: mind.simulators[interval as usize],
                chosen_under: mind.chosen_under(interval),
                g0,
                g1,
                real: self.real(robot, interval),
                simulated: mind.clock.found_in(last).map(|found| mind.dreamt[found as usize]),
                heard: heard[robot].count_ones() as u16,
                reached: reached[robot],
                taken: taken[robot],
            }
        });
        self.intervals.push(own.collect());
    }

    fn finish(mut self) -> Run {
        // The last interval is cut short where robots were switched on late.
        if let Some(interval) = self.minds.first().map(Mind::interval) {
            self.record(interval, &vec![false; self.minds.len()]);
        }
        Run {
            case: self.plan.settings.case,
            kind: self.plan.kind,
            number: self.plan.number,
            switched_on: self.clocks.iter().map(|clock| clock.offset as u16).collect(),
            brought: self.brought,
            intervals: self.intervals,
        }
    }
}

/// The seed of a robot's own random numbers.
fn robot_seed(seed: u64, robot: usize) -> u64 {
    let Key([low, high]) = Key::rollout(seed, u64::MAX, robot as u64, 0);
    u64::from(low) | u64::from(high) << 32
}

/// The middle of a scenario's bin.
fn middle(light: Light) -> f32 {
    match light {
        Light::OppositeNest => 0.165,
        Light::Nowhere => 0.495,
        Light::OverNest => 0.825,
    }
}

/// Where the light is not.
fn other(light: Light) -> Light {
    match light {
        Light::OverNest | Light::Nowhere => Light::OppositeNest,
        Light::OppositeNest => Light::OverNest,
    }
}

/// How many robots each is linked with by whom all heard, over others too, itself among them.
fn reached(heard: &[u128]) -> Vec<u16> {
    let mut linked: Vec<u128> = heard
        .iter()
        .enumerate()
        .map(|(robot, mask)| mask | 1 << robot)
        .collect();
    for (robot, &mask) in heard.iter().enumerate() {
        for (other, links) in linked.iter_mut().enumerate() {
            if mask >> other & 1 == 1 {
                *links |= 1 << robot;
            }
        }
    }
    let component = |robot: usize| {
        let mut seen = 1_u128 << robot;
        loop {
            let more = (0..linked.len())
                .filter(|other| seen >> other & 1 == 1)
                .fold(seen, |mask, other| mask | linked[other]);
            if more == seen {
                return seen.count_ones() as u16;
            }
            seen = more;
        }
    };
    (0..linked.len()).map(component).collect()
}

#[cfg(test)]
mod tests;
