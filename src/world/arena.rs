//! Arenas as data: walls, round obstacles and blocks. An arena is checked when a world is made from it.

use glam::Vec2;
use oneiro_shaders::episode;

use crate::exact::cosine;
use crate::parameter::field_of_pairs;
use crate::world::picture::Picture;

/// Walls, round obstacles and blocks, and the field that random starts are drawn from. Lengths in mm, x to the right
/// and y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arena {
    /// Name in reports.
    pub name: String,
    /// Field in which robots start.
    pub field: Field,
    /// Walls of no thickness, at any angle.
    pub walls: Vec<Wall>,
    /// Round obstacles.
    pub obstacles: Vec<Obstacle>,
    /// Rectangular obstacles.
    pub blocks: Vec<Block>,
    /// Lights, for the light sensors of parametric robots.
    pub lights: Vec<Light>,
    /// Grey of the floor, from 0 for black to 1 for white, for the ground sensors of parametric robots. `None`: white.
    pub floor: Option<f32>,
    /// A picture on the floor, beneath all patches.
    pub picture: Option<Picture>,
    /// Patches of the floor; of several at one place the last counts.
    pub patches: Vec<Patch>,
    /// Number of the last walls that are the sides of a convex polygon, counter-clockwise: see [`Arena::polygon`].
    pub sides: usize,
    /// Whether robots start in the disc within the field, a square, rather than anywhere in it.
    pub is_field_round: bool,
    /// Height of all walls, blocks and obstacles, mm, for the lamps of a robot with a reference model. `None`: they hide every lamp.
    pub wall_height: Option<f32>,
}

/// Most patches of an arena's floor, which have numbers from 0.
pub const GREATEST_PATCHES: usize = 4096;
/// Most walls, obstacles and blocks of an arena.
pub const GREATEST_OBJECTS: usize = 4096;
/// Most of them where a robot looks at all: sampled robots, those with sampled sensors or a reference model, and surrogates.
pub const GREATEST_SEEN: usize = episode::GREATEST_SHAPES as usize;

/// Corners of a polygon, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corners(pub Vec<[f32; 2]>);

field_of_pairs!(Corners);

/// A rectangle, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Field {
    /// Left edge.
    pub x: f32,
    /// Lower edge.
    pub y: f32,
    /// Width.
    pub width: f32,
    /// Height.
    pub height: f32,
}

impl Field {
    /// The rectangle with this lower left and upper right corner.
    fn between(low: Vec2, high: Vec2) -> Self {
        let size = high - low;
        Self {
            x: low.x,
            y: low.y,
            width: size.x,
            height: size.y,
        }
    }

    /// Whether a point lies in it, edges included.
    pub fn contains(&self, x: f32, y: f32) -> bool {
        (self.x..=self.x + self.width).contains(&x) && (self.y..=self.y + self.height).contains(&y)
    }
}

/// A wall from one point to another, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// One end.
    pub from: [f32; 2],
    /// Other end.
    pub to: [f32; 2],
    /// Class of object, which selects the sensor table.
    pub class: String,
}

/// A round obstacle, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Centre.
    pub x: f32,
    /// Centre.
    pub y: f32,
    /// Radius.
    pub radius: f32,
    /// Class of object, which selects the sensor table.
    pub class: String,
}

/// A rectangular obstacle at any angle, mm. Readings differ between its sides, so its class's sensor table may
/// have several points of view.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Centre.
    pub x: f32,
    /// Centre.
    pub y: f32,
    /// Length of one pair of sides, usually the longer one.
    pub length: f32,
    /// Length of the other sides.
    pub width: f32,
    /// Direction of its length in turns, counter-clockwise from the x axis, -1 to 1.
    pub heading: f32,
    /// Class of object, which selects the sensor table.
    pub class: String,
}

/// A light at the height of the sensors. Objects between hide it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Position.
    pub x: f32,
    /// Position.
    pub y: f32,
    /// Brightness: what a sensor that faces it reads from nearby.
    pub brightness: f32,
    /// Height above the floor, mm, for robots with a reference model. `None`: 0.
    pub height: Option<f32>,
    /// Divisor of its distance, for robots with a reference model. `None`: 1.
    pub intensity: Option<f32>,
}

