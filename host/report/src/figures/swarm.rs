//! A self-contained HTML page that replays foragers, or shows a fleet.
//!
//! Its data are JSON in which long lists of numbers are Base64 of little-endian 16-bit integers: fifty minutes of ten
//! robots with a line per second take half a megabyte. Poses are rounded to 0.1 mm (1 mm in arenas more than 3 m
//! across) and 1/65536 turn; counts are exact. The page of a running fleet loads newer data every second, from a script
//! in the same folder: a page that was opened as a file may load nothing else.

use std::collections::{BTreeMap, BTreeSet};

use oneiro::foraging::Light;
use oneiro::swarm::{Behaviour, Lamp, Line, SECOND, Seen, Swarm};
use serde_json::{Value, json};

use super::player::{self, Player, packed, turns};
use super::svg::number;

/// The panel next to the arena.
const PANEL: &str = include_str!("../components/foragers.html");
/// The page's module.
const SCRIPT: &str = "foragers";
/// Arena radius in mm up to which poses are in tenths of millimetres.
const FINE: f32 = 1600.0;
/// Position of a robot whose pose is unknown; others are clamped to one more.
const NOWHERE: i16 = i16::MIN;
/// An age or a fitness that is unknown; others are clamped to one less.
const UNKNOWN: u16 = u16::MAX;

/// Record of a swarm, to be played.
pub struct ForagersReplay<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// World of the swarm.
    pub foragers: &'a Swarm,
    pub lamp: Lamp,
    /// The robots' names, in their order.
    pub names: &'a [u32],
    /// What robots may do, 16 at most.
    pub acts: &'a [Act],
    /// The source of the lines.
    pub teller: Teller,
    /// What was recorded, in the order of time.
    pub lines: &'a [Moment],
    /// Each robot's genes in the order of cycles; empty if robots don't evolve.
    pub genes: &'a [Vec<Genes>],
}

/// The source of a page's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Teller {
    /// The simulated arena, which has everything.
    Arena,
    /// An arena's record without food on the floor and without who heard whom.
    #[cfg(feature = "twin")]
    Record,
    /// The robots, which may fall silent: their problems are known, but food on the floor and who heard whom are not.
    Robots,
}

/// Something that a robot may do.
#[derive(Clone, Copy, Debug)]
pub struct Act {
    /// After "robot 3".
    pub name: &'static str,
    /// In a table.
    pub short: &'static str,
    /// The robot's colour.
    pub colour: &'static str,
    /// Colour of its front; none if such a robot is nowhere.
    pub front: Option<&'static str>,
}

impl Act {
    /// Fronts of dark robots, and of light ones.
    pub const LIGHT: Option<&'static str> = Some("#ffffff");
    pub const DARK: Option<&'static str> = Some("#63666e");
}

/// The behaviours of the 2014 study, in the order of [`Behaviour`].
pub const BEHAVIOURS: [Act; 5] = [
    Act {
        name: "flees the light",
        short: "flees light",
        colour: "#2b3a8f",
        front: Act::LIGHT,
    },
    Act {
        name: "searches at random",
        short: "searches",
        colour: "#2a9d8f",
        front: Act::LIGHT,
    },
    Act {
        name: "seeks the light",
        short: "seeks light",
        colour: "#f4a23b",
        front: Act::LIGHT,
    },
    Act {
        name: "avoids an obstacle",
        short: "avoids",
        colour: "#b3263c",
        front: Act::LIGHT,
    },
    Act {
        name: "is off",
        short: "off",
        colour: "#dde0e6",
        front: Act::DARK,
    },
];

/// A swarm after a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Cycles since the experiment began.
    pub cycle: u32,
    /// Its robots, in their order.
    pub robots: Vec<Sight>,
    /// Positions of the food, mm.
    pub food: Vec<[f32; 2]>,
}

/// What is known of a robot at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sight {
    /// Position in mm and heading in turns, if they are known.
    pub pose: Option<[f32; 3]>,
    /// What it does: an index of [`ForagersReplay::acts`].
    pub act: usize,
    /// Whether it carries food.
    pub carries: bool,
    /// Food that it has brought since the moment before.
    pub brought: u32,
    /// Fitness in this interval so far, if it is known.
    pub earned: Option<f32>,
    /// Robots that it has heard since the moment before, one bit each.
    pub heard: u128,
    /// Age of its last word in s, if there was one.
    pub age: Option<f32>,
    /// What is in its way.
    pub problems: String,
}

