//! A swarm's run as a job. Its steps alternate: all robots' controllers are evaluated in their on-board simulators; then
//! the arena is simulated until all robots have ended an interval.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use oneiro::batch::{Rollout, WorldKind};
use oneiro::foraging::Light;
use oneiro::random::Key;
use oneiro::swarm::{Line, Order, SECOND, Seen, Swarm};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::sealed;
use oneiro_evolve::encapsulated::{Genome, any_gene};
use oneiro_evolve::random::{Stream, shuffled, stream};
use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::memory::{Memory, Second, Seconds};
use super::on_board::OnBoard;
use super::record::{Case, Credit, Kind, LIGHTS, RobotInterval, Run};
use super::{Plan, tables};
use crate::engine::job::{Added, Finished, Job, Place, Progress, Request, Results, Stage, Step};
use crate::exchange::Exchange;
use crate::exchange::links::{Links, Topology};

/// The name of saved states, and their version.
const NAME: &str = "swarm";
const VERSION: u32 = 3;
/// Intervals between two checkpoints of a run with a directory.
const CHECKPOINT_EVERY: usize = 10;
/// A controller that searches at random, with and without food.
const RANDOM: Genome = [0.495; 2];

/// One swarm from its beginning to its end.
pub struct SwarmJob {
    plan: Plan,
    swarm: Arc<Swarm>,
    arena: [Place; 1],
    simulators: [Place; LIGHTS.len()],
    state: State,
    /// The arena's input in the next stretch, which follows from the other fields.
    input: Vec<f32>,
    /// The trace so far, if requested.
    lines: Option<Vec<Line>>,
    /// Rows of the tables of details since the last step, if requested; all of them if the trace is kept.
    details: Option<Details>,
    /// Makes another file of the run, if requested.
    page: Option<Page>,
}

/// Rows of the tables from which a run can be recomputed.
#[derive(Clone, Debug, Default)]
struct Details {
    deposits: String,
    controllers: String,
    pairs: String,
}

impl Details {
    fn tables(&self) -> [(&'static str, &str); 3] {
        [
            (tables::DEPOSITS, &self.deposits),
            (tables::CONTROLLERS, &self.controllers),
            (tables::PAIRS, &self.pairs),
        ]
    }
}

/// A file of a run besides its tables: its name, and what makes it.
pub type Page = (&'static str, Box<dyn Fn(&Run) -> String + Send + Sync>);

/// The state that is saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    clocks: Vec<Clock>,
    /// Empty if nothing evolves.
    robots: Vec<OnBoard>,
    /// For each robot and each interval the robot whose first simulator its simulator descends from.
    founders: Vec<Vec<u16>>,
    /// What simulators with each place of the light said in this interval of the controllers that act in it; empty if one was asked.
    predicted: Vec<[f32; LIGHTS.len()]>,
    seconds: Seconds,
    /// Simulated seconds, and the words of the arena's state after them; none at the beginning.
    now: u32,
    arena: Option<Vec<u32>>,
    /// Each robot's fitness so far in its interval.
    earned: Vec<f32>,
    brought: Vec<u16>,
    intervals: Vec<Vec<RobotInterval>>,
}

impl SwarmJob {
    /// A run at its beginning.
    pub fn new(plan: Plan) -> Self {
        let settings = &plan.settings;
        let robots = settings.world.robots as usize;
        let clocks = plan.clocks();
        let on_board = |(robot, clock): (usize, &Clock)| OnBoard::new(settings, *clock, plan.robot_seed(robot));
        let state = State {
            robots: if settings.case == Case::Random {
                Vec::new()
            } else {
                clocks.iter().enumerate().map(on_board).collect()
            },
            founders: (0..robots).map(|robot| vec![robot as u16]).collect(),
            predicted: Vec::new(),
            clocks,
            seconds: Seconds::new(settings.clock.interval_s + settings.clock.offset_s),
            now: 0,
            arena: None,
            earned: vec![0.0; robots],
            brought: Vec::new(),
            intervals: Vec::new(),
        };
        let mut job = Self::at(plan, state);
        if !job.plan.kind.has_simulators() {
            job.state.robots.iter_mut().for_each(OnBoard::begin_without_simulator);
            job.order();
        }
        job.intervene();
        job
    }

