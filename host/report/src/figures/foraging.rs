//! The round arena of foraging e-pucks drawn to scale: positions of the light, and robots with the range of their
//! sensors.

use oneiro::foraging::{Foraging, Light};
use oneiro::random::pcg4d;
use oneiro::swarm::{SECOND, Swarm};
use oneiro_base::console::counted;

use super::arena::Sheet;
use super::frames::{self, Film, begin_robot, foot};
use super::svg::{self, Anchor, BOLD, INK, PLAIN, SOFT, Svg, number};
use super::swarm::ForagersReplay;

/// Room between arenas, around the light, and above for the title, in pixels.
const GAP: f64 = 24.0;
const AROUND: f64 = 56.0;
const HEAD: f64 = 56.0;
const FOOT: f64 = 40.0;
/// Diameter of an arena among three side by side, and of a single one.
const SMALL: f64 = 232.0;
const LARGE: f64 = 600.0;
/// Room between a single arena and the key to its right.
const KEY: f64 = 40.0;
/// Room next to the lamp and around the wall of a film, as parts of the arena's radius.
const BESIDE: f64 = 0.14;
const AROUND_WALL: f64 = 0.04;
const WIDTH: f64 = 1060.0;
const FLOOR: &str = "#f5f3ee";
const NEST: &str = "#9db8dd";
const FOOD: &str = "#8cbf7d";
const LAMP: &str = "#f2b51d";
const ROBOT: &str = "#33363f";
const PROXIMITY: &str = "#c8374f";
const MESSAGE: &str = "#23528f";
/// Range of proximity sensors from the body, mm.
const SIGHT: f64 = 70.0;

/// The three scenarios of Figure 2, which differ in the position of the light.
pub fn scenarios(title: &str, forager: &Foraging) -> String {
    let cell = SMALL + 2.0 * AROUND;
    let mut svg = Svg::new(3.0 * cell + 2.0 * GAP, HEAD + SMALL + FOOT, title);
    let food = food(forager);
    let scenarios = [
        (Light::OverNest, "A: light over the nest"),
        (Light::Nowhere, "B: no light"),
        (Light::OppositeNest, "C: light opposite the nest"),
    ];
    for (i, (light, words)) in scenarios.into_iter().enumerate() {
        let left = (cell + GAP) * i as f64;
        let sheet = sheet(forager, (left + AROUND, HEAD), SMALL);
        svg.words((left + 0.5 * cell, 24.0), 14.0, Anchor::Middle, BOLD, words);
        arena(&mut svg, &sheet, forager, &food);
        lamp(&mut svg, &sheet, forager, light);
        if i == 0 {
            let nest = sheet.place((
                0.5 * f64::from(forager.nest_radius) - f64::from(forager.arena_radius),
                0.0,
            ));
            svg.words((nest.0, nest.1 + 4.0), 11.0, Anchor::Middle, PLAIN, "nest");
        }
    }
    let y = HEAD + SMALL + 24.0;
    let radius = f64::from(forager.food_radius) * SMALL / (2.0 * f64::from(forager.arena_radius));
    svg.circle(
        (AROUND + radius, y - 4.0),
        0.7 * radius,
        &format!("fill=\"{FOOD}\""),
        "",
    );
    svg.words((AROUND + 2.5 * radius, y), 12.0, Anchor::Start, SOFT, "food");
    svg.circle((AROUND + 80.0, y - 4.0), 6.0, &format!("fill=\"{LAMP}\""), "");
    svg.words((AROUND + 92.0, y), 12.0, Anchor::Start, SOFT, "lamp");
    let scale = SMALL / (2.0 * f64::from(forager.arena_radius));
    ruler(&mut svg, (3.0 * cell + 2.0 * GAP - AROUND, y - 4.0), scale);
    svg.finish()
}

