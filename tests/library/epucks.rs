//! E-pucks by the reference models, and what their arenas have.

use std::f64::consts::TAU;

use oneiro::arena::{Arena, Light, Patch};
use oneiro::differential::{Build, Differential, WheelNoise};
use oneiro::reference::{Model, Reference};
use oneiro::world::Robot;

/// `count` e-pucks that live together.
pub(crate) fn epucks(model: Model, reference: Reference, count: u32) -> Robot {
    Robot {
        body_radius: 35.0,
        build: Build::Differential(Differential {
            wheel_noise: Some(0.05),
            wheel_noise_law: Some(WheelNoise::Normal),
            count: Some(count),
            model: Some(model),
            reference,
            ..Differential::new(53.0, 120.0)
        }),
        ..Robot::khepera()
    }
}

/// A model without any noise.
pub(crate) const QUIET: Reference = Reference {
    proximity_noise: Some(0.0),
    light_noise: Some(0.0),
    ground_noise: Some(0.0),
    grey_left: Some([0.41, 0.0]),
    grey_middle: Some([0.34, 0.0]),
    grey_right: Some([0.42, 0.0]),
    signal_loss: Some(0.0),
    ..Reference::DEFAULT
};

/// A dodecagon with sides at a distance `apothem` from its middle, and the radius of the disc in which robots start, mm.
pub(crate) fn dodecagon(apothem: f64, start_radius: f32) -> Arena {
    let corner = |side: u32| {
        let angle = TAU * (f64::from(side) + 0.5) / 12.0;
        [angle.cos(), angle.sin()].map(|part| (apothem / (TAU / 24.0).cos() * part) as f32)
    };
    let corners: Vec<_> = (0..12).map(corner).collect();
    Arena::polygon(&corners, Some(start_radius))
}

/// A round patch of the floor.
pub(crate) fn disc(x: f32, y: f32, radius: f32, grey: f32) -> Patch {
    Patch {
        x,
        y,
        radius: Some(radius),
        grey,
        ..Patch::default()
    }
}

/// A lamp.
pub(crate) fn lamp(x: f32, y: f32, height: f32, intensity: f32) -> Light {
    Light {
        x,
        y,
        height: Some(height),
        intensity: Some(intensity),
        ..Light::default()
    }
}
