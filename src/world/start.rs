//! Starts of episodes: poses and zones.

use glam::Vec2;

use crate::parameter::{Datum, Invalid};
use crate::world::arena::{Arena, Field, Patch};

/// Most poses of a list.
pub(crate) const GREATEST_POSES: usize = 1000;

/// Start of an episode.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// A free pose, drawn uniformly over the arena's field and all headings with the episode's own key.
    Random,
    /// A fixed pose: x and y in mm, heading in turns counter-clockwise from the x axis.
    At {
        /// x in mm.
        x: f32,
        /// y in mm.
        y: f32,
        /// Heading in turns, -1 to 1; a world has it from 0 to less than 1.
        heading: f32,
    },
    /// A list of poses: trial after trial takes the next one, or the next for each robot of a swarm.
    Poses(Poses),
    /// A free pose in a part of the arena, drawn like [`Start::Random`].
    Zone(Zone),
}

impl Start {
    /// Whether poses are drawn.
    pub fn is_drawn(&self) -> bool {
        matches!(self, Self::Random | Self::Zone(_))
    }
}

/// Starts of which trial after trial takes the next, or the next ones for all robots of a swarm: x and y in mm, heading in turns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Poses(pub Vec<[f32; 3]>);

impl crate::parameter::Field for Poses {
    fn get(&self) -> Option<Datum> {
        let poses = self.0.iter();
        let poses = poses.map(|pose| Datum::List(pose.iter().copied().map(Datum::Single).collect()));
        Some(Datum::List(poses.collect()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let pose = |datum: &Datum| -> Option<[f32; 3]> {
            let Datum::List(numbers) = datum else { return None };
            let mut pose = [0.0; 3];
            let is_pose = numbers.len() == pose.len();
            (is_pose
                && pose
                    .iter_mut()
                    .zip(numbers)
                    .all(|(own, number)| crate::parameter::Field::set(own, number))
                && (-1.0..=1.0).contains(&pose[2]))
            .then_some(pose)
        };
        let Datum::List(poses) = datum else { return false };
        let poses: Option<Vec<_>> = poses.iter().map(pose).collect();
        let is_set = poses.is_some();
        self.0 = poses.unwrap_or_default();
        is_set
    }

    fn kind(&self) -> &'static str {
        "a list of poses of three numbers each, x, y and heading in turns, -1 to 1"
    }
}

/// A part of the arena that robots start in, at a random heading: a rectangle, a disc, a ring, or a patch of the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Zone {
    /// Its middle, mm; not of a patch.
    pub x: Option<f32>,
    /// See `x`.
    pub y: Option<f32>,
    /// Sides of a rectangle along the axes, mm.
    pub sides: Option<[f32; 2]>,
    /// Radius of a disc, mm.
    pub radius: Option<f32>,
    /// Radius around the middle that it leaves out, mm.
    pub inner: Option<f32>,
    /// The number of a patch of the floor, from 0.
    pub patch: Option<u32>,
}

/// Where random starts are drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Area {
    /// Anywhere in a rectangle.
    Rectangle(Field),
    /// Anywhere in a ring; a disc has the inner radius 0.
    Ring {
        /// The middle, mm.
        middle: Vec2,
        /// Radii, mm.
        inner: f32,
        /// See `inner`.
        outer: f32,
    },
}

impl Area {
    /// That of random starts; the field for all others.
    ///
    /// # Errors
    /// A zone that is none, or beyond the arena.
    pub(crate) fn of(start: &Start, arena: &Arena) -> Result<Self, Invalid> {
        let Start::Zone(zone) = start else {
            return Ok(Self::of_field(arena));
        };
        let area = zone.area(arena)?;
        let Field { x, y, width, height } = area.bounds();
        let bounds = arena.start_bounds();
        if bounds.contains(x, y) && bounds.contains(x + width, y + height) {
            return Ok(area);
        }
        let problem = format!(
            "reaches from ({x}, {y}) to ({}, {}) mm; allowed: a zone within the arena, ({}, {}) to ({}, {}) mm",
            x + width,
            y + height,
            bounds.x,
            bounds.y,
            bounds.x + bounds.width,
            bounds.y + bounds.height,
        );
        Err(Invalid::new("start", problem))
    }

    pub(crate) fn of_field(arena: &Arena) -> Self {
        let Field { x, y, width, height } = arena.field;
        if arena.is_field_round {
            return Self::Ring {
                middle: Vec2::new(x + 0.5 * width, y + 0.5 * height),
                inner: 0.0,
                outer: 0.5 * width,
            };
        }
        Self::Rectangle(arena.field)
    }

