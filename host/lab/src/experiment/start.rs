//! Experiments to start from: what `oneiro new NAME` writes, at a glance or with all keys.

use std::fmt::Write as _;

use oneiro::compose;
use oneiro::tasks::Ready;
use oneiro::world::Task;

use super::reference::{self, Entry};
use super::robots::Shipped;
use super::settings::Settings;
use super::values::{Described, unit_words};

/// The lines of a file that can be read at a glance.
pub const SHORT: usize = 30;

/// An experiment to start from.
#[derive(Debug)]
pub struct Start<'a> {
    pub name: &'a str,
    pub robots: Robots,
    /// Custom parts and their files; a swarm's task is its mission.
    pub parts: Vec<(compose::Kind, String)>,
}

/// The robots of an experiment to start from.
#[derive(Clone, Copy, Debug)]
pub enum Robots {
    /// The sampled Khepera.
    Khepera,
    /// An e-puck that forages.
    Forager,
    /// A parametric robot.
    Parametric(Shipped),
    /// Ten of them.
    Swarm(Shipped),
}

/// A line of the short file.
struct Line {
    key: &'static str,
    /// As TOML.
    value: String,
    /// What the key means.
    words: String,
}

/// Patches of the floor for a task, as TOML, and what they are.
fn patches(ready: &Ready) -> Option<(&'static str, &'static str)> {
    Some(match ready.task {
        Task::Reach => ("[{ x_mm = 850.0, y_mm = 850.0, radius_mm = 80.0 }]", "the goal"),
        Task::Visit | Task::Collect => (
            "[{ x_mm = 250.0, y_mm = 250.0, radius_mm = 120.0 }, { x_mm = 750.0, y_mm = 750.0, radius_mm = 120.0 }]",
            "the goals, or the nest and a place with food",
        ),
        Task::FollowLine => (
            "[{ x_mm = 500.0, y_mm = 500.0, radius_mm = 300.0 }, { x_mm = 500.0, y_mm = 500.0, radius_mm = 240.0, grey = 1.0 }]",
            "a line: a black disc, and a white one on it",
        ),
        _ => return None,
    })
}

/// The key that names a robot that ships.
const PRESET: &str = "robot.preset";