/// The robots of Figure 4, each with the range of its proximity sensors, and one with the range of messages.
pub fn foragers(title: &str, foragers: &Swarm) -> String {
    let forager = &foragers.forager;
    let mut svg = Svg::new(WIDTH, HEAD + LARGE + FOOT, title);
    let sheet = sheet(forager, (AROUND + 20.0, HEAD - 20.0), LARGE);
    let scale = LARGE / (2.0 * f64::from(forager.arena_radius));
    let food = food(forager);
    arena(&mut svg, &sheet, forager, &food);
    lamp(&mut svg, &sheet, forager, Light::OverNest);
    let (body, range) = (f64::from(forager.body_radius), f64::from(foragers.range));
    let robots = robots(foragers);
    for &(at, _) in &robots {
        let style = format!("fill=\"{PROXIMITY}\" fill-opacity=\"0.07\" stroke=\"{PROXIMITY}\" stroke-opacity=\"0.5\"");
        svg.circle(sheet.place(at), (body + SIGHT) * scale, &style, "");
    }
    // The robot that hears most others is the one to show.
    let heard = |of: usize| -> Vec<usize> {
        let all = 0..robots.len();
        all.filter(|&other| other != of && distance(robots[of].0, robots[other].0) <= range)
            .collect()
    };
    let hears = (0..robots.len()).max_by_key(|&robot| (heard(robot).len(), std::cmp::Reverse(robot)));
    if let Some(hears) = hears {
        let at = sheet.place(robots[hears].0);
        let style = format!(
            "fill=\"{MESSAGE}\" fill-opacity=\"0.06\" stroke=\"{MESSAGE}\" stroke-dasharray=\"6 4\" stroke-width=\"1.5\""
        );
        svg.circle(at, range * scale, &style, "");
        for other in heard(hears) {
            let style = format!("stroke=\"{MESSAGE}\" stroke-width=\"1.6\"");
            svg.line(at, sheet.place(robots[other].0), &style);
        }
    }
    for &(at, heading) in &robots {
        sheet.robot(&mut svg, at, heading, body, ROBOT, 0.25);
    }
    key(&mut svg, foragers);
    let right = AROUND + 20.0 + LARGE;
    ruler(&mut svg, (right, HEAD + LARGE + 14.0), scale);
    svg.finish()
}

/// Draws the key to the marks around robots, with their sizes.
fn key(svg: &mut Svg, foragers: &Swarm) {
    let forager = &foragers.forager;
    let left = AROUND + 20.0 + LARGE + KEY;
    let mm = |length: f32| number(f64::from(length));
    let lines = [
        (
            ROBOT,
            format!("{} e-pucks, radius {} mm", foragers.robots, mm(forager.body_radius)),
            "with a line to their front",
        ),
        (
            PROXIMITY,
            format!("proximity, {} mm", number(SIGHT)),
            "from the body: walls and robots are seen",
        ),
        (
            MESSAGE,
            format!("messages, {} mm", mm(foragers.range)),
            "between centres, of one robot; lines: heard",
        ),
        (
            FOOD,
            format!(
                "{} of food, radius {} mm",
                counted(forager.food_items, "item", "items"),
                mm(forager.food_radius)
            ),
            "taken when a robot's centre is inside",
        ),
        (
            NEST,
            format!("nest, radius {} mm", mm(forager.nest_radius)),
            "around a point of the wall",
        ),
        (
            LAMP,
            format!("lamp, {} mm behind the wall", mm(forager.lamp_behind_wall)),
            "here over the nest",
        ),
    ];
    for (i, (colour, words, more)) in lines.into_iter().enumerate() {
        let y = HEAD + 40.0 + 62.0 * i as f64;
        svg.circle(
            (left + 10.0, y - 5.0),
            9.0,
            &format!("fill=\"{colour}\" fill-opacity=\"0.85\""),
            "",
        );
        svg.words((left + 30.0, y), 14.0, Anchor::Start, BOLD, &words);
        svg.words((left + 30.0, y + 18.0), 12.0, Anchor::Start, SOFT, more);
    }
}

/// Draws moments of foragers.
pub struct ForagersFrames<'a> {
    replay: &'a ForagersReplay<'a>,
    sheet: Sheet,
    /// Width and height in pixels.
    size: (f64, f64),
    /// Food that was brought up to each line.
    brought: Vec<u32>,
}

