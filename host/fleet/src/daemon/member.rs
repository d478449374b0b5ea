//! One robot of a swarm on its computer: its reactions to sightings and messages, cycle by cycle. The schedule and the
//! evolution are those of the batched study (`swarm/`), without clock, files or sockets.

use oneiro::swarm::SECOND;
use oneiro_evolve::encapsulated::Genome;
use oneiro_lab::exchange::contact::{Contact, Heard};
use oneiro_lab::exchange::{Exchange, Message};
use oneiro_lab::swarm::Plan;
use oneiro_lab::swarm::on_board::OnBoard;
use oneiro_lab::swarm::settings::most_items;
use serde::{Deserialize, Serialize};

/// A cycle in s, as kernels count it.
const CYCLE_S: f32 = 0.1;

/// The tracker's report on the robot in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sighted {
    /// Whether it carries food.
    pub carries: bool,
    /// Food that it has brought to the nest since the experiment began.
    pub brought: u32,
}

/// An interval that has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ended {
    /// Its number, from 0, by the robot's clock.
    pub interval: u32,
    /// The robot's number.
    pub robot: u32,
    /// The gene of the robot's simulator.
    pub simulator: f32,
    /// The gene of the simulator in which the acting controller was chosen.
    pub chosen_under: f32,
    /// The controller that acted at its end.
    pub controller: Genome,
    /// The robot's fitness.
    pub real: f32,
    /// Food that it brought, by the tracker.
    pub brought: u32,
    /// The acting controller's fitness in the simulator in which it was chosen; none in the first interval.
    pub simulated: Option<f32>,
    /// Number of robots that it took messages from.
    pub heard: u32,
    /// Whether its next simulator came from another robot.
    pub taken: bool,
    /// Whether it did not live through all of it: its fitness is what it earned in the rest, and nothing evolved.
    pub missed: bool,
}

/// What a cycle asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Deeds {
    /// The controller that acts; none before the robot is switched on.
    pub controller: Option<Genome>,
    /// The message to broadcast, and its second.
    pub say: Option<(u32, Message)>,
    /// Intervals that have ended.
    pub ended: Vec<Ended>,
    /// Whether the experiment is over.
    pub is_over: bool,
}

/// A robot and its evolution.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    plan: Plan,
    robot: usize,
    state: MemberState,
    /// What it has heard, and from whom.
    heard: Heard,
    /// The current second; none before the first cycle.
    second: Option<u32>,
    /// The cycle from which it has lived without interruption.
    since: u32,
    /// The first cycle of this interval.
    began: u32,
    /// Its fitness in this interval so far, and the food that it has brought.
    earned: f32,
    brought: u32,
    /// Whether it carries food.
    carries: bool,
    /// The cycle of the last sighting; none since its program has begun.
    sighted: Option<u32>,
}

/// What is saved of a robot between two intervals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MemberState {
    pub evolution: OnBoard,
    /// Its food by the tracker.
    pub brought: Option<u32>,
}

impl Member {
    /// A robot before the experiment.
    pub(crate) fn new(plan: Plan, robot: usize, contact: Contact) -> Self {
        let state = MemberState {
            evolution: OnBoard::new(&plan.settings, plan.clocks()[robot], plan.robot_seed(robot)),
            brought: None,
        };
        Self::at(plan, robot, contact, state)
    }

    /// A robot from where its state was saved.
    pub(crate) fn at(plan: Plan, robot: usize, contact: Contact, state: MemberState) -> Self {
        /// Margin around an interval and the time within which robots are switched on, s.
        const SPARE: u32 = 5;
        let clock = &plan.settings.clock;
        Self {
            heard: Heard::new(contact, clock.interval_s + clock.offset_s + SPARE),
            plan,
            robot,
            state,
            second: None,
            since: 0,
            began: 0,
            earned: 0.0,
            brought: 0,
            carries: false,
            sighted: None,
        }
    }

    /// What has to be saved.
    pub(crate) fn state(&self) -> &MemberState {
        &self.state
    }

    /// Its evolution on board.
    pub(crate) fn evolution(&self) -> &OnBoard {
        &self.state.evolution
    }

    /// Whether it carries food.
    pub(crate) fn carries(&self) -> bool {
        self.carries
    }

    /// Its fitness in this interval so far.
    pub(crate) fn earned(&self) -> f32 {
        self.earned
    }

    /// Takes the fitness of its controllers in its simulator, if these are still those of its interval.
    pub(crate) fn take_simulated(&mut self, interval: u32, fitness: &[f32]) {
        let evolution = &mut self.state.evolution;
        if evolution.is_to_simulate()
            && evolution.interval() == interval
            && evolution.controllers().len() == fitness.len()
        {
            evolution.take_simulated(fitness);
        }
    }

    /// Takes another robot's message of this second. Returns whether it is new.
    pub(crate) fn hear(&mut self, second: u32, message: Message) -> bool {
        self.heard.hear(second, message)
    }