    /// The smallest rectangle around it.
    pub(crate) fn bounds(&self) -> Field {
        match *self {
            Self::Rectangle(field) => field,
            Self::Ring { middle, outer, .. } => Field {
                x: middle.x - outer,
                y: middle.y - outer,
                width: 2.0 * outer,
                height: 2.0 * outer,
            },
        }
    }

    pub(crate) fn contains(&self, at: Vec2) -> bool {
        match *self {
            Self::Rectangle(field) => field.contains(at.x, at.y),
            Self::Ring { middle, inner, outer } => (inner..=outer).contains(&at.distance(middle)),
        }
    }

    /// As the kernels read it: a corner and the sides, or the middle, the inner radius squared, and the range of squares above it.
    pub(crate) fn numbers(&self) -> [f32; 4] {
        match *self {
            Self::Rectangle(Field { x, y, width, height }) => [x, y, width, height],
            Self::Ring { middle, inner, outer } => [middle.x, middle.y, inner * inner, outer * outer - inner * inner],
        }
    }
}

impl Zone {
    /// What it is, in words.
    pub fn words(&self) -> String {
        let middle = format!("around ({}, {}) mm", self.x.unwrap_or(0.0), self.y.unwrap_or(0.0));
        match (self.patch, self.sides, self.radius, self.inner) {
            (Some(patch), ..) => format!("patch {patch} of the floor"),
            (None, Some([width, height]), ..) => format!("a rectangle of {width} x {height} mm {middle}"),
            (None, None, radius, None) => format!("a disc of radius {} mm {middle}", radius.unwrap_or(0.0)),
            (None, None, radius, Some(inner)) => {
                format!("a ring of radii {inner} to {} mm {middle}", radius.unwrap_or(0.0))
            }
        }
    }

    /// The rectangle around it, if it lies in this arena.
    pub fn bounds(&self, arena: &Arena) -> Option<Field> {
        self.area(arena).ok().map(|area| area.bounds())
    }

    fn area(&self, arena: &Arena) -> Result<Area, Invalid> {
        let refused = |key: &str, problem: &str| Err(Invalid::new(format!("start.{key}"), problem));
        if let Some(index) = self.patch {
            if self.x.is_some() || self.y.is_some() || self.sides.is_some() || self.radius.is_some() {
                return refused("patch", "is given together with a place or a size; allowed: either");
            }
            let Some(patch) = arena.patches.get(index as usize) else {
                let problem = format!(
                    "is {index}, but there are {} patches; allowed: the number of one, from 0",
                    arena.patches.len()
                );
                return refused("patch", &problem);
            };
            return self.on(patch);
        }
        let (Some(x), Some(y)) = (self.x, self.y) else {
            return refused(
                "kind",
                "is `zone` without a place; allowed: x_mm and y_mm of its middle, or patch",
            );
        };
        let middle = Vec2::new(x, y);
        match (self.sides, self.radius) {
            (Some([width, height]), None) if self.inner.is_none() => Ok(Area::Rectangle(Field {
                x: x - 0.5 * width,
                y: y - 0.5 * height,
                width,
                height,
            })),
            (None, Some(outer)) => self.ring(middle, outer),
            (Some(_), _) => refused("sides_mm", "is given together with a radius; allowed: either"),
            (None, None) => refused("kind", "is `zone` without a size; allowed: sides_mm, or radius_mm"),
        }
    }

    fn ring(&self, middle: Vec2, outer: f32) -> Result<Area, Invalid> {
        let inner = self.inner.unwrap_or(0.0);
        // Their squares differ.
        if inner > outer - 1.0 {
            let problem = format!("is {inner}; allowed: 0 to {}, 1 mm less than the radius", outer - 1.0);
            return Err(Invalid::new("start.inner_radius_mm", problem));
        }
        Ok(Area::Ring { middle, inner, outer })
    }

    fn on(&self, patch: &Patch) -> Result<Area, Invalid> {
        if let Some(radius) = patch.radius {
            return self.ring(Vec2::new(patch.x, patch.y), radius);
        }
        let [mut width, mut height] = patch.sides.unwrap_or_default();
        let quarters = 4.0 * patch.heading;
        if quarters.fract() != 0.0 || self.inner.is_some() {
            let problem =
                "is a rectangle at an angle, or has an inner radius; allowed: a disc, or a rectangle along the axes";
            return Err(Invalid::new("start.patch", problem));
        }
        if quarters % 2.0 != 0.0 {
            (width, height) = (height, width);
        }
        Ok(Area::Rectangle(Field {
            x: patch.x - 0.5 * width,
            y: patch.y - 0.5 * height,
            width,
            height,
        }))
    }
}
