//! A twin of the swarm's arena, written from its documentation (`src/foragers/swarm.rs`, `src/foragers/foraging.rs`) and not from its
//! kernel: in double precision, with other random numbers, and with bodies that rapier moves. Where the documentation
//! leaves a law's form open, [`Forms`] or a comment states the choice. Messages are left out, since food doesn't depend
//! on them.
//!
//! Bodies are discs of 150 g on a plane without gravity. Wheels don't resist pushes: each substep of 20 ms sets a
//! body's velocity to that of its wheels along its heading, and contacts then reduce it. The wall is a fixed ring of
//! 256 segments, whose midpoints are 0.05 mm inside the circle. Friction is 0.2 wherever bodies touch.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use oneiro::foraging::{Foraging, Light};
use oneiro::swarm::{Arena, Behaviour, Lamp, Line, Order, Seen, Swarm, Trouble};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rapier2d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, Vector as RapierVector};
use rayon::prelude::*;

/// Duration of a cycle in seconds.
const CYCLE: f64 = 0.1;
const SUBSTEPS: u32 = 5;
/// Rapier is tuned for bodies of about unit size: decimetres here.
const UNIT: f64 = 100.0;
const FRICTION: f32 = 0.2;
/// Grams.
const MASS: f32 = 150.0;
const SEGMENTS: u32 = 256;

const BEARINGS: [f64; 8] = [17.0, 50.0, 310.0, 343.0, 90.0, 150.0, 210.0, 270.0];
const FRONT: usize = 4;
/// Greatest tangent of the angle off its axis at which a sensor sees.
const BEAM: f64 = 0.25;
const SIGHT: f64 = 70.0;
/// Webots' table: mm, reading of 4095, relative deviation of noise.
const PROXIMITY: [(f64, f64, f64); 10] = [
    (0.0, 4095.0, 0.002),
    (5.0, 2133.0, 0.003),
    (10.0, 1466.0, 0.007),
    (15.0, 601.0, 0.041),
    (20.0, 384.0, 0.015),
    (30.0, 235.0, 0.024),
    (40.0, 158.0, 0.029),
    (50.0, 120.0, 0.042),
    (60.0, 104.0, 0.031),
    (70.0, 67.0, 0.049),
];

/// Forms of three laws that the documentation leaves open: the distance of another body from a sensor, the shadows of
/// bodies, and the light to which a sensor's gain applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Forms {
    /// As the twin was first written. A sensor has a cone that begins at the body's edge; each robot in between hides
    /// its own share of a robot's width, as seen from the lamp; a gain applies to all light.
    First,
    /// As in the arena. A sensor reads the gap between two bodies if the other reaches into a beam as wide as the body;
    /// shade falls linearly with the distance from the line to the lamp, the same all along it, and the darkest counts;
    /// a gain doesn't apply to ambient light.
    Arena,
}

pub(crate) struct Twins {
    now: u32,
    worlds: Vec<Twin>,
}

impl Twins {
    /// Worlds under one lamp, each with different robots.
    pub(crate) fn new(swarm: Swarm, lamp: Lamp, forms: Forms, worlds: u64) -> Self {
        Self {
            now: 0,
            worlds: (0..worlds).map(|seed| Twin::new(swarm, lamp, forms, seed)).collect(),
        }
    }
}

impl Arena for Twins {
    fn live(&mut self, until: u32, orders: &[Vec<Order>], every: u32) -> Result<Vec<Vec<Line>>, Trouble> {
        let now = std::mem::replace(&mut self.now, until);
        let worlds = self.worlds.par_iter_mut().zip(orders);
        Ok(worlds
            .map(|(world, orders)| world.live(now..until, orders, every))
            .collect())
    }
}

/// Properties, state and orders of one robot.
struct Robot {
    at: DVec2,
    heading: f64,
    body: RigidBodyHandle,
    wheels: [f64; 2],
    proximity: [f64; FRONT],
    light: [f64; 8],
    carries: bool,
    brought: u32,
    earned: f64,
    since: u32,
    behaviour: Behaviour,
    /// 1 to the left, -1 to the right, 0 if nothing is near.
    side: f64,
    escape: u32,
    /// Rest of a turn in rad, and time to the next one in s.
    turn: f64,
    straight: f64,
    /// Forward mm/s and turning rad/s, as decided now and a cycle ago.
    wanted: [f64; 2],
}

struct Twin {
    swarm: Swarm,
    lamp: Lamp,
    forms: Forms,
    random: Pcg64,
    physics: PhysicsWorld,
    robots: Vec<Robot>,
    food: Vec<DVec2>,
}

