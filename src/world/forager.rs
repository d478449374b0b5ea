//! A forager as a world's robot.

use oneiro_shaders::forager;

use crate::exact::cosine;
use crate::foragers::foraging::{Foraging, Light};
use crate::world::arena::{Arena, Field, Patch, Wall};

/// A forager with any controller and any task, as a world's robot: see [`Build::Forager`](crate::differential::Build::Forager).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forager {
    /// Its body, its behaviours and its arena. The world has the start and the cycles of its episodes.
    pub foraging: Foraging,
    /// Seconds from the start of an episode in which food earns: the remaining ones.
    pub food_earns: f32,
}

impl Forager {
    /// A forager of the 2014 study.
    pub const ODOWD2014: Self = Self {
        foraging: Foraging::odowd2014(Light::OverNest),
        food_earns: 60.0,
    };

    /// Its arena for pictures and measures: the nest, and tangents of the wall.
    pub(crate) fn arena(&self) -> Arena {
        const SIDES: u32 = 64;
        let radius = f64::from(self.foraging.arena_radius);
        let corner = |side: u32| {
            let degrees = 360.0 * (f64::from(side) + 0.5) / f64::from(SIDES);
            let away = radius / cosine(180.0 / f64::from(SIDES));
            [away * cosine(degrees), away * cosine(degrees - 90.0)].map(|mm| mm as f32)
        };
        let wall = |side: u32| Wall {
            from: corner(side),
            to: corner((side + 1) % SIDES),
            ..Wall::default()
        };
        let nest = Patch {
            x: -self.foraging.arena_radius,
            y: 0.0,
            radius: Some(self.foraging.nest_radius),
            grey: 0.75,
            ..Patch::default()
        };
        Arena {
            name: "round".into(),
            field: Field {
                x: -self.foraging.arena_radius,
                y: -self.foraging.arena_radius,
                width: 2.0 * self.foraging.arena_radius,
                height: 2.0 * self.foraging.arena_radius,
            },
            walls: (0..SIDES).map(wall).collect(),
            patches: vec![nest],
            ..Arena::default()
        }
    }

    /// Share of its field, 0 to 1, where its body doesn't touch the wall.
    pub(crate) fn free_share(&self) -> f32 {
        let free = 1.0 - self.foraging.body_radius / self.foraging.arena_radius;
        std::f32::consts::FRAC_PI_4 * free * free
    }

    /// The kernel's cells of its values.
    pub(crate) fn table(&self) -> Vec<[u32; 4]> {
        let cells = self.foraging.cells(forager::FORAGER_CELLS, 1, self.food_earns.into());
        cells.into_table()
    }
}