impl<'a> ForagersFrames<'a> {
    /// The longer side of the arena with its lamp gets `side` pixels; there is at least one line.
    pub fn new(replay: &'a ForagersReplay<'a>, side: f64) -> Self {
        let forager = &replay.foragers.forager;
        let radius = f64::from(forager.arena_radius);
        let (right, top) = (
            radius + f64::from(forager.lamp_behind_wall) + BESIDE * radius,
            (1.0 + AROUND_WALL) * radius,
        );
        let sheet = Sheet::of((-right, top), (2.0 * right, 2.0 * top), (0.0, 0.0), side);
        let (width, height) = sheet.extent();
        let brought = replay.lines.iter().scan(0, |all, line| {
            *all += line.robots.iter().map(|robot| robot.brought).sum::<u32>();
            Some(*all)
        });
        Self {
            size: (width.round(), (height + frames::FOOT).round()),
            sheet,
            brought: brought.collect(),
            replay,
        }
    }

    fn draw(&self, number: usize) -> String {
        let ForagersReplay {
            foragers,
            lamp: lit,
            lines,
            acts,
            title,
            ..
        } = self.replay;
        let (forager, line) = (&foragers.forager, &lines[number]);
        let (width, height) = self.size;
        let mut svg = Svg::new(width, height, title);
        let food: Vec<(f64, f64)> = line.food.iter().map(|at| (at[0].into(), at[1].into())).collect();
        arena(&mut svg, &self.sheet, forager, &food);
        let light = if line.cycle >= lit.moves { lit.then } else { lit.first };
        lamp(&mut svg, &self.sheet, forager, light);
        for robot in &line.robots {
            let Some([x, y, heading]) = robot.pose.map(|pose| pose.map(f64::from)) else {
                continue;
            };
            let act = acts.get(robot.act);
            let colours = (
                act.map_or(ROBOT, |act| act.colour),
                act.and_then(|act| act.front).unwrap_or("#ffffff"),
            );
            let radius = f64::from(forager.body_radius) * self.sheet.scale;
            begin_robot(&mut svg, self.sheet.place((x, y)), heading, radius, colours);
            if robot.carries {
                svg.circle(
                    (0.0, 0.0),
                    0.5 * radius,
                    &format!("fill=\"{FOOD}\" stroke=\"#ffffff\""),
                    "",
                );
            }
            svg.raw("</g>");
        }
        let seconds = |cycles: u32| f64::from(cycles) / f64::from(SECOND);
        let words = format!(
            "{} s of {} s, food {}",
            svg::number(seconds(line.cycle)),
            svg::number(self.seconds()),
            self.brought[number]
        );
        foot(&mut svg, self.size, (number + 1) as f64 / lines.len() as f64, &words);
        svg.finish()
    }
}

impl Film for ForagersFrames<'_> {
    fn seconds(&self) -> f64 {
        self.step() * self.replay.lines.len() as f64
    }

    fn step(&self) -> f64 {
        f64::from(self.replay.lines[0].cycle) / f64::from(SECOND)
    }

    fn at(&self, seconds: f64) -> String {
        let number = (seconds / self.step()).round() as usize;
        self.draw(number.clamp(1, self.replay.lines.len()) - 1)
    }
}

fn sheet(forager: &Foraging, corner: (f64, f64), side: f64) -> Sheet {
    let radius = f64::from(forager.arena_radius);
    Sheet::of((-radius, radius), (2.0 * radius, 2.0 * radius), corner, side)
}

