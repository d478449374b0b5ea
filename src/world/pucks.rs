//! Pucks: discs that the robots of a swarm push, and carry.

use crate::parameter::Invalid;
use crate::world::described::{Contact, Described, GREATEST_MEMBERS};
use crate::world::differential::{FARTHEST, Starts};
use crate::world::discs::Discs;
use crate::world::sensors::Feature;

/// The part of an overlap with a robot by which a puck gives way if it has no other: ours. A robot that pushes one gets on by about
/// this part of its way.
const YIELDS: f32 = 0.8;
/// The most that it may be: bodies that a wall holds get free in twelve pushes.
pub(super) const GREATEST_YIELDS: f64 = 0.9;

/// Pucks of a world, which are alike. All are `None` where there are none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pucks {
    /// Number of pucks, 1 to 127, and at most 1,024 with the robots.
    pub count: Option<u32>,
    /// Radius, mm.
    pub radius: Option<f32>,
    /// Part of an overlap with a robot by which a puck gives way, 0 to 0.9; the robot gives way by the rest. `None`: 0.8.
    pub yields: Option<f32>,
    /// Gap between a robot and a puck within which the robot can take it, mm. `None`: robots can only push.
    pub grip: Option<f32>,
    /// Where each is at the start. `None`: at random places in the arena.
    pub places: Option<Starts>,
}

impl Pucks {
    /// Gives pucks to a robot's swarm.
    pub(super) fn add_to(&self, robot: &mut Described, body_radius: f32) -> Result<(), Invalid> {
        let Some(discs) = self.check(Some(robot), body_radius)? else {
            let reads = |sensor: &super::sensors::Sensor| sensor.kind.entry().has(Feature::ReadsPucks);
            return match robot.sensors.iter().position(reads) {
                Some(index) => {
                    let problem = format!(
                        "is {}; allowed: only with pucks.count",
                        robot.sensors[index].kind.entry().name
                    );
                    Err(Invalid::new(format!("robot.sensors[{index}].kind"), problem))
                }
                None => Ok(()),
            };
        };
        if let Some(swarm) = &mut robot.together {
            swarm.pucks = Some(discs);
        }
        Ok(())
    }

    /// Checks them for a robot; others have none.
    pub(super) fn check(&self, robot: Option<&Described>, body_radius: f32) -> Result<Option<Discs>, Invalid> {
        let invalid = |key: &str, problem: String| Err(Invalid::new(format!("pucks.{key}"), problem));
        let Some(count) = self.count else {
            let given = [
                ("radius_mm", self.radius.is_some()),
                ("yields", self.yields.is_some()),
                ("grip_mm", self.grip.is_some()),
                ("places_mm", self.places.is_some()),
            ];
            return match given.into_iter().find(|(_, is_given)| *is_given) {
                Some((key, _)) => invalid(key, "is given; allowed: only with pucks.count".to_owned()),
                None => Ok(None),
            };
        };
        let Some((robot, swarm)) = robot.and_then(|robot| Some((robot, robot.together.as_ref()?))) else {
            return invalid(
                "count",
                "is given; allowed: only in swarms, with robot.count".to_owned(),
            );
        };
        if swarm.contact == Contact::Stop {
            return invalid(
                "count",
                "is given; allowed: only with robot.contact = \"push\"".to_owned(),
            );
        }
        if swarm.model.is_some() {
            return invalid("count", "is given; allowed: only without robot.model".to_owned());
        }
        if count + swarm.count > GREATEST_MEMBERS {
            let problem = match GREATEST_MEMBERS - swarm.count {
                0 => format!("is {count}; allowed with {} robots: no pucks", swarm.count),
                most => format!("is {count}; allowed with {} robots: 1 to {most}", swarm.count),
            };
            return invalid("count", problem);
        }
        let Some(radius) = self.radius else {
            return Err(Invalid::new(
                "pucks",
                "lacks `radius_mm`; allowed: the radius of a puck in mm",
            ));
        };
        // A puck in a wall comes out on the side that it was on.
        let farthest = robot.drive.farthest().unwrap_or(0.0);
        if farthest > FARTHEST * radius {
            let least = farthest / FARTHEST;
            let problem = format!(
                "is {radius}; allowed: at least {least}, since robots move up to {farthest} mm in a cycle, noise included"
            );
            return invalid("radius_mm", problem);
        }
        let places = self.places.as_ref().map(|Starts(places)| places.clone());
        if let Some(places) = &places {
            if places.len() != count as usize {
                let problem = format!("has {} places; allowed: one for each puck, {count}", places.len());
                return invalid("places_mm", problem);
            }
            let overlaps =
                |a: [f32; 2], b: [f32; 2], least: f32| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) < least * least;
            for (index, &place) in places.iter().enumerate() {
                if let Some(other) = places[..index]
                    .iter()
                    .position(|&other| overlaps(place, other, 2.0 * radius))
                {
                    let least = 2.0 * radius;
                    let problem = format!(
                        "has overlapping places {other} and {index}; allowed: at least {least} mm between any two"
                    );
                    return invalid("places_mm", problem);
                }
                let robots = robot.start_places().iter();
                if let Some(other) = robots
                    .clone()
                    .position(|&other| overlaps(place, other, radius + body_radius))
                {
                    let problem =
                        format!("has place {index} where robot {other} starts; allowed: places that are free");
                    return invalid("places_mm", problem);
                }
            }
        }
        Ok(Some(Discs {
            count,
            radius,
            yields: self.yields.unwrap_or(YIELDS),
            grip: self.grip.unwrap_or(0.0),
            places,
        }))
    }
}