    /// A run from where [`Job::save`] was called.
    ///
    /// # Errors
    /// Exit 5 for a state that is damaged, or of another swarm or version.
    pub fn restore(plan: Plan, saved: &[u8]) -> Result<Self> {
        let state = sealed::open(NAME, VERSION, &plan.hash(), saved)
            .map_err(|problem| Failure::corrupt(format_args!("the saved state of a swarm {problem}")))?;
        Ok(Self::at(plan, state))
    }

    fn at(plan: Plan, state: State) -> Self {
        let swarm = Arc::new(plan.settings.swarm());
        let simulator = |light| place(Arc::new(plan.settings.simulator(light)));
        let mut job = Self {
            arena: [place(Arc::clone(&swarm))],
            simulators: LIGHTS.map(simulator),
            swarm,
            plan,
            state,
            input: Vec::new(),
            lines: None,
            details: None,
            page: None,
        };
        job.order();
        job
    }

    /// Keeps the trace from now on.
    #[must_use]
    pub fn keeping_lines(mut self) -> Self {
        self.lines = Some(Vec::new());
        self
    }

    /// Adds rows to the tables of details.
    #[must_use]
    pub fn with_details(mut self) -> Self {
        self.details = Some(Details::default());
        self
    }

    /// The rows of the tables of details; all of them if the trace is kept.
    pub fn details(&self) -> Vec<(&'static str, &str)> {
        self.details.iter().flat_map(Details::tables).collect()
    }

    /// Writes another file at the end.
    #[must_use]
    pub fn with_page(mut self, page: Page) -> Self {
        self.page = Some(page);
        self
    }

    /// The kept trace, a line for each second.
    pub fn lines(&self) -> &[Line] {
        self.lines.as_deref().unwrap_or_default()
    }

    /// The record so far.
    pub fn run(&self) -> Run {
        let state = &self.state;
        Run {
            case: self.plan.settings.case,
            kind: self.plan.kind,
            number: self.plan.number,
            switched_on: state.clocks.iter().map(|clock| clock.offset as u16).collect(),
            brought: state.brought.clone(),
            intervals: state.intervals.clone(),
        }
    }

    fn is_finished(&self) -> bool {
        self.state.now == self.plan.settings.seconds()
    }

    /// Whether controllers are to be evaluated on board before the arena's next stretch.
    fn is_to_simulate(&self) -> bool {
        self.state.robots.iter().any(OnBoard::is_to_simulate)
    }

    /// Cycles from a line of the arena's trace to the next. Details have the cycle in which each item was brought.
    fn trace_every(&self) -> u32 {
        if self.details.is_some() { 1 } else { SECOND }
    }

    /// The arena's next stretch in seconds: until all robots have ended an interval, or all have been switched on.
    fn stretch(&self) -> Range<u32> {
        let Self { plan, state, .. } = self;
        let clock = &plan.settings.clock;
        let ended = state
            .now
            .checked_sub(clock.offset_s)
            .map_or(0, |since| since / clock.interval_s + 1);
        let end = clock.offset_s + ended * clock.interval_s;
        state.now..end.min(plan.settings.seconds())
    }

    /// Computes the robots' orders for the next stretch.
    fn order(&mut self) {
        let (seconds, state) = (self.stretch(), &self.state);
        if self.is_finished() || self.is_to_simulate() {
            return;
        }
        let order = |(robot, clock): (usize, &Clock)| {
            if let Some(own) = state.robots.get(robot) {
                return clock.order(seconds.clone(), own.first, &own.chosen);
            }
            let never = Clock {
                installed: u32::MAX - clock.offset,
                ..*clock
            };
            never.order(seconds.clone(), RANDOM, &[])
        };
        let orders: Vec<Order> = state.clocks.iter().enumerate().map(order).collect();
        self.input = self.swarm.inputs(&self.plan.lamp(), &orders);
    }

