//! Tests of colours: readers can tell robots apart, also colour-blind ones, and can read all text in both schemes.

use super::episode::{AGES, COLOURS};
use super::svg::ramp;
use super::swarm::BEHAVIOURS;

const STYLE: &str = include_str!("../components/page.css");
/// The minimum distance of two colours in CIELAB. That of neighbouring shades that people can just tell apart is about 2.
const APART: f64 = 28.0;
/// How a protanope and a deuteranope see linear red, green and blue (Machado, Oliveira and Fernandes 2009, severity 1).
const PROTANOPE: [[f64; 3]; 3] = [
    [0.152_286, 1.052_583, -0.204_868],
    [0.114_503, 0.786_281, 0.099_216],
    [-0.003_882, -0.048_116, 1.051_998],
];
const DEUTERANOPE: [[f64; 3]; 3] = [
    [0.367_322, 0.860_646, -0.227_968],
    [0.280_085, 0.672_501, 0.047_413],
    [-0.011_820, 0.042_940, 0.968_881],
];
const TRICHROMAT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Linear red, green and blue of a colour as `#rrggbb`.
fn linear(colour: &str) -> [f64; 3] {
    [1, 3, 5].map(|at| {
        let part = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
        if part <= 0.04045 {
            part / 12.92
        } else {
            ((part + 0.055) / 1.055).powf(2.4)
        }
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Linear red, green and blue in CIELAB, with the white of D65.
fn lab(colour: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = [
        dot([0.4124, 0.3576, 0.1805], colour) / 0.9505,
        dot([0.2126, 0.7152, 0.0722], colour),
        dot([0.0193, 0.1192, 0.9505], colour) / 1.089,
    ]
    .map(|t| {
        if t > 0.008_856 {
            t.cbrt()
        } else {
            7.787 * t + 16.0 / 116.0
        }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The two colours that are nearest to each other for somebody, and their distance.
fn nearest<'a>(colours: &[&'a str], sight: [[f64; 3]; 3]) -> (f64, &'a str, &'a str) {
    let seen = |colour: &str| lab(sight.map(|row| dot(row, linear(colour)).clamp(0.0, 1.0)));
    let mut nearest = (f64::INFINITY, "", "");
    for (place, one) in colours.iter().enumerate() {
        for other in &colours[..place] {
            let (a, b) = (seen(one), seen(other));
            let distance = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            if distance < nearest.0 {
                nearest = (distance, one, other);
            }
        }
    }
    nearest
}

#[test]
fn colour_blind_readers_tell_robots_apart() {
    let ages = [0.0, 0.5, 1.0].map(|share| ramp(&AGES, share));
    let palettes: [Vec<&str>; 3] = [
        COLOURS.to_vec(),
        BEHAVIOURS.iter().map(|act| act.colour).collect(),
        ages.iter().map(String::as_str).collect(),
    ];
    for palette in &palettes {
        for sight in [TRICHROMAT, PROTANOPE, DEUTERANOPE] {
            let (distance, one, other) = nearest(palette, sight);
            assert!(distance >= APART, "{one} and {other}: {distance}");
        }
    }
}

/// A diagram's weights and values by their sign.
#[test]
fn colour_blind_readers_tell_signs_apart() {
    let dark = STYLE.find("@media (prefers-color-scheme: dark)").unwrap();
    for scheme in [&STYLE[..dark], &STYLE[dark..]] {
        let signs = ["link", "lamp-edge"].map(|name| variable(scheme, name));
        for sight in [TRICHROMAT, PROTANOPE, DEUTERANOPE] {
            assert!(nearest(&signs, sight).0 >= APART, "{signs:?}");
        }
    }
}

/// The colour of a variable in a scheme.
fn variable<'a>(scheme: &'a str, name: &str) -> &'a str {
    let (_, after) = scheme
        .split_once(&format!("--{name}: "))
        .unwrap_or_else(|| panic!("no {name}"));
    after.split(';').next().unwrap()
}

/// The contrast of two colours (WCAG 2).
fn contrast(one: &str, other: &str) -> f64 {
    let [one, other] = [one, other].map(|colour| dot([0.2126, 0.7152, 0.0722], linear(colour)) + 0.05);
    (one / other).max(other / one)
}

#[test]
fn text_and_marks_have_contrast_in_both_schemes() {
    let dark = STYLE.find("@media (prefers-color-scheme: dark)").unwrap();
    for scheme in [&STYLE[..dark], &STYLE[dark..]] {
        for (names, least) in [
            (
                "ink page, soft page, ink ground, soft ground, ink chosen, on-link link, bad page, bad chosen, lamp-text page, \
                 lamp-text over, lamp-text opposite, nest-text page, food-text page, food-text floor",
                4.5,
            ),
            (
                "link page, lamp-edge page, focus page, edge page, message floor, sensor floor, link floor, food-edge floor, object-edge floor",
                3.0,
            ),
        ] {
            for pair in names.split(", ") {
                let (one, other) = pair.split_once(' ').unwrap();
                let contrast = contrast(variable(scheme, one), variable(scheme, other));
                assert!(contrast >= least, "{pair}: {contrast}");
            }
        }
    }
}