/// A patch of the floor, mm: a disc, or a rectangle at any angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Centre.
    pub x: f32,
    /// Centre.
    pub y: f32,
    /// Radius of a disc.
    pub radius: Option<f32>,
    /// Sides of a rectangle.
    pub sides: Option<[f32; 2]>,
    /// Direction of its first side in turns, counter-clockwise from the x axis, -1 to 1.
    pub heading: f32,
    /// Grey, from 0 for black to 1 for white.
    pub grey: f32,
    /// Whether it charges the battery of a parametric robot whose centre is on it. `None`: it doesn't.
    pub charges: Option<bool>,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            x: f32::NAN,
            y: f32::NAN,
            brightness: 1.0,
            height: None,
            intensity: None,
        }
    }
}

impl Default for Patch {
    fn default() -> Self {
        Self {
            x: f32::NAN,
            y: f32::NAN,
            radius: None,
            sides: None,
            heading: 0.0,
            grey: 0.0,
            charges: None,
        }
    }
}

/// All zeros, with the class `wall`.
impl Default for Wall {
    fn default() -> Self {
        Self {
            from: [f32::NAN; 2],
            to: [f32::NAN; 2],
            class: "wall".into(),
        }
    }
}

/// All zeros, with the class `round`.
impl Default for Obstacle {
    fn default() -> Self {
        Self {
            x: f32::NAN,
            y: f32::NAN,
            radius: f32::NAN,
            class: "round".into(),
        }
    }
}

/// All zeros, with the class `block`.
impl Default for Block {
    fn default() -> Self {
        Self {
            x: f32::NAN,
            y: f32::NAN,
            length: f32::NAN,
            width: f32::NAN,
            heading: 0.0,
            class: "block".into(),
        }
    }
}

impl Wall {
    /// How far a point is to the left of the wall, seen along it, mm.
    pub fn room(&self, at: Vec2) -> f32 {
        let from = Vec2::from(self.from);
        let along = Vec2::from(self.to) - from;
        along.perp_dot(at - from) / along.length()
    }
}

/// A heading as a unit vector, exactly along an axis if it is nearly so.
pub(crate) fn axis(heading: f32) -> Vec2 {
    const NEARLY: f64 = 1e-6;
    let degrees = 360.0 * f64::from(heading);
    let [x, y] = [cosine(degrees), cosine(degrees - 90.0)].map(|part| if part.abs() < NEARLY { 0.0 } else { part });
    Vec2::new(x as f32, y as f32)
}

impl Patch {
    /// A rectangle's shape; of a disc only the place is meant.
    pub(crate) fn shape(&self) -> episode::Shape {
        let axis = axis(self.heading);
        let [length, width] = self.sides.unwrap_or_default();
        episode::Shape {
            x: self.x,
            y: self.y,
            unit_x: axis.x,
            unit_y: axis.y,
            half_length: 0.5 * length,
            half_width: 0.5 * width,
            kind: episode::BLOCK,
            ..episode::Shape::default()
        }
    }
}

impl Block {
    /// Direction of its length as a unit vector, exactly along an axis if it is nearly so.
    pub fn axis(&self) -> Vec2 {
        axis(self.heading)
    }

    /// Corners, in order around the block.
    pub fn corners(&self) -> [Vec2; 4] {
        corners(Vec2::new(self.x, self.y), self.axis(), [self.length, self.width])
    }
}

impl Patch {
    /// Corners of a rectangle, in order around it.
    pub fn corners(&self) -> Option<[Vec2; 4]> {
        let sides = self.sides?;
        Some(corners(Vec2::new(self.x, self.y), axis(self.heading), sides))
    }
}

/// Corners of a rectangle, in order around it, given the direction of its first side.
fn corners(centre: Vec2, axis: Vec2, [length, width]: [f32; 2]) -> [Vec2; 4] {
    let (along, across) = (0.5 * length * axis, 0.5 * width * axis.perp());
    [
        centre - along - across,
        centre + along - across,
        centre + along + across,
        centre - along + across,
    ]
}

impl Arena {
    /// The names that [`Arena::named`] knows.
    pub const NAMES: [&str; 5] = [
        "miglino1995",
        "miglino1995-triangle",
        "miglino1995-block",
        "open",
        "octagon",
    ];