impl Sight {
    fn of(seen: &Seen) -> Self {
        let act = match seen.behaviour {
            Behaviour::FleeLight => 0,
            Behaviour::Search => 1,
            Behaviour::SeekLight => 2,
            Behaviour::Avoid => 3,
            Behaviour::Off => 4,
        };
        Self {
            pose: Some([seen.x, seen.y, seen.heading]),
            act,
            carries: seen.carries,
            brought: seen.brought,
            earned: Some(seen.earned),
            heard: seen.heard,
            ..Self::default()
        }
    }
}

/// Converts the lines of a trace, which was recorded every `every` cycles, to moments.
pub fn moments(lines: &[Line], every: u32) -> Vec<Moment> {
    let of_line = |(number, line): (u32, &Line)| Moment {
        cycle: number * every,
        robots: line.robots.iter().map(Sight::of).collect(),
        food: line.food.clone(),
    };
    (1..).zip(lines).map(of_line).collect()
}

/// Genes of a robot from a cycle on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Genes {
    /// First cycle.
    pub cycle: u32,
    /// Gene of its simulator.
    pub s0: f32,
    /// Gene of its controller when carrying food.
    pub g0: f32,
    /// Gene of its controller when carrying none.
    pub g1: f32,
}

/// Makes the page.
pub fn foragers_page(replay: &ForagersReplay<'_>) -> String {
    page(replay, &facts(replay))
}

/// Makes the page of a running fleet, which loads a script of this name from the same folder every second.
pub fn live_page(replay: &ForagersReplay<'_>, script: &str) -> String {
    let mut facts = facts(replay);
    facts.insert("live", json!(script));
    page(replay, &facts)
}

/// The script element of all these pages, by which they are recognised.
pub fn foragers_script() -> String {
    player::script_element(SCRIPT)
}

/// Makes that script: what is known now. `written` differs each time, and `end` says how the experiment has ended, if
/// it has.
pub fn live_script(replay: &ForagersReplay<'_>, written: u64, end: Option<&str>) -> String {
    let mut facts = facts(replay);
    facts.extend([("written", json!(written)), ("end", json!(end))]);
    format!("window.oneiro.take({});\n", json!(facts))
}

fn page(replay: &ForagersReplay<'_>, facts: &BTreeMap<&str, Value>) -> String {
    player::page(&Player {
        title: replay.title,
        lead: &lead(replay),
        drawn: "The arena from above, with its robots, food, nest and light",
        switches: "",
        strip: "<div id=\"lights\" aria-hidden=\"true\"></div>",
        panel: PANEL,
        facts,
        script: SCRIPT,
    })
}

/// Text below the title.
fn lead(replay: &ForagersReplay<'_>) -> String {
    let ForagersReplay {
        names, foragers, lines, ..
    } = replay;
    let (robots, forage) = match names.len() {
        1 => ("One e-puck".to_owned(), "forages"),
        count => (format!("{count} e-pucks"), "forage"),
    };
    let across = number(f64::from(foragers.forager.arena_radius) / 500.0);
    let seconds = |cycles: u32| f64::from(cycles) / f64::from(SECOND);
    let length = match lines {
        [] => String::new(),
        [first, ..] => {
            let last = seconds(lines[lines.len() - 1].cycle);
            let spacing = match lines.get(1).map_or(first.cycle, |next| next.cycle - first.cycle) {
                SECOND => "a line each second".to_owned(),
                cycles => format!("a line each {} s", number(seconds(cycles))),
            };
            format!(": {} s, {spacing}", number(last))
        }
    };
    format!("{robots} {forage} for food in an arena {across} m across{length}.")
}