    fn rollouts_on_board(&self) -> impl Iterator<Item = Rollout<'_>> {
        let seed = self.plan.seed;
        let asked = self.plan.kind.simulators();
        self.state.robots.iter().zip(0..).flat_map(move |(own, robot)| {
            let first = if asked == 1 { number_of(own.scenario()) } else { 0 };
            (first..first + asked).flat_map(move |world| own.rollouts(world, seed, robot))
        })
    }

    /// The number of episodes on board in an interval.
    fn simulations(&self) -> usize {
        let controllers: usize = self.state.robots.iter().map(|own| own.controllers().len()).sum();
        controllers * self.plan.kind.simulators()
    }

    /// Takes the fitness of all controllers on board.
    fn take_simulated(&mut self, fitness: &[f32]) -> Result {
        let (expected, asked) = (self.simulations(), self.plan.kind.simulators());
        let Self { details, state, .. } = self;
        state.predicted.clear();
        if fitness.len() != expected {
            return Err(wrong("fitness", fitness.len(), expected));
        }
        let mut rest = fitness;
        for (robot, own) in state.robots.iter_mut().enumerate() {
            let controllers = own.controllers().len();
            let (all, others) = rest.split_at(asked * controllers);
            let mut fitness = all;
            if asked == LIGHTS.len() {
                // The controller that acts is the first, the best one of the interval before.
                state.predicted.push([0, 1, 2].map(|world| all[world * controllers]));
                fitness = &all[number_of(own.scenario()) * controllers..][..controllers];
            }
            own.take_simulated(fitness);
            if let Some(details) = details {
                details.controllers += &tables::controller_rows(own.interval(), robot, own, fitness);
            }
            rest = others;
        }
        Ok(())
    }

    /// Takes the trace and the state of a stretch.
    fn take_stretch(&mut self, results: &Results<'_>) -> Result {
        let Range { start, end } = self.stretch();
        let words = self.swarm.state_words() as usize;
        let ([log], [arena]) = (results.logs, results.states) else {
            return Err(wrong("logs and states", results.logs.len() + results.states.len(), 2));
        };
        let a_second = (SECOND / self.trace_every()) as usize;
        let lines = (end - start) as usize * a_second;
        if log.len() != lines * results.log_words {
            return Err(wrong("words of a trace", log.len(), lines * results.log_words));
        }
        let Some(arena) = arena.get(..words) else {
            return Err(wrong("words of a state", arena.len(), words));
        };
        self.state.arena = Some(arena.to_vec());
        let lines = self.swarm.lines(log, results.log_words);
        if let Some(details) = &mut self.details {
            for (cycle, line) in (SECOND * start..).zip(&lines) {
                details.deposits += &deposits(&self.state.clocks, cycle, line);
            }
        }
        let mut lines: Vec<Line> = lines.chunks(a_second).map(second).collect();
        self.link(start, &mut lines);
        for line in &lines {
            self.state.see(line);
        }
        if let Some(kept) = &mut self.lines {
            kept.extend(lines);
        }
        if self.is_finished() {
            // The last interval is cut short where robots were switched on late.
            if let Some(interval) = self.state.interval() {
                self.state.record(interval, &vec![false; self.state.robots.len()]);
            }
        } else if self.state.now > self.plan.settings.clock.offset_s {
            self.end_interval();
            self.intervene();
        }
        Ok(())
    }

    /// Lets robots hear those that they are linked to, or fewer than they met, in the seconds from `start` on.
    fn link(&self, start: u32, lines: &mut [Line]) {
        let links = match self.plan.kind {
            Kind::HeardByAll => Links {
                topology: Topology::All,
                ..Links::ENCOUNTERS
            },
            _ => self.plan.settings.links,
        };
        if links == Links::ENCOUNTERS {
            return;
        }
        let mut of_intervals = BTreeMap::new();
        for (second, line) in (start..).zip(lines) {
            let robots = line.robots.len();
            for (robot, own) in line.robots.iter_mut().enumerate() {
                own.heard = self.state.clocks[robot].interval_at(second).map_or(0, |interval| {
                    let open = || links.open(self.plan.seed, interval, robots);
                    of_intervals.entry(interval).or_insert_with(open)[robot].of(own.heard)
                });
            }
        }
    }