/// Draws floor, nest, food and wall.
fn arena(svg: &mut Svg, sheet: &Sheet, forager: &Foraging, food: &[(f64, f64)]) {
    let (arena, nest) = (f64::from(forager.arena_radius), f64::from(forager.nest_radius));
    let (centre, (right, _)) = (sheet.place((0.0, 0.0)), sheet.place((arena, 0.0)));
    let scale = (right - centre.0) / arena;
    svg.circle(centre, arena * scale, &format!("fill=\"{FLOOR}\""), "");
    // The nest's circle meets the wall here.
    let x = 0.5 * nest * nest / arena - arena;
    let y = (arena * arena - x * x).max(0.0).sqrt();
    let [(left, upper), (_, lower)] = [sheet.place((x, y)), sheet.place((x, -y))];
    let [nest, wall] = [nest, arena].map(|radius| number(radius * scale));
    let [left, upper, lower] = [left, upper, lower].map(number);
    svg.raw(&format!(
        "<path d=\"M{left} {upper}A{nest} {nest} 0 0 1 {left} {lower}A{wall} {wall} 0 0 1 {left} {upper}z\" fill=\"{NEST}\"/>"
    ));
    for &at in food {
        svg.circle(
            sheet.place(at),
            f64::from(forager.food_radius) * scale,
            &format!("fill=\"{FOOD}\""),
            "",
        );
    }
    svg.circle(
        centre,
        arena * scale,
        &format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"3\""),
        "",
    );
}

/// Draws a lamp with its rays.
fn lamp(svg: &mut Svg, sheet: &Sheet, forager: &Foraging, light: Light) {
    let away = f64::from(forager.arena_radius + forager.lamp_behind_wall);
    let (x, y) = match light {
        Light::Nowhere => return,
        Light::OverNest => sheet.place((-away, 0.0)),
        Light::OppositeNest => sheet.place((away, 0.0)),
    };
    for ray in 0..8 {
        let (sine, cosine) = (f64::from(ray) * std::f64::consts::FRAC_PI_4).sin_cos();
        let at = |radius: f64| (x + radius * cosine, y + radius * sine);
        svg.line(
            at(10.0),
            at(16.0),
            &format!("stroke=\"{LAMP}\" stroke-width=\"2.4\" stroke-linecap=\"round\""),
        );
    }
    svg.circle((x, y), 7.0, &format!("fill=\"{LAMP}\""), "lamp");
}