    /// Looks up an arena of the catalogue.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "miglino1995" => Some(Self::miglino1995()),
            "miglino1995-triangle" => Some(Self::miglino1995_triangle()),
            "miglino1995-block" => Some(Self::miglino1995_block()),
            "open" => Some(Self {
                name: name.into(),
                ..Self::rectangle(1000.0, 1000.0)
            }),
            "octagon" => Some(Self::octagon()),
            _ => None,
        }
    }

    /// Four walls of the class `wall`, with the lower left corner at the origin.
    pub fn rectangle(width: f32, height: f32) -> Self {
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        Self {
            name: "rectangle".into(),
            ..Self::enclosed(width, height, &corners)
        }
    }

    /// A convex polygon, given its corners counter-clockwise. Robots start in the largest disc around the middle of the rectangle
    /// around it, of `start_radius` if set.
    pub fn polygon(corners: &[[f32; 2]], start_radius: Option<f32>) -> Self {
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in corners {
            low = low.min((*corner).into());
            high = high.max((*corner).into());
        }
        let enclosed = Self::enclosed(0.0, 0.0, corners);
        let middle = 0.5 * (low + high);
        let rooms = enclosed.walls.iter().map(|side| side.room(middle));
        let radius = start_radius.unwrap_or_else(|| rooms.fold(f32::INFINITY, f32::min));
        Self {
            name: "polygon".into(),
            sides: corners.len(),
            ..enclosed
        }
        .starting_within(middle.into(), radius)
    }

    /// Robots start in a disc.
    #[must_use]
    pub fn starting_within(mut self, middle: [f32; 2], radius: f32) -> Self {
        let middle = Vec2::from(middle);
        self.field = Field::between(middle - radius, middle + radius);
        self.is_field_round = true;
        self
    }

    /// Number of walls, obstacles and blocks.
    pub fn objects(&self) -> usize {
        self.walls.len() + self.obstacles.len() + self.blocks.len()
    }

    /// The walls that are the sides of a convex polygon.
    pub fn polygon_sides(&self) -> &[Wall] {
        &self.walls[self.walls.len().saturating_sub(self.sides)..]
    }

    /// Corners of the floor in order around it, mm: those of the polygon, or else of the field.
    pub fn ground(&self) -> Vec<[f32; 2]> {
        let sides = self.polygon_sides();
        if !sides.is_empty() {
            return sides.iter().map(|side| side.from).collect();
        }
        let Field { x, y, width, height } = self.field;
        let (right, top) = (x + width, y + height);
        vec![[x, y], [right, y], [right, top], [x, top]]
    }

    /// Whether the sides of the polygon hide a lamp from a body of this radius somewhere: a lamp outside, by how far it is beyond a
    /// side, and how much higher.
    #[cfg(feature = "compose")]
    pub(crate) fn sides_hide_lamps(&self, body_radius: f32) -> bool {
        let hides = |light: &Light, side: &Wall| {
            let beyond = -side.room(Vec2::new(light.x, light.y));
            let above = self.wall_height.map_or(0.0, |wall| light.height.unwrap_or(0.0) - wall);
            beyond > 0.0 && above * (body_radius - 1.0) <= self.wall_height.unwrap_or(0.0) * beyond
        };
        let sides = self.polygon_sides();
        self.lights
            .iter()
            .any(|light| sides.iter().any(|side| hides(light, side)))
    }

    /// 600 x 350 mm with three obstacles of 55 mm diameter in a row (Miglino et al. 1995; the paper says "in the
    /// center", the exact positions are ours).
    pub fn miglino1995() -> Self {
        Self::rectangle(600.0, 350.0)
            .with_obstacles([(180.0, 175.0), (300.0, 175.0), (420.0, 175.0)], 27.5)
            .called("miglino1995")
    }

    /// Like [`Arena::miglino1995`], with the obstacles in a triangle.
    pub fn miglino1995_triangle() -> Self {
        Self::rectangle(600.0, 350.0)
            .with_obstacles([(300.0, 250.0), (235.0, 137.5), (365.0, 137.5)], 27.5)
            .called("miglino1995-triangle")
    }

    /// Like [`Arena::miglino1995`], with the middle obstacle replaced by a block of 110 x 55 mm that is rotated by a
    /// twelfth of a turn, for the asymmetric objects of the paper's section 3.2. It needs a sensor table of the class
    /// `block`, which isn't compiled in: `oneiro robot sample --objects wall,round,block` makes one.
    pub fn miglino1995_block() -> Self {
        let mut arena = Self::rectangle(600.0, 350.0)
            .with_obstacles([(140.0, 175.0), (460.0, 175.0)], 27.5)
            .called("miglino1995-block");
        arena.blocks.push(Block {
            x: 300.0,
            y: 175.0,
            length: 110.0,
            width: 55.0,
            heading: 1.0 / 12.0,
            class: "block".into(),
        });
        arena
    }

    /// A regular octagon, 800 mm across, with one obstacle in its middle.
    pub fn octagon() -> Self {
        const NEAR: f32 = 234.3;
        const FAR: f32 = 565.7;
        const SIDE: f32 = 800.0;
        let corners = [
            [NEAR, 0.0],
            [FAR, 0.0],
            [SIDE, NEAR],
            [SIDE, FAR],
            [FAR, SIDE],
            [NEAR, SIDE],
            [0.0, FAR],
            [0.0, NEAR],
        ];
        // Random starts stay within a square inside the octagon.
        let field = Field {
            x: NEAR / 2.0,
            y: NEAR / 2.0,
            width: SIDE - NEAR,
            height: SIDE - NEAR,
        };
        Self {
            field,
            ..Self::enclosed(SIDE, SIDE, &corners)
        }
        .with_obstacles([(SIDE / 2.0, SIDE / 2.0)], 27.5)
        .called("octagon")
    }

    /// The rectangle in which robots may start: around the field and all walls, and without walls around all objects.
    pub fn start_bounds(&self) -> Field {
        if self.walls.is_empty() {
            self.walled()
        } else {
            self.within_walls()
        }
    }

    /// The smallest rectangle around the field and all objects.
    pub fn walled(&self) -> Field {
        let [low, high] = self.around();
        Field::between(low, high)
    }

    /// The smallest rectangle around the field and all walls.
    pub fn within_walls(&self) -> Field {
        let [low, high] = self.around_walls();
        Field::between(low, high)
    }

    /// The smallest rectangle around the field, all objects and all lights, for pictures.
    pub fn bounds(&self) -> Field {
        let [mut low, mut high] = self.around();
        for light in &self.lights {
            low = low.min(Vec2::new(light.x, light.y));
            high = high.max(Vec2::new(light.x, light.y));
        }
        Field::between(low, high)
    }

    /// Lower left and upper right corner of the rectangle around the field and all walls.
    fn around_walls(&self) -> [Vec2; 2] {
        let Field { x, y, width, height } = self.field;
        let mut low = Vec2::new(x, y);
        let mut high = low + Vec2::new(width, height);
        for point in self.walls.iter().flat_map(|wall| [wall.from, wall.to]).map(Vec2::from) {
            low = low.min(point);
            high = high.max(point);
        }
        [low, high]
    }

    /// The same of the rectangle around the field and all objects.
    fn around(&self) -> [Vec2; 2] {
        let [mut low, mut high] = self.around_walls();
        for obstacle in &self.obstacles {
            let centre = Vec2::new(obstacle.x, obstacle.y);
            low = low.min(centre - obstacle.radius);
            high = high.max(centre + obstacle.radius);
        }
        for corner in self.blocks.iter().flat_map(Block::corners) {
            low = low.min(corner);
            high = high.max(corner);
        }
        [low, high]
    }

    /// A closed chain of walls.
    fn enclosed(width: f32, height: f32, corners: &[[f32; 2]]) -> Self {
        let next = corners.iter().cycle().skip(1);
        Self {
            field: Field {
                x: 0.0,
                y: 0.0,
                width,
                height,
            },
            walls: corners
                .iter()
                .zip(next)
                .map(|(&from, &to)| Wall {
                    from,
                    to,
                    class: "wall".into(),
                })
                .collect(),
            ..Self::default()
        }
    }

    /// Adds obstacles of the class `round`; centres and radius in mm.
    #[must_use]
    pub fn with_obstacles(mut self, centres: impl IntoIterator<Item = (f32, f32)>, radius: f32) -> Self {
        self.obstacles.extend(centres.into_iter().map(|(x, y)| Obstacle {
            x,
            y,
            radius,
            class: "round".into(),
        }));
        self
    }

    /// Renames the arena.
    #[must_use]
    pub fn called(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }
}