    /// Ends an interval of all robots, in the order of their clocks: a robot's messages of its next interval reach others in
    /// this interval of theirs.
    fn end_interval(&mut self) {
        let Self {
            plan, state, details, ..
        } = self;
        let Some(interval) = state.interval() else {
            return;
        };
        let settings = &plan.settings;
        let robots = state.robots.len();
        let whose = match plan.kind {
            Kind::FitnessShuffled => shuffled(robots, &mut stream(plan.seed, Stream::Intervention, interval)),
            _ => (0..robots).collect(),
        };
        let central = (plan.kind == Kind::Central).then(|| state.best_light(interval));
        let mut order: Vec<usize> = (0..robots).collect();
        order.sort_by_key(|&robot| state.clocks[robot].offset);
        let mut taken = vec![false; robots];
        for robot in order {
            let exchange = Memory {
                seconds: &state.seconds,
                robots: &state.robots,
                says: settings.simulators.says,
                credit: settings.simulators.credit,
                whose: &whose,
                kind: plan.kind,
            };
            let heard = exchange.heard(robot, state.clocks[robot].seconds_of(interval));
            let real = state.real(whose[robot], interval);
            let own = &mut state.robots[robot];
            let mut credit = settings.simulators.credit;
            let ended = match plan.kind {
                Kind::Embodied | Kind::EmbodiedRandom => {
                    let is_random = plan.kind == Kind::EmbodiedRandom;
                    own.end_interval_without_simulator(settings, real, &heard, is_random)
                }
                Kind::Disparity => {
                    let reached = own.agreement(interval, real).unwrap_or(f32::NEG_INFINITY);
                    credit = Credit::Matched;
                    own.end_interval_by(settings, real, (credit, reached), &heard)
                }
                _ => own.end_interval(settings, real, if plan.kind.exchanges() { &heard } else { &[] }),
            };
            if let Some(light) = central {
                own.set_simulator(middle(light));
            }
            taken[robot] = ended.from.is_some() && !plan.kind.sets_simulators();
            let from = ended.from.filter(|_| plan.kind.has_lineages());
            let (parent, at) = from.unwrap_or((robot, interval));
            let founder = state.founders[parent][state.robots[parent].credited_in(at, credit) as usize];
            state.founders[robot].push(founder);
            if let Some(details) = details {
                details.pairs += &tables::pair_rows(interval, robot, &ended.pairs);
            }
        }
        state.record(interval, &taken);
    }

    /// The experimenter's intervention at the beginning of an interval.
    fn intervene(&mut self) {
        let Self { plan, state, .. } = self;
        let Some(interval) = state.interval() else {
            return;
        };
        let mut random = stream(plan.seed, Stream::Intervention, interval);
        let moves = plan.settings.light_moves();
        let [first, then] = plan.settings.case.lights();
        let now = |own: &OnBoard| {
            if own.clock.seconds_of(interval).start < moves {
                first
            } else {
                then
            }
        };
        let genes: Vec<f32> = state.robots.iter().map(OnBoard::simulator).collect();
        let sources = match plan.kind {
            Kind::SimulatorShuffled => shuffled(genes.len(), &mut random),
            _ => Vec::new(),
        };
        for (robot, own) in state.robots.iter_mut().enumerate() {
            own.set_simulator(match plan.kind {
                Kind::SimulatorShuffled => genes[sources[robot]],
                Kind::SimulatorRight => middle(now(own)),
                Kind::SimulatorWrong => middle(other(now(own))),
                Kind::SimulatorRandom => any_gene(&mut random),
                _ => continue,
            });
        }
    }
}