impl Start<'_> {
    /// The lines of the short file, table by table.
    fn lines(&self) -> Vec<Line> {
        let all = self.entries();
        let default = |key: &str| all.iter().find(|entry| entry.key == key)?.default.clone();
        let mut lines = Vec::new();
        let mut set = |key, value: String, words: &str| {
            let words = words.to_owned();
            lines.push(Line { key, value, words });
        };
        let usual = |key| default(key).unwrap_or_default();
        set("name", format!("{:?}", self.name), "name of its runs");
        let is_swarm = matches!(self.robots, Robots::Swarm(_));
        let is_forager = matches!(self.robots, Robots::Forager);
        let cycles = if is_swarm || is_forager {
            "600".to_owned()
        } else {
            usual("cycles")
        };
        set("cycles", cycles, "length of an episode");
        if is_swarm {
            set("trials", "5".to_owned(), "episodes of each genome in a generation");
        }
        match self.robots {
            Robots::Khepera => set(
                "robot.tables",
                usual("robot.tables"),
                "a Khepera's recorded sensors; `oneiro new NAME --robot epuck` has another robot",
            ),
            Robots::Forager => set(
                "robot.kind",
                "\"forager\"".to_owned(),
                "an e-puck with a nest, food and a lamp",
            ),
            Robots::Parametric(robot) | Robots::Swarm(robot) => {
                let others = format!("one of {}", super::robots::names());
                set(PRESET, format!("{:?}", robot.name), &others);
            }
        }
        if is_swarm {
            set("robot.count", "10".to_owned(), "robots in the swarm");
        }
        match self.robots {
            Robots::Khepera => set(
                "arena.preset",
                usual("arena.preset"),
                "or your own: width_mm and height_mm",
            ),
            Robots::Forager => {
                set("arena.radius_mm", usual("arena.radius_mm"), "radius of the round arena");
                set(
                    "arena.food_items",
                    usual("arena.food_items"),
                    "items of food at any time",
                );
            }
            Robots::Parametric(_) => {
                set("arena.width_mm", "1000.0".to_owned(), "width of the rectangle");
                set("arena.height_mm", "1000.0".to_owned(), "height");
                if let Some((patches, words)) = self.ready().and_then(patches) {
                    set("arena.patches", patches.to_owned(), words);
                }
            }
            Robots::Swarm(_) => {
                set("arena.width_mm", "2000.0".to_owned(), "width of the rectangle");
                set("arena.height_mm", "2000.0".to_owned(), "height");
                let spot = "[{ x_mm = 1000.0, y_mm = 1000.0, radius_mm = 300.0, grey = 0.0 }]".to_owned();
                set("arena.patches", spot, "a black spot on the floor");
            }
        }
        let lights = self.ready().is_some_and(|ready| ready.task == Task::Phototaxis);
        let has_light = |robot: &Shipped| lights || robot.text.contains("kind = \"light\"");
        if let Some(robot) = self.shipped().filter(has_light) {
            let at = if is_swarm { "1000.0" } else { "500.0" };
            let words = format!("a lamp for the light sensors of {}", robot.name);
            set("arena.lights", format!("[{{ x_mm = {at}, y_mm = {at} }}]"), &words);
        }
        if self.ready().is_some_and(Ready::has_pucks) {
            set("pucks.count", "10".to_owned(), "discs that the robots push and carry");
            set("pucks.radius_mm", "40.0".to_owned(), "their radius");
            set(
                "pucks.grip_mm",
                "10.0".to_owned(),
                "gap within which a robot can take one",
            );
        }
        if is_forager {
            set(
                "arena.light_noise",
                usual("arena.light_noise"),
                "maximum error of a light reading, a fraction",
            );
        } else {
            let error = if is_swarm {
                "error on top of the robot's own noise"
            } else {
                "error of a reading"
            };
            let range = format!("{error}, minimum and maximum, a fraction");
            set("noise.sensor", usual("noise.sensor"), &range);
            set(
                "noise.motor",
                usual("noise.motor"),
                "maximum error of a move, a fraction",
            );
        }
        for kind in [compose::Kind::Sensor, compose::Kind::Controller, compose::Kind::Task] {
            let [chosen, part] = match kind {
                compose::Kind::Sensor => ["", "sensor.part"],
                compose::Kind::Controller => ["controller.kind", "controller.part"],
                compose::Kind::Task => ["task.kind", "task.part"],
            };
            let file = self.parts.iter().find(|(own, _)| *own == kind);
            if let Some((_, file)) = file {
                if !chosen.is_empty() {
                    set(chosen, "\"own\"".to_owned(), "a custom one");
                }
                let values = self.values(kind);
                let values: Vec<&str> = values.iter().map(|value| &*value.name).collect();
                let words = if values.is_empty() {
                    "edit this file".to_owned()
                } else {
                    format!("edit this file; [{}.values] may set {}", kind.word(), values.join(", "))
                };
                set(part, format!("{file:?}"), &words);
            } else if kind == compose::Kind::Controller {
                match self.robots {
                    Robots::Forager => set(
                        chosen,
                        "\"behaviours\"".to_owned(),
                        "what it does with food and without",
                    ),
                    Robots::Swarm(_) => set(
                        chosen,
                        "\"network\"".to_owned(),
                        "readings to wheels; [[controller.layers]] adds layers",
                    ),
                    _ => set(chosen, usual(chosen), "or hidden, recurrent, network"),
                }
            } else if kind == compose::Kind::Task {
                match self.robots {
                    Robots::Forager => set(chosen, "\"foraging\"".to_owned(), "rewards food in the nest"),
                    _ => set(
                        chosen,
                        usual(chosen),
                        "rewards fast, straight driving far from obstacles",
                    ),
                }
            }
        }
        if is_swarm {
            set(
                "evolution.kind",
                "\"cma-es\"".to_owned(),
                "the optimiser; `oneiro new --keys evolution.kind` lists all",
            );
            set("evolution.generations", "40".to_owned(), "number of generations");
            set("evolution.population", "50".to_owned(), "genomes in a generation");
        } else {
            set(
                "evolution.generations",
                usual("evolution.generations"),
                "number of generations",
            );
            set(
                "evolution.population",
                usual("evolution.population"),
                "genomes in a generation",
            );
            set(
                "evolution.parents",
                usual("evolution.parents"),
                "the best that have children",
            );
        }
        lines
    }

    /// The robot that ships, if it has one.
    fn shipped(&self) -> Option<Shipped> {
        match self.robots {
            Robots::Parametric(robot) | Robots::Swarm(robot) => Some(robot),
            Robots::Khepera | Robots::Forager => None,
        }
    }

    /// All keys that it may have.
    fn entries(&self) -> Vec<Entry> {
        match self.robots {
            Robots::Forager => reference::forager(),
            Robots::Khepera | Robots::Parametric(_) | Robots::Swarm(_) => reference::single(),
        }
    }

    /// What it is about.
    fn about(&self) -> String {
        let (robot, page) = match self.robots {
            Robots::Khepera if self.parts.is_empty() => (
                "A Khepera learns to avoid obstacles, as in Miglino, Lund and Nolfi 1995, without noise".to_owned(),
                "khepera",
            ),
            Robots::Khepera => ("A Khepera".to_owned(), "extend"),
            Robots::Forager if self.parts.is_empty() => (
                "An e-puck learns when to seek light and when to avoid it, to bring food to its nest".to_owned(),
                "epuck",
            ),
            Robots::Forager => ("An e-puck in an arena with food and a nest".to_owned(), "epuck"),
            Robots::Parametric(robot) => (format!("A parametric robot ({})", robot.name), "robots"),
            Robots::Swarm(robot) => {
                let about = format!("Ten robots ({}) gather on a black spot", robot.name);
                (about, "swarms")
            }
        };
        let files: Vec<&str> = self.parts.iter().map(|(_, file)| &**file).collect();
        let with = if files.is_empty() { "" } else { ", with " };
        format!("{robot}{with}{}: docs/{page}.md", files.join(", "))
    }

    /// The experiment at a glance: at most [`SHORT`] lines, with the keys that most people change first.
    pub fn short(&self) -> String {
        let mut text = format!("# {}.\n#     oneiro run {}.toml --seed 1\n\n", self.about(), self.name);
        let mut table = "";
        for Line { key, value, words } in self.lines() {
            let (own, name) = key.rsplit_once('.').unwrap_or(("", key));
            if own != table {
                text.extend(["\n[", own, "]\n"]);
                table = own;
            }
            let unit = Settings::rows()
                .iter()
                .find(|row| row.key == key)
                .map_or("", |row| row.unit);
            let line = format!("{name} = {value}");
            let _ = writeln!(text, "{line:<27} # {words}{}", unit_words(key, unit));
        }
        text += "\n# `oneiro new --keys` lists all other keys; `oneiro new NAME --all-keys` writes them.\n";
        if text.lines().count() > SHORT {
            text = text.replace("\n\n[", "\n[");
        }
        text
    }

    /// The same experiment with all keys, each with a comment. Those that the short file doesn't have are comments.
    pub fn whole(&self) -> String {
        let entries = self.entries();
        let lines = self.lines();
        let set = |key: &str| lines.iter().find(|line| line.key == key);
        let mut text = format!(
            "{}#\n#     oneiro run {}.toml --seed 1\n#\n{}\n",
            comment(&(self.about() + ".")),
            self.name,
            comment(
                "This file has all keys. A key in a comment has its default, which the comment shows. --set KEY=VALUE changes a key \
                 for one run, such as --set evolution.generations=50. Files are relative to this file. docs/configuration.md says \
                 where each default is from."
            )
        );
        let robot = self.shipped();
        let is_described =
            |key: &str| robot.is_some_and(|robot| key == PRESET || robot.has(key.trim_start_matches("robot.")));
        let mut table = "";
        for entry in &entries {
            let (own, name) = entry.place();
            // Elements are in the line of their list; hashes of files are added by runs.
            if entry.key.contains("[]") || entry.key == "files" {
                continue;
            }
            if own != table {
                text += &self.rest(table, robot);
                text.extend(["\n[", own, "]\n"]);
                table = own;
            }
            let is_of_robot = own == "robot" && is_described(entry.key);
            // A part's values have a separate table.
            let is_of_part = name == "values" && self.parts.iter().any(|(kind, _)| kind.word() == own);
            if is_of_robot || is_of_part {
                continue;
            }
            text += &comment(&entry.words());
            match set(entry.key) {
                Some(line) => text.extend([name, " = ", &line.value, "\n"]),
                None => text += &entry.line(&entries),
            }
        }
        text + &self.rest(table, robot)
    }

    /// What follows the keys of a table: a parametric robot's numbers, and the values that a custom part declares, as comments.
    fn rest(&self, table: &str, robot: Option<Shipped>) -> String {
        if let Some(robot) = robot.filter(|_| table == "robot") {
            let lines = robot.text.lines().filter(|line| *line != "[robot]");
            // Robots of a swarm collide by `contact`.
            let is_swarm = matches!(self.robots, Robots::Swarm(_));
            let lines = lines.filter(|line| !(is_swarm && line.starts_with("collision = ")));
            return lines.fold("\n".to_owned(), |text, line| text + line + "\n");
        }
        let Some((kind, file)) = self.parts.iter().find(|(kind, _)| kind.word() == table) else {
            return String::new();
        };
        let values = self.values(*kind);
        if values.is_empty() {
            return String::new();
        }
        let value = |value: &compose::Value| {
            let compose::Value {
                name,
                default,
                allowed,
                unit,
                about,
            } = value;
            let space = if unit.is_empty() { "" } else { " " };
            format!("# {name} = {default:?} # {allowed}{space}{unit}: {about}\n")
        };
        let values: String = values.iter().map(value).collect();
        let head = comment(&format!("Values that {file} declares, with their defaults."));
        format!("\n[{table}.values]\n{head}{values}")
    }

    /// The values that the part of a kind declares.
    fn values(&self, kind: compose::Kind) -> Vec<compose::Value> {
        let part = compose::Part::new(kind, "part.wgsl", self.part(kind));
        part.map(|part| part.values().to_vec()).unwrap_or_default()
    }

    /// The task that is copied: that after which the task's file is called.
    fn ready(&self) -> Option<&'static Ready> {
        let (_, file) = self.parts.iter().find(|(kind, _)| *kind == compose::Kind::Task)?;
        Ready::named(file.strip_suffix(".wgsl")?).filter(|_| !matches!(self.robots, Robots::Forager))
    }

    /// The text of a part's file, in WGSL.
    pub fn part(&self, kind: compose::Kind) -> &'static str {
        if let Some(ready) = self.ready().filter(|_| kind == compose::Kind::Task) {
            return ready.text;
        }
        match (kind, self.robots) {
            (compose::Kind::Sensor, _) => include_str!("parts/sensor.wgsl"),
            (compose::Kind::Controller, _) => include_str!("parts/controller.wgsl"),
            (compose::Kind::Task, Robots::Forager) => include_str!("parts/forager_task.wgsl"),
            (compose::Kind::Task, Robots::Swarm(_)) => include_str!("parts/mission.wgsl"),
            (compose::Kind::Task, _) => include_str!("parts/task.wgsl"),
        }
    }
}

/// Formats text as lines of a comment.
fn comment(words: &str) -> String {
    const WIDTH: usize = 118;
    let mut lines = String::new();
    let mut line = String::new();
    for word in words.split(' ') {
        if !line.is_empty() && line.len() + 1 + word.len() > WIDTH {
            lines.extend(["# ", &line, "\n"]);
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    lines + &format!("# {line}\n")
}