fn of(number: f32) -> f64 {
    f64::from(number)
}

/// A normal random number by Box and Muller's method.
fn normal(random: &mut Pcg64) -> f64 {
    let [a, b]: [f64; 2] = [random.random(), random.random()];
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

fn uniform(random: &mut Pcg64, size: f64) -> f64 {
    size * (2.0 * random.random::<f64>() - 1.0)
}

fn in_circle(random: &mut Pcg64, radius: f64) -> DVec2 {
    DVec2::from_angle(TAU * random.random::<f64>()) * radius * random.random::<f64>().sqrt()
}

fn nest(forager: &Foraging) -> DVec2 {
    DVec2::new(-of(forager.arena_radius), 0.0)
}

fn food_place(random: &mut Pcg64, forager: &Foraging) -> DVec2 {
    loop {
        let place = in_circle(random, of(forager.arena_radius));
        if place.distance(nest(forager)) >= of(forager.nest_radius) {
            return place;
        }
    }
}

/// Reading, of 1, and the relative standard deviation of its noise.
fn proximity(distance: f64) -> (f64, f64) {
    if distance >= SIGHT {
        return (0.0, 0.0);
    }
    let after = PROXIMITY.partition_point(|point| point.0 <= distance);
    let [near, far] = [PROXIMITY[after - 1], PROXIMITY[after]];
    let share = (distance - near.0) / (far.0 - near.0);
    let between = |a: f64, b: f64| a + share * (b - a);
    (between(near.1, far.1) / 4095.0, between(near.2, far.2))
}

/// Distance of the nearest point of a disc in a cone around an axis.
fn along_cone(to: DVec2, axis: DVec2, radius: f64) -> f64 {
    let ahead = to.dot(axis);
    let aside = axis.perp_dot(to);
    if ahead > 0.0 && aside.abs() <= BEAM * ahead {
        return (to.length() - radius).max(0.0);
    }
    let edge = (axis + BEAM.copysign(aside) * axis.perp()).normalize();
    let ahead = to.dot(edge);
    let off = edge.perp_dot(to);
    let half = radius * radius - off * off;
    if half <= 0.0 || ahead <= 0.0 {
        return f64::INFINITY;
    }
    (ahead - half.sqrt()).max(0.0)
}

/// Gap between two bodies, if the other reaches into a beam that is as wide as the body where it begins.
fn gap_in_beam(to: DVec2, axis: DVec2, radius: f64) -> f64 {
    let ahead = to.dot(axis);
    if ahead > 0.0 && axis.perp_dot(to).abs() < radius + BEAM * ahead {
        (to.length() - 2.0 * radius).max(0.0)
    } else {
        f64::INFINITY
    }
}

impl Twin {
    fn new(swarm: Swarm, lamp: Lamp, forms: Forms, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let forager = swarm.forager;
        let room = of(forager.arena_radius) - of(forager.body_radius);
        let mut places: Vec<DVec2> = Vec::new();
        while places.len() < swarm.robots as usize {
            let place = in_circle(&mut random, room);
            if places
                .iter()
                .all(|other| other.distance(place) >= 2.0 * of(forager.body_radius))
            {
                places.push(place);
            }
        }
        let mut physics = PhysicsWorld {
            gravity: RapierVector::ZERO,
            ..PhysicsWorld::default()
        };
        physics.integration_parameters.dt = (CYCLE / f64::from(SUBSTEPS)) as f32;
        physics.integration_parameters.contact_recycling = false;
        let corner = |index: u32| {
            let angle = TAU * f64::from(index) / f64::from(SEGMENTS);
            let place = DVec2::from_angle(angle) * of(forager.arena_radius) / UNIT;
            RapierVector::new(place.x as f32, place.y as f32)
        };
        let corners = (0..SEGMENTS).map(corner).collect();
        let edges = (0..SEGMENTS).map(|index| [index, (index + 1) % SEGMENTS]).collect();
        physics.insert(
            RigidBodyBuilder::fixed(),
            ColliderBuilder::polyline(corners, Some(edges)).friction(FRICTION),
        );
        let own = swarm.differences;
        let robots = places
            .into_iter()
            .map(|at| {
                let heading = TAU * random.random::<f64>();
                let place = at / UNIT;
                let disc = ColliderBuilder::ball((of(forager.body_radius) / UNIT) as f32)
                    .mass(MASS)
                    .friction(FRICTION);
                let (body, _) = physics.insert(
                    RigidBodyBuilder::dynamic()
                        .translation(RapierVector::new(place.x as f32, place.y as f32))
                        .rotation(heading as f32)
                        .can_sleep(false),
                    disc,
                );
                let mut gain = |deviation: f32| 1.0 + of(deviation) * normal(&mut random);
                Robot {
                    at,
                    heading,
                    body,
                    wheels: [(); 2].map(|()| gain(own.wheels)),
                    proximity: [(); FRONT].map(|()| gain(own.proximity)),
                    light: [(); 8].map(|()| gain(own.light)),
                    carries: false,
                    brought: 0,
                    earned: 0.0,
                    since: 0,
                    behaviour: Behaviour::Off,
                    side: 0.0,
                    escape: 0,
                    turn: 0.0,
                    straight: -of(forager.search_interval) * (1.0 - random.random::<f64>()).ln(),
                    wanted: [0.0; 2],
                }
            })
            .collect();
        let food = (0..forager.food_items)
            .map(|_| food_place(&mut random, &forager))
            .collect();
        Self {
            swarm,
            lamp,
            forms,
            random,
            physics,
            robots,
            food,
        }
    }

    fn live(&mut self, cycles: std::ops::Range<u32>, orders: &[Order], every: u32) -> Vec<Line> {
        let mut lines = Vec::new();
        for cycle in cycles {
            self.cycle(cycle, orders);
            if (cycle + 1).is_multiple_of(every) {
                lines.push(self.line());
            }
        }
        lines
    }

    fn line(&mut self) -> Line {
        let robots = self.robots.iter_mut().map(|robot| Seen {
            x: robot.at.x as f32,
            y: robot.at.y as f32,
            heading: (robot.heading / TAU).rem_euclid(1.0) as f32,
            behaviour: robot.behaviour,
            carries: robot.carries,
            brought: std::mem::take(&mut robot.brought),
            earned: robot.earned as f32,
            heard: 0,
        });
        Line {
            robots: robots.collect(),
            food: self.food.iter().map(|place| place.as_vec2().to_array()).collect(),
        }
    }

    fn cycle(&mut self, cycle: u32, orders: &[Order]) {
        let forager = self.swarm.forager;
        let light = if cycle < self.lamp.moves {
            self.lamp.first
        } else {
            self.lamp.then
        };
        let places: Vec<DVec2> = self.robots.iter().map(|robot| robot.at).collect();
        let mut drives = Vec::new();
        let mut on = Vec::new();
        for (index, order) in orders.iter().enumerate() {
            if order.begins == Some(cycle) {
                self.robots[index].since = cycle;
                self.robots[index].earned = 0.0;
            }
            let genes = if cycle < order.at {
                order.before
            } else {
                Some(order.after)
            };
            on.push(genes.is_some());
            let drive = if let Some(genes) = genes {
                self.decide(index, &places, light, genes)
            } else {
                self.robots[index].behaviour = Behaviour::Off;
                self.robots[index].wanted = [0.0; 2];
                [0.0; 2]
            };
            drives.push(drive);
        }
        // Limit of the wheels, their noise, and slip, for both distance and turn.
        let own = self.swarm.differences;
        let half = 0.5 * of(forager.wheel_base);
        let greatest = of(forager.greatest_speed);
        for ([forward, turn], robot) in drives.iter_mut().zip(&self.robots) {
            let wheel = [*forward - half * *turn, *forward + half * *turn];
            let mut made = [0.0; 2];
            for side in 0..2 {
                let noise = 1.0 + uniform(&mut self.random, of(forager.wheel_noise));
                made[side] = wheel[side].clamp(-greatest, greatest) * noise * robot.wheels[side];
            }
            let kept = 1.0 - of(own.slip) * self.random.random::<f64>();
            *forward = kept * 0.5 * (made[0] + made[1]);
            *turn = kept * 0.5 * (made[1] - made[0]) / half;
        }
        for _ in 0..SUBSTEPS {
            for (robot, &[forward, turn]) in self.robots.iter().zip(&drives) {
                let body = &mut self.physics.bodies[robot.body];
                let ahead = DVec2::from_angle(f64::from(body.rotation().angle())) * forward / UNIT;
                body.set_linvel(RapierVector::new(ahead.x as f32, ahead.y as f32), true);
                body.set_angvel(turn as f32, true);
            }
            self.physics.step();
        }
        for robot in &mut self.robots {
            let body = &self.physics.bodies[robot.body];
            let at = body.translation();
            robot.at = DVec2::new(f64::from(at.x), f64::from(at.y)) * UNIT;
            robot.heading = f64::from(body.rotation().angle());
        }
        self.forage(cycle, &on);
    }

    fn forage(&mut self, cycle: u32, on: &[bool]) {
        let forager = self.swarm.forager;
        let lost = of(self.swarm.differences.tracking_loss);
        let mut asked: Vec<Option<(usize, f64)>> = vec![None; self.food.len()];
        for (index, robot) in self.robots.iter_mut().enumerate() {
            if !on[index] || self.random.random::<f64>() < lost {
                continue;
            }
            if robot.carries {
                if robot.at.distance(nest(&forager)) < of(forager.nest_radius) {
                    robot.carries = false;
                    robot.brought += 1;
                    let gone = f64::from(cycle + 1 - robot.since) * CYCLE;
                    robot.earned += (f64::from(self.swarm.interval) * CYCLE - gone).max(0.0);
                }
                continue;
            }
            let reached = self
                .food
                .iter()
                .position(|item| item.distance(robot.at) < of(forager.food_radius));
            if let Some(item) = reached {
                let distance = self.food[item].distance(robot.at);
                if asked[item].is_none_or(|(_, nearest)| distance < nearest) {
                    asked[item] = Some((index, distance));
                }
            }
        }
        for (item, asked) in asked.into_iter().enumerate() {
            if let Some((robot, _)) = asked {
                self.robots[robot].carries = true;
                self.food[item] = food_place(&mut self.random, &forager);
            }
        }
    }

    /// Commands for a robot's wheels in this cycle: mm/s and rad/s.
    fn decide(&mut self, index: usize, places: &[DVec2], light: Light, genes: [f32; 2]) -> [f64; 2] {
        let forager = self.swarm.forager;
        let readings = self.proximity(index, places);
        let near = proximity(of(forager.near)).0;
        let (cruise, turning) = (of(forager.cruise), of(forager.turn));
        let gene = if self.robots[index].carries { genes[0] } else { genes[1] };
        let wanted = if readings.iter().any(|&reading| reading > near) {
            // The first two are on the left; comparing the sums is our choice of form.
            let [left, right] = [readings[0] + readings[1], readings[2] + readings[3]];
            let chance = if self.random.random::<bool>() { 1.0 } else { -1.0 };
            let robot = &mut self.robots[index];
            if robot.side == 0.0 {
                robot.side = if left == right { chance } else { (right - left).signum() };
            }
            robot.escape = (of(forager.escape) / CYCLE).round() as u32;
            robot.behaviour = Behaviour::Avoid;
            [0.0, robot.side * turning]
        } else if self.robots[index].escape > 0 {
            let robot = &mut self.robots[index];
            robot.side = 0.0;
            robot.escape -= 1;
            robot.behaviour = Behaviour::Avoid;
            [cruise, 0.0]
        } else if (0.33..0.66).contains(&gene) {
            self.search(index)
        } else {
            let toward = if gene >= 0.66 { 1.0 } else { -1.0 };
            let robot = &mut self.robots[index];
            robot.side = 0.0;
            robot.behaviour = if gene >= 0.66 {
                Behaviour::SeekLight
            } else {
                Behaviour::FleeLight
            };
            let bright = self.light(index, places, light);
            let off = (toward * bright).to_angle();
            let fastest = of(forager.phototaxis_turn);
            [
                cruise * off.cos().max(0.0),
                (of(forager.phototaxis_gain) * off).clamp(-fastest, fastest),
            ]
        };
        let before = std::mem::replace(&mut self.robots[index].wanted, wanted);
        if self.swarm.differences.latency { before } else { wanted }
    }

    fn search(&mut self, index: usize) -> [f64; 2] {
        let forager = self.swarm.forager;
        let robot = &mut self.robots[index];
        robot.side = 0.0;
        robot.behaviour = Behaviour::Search;
        if robot.turn == 0.0 && robot.straight < CYCLE {
            robot.turn = uniform(&mut self.random, 0.5 * PI);
            robot.straight = -of(forager.search_interval) * (1.0 - self.random.random::<f64>()).ln();
        }
        if robot.turn == 0.0 {
            robot.straight -= CYCLE;
            return [of(forager.cruise), 0.0];
        }
        let most = of(forager.turn) * CYCLE;
        let now = robot.turn.clamp(-most, most);
        robot.turn -= now;
        [0.0, now / CYCLE]
    }

    /// Readings of the front sensors for the wall and other robots; a sensor sits on the body's edge and looks
    /// outwards.
    fn proximity(&mut self, index: usize, places: &[DVec2]) -> [f64; FRONT] {
        let forager = self.swarm.forager;
        let radius = of(forager.body_radius);
        let robot = &self.robots[index];
        let mut readings = [0.0; FRONT];
        for (sensor, reading) in readings.iter_mut().enumerate() {
            let axis = DVec2::from_angle(robot.heading + BEARINGS[sensor].to_radians());
            let from = robot.at + of(forager.body_radius) * axis;
            // The wall is nearly flat, so its distance along the axis is enough.
            let inward = from.dot(axis);
            let reach = inward * inward + of(forager.arena_radius).powi(2) - from.length_squared();
            let mut distance = (reach.max(0.0).sqrt() - inward).max(0.0);
            for (other, &place) in places.iter().enumerate() {
                if other == index || place.distance(robot.at) > SIGHT + 2.0 * radius {
                    continue;
                }
                distance = distance.min(match self.forms {
                    Forms::First => along_cone(place - from, axis, radius),
                    Forms::Arena => gap_in_beam(place - robot.at, axis, radius),
                });
            }
            let (mean, noise) = proximity(distance);
            *reading = (robot.proximity[sensor] * mean * (1.0 + noise * normal(&mut self.random))).clamp(0.0, 1.0);
        }
        readings
    }

    /// Sum of the light sensors' axes, weighted by their readings, in the robot's frame: x is ahead.
    fn light(&mut self, index: usize, places: &[DVec2], light: Light) -> DVec2 {
        let forager = self.swarm.forager;
        let own = self.swarm.differences;
        let radius = of(forager.body_radius);
        let lamp_radius = of(forager.arena_radius) + of(forager.lamp_behind_wall);
        let side = match light {
            Light::OverNest => -1.0,
            Light::Nowhere => 0.0,
            Light::OppositeNest => 1.0,
        };
        let lamp = DVec2::new(side * lamp_radius, 0.0);
        let at = self.robots[index].at;
        let to = lamp - at;
        let (strength, back) = if side == 0.0 {
            (0.0, 0.0)
        } else {
            let beam = 1.0 - of(own.beam) * (to.y / to.length()).powi(2);
            // Our choice of form: linear from the wall next to the lamp to the other end.
            let near = 0.5 * (1.0 + side * at.x / of(forager.arena_radius));
            let shade = match self.forms {
                Forms::First => shadows(places, index, to, radius, of(own.shadows)),
                Forms::Arena => strips(places, index, to, radius, of(own.shadows)),
            };
            (beam * shade, of(own.reflection) * near.clamp(0.0, 1.0))
        };
        let mut sum = DVec2::ZERO;
        for (sensor, bearing) in BEARINGS.into_iter().enumerate() {
            let bearing = bearing.to_radians();
            let axis = DVec2::from_angle(self.robots[index].heading + bearing);
            let mut shine = back;
            if strength > 0.0 {
                let to = lamp - (at + radius * axis);
                let fade = (-of(forager.light_decay) * to.length() / 1000.0).exp();
                shine += strength * fade * (1.0 - 2.0 * axis.angle_to(to).abs() / PI).max(0.0);
            }
            let gain = self.robots[index].light[sensor];
            let ambient = of(forager.ambient);
            let got = match self.forms {
                Forms::First => gain * (shine + ambient),
                Forms::Arena => gain * shine + ambient,
            };
            let reading = (got + uniform(&mut self.random, of(forager.light_noise))).clamp(0.0, 1.0);
            sum += reading * DVec2::from_angle(bearing);
        }
        sum
    }
}

/// Share of the lamp's light that other robots leave: those in between hide a part of its width as seen from the lamp.
fn shadows(places: &[DVec2], index: usize, to: DVec2, radius: f64, share: f64) -> f64 {
    let from_lamp = -to;
    let half = |distance: f64| (radius / distance).clamp(0.0, 1.0).asin();
    let own = half(from_lamp.length());
    let mut left = 1.0;
    for (other, &place) in places.iter().enumerate() {
        let seen = from_lamp + (place - places[index]);
        if other == index || seen.length() >= from_lamp.length() {
            continue;
        }
        let off = from_lamp.angle_to(seen).abs();
        let hidden = (own + half(seen.length()) - off).min(2.0 * own) / (2.0 * own);
        left *= 1.0 - share * hidden.max(0.0);
    }
    left
}

/// The same with shadows as wide as two bodies, of which the darkest counts.
fn strips(places: &[DVec2], index: usize, to: DVec2, radius: f64, share: f64) -> f64 {
    let line = to.normalize();
    let mut darkest = 0.0_f64;
    for (other, &place) in places.iter().enumerate() {
        let ahead = (place - places[index]).dot(line);
        if other != index && ahead > 0.0 && ahead < to.length() {
            darkest = darkest.max(1.0 - line.perp_dot(place - places[index]).abs() / (2.0 * radius));
        }
    }
    1.0 - share * darkest
}