impl Job for SwarmJob {
    fn ask(&self) -> Option<Request<'_>> {
        if self.is_finished() {
            return None;
        }
        let Self { plan, state, .. } = self;
        let reached = SECOND * state.now;
        if self.is_to_simulate() {
            let simulations = self.simulations();
            return Some(Request {
                stage: Stage {
                    reached,
                    ..Stage::lives(self.simulators[0].world.kernel().name)
                },
                worlds: &self.simulators,
                outside: None,
                states: &[],
                lives: simulations,
                steps: simulations as u64 * u64::from(SECOND * plan.settings.clock.interval_s),
            });
        }
        let Range { start, end } = self.stretch();
        Some(Request {
            stage: Stage {
                kernel: oneiro_shaders::SWARM.name,
                reached,
                cycles: Some([SECOND * start, SECOND * end]),
                trace_every: Some(self.trace_every()),
            },
            worlds: &self.arena,
            outside: None,
            states: state.arena.as_slice(),
            lives: 1,
            steps: u64::from(plan.settings.world.robots * SECOND * (end - start)),
        })
    }

    fn rollouts<'a>(&'a self, into: &mut Vec<Rollout<'a>>) {
        if self.is_to_simulate() {
            into.extend(self.rollouts_on_board());
        } else if !self.is_finished() {
            into.push(Rollout {
                world: 0,
                genes: &self.input,
                key: Key::rollout(self.plan.seed, 0, 0, 0),
            });
        }
    }

    fn tell(&mut self, results: &Results<'_>) -> Result<Step> {
        if self.is_finished() {
            return Err(Failure::failed("a swarm has ended"));
        }
        let recorded = self.state.intervals.len();
        let simulated = self.is_to_simulate();
        if simulated {
            self.take_simulated(results.fitness)?;
        } else {
            self.take_stretch(results)?;
        }
        self.order();
        let state = &self.state;
        let intervals = state.intervals.len();
        let added = (recorded..intervals).map(|interval| Added {
            file: tables::INTERVALS,
            bytes: tables::interval_rows(interval, &state.intervals[interval]).into_bytes(),
        });
        let mut added: Vec<Added> = added.collect();
        if let Some(details) = &mut self.details {
            added.extend(details.tables().map(|(file, rows)| Added {
                file,
                bytes: rows.as_bytes().to_vec(),
            }));
            if self.lines.is_none() {
                *details = Details::default();
            }
        }
        Ok(Step {
            added,
            progress: (!simulated).then(|| Progress {
                done: state.now / 60,
                best: state.brought.iter().copied().map(f32::from).sum(),
            }),
            is_checkpoint: intervals > recorded && intervals.is_multiple_of(CHECKPOINT_EVERY) && !self.is_finished(),
        })
    }

    fn save(&self) -> Vec<u8> {
        sealed::seal(NAME, VERSION, &self.plan.hash(), &self.state)
    }

    fn finish(&mut self, _: &str) -> Result<Finished> {
        let run = self.run();
        let mut files = vec![(tables::FOOD, run.food_table().into_bytes())];
        files.extend(self.page.iter().map(|(name, page)| (*name, page(&run).into_bytes())));
        Ok(Finished {
            files,
            outcomes: run.outcomes(&self.plan.settings),
            champion: Vec::new(),
        })
    }
}

impl State {
    /// The interval that all robots are in.
    fn interval(&self) -> Option<u32> {
        self.robots.first().map(OnBoard::interval)
    }

    /// Takes one line of the trace: a second.
    fn see(&mut self, line: &Line) {
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
        let earned_after: Vec<f32> = line.robots.iter().map(|robot| robot.earned).collect();
        self.seconds.push(Second {
            heard: line.robots.iter().map(|robot| robot.heard).collect(),
            earned,
            earned_after: earned_after.clone(),
        });
        self.earned = earned_after;
        self.brought
            .push(line.robots.iter().map(|robot| robot.brought as u16).sum());
        self.now += 1;
    }

    /// A robot's fitness at the end of an interval, or so far if the interval has not ended.
    fn real(&self, robot: usize, interval: u32) -> f32 {
        let last = self.clocks[robot].seconds_of(interval).end.min(self.now) - 1;
        self.seconds.get(last).map_or(0.0, |second| second.earned_after[robot])
    }