    /// Can hear these robots in a second, a bit each.
    pub(crate) fn meet(&mut self, second: u32, robots: u128) {
        self.heard.meet(second, robots);
    }

    /// Whether the robot can have brought so many items by a cycle: since its last sighting, and since the experiment began.
    pub(crate) fn can_have_brought(&self, items: u32, cycle: u32) -> bool {
        let before = self.state.brought.unwrap_or_default();
        let since = self
            .sighted
            .map_or(cycle, |sighted| cycle.saturating_sub(sighted).max(1));
        items <= most_items(cycle).min(before.saturating_add(most_items(since)))
    }

    /// Runs a cycle of the experiment, which must be later than the one before. Until then `sighted` is the tracker's
    /// last sighting of the robot. A sighting of more items than it can have brought is ignored.
    pub(crate) fn cycle(&mut self, cycle: u32, sighted: Option<Sighted>) -> Deeds {
        let mut deeds = Deeds::default();
        if let Some(sighted) = sighted.filter(|sighted| self.can_have_brought(sighted.brought, cycle)) {
            self.see(sighted, cycle);
        }
        let (second, last) = (cycle / SECOND, self.plan.settings.seconds());
        let begins = self.second != Some(second);
        if begins {
            if self.second.replace(second).is_none() {
                self.since = cycle;
            }
            while self.has_ended(second.min(last)) {
                let ended = self.end_interval();
                deeds.ended.push(ended);
                self.begin(cycle);
            }
        }
        deeds.is_over = second >= last;
        let evolution = &self.state.evolution;
        if deeds.is_over || evolution.clock.interval_at(second).is_none() {
            return deeds;
        }
        if evolution.clock.seconds_of(evolution.interval()).start == second && begins {
            self.begin(cycle);
        }
        let evolution = &self.state.evolution;
        deeds.controller = Some(evolution.acts(second));
        if begins {
            let rules = &self.plan.settings.simulators;
            let whole = |interval: usize| evolution.real.get(interval).copied();
            let message = evolution.message(self.robot, second, (rules.says, rules.credit), self.earned, whole);
            deeds.say = message.map(|message| (second, message));
        }
        deeds
    }

    /// Begins an interval.
    fn begin(&mut self, cycle: u32) {
        self.began = cycle;
        self.earned = 0.0;
        self.brought = 0;
    }

    /// Takes a sighting at the beginning of a cycle.
    fn see(&mut self, sighted: Sighted, cycle: u32) {
        self.carries = sighted.carries;
        self.sighted = Some(cycle);
        let before = self.state.brought.replace(sighted.brought).unwrap_or_default();
        let most = self.plan.settings.limits().fitness;
        // Equation 1 of O'Dowd, Studley and Winfield (2014), with the kernel's arithmetic. A restarted tracker counts
        // from 0.
        let seconds = (cycle - self.began.min(cycle)) as f32 * CYCLE_S;
        let worth = (self.plan.settings.clock.interval_s as f32 - seconds).max(0.0);
        let items = sighted.brought.saturating_sub(before);
        self.brought = self.brought.saturating_add(items);
        // No interval can earn more, so there are few iterations, whatever the tracker sends.
        for _ in 0..items {
            if worth == 0.0 || self.earned >= most {
                break;
            }
            self.earned = (self.earned + worth).min(most);
        }
    }

    /// Whether its interval is over when a second begins.
    fn has_ended(&self, second: u32) -> bool {
        let evolution = &self.state.evolution;
        second >= evolution.clock.seconds_of(evolution.interval()).end
    }

    /// Ends its interval. If it has not lived through all of it, or its controllers are not simulated yet, nothing evolves.
    fn end_interval(&mut self) -> Ended {
        let evolution = &mut self.state.evolution;
        let interval = evolution.interval();
        let seconds = evolution.clock.seconds_of(interval);
        let missed = evolution.is_to_simulate() || SECOND * seconds.start < self.since;
        let messages = self.heard.heard(self.robot, seconds.clone());
        self.heard.forget_before(seconds.end);
        let real = self.earned;
        let taken = if missed {
            evolution.miss_interval(real);
            false
        } else {
            evolution
                .end_interval(&self.plan.settings, real, &messages)
                .from
                .is_some()
        };
        let last = seconds.end - 1;
        let senders = messages.iter().fold(0, |all, message| all | 1_u128 << message.sender);
        Ended {
            interval,
            robot: self.robot as u32,
            simulator: evolution.simulators[interval as usize],
            chosen_under: evolution.chosen_under(interval),
            controller: evolution.acts(last),
            real,
            brought: self.brought,
            simulated: evolution
                .clock
                .chosen_in(last)
                .map(|chosen| evolution.simulated[chosen as usize])
                .filter(|fitness| fitness.is_finite()),
            heard: senders.count_ones(),
            taken,
            missed,
        }
    }
}

#[cfg(test)]
mod tests;