/// Draws a scale bar, given its right end.
fn ruler(svg: &mut Svg, (right, y): (f64, f64), scale: f64) {
    const LENGTH: f64 = 200.0;
    let left = right - LENGTH * scale;
    let style = format!("stroke=\"{INK}\" stroke-width=\"2\"");
    svg.line((left, y), (right, y), &style);
    for x in [left, right] {
        svg.line((x, y - 4.0), (x, y + 4.0), &style);
    }
    let words = format!("{} mm", number(LENGTH));
    svg.words((left - 8.0, y + 4.0), 12.0, Anchor::End, SOFT, &words);
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Fixed pseudorandom positions and headings (turns) in a circle.
fn places(radius: f64, what: u32) -> impl Iterator<Item = ((f64, f64), f64)> {
    // Enough for everything that fits into an arena to find a place.
    const TRIES: u32 = 20_000;
    (0..TRIES).filter_map(move |i| {
        let [x, y, heading, _] = pcg4d([i, what, 20, 14]).map(|word| f64::from(word) / f64::from(u32::MAX));
        let at = ((2.0 * x - 1.0) * radius, (2.0 * y - 1.0) * radius);
        (at.0.hypot(at.1) <= radius).then_some((at, heading))
    })
}

/// Food in the arena, outside the nest, and spaced out for the sake of the picture.
fn food(forager: &Foraging) -> Vec<(f64, f64)> {
    let (arena, radius) = (f64::from(forager.arena_radius), f64::from(forager.food_radius));
    let nest = f64::from(forager.nest_radius);
    let mut food: Vec<(f64, f64)> = Vec::new();
    for (at, _) in places(arena - radius, 1) {
        if food.len() >= forager.food_items as usize {
            break;
        }
        if distance(at, (-arena, 0.0)) > nest + radius && food.iter().all(|&other| distance(at, other) > 3.0 * radius) {
            food.push(at);
        }
    }
    food
}

/// Robots and their headings (turns), without overlaps.
fn robots(foragers: &Swarm) -> Vec<((f64, f64), f64)> {
    let body = f64::from(foragers.forager.body_radius);
    let mut robots: Vec<((f64, f64), f64)> = Vec::new();
    for (at, heading) in places(f64::from(foragers.forager.arena_radius) - body, 2) {
        if robots.len() >= foragers.robots as usize {
            break;
        }
        if robots.iter().all(|&(other, _)| distance(at, other) > 2.4 * body) {
            robots.push((at, heading));
        }
    }
    robots
}

#[cfg(test)]
mod tests {
    use oneiro::swarm::Lamp;

    use super::super::swarm::{BEHAVIOURS, Moment, Sight, Teller};
    use super::*;

    #[test]
    fn food_lies_outside_the_nest_and_robots_are_apart() {
        let foragers = Swarm::odowd2014(10);
        let food = food(&foragers.forager);
        assert_eq!(food.len(), 7);
        assert!(
            food.iter()
                .all(|&at| distance(at, (-600.0, 0.0)) > 250.0 && at.0.hypot(at.1) <= 550.0)
        );
        let robots = robots(&foragers);
        assert_eq!(robots.len(), 10);
        for (i, (one, _)) in robots.iter().enumerate() {
            assert!(one.0.hypot(one.1) <= 565.0);
            assert!(robots[..i].iter().all(|(other, _)| distance(*one, *other) > 70.0));
        }
    }

    /// A moment has the light, the food and the robots of its line.
    #[test]
    fn a_film_follows_its_lines() {
        let foragers = Swarm::odowd2014(2);
        let robot = |x, act, carries, brought| Sight {
            pose: Some([x, 0.0, 0.25]),
            act,
            carries,
            brought,
            ..Sight::default()
        };
        let line = |number: u32| Moment {
            cycle: number * SECOND,
            robots: vec![
                robot(100.0 * number as f32, 2, number == 2, number),
                robot(-100.0, 0, false, 0),
            ],
            food: vec![[0.0, 0.0]; number as usize],
        };
        let lines = [line(1), line(2), line(3)];
        let replay = ForagersReplay {
            title: "t",
            foragers: &foragers,
            lamp: Lamp {
                first: Light::OverNest,
                then: Light::OppositeNest,
                moves: 3 * SECOND,
            },
            names: &[1, 2],
            acts: &BEHAVIOURS,
            teller: Teller::Arena,
            lines: &lines,
            genes: &[],
        };
        let film = ForagersFrames::new(&replay, 480.0);
        assert_eq!((film.step(), film.seconds()), (1.0, 3.0));
        let food = format!("fill=\"{FOOD}\"/>");
        for (seconds, words, items) in [
            (0.0, "1 s of 3 s, food 1", 1),
            (2.2, "2 s of 3 s, food 3", 2),
            (9.0, "3 s of 3 s, food 6", 3),
        ] {
            let drawn = film.at(seconds);
            assert!(drawn.contains(&format!(">{words}</text>")), "{drawn}");
            assert_eq!(drawn.matches(&food).count(), items, "{drawn}");
            assert_eq!(
                drawn.contains(&format!("fill=\"{FOOD}\" stroke=\"#ffffff\"")),
                items == 2
            );
        }
        let lamp = |drawn: String| -> f64 {
            let (before, _) = drawn.split_once("><title>lamp</title>").unwrap();
            before
                .rsplit("cx=\"")
                .next()
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        };
        assert!(lamp(film.at(2.0)) < 240.0 && lamp(film.at(3.0)) > 240.0);
    }

    #[test]
    fn everything_is_drawn_to_scale() {
        let foragers = Swarm::odowd2014(10);
        let text = super::foragers("t", &foragers);
        // 600 pixels are 1200 mm.
        for (radius, count) in [
            ("r=\"17.5\"", 10),
            ("r=\"52.5\"", 10),
            ("r=\"125\"", 1),
            ("r=\"25\"", 7),
        ] {
            assert_eq!(text.matches(radius).count(), count, "{radius}");
        }
        let text = scenarios("t", &foragers.forager);
        assert_eq!(text.matches(">lamp</title>").count(), 2, "one scenario has no light");
        assert_eq!(text.matches("<path").count(), 3, "nests");
    }
}