    /// The light's place with which simulators predicted best what all robots reached in an interval: with the smallest sum of differences.
    fn best_light(&self, interval: u32) -> Light {
        let difference = |world: usize| -> f64 {
            let robots = self.predicted.iter().enumerate();
            robots
                .map(|(robot, said)| f64::from(said[world] - self.real(robot, interval)).abs())
                .sum()
        };
        let best = (0..LIGHTS.len()).min_by(|a, b| difference(*a).total_cmp(&difference(*b)));
        LIGHTS[best.unwrap_or(0)]
    }

    /// Records an interval.
    fn record(&mut self, interval: u32, taken: &[bool]) {
        let heard: Vec<u128> = self
            .clocks
            .iter()
            .enumerate()
            .map(|(robot, clock)| {
                let seconds = clock.seconds_of(interval);
                seconds
                    .filter_map(|at| self.seconds.get(at))
                    .fold(0, |mask, second| mask | second.heard[robot])
            })
            .collect();
        let reached = reached(&heard);
        let robots = self.robots.iter().enumerate().map(|(robot, own)| {
            let last = own.clock.seconds_of(interval).end - 1;
            let [g0, g1] = own.acts(last);
            RobotInterval {
                s0: own.simulators[interval as usize],
                chosen_under: own.chosen_under(interval),
                g0,
                g1,
                real: self.real(robot, interval),
                // Not a number without simulators.
                simulated: own
                    .clock
                    .chosen_in(last)
                    .map(|chosen| own.simulated[chosen as usize])
                    .filter(|simulated| !simulated.is_nan()),
                heard: heard[robot].count_ones() as u16,
                reached: reached[robot],
                taken: taken[robot],
                founder: self.founders[robot][interval as usize],
            }
        });
        let robots = robots.collect();
        self.intervals.push(robots);
    }
}

/// A line for each item that was brought in a cycle.
fn deposits(clocks: &[Clock], cycle: u32, line: &Line) -> String {
    let row = |(robot, (own, clock)): (usize, (&Seen, &Clock))| {
        let interval = clock.interval_at(cycle / SECOND).filter(|_| own.brought > 0)?;
        let began = SECOND * clock.seconds_of(interval).start;
        Some(tables::deposit_row(cycle, robot, interval, began, [own.x, own.y]))
    };
    line.robots.iter().zip(clocks).enumerate().filter_map(row).collect()
}

/// The line of a second, from those of its cycles.
fn second(cycles: &[Line]) -> Line {
    let mut line = cycles[cycles.len() - 1].clone();
    for before in &cycles[..cycles.len() - 1] {
        for (own, before) in line.robots.iter_mut().zip(&before.robots) {
            own.brought += before.brought;
            own.heard |= before.heard;
        }
    }
    line
}

fn wrong(what: &str, given: usize, expected: usize) -> Failure {
    Failure::failed(format_args!("{given} {what} for a swarm; allowed: {expected}"))
}

/// A world by its values.
fn place(world: Arc<impl WorldKind + Debug + Send + Sync + 'static>) -> Place {
    Place {
        key: blake3::hash(format!("{world:?}").as_bytes()),
        world,
    }
}

/// The number of a scenario's world.
fn number_of(scenario: Light) -> usize {
    LIGHTS.iter().position(|light| *light == scenario).unwrap_or(0)
}

/// The middle of a scenario's bin.
fn middle(light: Light) -> f32 {
    match light {
        Light::OppositeNest => 0.165,
        Light::Nowhere => 0.495,
        Light::OverNest => 0.825,
    }
}

/// The light's other place.
fn other(light: Light) -> Light {
    match light {
        Light::OverNest | Light::Nowhere => Light::OppositeNest,
        Light::OppositeNest => Light::OverNest,
    }
}

/// For each robot the number of robots it is linked to, directly or over others, itself included. `heard` has the robots whose
/// messages each robot received.
pub(super) fn reached(heard: &[u128]) -> Vec<u16> {
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