/// All data for the script.
fn facts(replay: &ForagersReplay<'_>) -> BTreeMap<&'static str, Value> {
    let ForagersReplay { foragers, lines, .. } = replay;
    let forager = &foragers.forager;
    let unit = if forager.arena_radius <= FINE { 0.1 } else { 1.0 };
    let robots = || lines.iter().flat_map(|line| &line.robots);
    let food = || lines.iter().flat_map(|line| &line.food);
    let length = |mm: f32| ((f64::from(mm) / unit).round() as i16).max(NOWHERE + 1) as u16;
    let place = |sight: &Sight, axis: usize| sight.pose.map_or(NOWHERE as u16, |pose| length(pose[axis]));
    let problems: BTreeSet<&str> = robots().map(|sight| &*sight.problems).collect();
    let problems: Vec<&str> = problems.into_iter().collect();
    let problem = |sight: &Sight| problems.binary_search(&&*sight.problems).unwrap_or_default() as u16;
    let act = |act: &Act| json!({ "name": act.name, "short": act.short, "colour": act.colour, "front": act.front });
    // Keys in alphabetical order, so that the page is always the same.
    let mut facts: BTreeMap<&str, Value> = BTreeMap::from([
        ("names", json!(replay.names)),
        ("acts", replay.acts.iter().map(act).collect()),
        ("whole", json!(replay.teller == Teller::Arena)),
        // Cycles of the lines.
        ("times", lines.iter().map(|line| line.cycle).collect()),
        ("arena", json!(forager.arena_radius)),
        ("nest", json!(forager.nest_radius)),
        ("body", json!(forager.body_radius)),
        ("food", json!(forager.food_radius)),
        ("lamp", json!(forager.lamp_behind_wall)),
        ("decay", json!(forager.light_decay)),
        ("range", json!(foragers.range)),
        ("lights", lights(replay.lamp)),
        ("genes", genes(replay.genes)),
        // Unit of positions, mm.
        ("unit", json!(unit)),
        // For each line, for each robot.
        ("x", json!(packed(robots().map(|sight| place(sight, 0))))),
        ("y", json!(packed(robots().map(|sight| place(sight, 1))))),
        (
            "heading",
            json!(packed(
                robots().map(|sight| sight.pose.map_or(0, |pose| turns(pose[2])))
            )),
        ),
        ("state", json!(packed(robots().map(state)))),
        ("earned", json!(packed(robots().map(|sight| tenths(sight.earned))))),
        // For each line, for each item.
        ("food_x", json!(packed(food().map(|at| length(at[0]))))),
        ("food_y", json!(packed(food().map(|at| length(at[1]))))),
        ("heard", json!(packed(lines.iter().flat_map(heard)))),
    ]);
    if replay.teller == Teller::Robots {
        facts.extend([
            ("age", json!(packed(robots().map(|sight| tenths(sight.age))))),
            ("problems", json!(problems)),
            ("problem", json!(packed(robots().map(problem)))),
        ]);
    }
    facts
}

/// Converts to tenths.
fn tenths(value: Option<f32>) -> u16 {
    value.map_or(UNKNOWN, |value| ((10.0 * value).round() as u16).min(UNKNOWN - 1))
}

/// Positions of the light with the cycles from which they hold.
fn lights(lamp: Lamp) -> Value {
    let name = |light| match light {
        Light::OverNest => "over",
        Light::Nowhere => "none",
        Light::OppositeNest => "opposite",
    };
    if lamp.first == lamp.then || lamp.moves == 0 {
        return json!([[0, name(lamp.then)]]);
    }
    json!([[0, name(lamp.first)], [lamp.moves, name(lamp.then)]])
}

/// Changes of each robot's genes: cycle, S0, G0, G1, and the third that each of them is in.
fn genes(robots: &[Vec<Genes>]) -> Value {
    // All three have the same thirds. The kernels' source of the thirds is used, so that rounding agrees.
    let third = |gene| match Light::of_gene(gene) {
        Light::OppositeNest => 0,
        Light::Nowhere => 1,
        Light::OverNest => 2,
    };
    let change = |&Genes { cycle, s0, g0, g1 }: &Genes| {
        let thirds = [s0, g0, g1].map(third);
        json!([cycle, s0, g0, g1, thirds])
    };
    robots
        .iter()
        .map(|changes| changes.iter().map(change).collect::<Value>())
        .collect()
}

/// State in bits, from the lowest: 4 for what it does, 1 for whether it carries food, 11 for the food it has brought.
fn state(sight: &Sight) -> u16 {
    (sight.act & 0xf) as u16 | u16::from(sight.carries) << 4 | (sight.brought.min(0x7ff) as u16) << 5
}

/// Who heard whom: the number of pairs, then each pair with the hearer in the upper half and the robot it heard in the
/// lower half.
fn heard(line: &Moment) -> Vec<u16> {
    let mut words = vec![0];
    for (hearer, sight) in line.robots.iter().enumerate() {
        let others = (0..128).filter(|&other| sight.heard >> other & 1 == 1);
        words.extend(others.map(|other: u16| (hearer as u16) << 8 | other));
    }
    words[0] = (words.len() - 1) as u16;
    words
}

#[cfg(test)]
mod tests {
    use oneiro::cpu::Cpu;
    use oneiro::evaluator::Control;
    use oneiro::random::Key;
    use oneiro::swarm::{Arena as _, Order, Simulated, World};

    use super::super::browser;
    use super::*;
    use crate::bundle::typed_keys;

    /// A made-up record of a swarm with made-up genes.
    struct Life {
        foragers: Swarm,
        lamp: Lamp,
        names: Vec<u32>,
        lines: Vec<Line>,
        moments: Vec<Moment>,
        genes: Vec<Vec<Genes>>,
    }

    impl Life {
        /// `robots` robots whose genes change every minute; the light moves half-way through.
        fn of(robots: u32, seconds: u32, every: u32) -> Self {
            let cycles = seconds * SECOND;
            let foragers = Swarm::odowd2014(robots);
            let lamp = Lamp {
                first: Light::OverNest,
                then: Light::OppositeNest,
                moves: cycles / 2,
            };
            let world = World {
                swarm: 0,
                lamp,
                key: Key::rollout(5, 0, 0, 0),
            };
            let control = Control::new();
            let mut cpu = Cpu::new(Some(1)).unwrap();
            let mut arena = Simulated::new(&mut cpu, &control, &[foragers], &[world]).unwrap();
            let mut lines = Vec::new();
            let mut genes = vec![Vec::new(); robots as usize];
            let gene =
                |robot: u32, cycle: u32, which: u32| (robot * 37 + cycle / foragers.interval * 23 + which * 61) % 100;
            let mut now = 0;
            while now < cycles {
                let until = (now + foragers.interval).min(cycles);
                let mut orders = Vec::new();
                for (robot, changes) in (0..).zip(&mut genes) {
                    let [s0, g0, g1] = [0, 1, 2].map(|which| gene(robot, now, which) as f32 / 100.0);
                    // Robots are switched on one after another.
                    let at = if now == 0 { robot % 5 * SECOND } else { now };
                    changes.push(Genes { cycle: at, s0, g0, g1 });
                    orders.push(Order {
                        before: (now > 0).then_some([g0, g1]),
                        after: [g0, g1],
                        at,
                        begins: Some(at),
                    });
                }
                lines.extend(arena.live(until, &[orders], every).unwrap().remove(0));
                now = until;
            }
            Self {
                foragers,
                lamp,
                names: (1..=robots).collect(),
                moments: moments(&lines, every),
                lines,
                genes,
            }
        }

        fn replay(&self) -> ForagersReplay<'_> {
            ForagersReplay {
                title: "Light Over Nest to Light Opposite Nest, run 1",
                foragers: &self.foragers,
                lamp: self.lamp,
                names: &self.names,
                acts: &BEHAVIOURS,
                teller: Teller::Arena,
                lines: &self.moments,
                genes: &self.genes,
            }
        }
    }

    /// Reads the data of a page.
    fn read(page: &str) -> Value {
        let (_, after) = page
            .split_once("<script type=\"application/json\" id=\"replay\">")
            .unwrap();
        serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
    }

    #[test]
    fn a_page_depends_on_its_input_only_and_needs_nothing_else() {
        let life = Life::of(10, 20, 10);
        let page = foragers_page(&life.replay());
        assert_eq!(page, foragers_page(&Life::of(10, 20, 10).replay()));
        // Drawings name their own parts.
        let outside = page.replace("url(#", "");
        for reference in ["http", "//cdn", " src=", "@import", "url(", "fetch(", "import("] {
            assert!(!outside.contains(reference), "{reference}");
        }
        assert!(!page.contains("{{"), "all is filled");
    }

    #[test]
    fn the_script_has_types_of_all_facts() {
        let life = Life::of(1, 1, 10);
        let replay = ForagersReplay {
            teller: Teller::Robots,
            ..life.replay()
        };
        let keys = facts(&replay).into_keys().chain(["live", "written", "end"]);
        let keys: BTreeSet<_> = keys.map(str::to_owned).collect();
        let typed = typed_keys(&["PoseFacts", "RobotFacts", "ForagersOnly"]);
        assert_eq!(keys.into_iter().collect::<Vec<_>>(), typed);
    }

    #[test]
    fn text_is_escaped() {
        let life = Life::of(1, 1, 10);
        let replay = ForagersReplay {
            title: "</title><script>alert(1)</script> & {{data}}",
            ..life.replay()
        };
        let page = foragers_page(&replay);
        assert_eq!(page.matches("<script").count(), 2);
        assert_eq!(
            page.matches("&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt; &amp; {{data}}")
                .count(),
            2
        );
    }

    #[test]
    fn a_page_holds_every_line() {
        let life = Life::of(3, 20, 5);
        let data = read(&foragers_page(&life.replay()));
        let seen: Vec<&Seen> = life.lines.iter().flat_map(|line| &line.robots).collect();
        assert_eq!(seen.len(), 3 * 40);
        let times: Vec<u32> = (1..=40).map(|line| 5 * line).collect();
        assert_eq!(data["times"], json!(times));
        assert_eq!(data["state"], packed(seen.iter().map(|seen| state(&Sight::of(seen)))));
        assert_eq!(
            data["x"],
            packed(seen.iter().map(|seen| (10.0 * f64::from(seen.x)).round() as i16 as u16))
        );
        assert_eq!(data["lights"], json!([[0, "over"], [100, "opposite"]]));
        assert_eq!(
            data["genes"][1][0],
            json!([10, 0.37_f32, 0.98_f32, 0.59_f32, [1, 2, 1]])
        );
    }

    #[test]
    fn who_heard_whom_is_packed_in_pairs() {
        let seen = |heard| Seen {
            x: 0.0,
            y: 0.0,
            heading: 0.0,
            behaviour: Behaviour::Search,
            carries: false,
            brought: 0,
            earned: 0.0,
            heard,
        };
        let line = Line {
            robots: vec![seen(0), seen(1 << 127 | 1), seen(2)],
            food: Vec::new(),
        };
        assert_eq!(heard(&moments(&[line], 10)[0]), [3, 1 << 8, 1 << 8 | 127, 2 << 8 | 1]);
    }

    #[test]
    fn every_number_of_robots_has_a_page() {
        let many = Life::of(128, 2, 10);
        let data = read(&foragers_page(&many.replay()));
        assert_eq!(data["genes"].as_array().unwrap().len(), 128);
        let one = Life::of(1, 1, 10);
        let without = ForagersReplay {
            genes: &[],
            ..one.replay()
        };
        let page = foragers_page(&without);
        let data = read(&page);
        assert_eq!((&data["times"], &data["genes"]), (&json!([10]), &json!([])));
        assert!(page.contains("One e-puck forages"));
        let nothing = ForagersReplay {
            lines: &[],
            ..one.replay()
        };
        assert_eq!(read(&foragers_page(&nothing))["x"], "");
    }

    #[test]
    fn fifty_minutes_of_ten_robots_fit_in_a_megabyte() {
        let mut life = Life::of(10, 60, 10);
        life.moments = life.moments.iter().cycle().take(3000).cloned().collect();
        (1..)
            .zip(&mut life.moments)
            .for_each(|(line, moment)| moment.cycle = 10 * line);
        let page = foragers_page(&life.replay());
        assert!(page.len() < 1_000_000, "{}", page.len());
    }

    #[test]
    fn a_browser_draws_robots_and_food_in_place() {
        let life = Life::of(10, 120, 10);
        let page = foragers_page(&life.replay());
        // Drawings, and the effects of keys and clicks.
        let ask = "\
            const at = (id) => document.getElementById(id);\n\
            const press = (key) => document.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));\n\
            const soon = () => new Promise((then) => setTimeout(then, 200));\n\
            const drawn = [1, 2, 30, 60, 61, 119, 120, 60.5].map(window.oneiro.drawn);\n\
            const acts = [];\n\
            await soon(); press('ArrowRight'); press('ArrowRight'); press('ArrowLeft'); await soon();\n\
            acts.push(at('when').value, at('clock').textContent);\n\
            press(' '); acts.push(at('play').textContent); await soon(); press(' ');\n\
            acts.push(at('play').textContent, Number(at('when').value) > 61);\n\
            document.querySelectorAll('.who')[3].click(); await soon();\n\
            acts.push(document.querySelectorAll('.who')[3].getAttribute('aria-pressed'));\n\
            acts.push(at('robot').textContent.startsWith('Robot 4 '));\n\
            press('Escape'); await soon(); acts.push(document.querySelectorAll('[aria-pressed=true]').length);\n\
            press('End'); await soon(); acts.push(document.querySelector('.all .food').textContent);\n\
            return { drawn, acts };";
        let Some(told) = browser::told("page", &page, ask) else {
            return;
        };
        let drawn = told["drawn"].as_array().unwrap();
        assert_eq!(drawn.len(), 8);

        // Half a step of packing, plus the canvas's rounding.
        let (length, turn) = (0.05 + 0.005, 0.5 / 65_536.0 + 1e-6);
        let near = |value: &Value, expected: f64, tolerance: f64| {
            let value = value.as_f64().unwrap();
            assert!((value - expected).abs() <= tolerance, "{value}, not {expected}");
        };
        let apart = |value: &Value, heading: f64| {
            let off = (value.as_f64().unwrap() - heading).rem_euclid(1.0);
            assert!(off.min(1.0 - off) <= turn, "{value} turns, not {heading}");
        };
        let mut plain = 0;
        for at in &drawn[..7] {
            let seconds = at["time"].as_f64().unwrap();
            let line = &life.lines[seconds as usize - 1];
            let (robots, food) = (at["robots"].as_array().unwrap(), at["food"].as_array().unwrap());
            assert_eq!((robots.len(), food.len()), (10, 7));
            for (robot, seen) in robots.iter().zip(&line.robots) {
                near(&robot["x"], f64::from(seen.x), length);
                near(&robot["y"], f64::from(seen.y), length);
                apart(&robot["heading"], f64::from(seen.heading));
                let colour = BEHAVIOURS[Sight::of(seen).act].colour;
                plain += u32::from(robot["colour"] == colour);
            }
            for (item, place) in food.iter().zip(&line.food) {
                near(&item[0], f64::from(place[0]), length);
                near(&item[1], f64::from(place[1]), length);
            }
        }
        // Half-way between two lines; food stays until the next line.
        let (before, after) = (&life.lines[59], &life.lines[60]);
        let robots = drawn[7]["robots"].as_array().unwrap();
        for ((robot, from), to) in robots.iter().zip(&before.robots).zip(&after.robots) {
            near(&robot["x"], 0.5 * f64::from(from.x + to.x), length);
            near(&robot["y"], 0.5 * f64::from(from.y + to.y), length);
            let turned = (f64::from(to.heading - from.heading) + 0.5).rem_euclid(1.0) - 0.5;
            apart(&robot["heading"], f64::from(from.heading) + 0.5 * turned);
        }
        assert_eq!(drawn[7]["food"], drawn[3]["food"]);
        // Another's food may hide a robot's side.
        assert!(plain >= 65, "{plain} of 70 robots have their colour");

        let brought: u32 = life.lines.iter().flat_map(|line| &line.robots).map(|r| r.brought).sum();
        assert_eq!(
            told["acts"],
            json!([
                "61",
                "1:01 of 2:00",
                "Pause",
                "Play",
                true,
                "true",
                true,
                0,
                brought.to_string()
            ])
        );
    }
}
