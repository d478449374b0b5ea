//! Thymio II, and other robots on an Aseba network.
//!
//! The robot runs its program and shares its variables; driving sets the motors' targets. It has no
//! time-out: it keeps them. So where it can, it gets a program that stops it (`fuse.rs`).

mod fuse;

use std::ops::Range;

use super::aseba::{self, Network, Node};
use super::epuck;
use super::error::{Error, Result};
use super::link::Link;
use super::talk::Stepped;
use super::{Battery, Description, Group, Kind, Odometry, Reading, Robot, Wheels};
use fuse::Fuse;

/// A kind of robot on a network: names of its variables.
pub(super) struct Body {
    /// Name for people.
    name: &'static str,
    /// How the names of its nodes begin.
    node: &'static str,
    /// Targets of the left and the right wheel.
    targets: [&'static str; 2],
    /// Sensors and the variables that hold them.
    pub(super) sensors: &'static [(Group, &'static [&'static str])],
    wheels: Wheels,
}

/// From a Thymio II's firmware and its simulation in Enki: 500 units are 166 mm/s (a driver for ROS has 171); the firmware
/// obeys up to 1000, its own behaviours go up to 600. The distance between the wheels is that driver's: Enki has 94 mm.
/// Sensors have the names of the preset `thymio2`.
pub(super) const THYMIO: Body = Body {
    name: "Thymio II",
    node: "thymio",
    targets: ["motor.left.target", "motor.right.target"],
    sensors: &[
        (
            Group {
                kind: Kind::Proximity,
                names: &["prox_0", "prox_1", "prox_2", "prox_3", "prox_4", "prox_5", "prox_6"],
                unit: "",
                range: (0.0, 4500.0),
            },
            &["prox.horizontal"],
        ),
        (
            Group {
                kind: Kind::Ground,
                names: &["ground_left", "ground_right"],
                unit: "",
                range: (0.0, 1023.0),
            },
            &["prox.ground.delta"],
        ),
        (
            Group {
                kind: Kind::Acceleration,
                names: &["acceleration_x", "acceleration_y", "acceleration_z"],
                unit: "",
                range: (-32.0, 32.0),
            },
            &["acc"],
        ),
        (
            Group {
                kind: Kind::Button,
                names: &[
                    "button_backward",
                    "button_left",
                    "button_center",
                    "button_forward",
                    "button_right",
                ],
                unit: "",
                range: (0.0, 1.0),
            },
            &[
                "button.backward",
                "button.left",
                "button.center",
                "button.forward",
                "button.right",
            ],
        ),
        (
            Group {
                kind: Kind::WheelSpeed,
                names: &["wheel_speed_left", "wheel_speed_right"],
                unit: THYMIO_UNIT,
                range: (-1000.0, 1000.0),
            },
            &["motor.left.speed", "motor.right.speed"],
        ),
    ],
    wheels: Wheels {
        unit: THYMIO_UNIT,
        greatest: 600,
        mm_s: 0.332,
        base_mm: 95.0,
        mm_per_count: None,
    },
};
const THYMIO_UNIT: &str = "1/500 of 166 mm/s";

/// The e-puck of Aseba's playground: 1000 units are 128 mm/s. Its wheels are closer to each other than a real one's (Enki, EPuck.cpp). It has no
/// odometers.
const PLAYGROUND_EPUCK: Body = Body {
    name: "e-puck (Aseba)",
    node: "e-puck",
    targets: ["speed.left", "speed.right"],
    sensors: &[(epuck::PROXIMITY, &["prox"])],
    wheels: Wheels {
        mm_s: 0.128,
        base_mm: 51.0,
        mm_per_count: None,
        ..epuck::WHEELS
    },
};

const BODIES: [Body; 2] = [THYMIO, PLAYGROUND_EPUCK];

/// A robot on an Aseba network.
pub(crate) struct Thymio {
    network: Network,
    node: Node,
    body: &'static Body,
    description: Description,
    /// Whether it is to stop by itself, and whether it does; none if that has not been tried since it was connected.
    is_to_stop: bool,
    fuse: Option<Armed>,
}

/// Whether the robot stops by itself.
#[derive(Clone, Copy, Debug)]
enum Armed {
    /// It runs a fuse.
    With(Fuse),
    /// It can't.
    Without,
}

impl Thymio {
    /// Finds the robot on a network, ends its program and stops it. `node` is its number, if there are several.
    ///
    /// # Errors
    /// There is no known robot, there are several, or the link fails.
    pub(crate) fn connect(link: Box<dyn Link>, node: Option<u16>) -> Result<Self> {
        let mut network = Network::new(link);
        let (node, body) = find(&mut network, node)?;
        let mut robot = Self {
            description: describe(&node, body),
            network,
            node,
            body,
            is_to_stop: false,
            fuse: None,
        };
        robot.begin()?;
        Ok(robot)
    }

    /// Ends the program, which may set the targets as well, and stops.
    fn begin(&mut self) -> Result {
        self.fuse = None;
        self.network.halt(self.node.id)?;
        self.stop()
    }

    /// Gives the robot its fuse, if it can have one and has none.
    fn armed(&mut self) -> Result<Armed> {
        if !self.is_to_stop {
            return Ok(Armed::Without);
        }
        if let Some(armed) = self.fuse {
            return Ok(armed);
        }
        let events = self.network.events(&self.node)?;
        let targets = self
            .targets([0; 2])
            .iter()
            .map(|(address, _)| *address)
            .collect::<Vec<_>>();
        let armed = match Fuse::of(&self.node.free, [targets[0], targets[1]], &events) {
            Some((fuse, program)) => {
                self.network.load(self.node.id, &program)?;
                Armed::With(fuse)
            }
            None => Armed::Without,
        };
        self.fuse = Some(armed);
        Ok(armed)
    }

    /// Tells the fuse, if there is one, that nothing is wanted any more, without waiting for an answer.
    fn put_out(&mut self) -> Result {
        match self.fuse {
            Some(Armed::With(fuse)) => self.network.put(self.node.id, &fuse.out()),
            _ => Ok(()),
        }
    }

    /// Keeps the wheels at these speeds, until the fuse has burnt down.
    fn keep(&mut self, fuse: Fuse, speeds: [i16; 2]) -> Result {
        if self.network.set_running(self.node.id, &fuse.lit(speeds), 2)? {
            return Ok(());
        }
        // Somebody has stopped its program, or it has restarted.
        self.begin()?;
        Err(Error::Restarted)
    }

    /// What sets the targets of the motors: addresses and speeds.
    fn targets(&self, speeds: [i16; 2]) -> Vec<(u16, i16)> {
        let addresses = self.body.targets.iter().filter_map(|name| self.node.variable(name));
        addresses.map(|address| address.start).zip(speeds).collect()
    }
}

/// The robot with this number, or the only one. Programs of nodes that may be it are ended before anything else is asked:
/// they may drive.
fn find(network: &mut Network, wanted: Option<u16>) -> Result<(Node, &'static Body)> {
    let (possible, others): (Vec<_>, Vec<_>) = network
        .list()?
        .into_iter()
        .partition(|(id, _)| wanted.is_none_or(|wanted| wanted == *id));
    for (id, _) in &possible {
        network.tell_to_halt(*id)?;
    }
    let end = network.now() + aseba::DESCRIBING;
    let mut robots = Vec::new();
    let mut others: Vec<String> = others.iter().map(|(id, _)| format!("node {id}")).collect();
    for (id, version) in possible {
        let node = network.describe(id, version, end)?;
        match BODIES.iter().find(|body| body.fits(&node)) {
            Some(body) => robots.push((node, body)),
            None => others.push(format!("node {id}, \"{}\"", node.name)),
        }
    }
    if robots.len() == 1 {
        return Ok(robots.remove(0));
    }
    let advice = "; check that the robot is on, or name another network";
    let problem = match (robots.is_empty(), wanted) {
        (false, _) => {
            let names = robots.iter().map(|(node, _)| format!("#{} ({})", node.id, node.name));
            let names: Vec<String> = names.collect();
            format!(
                "has several robots; add one of these to the address: {}",
                names.join(", ")
            )
        }
        (true, Some(id)) => format!(
            "no robot has the number {id}, but there are {}{advice}",
            others.join(", ")
        ),
        (true, None) => format!("has no known robot, but {}{advice}", others.join(", ")),
    };
    Err(Error::Unknown {
        link: network.name().into(),
        problem,
    })
}

impl Body {
    fn fits(&self, node: &Node) -> bool {
        node.name.to_lowercase().starts_with(self.node) && self.targets.iter().all(|name| node.variable(name).is_some())
    }

    /// Sensors that a node has, with their addresses.
    fn sensors<'a>(&'a self, node: &'a Node) -> impl Iterator<Item = (Group, Vec<u16>)> + 'a {
        self.sensors.iter().filter_map(|(group, names)| {
            let variables: Vec<Range<u16>> = names.iter().map(|name| node.variable(name)).collect::<Option<_>>()?;
            let addresses: Vec<u16> = variables.into_iter().flatten().collect();
            (addresses.len() == group.names.len()).then_some((*group, addresses))
        })
    }
}

fn describe(node: &Node, body: &Body) -> Description {
    Description {
        robot: body.name.into(),
        firmware: format!("{}, node {}, protocol {}", node.name, node.id, node.version),
        sensors: body.sensors(node).map(|(group, _)| group).collect(),
        wheels: body.wheels,
        // Lights are native functions, which only a program can call.
        lights: &[],
    }
}

impl Robot for Thymio {
    fn description(&self) -> &Description {
        &self.description
    }

    fn halt(&self) -> Vec<u8> {
        let out = match self.fuse {
            Some(Armed::With(fuse)) => fuse.out().into(),
            _ => Vec::new(),
        };
        aseba::set(self.node.id, &[&out[..], &self.targets([0; 2])].concat())
    }

    fn sense(&mut self, kinds: &[Kind]) -> Result<Reading> {
        let start = self.network.now();
        let groups = self.description.groups(kinds)?;
        let known: Vec<_> = self.body.sensors(&self.node).collect();
        let addresses: Vec<u16> = groups
            .iter()
            .filter_map(|group| known.iter().find(|(known, _)| known == group))
            .flat_map(|(_, addresses)| addresses)
            .copied()
            .collect();
        let values = self.network.get(self.node.id, &addresses)?;
        let at = self.network.now();
        Ok(Reading {
            at,
            age: at.saturating_sub(start),
            values: values.into_iter().map(f64::from).collect(),
        })
    }

    fn drive(&mut self, left: i32, right: i32) -> Result {
        let greatest = self.body.wheels.greatest;
        let speeds = [left, right].map(|speed| speed.clamp(-greatest, greatest) as i16);
        match self.armed()? {
            Armed::With(fuse) => self.keep(fuse, speeds),
            Armed::Without => self.network.set(self.node.id, &self.targets(speeds)),
        }
    }

    fn stop(&mut self) -> Result {
        self.put_out()?;
        if !*self.network.in_step() {
            // Getting back in step may fail: the robot must have heard of the stop before.
            self.network.put(self.node.id, &self.targets([0; 2]))?;
        }
        self.network
            .set(self.node.id, &self.targets([0; 2]))
            .map_err(|error| match error {
                Error::Refused { answer, .. } => Error::StillTurning {
                    seen: format!("the targets of its motors are {answer}"),
                },
                error => error,
            })
    }

    fn arm(&mut self) -> Result {
        self.is_to_stop = true;
        self.armed().map(drop)
    }

    fn light(&mut self, light: usize, _: bool) -> Result {
        self.description.light(light)
    }

    /// Two measurements of the battery; their sum is in units of 1/397.8 V. Below 3.4 V the robot's light blinks.
    fn battery(&mut self) -> Result<Battery> {
        let both = self.node.variable("_vbat").filter(|addresses| addresses.len() == 2);
        let addresses = both.ok_or_else(|| self.description.lacks("reading of its battery", "none"))?;
        let both = self.network.get(self.node.id, &addresses.collect::<Vec<_>>())?;
        let sum: f64 = both.into_iter().map(f64::from).sum();
        let volts = sum / 397.8;
        Ok(Battery {
            volts: Some(volts),
            low: volts < 3.4,
        })
    }

    /// Both sensors of the ground see nothing. Each limit is that of the firmware's own behaviours (aseba-target-thymio2,
    /// mode.c), which stop at it. A black floor looks the same.
    fn lifted(&mut self) -> Result<bool> {
        const LEAST: f64 = 130.0;
        let ground = self.sense(&[Kind::Ground])?.values;
        Ok(ground.iter().all(|delta| *delta < LEAST))
    }

    fn odometry(&mut self) -> Result<Odometry> {
        Err(self
            .description
            .lacks("odometers", "sensors of wheel_speed, if it has them"))
    }

    /// Ends the fuse too, which would keep other programs from setting the motors' targets.
    fn close(mut self: Box<Self>) -> Result {
        self.begin()
    }

    fn reconnect(&mut self) -> Result {
        let before = self.description.robot.clone();
        self.network.reopen()?;
        // Stops the wheels first: finding the robot takes a third of a second.
        self.put_out()?;
        self.network.put(self.node.id, &self.targets([0; 2]))?;
        // Addresses may have changed with the firmware.
        let (node, body) = find(&mut self.network, Some(self.node.id))?;
        self.description = describe(&node, body);
        (self.node, self.body) = (node, body);
        self.begin()?;
        self.description.is_still(&before, self.network.name())
    }
}

#[cfg(test)]
pub(super) mod tests;
