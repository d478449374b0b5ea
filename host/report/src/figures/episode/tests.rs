use oneiro::arena::{Light, Obstacle};
use oneiro::automode::{Behaviour, Condition, Machine, MachineState, Modules, Transition};
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::differential::{Differential, Genomes, Sensor, SensorKind};
use oneiro::evaluator::{Control, Evaluator as _};
use oneiro::random::Key;
use oneiro::reference::{Model, Reference};
use oneiro::world::{Controller, Robot, WorldSpec};

use super::super::browser;
use super::*;
use crate::bundle::typed_keys;

pub(super) const CYCLES: u32 = 60;

/// An episode, and a page's other data for it.
pub(super) struct Life {
    pub(super) world: World,
    pub(super) robots: Vec<Trace>,
    earned: Vec<Vec<f32>>,
    genome: Vec<f32>,
}

impl Life {
    pub(super) fn of(spec: WorldSpec, genes: &[f32]) -> Self {
        let world = World::new(spec).unwrap();
        let world = match world.robots() {
            1 => world,
            _ => world.observed().unwrap(),
        };
        let life = Rollout {
            world: 0,
            genes,
            key: Key::rollout(4, 0, 0, 0),
        };
        let batch = Batch::new(std::slice::from_ref(&world), &[life], Some(TraceRequest { every: 1 })).unwrap();
        let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
        let robots = outcome.traces[0].by_robot(world.robots());
        // A robot's earnings after line N: made up.
        let earned = |robot: usize| (0..robots[0].len()).map(|line| (line * (robot + 1)) as f32).collect();
        Self {
            earned: (0..robots.len()).map(earned).collect(),
            genome: genes.to_vec(),
            world,
            robots,
        }
    }

    /// Twelve e-pucks that explore until they are on black, and stop there for a while.
    /// One Khepera, all of whose genes have this value.
    fn khepera(gene: f32) -> Self {
        let spec = WorldSpec {
            cycles: CYCLES,
            ..WorldSpec::miglino1995()
        };
        Self::of(spec, &[gene; 18])
    }

    fn machines() -> Self {
        let to = |condition| Transition { to: 0, condition };
        let machine = Machine {
            states: vec![
                MachineState {
                    behaviour: Behaviour::Exploration { turning: 10 },
                    transitions: vec![to(Condition::BlackFloor(0.9))],
                },
                MachineState {
                    behaviour: Behaviour::Stop,
                    transitions: vec![to(Condition::BlackFloor(0.1))],
                },
            ],
        };
        Self::of(epucks(Model::Vectors, 12), &machine.genome())
    }

    pub(super) fn replay(&self) -> EpisodeReplay<'_> {
        let robots = 0..self.world.robots();
        EpisodeReplay {
            title: "a <life>",
            world: &self.world,
            cycles: self.world.cycles(),
            robots: self.robots.clone(),
            compared: Compared::Nothing,
            every: 1,
            earned: self.earned.clone(),
            genes: robots.map(|robot| &self.genome[self.world.genes_of(robot)]).collect(),
        }
    }

    pub(super) fn page(&self) -> String {
        episode_page(&self.replay())
    }

    pub(super) fn word(&self, robot: usize, line: usize, kind: DetailKind, name: &str) -> u32 {
        let mut details = self.world.details().iter();
        let place = details
            .position(|detail| detail.kind == kind && detail.name == name)
            .unwrap();
        self.robots[robot].details(line)[place]
    }
}

/// E-pucks by a reference model in an arena that has everything.
pub(super) fn epucks(model: Model, count: u32) -> WorldSpec {
    let mut arena = Arena::polygon(
        &[
            [-700.0, -600.0],
            [700.0, -600.0],
            [800.0, 0.0],
            [700.0, 600.0],
            [-700.0, 600.0],
        ],
        None,
    );
    arena.floor = Some(0.5);
    arena.wall_height = Some(80.0);
    let round = |x, radius, grey| Patch {
        x,
        y: 0.0,
        radius: Some(radius),
        grey,
        ..Patch::default()
    };
    arena.patches = vec![round(-300.0, 250.0, 0.0), round(300.0, 250.0, 1.0)];
    arena.obstacles = vec![Obstacle {
        x: 0.0,
        y: 300.0,
        radius: 60.0,
        class: "round".into(),
    }];
    arena.lights = vec![Light {
        x: 0.0,
        y: -700.0,
        height: Some(750.0),
        intensity: Some(5.0),
        ..Light::default()
    }];
    let controller = match model {
        Model::Vectors => Controller::StateMachine(Modules::DEFAULT),
        _ => Controller::Perceptron,
    };
    WorldSpec {
        robot: Robot {
            body_radius: 35.0,
            build: Build::Differential(Differential {
                count: Some(count),
                model: Some(model),
                reference: Reference::DEFAULT,
                ..Differential::new(53.0, 120.0)
            }),
            ..Robot::khepera()
        },
        arena,
        controller,
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

/// Red, green and blue of a colour as `#rrggbb`.
fn channels(colour: &str) -> [u8; 3] {
    [1, 3, 5].map(|at| u8::from_str_radix(&colour[at..at + 2], 16).unwrap())
}

#[test]
fn a_browser_draws_robots_in_place_and_shows_what_the_followed_one_reads() {
    let life = Life::machines();
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const soon = () => new Promise((then) => setTimeout(then, 100));\n\
        const drawn = [0, 3.1, 5.9, 2.05].map(window.oneiro.drawn);\n\
        window.oneiro.drawn(4);\n\
        const told = () => ({ robot: at('robot').textContent, fitness: at('light').textContent,\n\
            names: [...at('readings').querySelectorAll('dt')].map((node) => node.textContent),\n\
            values: [...at('readings').querySelectorAll('dd')].map((node) => node.textContent),\n\
            hears: [...document.querySelectorAll('td.hears')].map((node) => node.textContent),\n\
            scores: [...document.querySelectorAll('td.score')].map((node) => node.textContent) });\n\
        const shown = [told()];\n\
        document.querySelectorAll('.who')[7].click(); await soon(); shown.push(told());\n\
        const box = at('arena').getBoundingClientRect();\n\
        const [x, y] = window.oneiro.shown(3);\n\
        at('arena').dispatchEvent(new MouseEvent('click', { clientX: box.left + x, clientY: box.top + y }));\n\
        await soon(); shown.push(told());\n\
        document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' })); await soon(); shown.push(told());\n\
        const before = at('arena').toDataURL(); at('trails').click(); await soon();\n\
        const trails = at('arena').toDataURL() !== before; at('trails').click(); await soon();\n\
        const back = at('arena').toDataURL() === before; at('messages').click(); await soon();\n\
        const messages = at('arena').toDataURL() !== before;\n\
        const legend = [...at('legend').children].map((node) => node.textContent);\n\
        return { drawn, shown, trails, back, messages, legend, title: document.title };";
    let Some(told) = browser::told("mission", &life.page(), ask) else {
        return;
    };
    assert_eq!(told["title"], "a <life>");
    assert_eq!(told["legend"], json!(["0 exploration", "1 stop", "hears now", "lamp"]));
    assert_eq!([&told["trails"], &told["back"], &told["messages"]], [true, true, true]);

    let near = |value: &Value, expected: f64, most: f64| {
        let value = value.as_f64().unwrap();
        assert!((value - expected).abs() <= most, "{value}, not {expected}");
    };
    let mut colours = std::collections::BTreeSet::new();
    for (at, line) in told["drawn"].as_array().unwrap().iter().zip([0, 31, 59]) {
        let robots = at["robots"].as_array().unwrap();
        assert_eq!(robots.len(), 12);
        for (robot, drawn) in robots.iter().enumerate() {
            let record = &life.robots[robot][line];
            // Half a step of packing, plus the canvas's rounding.
            near(&drawn["x"], f64::from(record.x), 0.055);
            near(&drawn["y"], f64::from(record.y), 0.055);
            let off = (drawn["heading"].as_f64().unwrap() - f64::from(record.heading)).rem_euclid(1.0);
            assert!(off.min(1.0 - off) < 1e-5);
            let state = life.word(robot, line, DetailKind::Memory(Kind::Controller), "state");
            // Near its rim the pixel may have a little of that.
            let [seen, expected] = [drawn["colour"].as_str().unwrap(), COLOURS[state as usize]].map(channels);
            let off = seen
                .iter()
                .zip(expected)
                .map(|(one, other)| one.abs_diff(other))
                .max()
                .unwrap();
            assert!(off < 16, "robot {robot}, line {line}: {seen:?}, not {expected:?}");
            colours.insert(state);
        }
    }
    assert_eq!(colours.len(), 2, "robots are in both states");
    let between = &told["drawn"][3]["robots"][5];
    let [from, to] = [20, 21].map(|line| &life.robots[5][line]);
    near(&between["x"], 0.5 * f64::from(from.x + to.x), 0.11);

    let line = 40;
    for (shown, robot) in told["shown"].as_array().unwrap().iter().zip([0, 7, 3]) {
        let names = shown["names"].as_array().unwrap();
        let remembered = life
            .world
            .details()
            .iter()
            .filter(|detail| matches!(detail.kind, DetailKind::Memory(_)));
        assert_eq!(names.len(), 8 + 2 + remembered.count());
        let values: Vec<f64> = shown["values"]
            .as_array()
            .unwrap()
            .iter()
            .map(|text| text.as_str().unwrap().parse().unwrap())
            .collect();
        for (name, value) in names.iter().zip(&values).take(8) {
            let perceived = f32::from_bits(life.word(robot, line, DetailKind::Perceived, name.as_str().unwrap()));
            // Half a step of packing in a span of up to 20, and the rounding to three decimals.
            assert!(
                (value - f64::from(perceived)).abs() < 7e-4,
                "robot {robot}, {name}: {value}, not {perceived}"
            );
        }
        assert!((values[8] - f64::from(life.robots[robot][line].speed_left)).abs() < 6e-4);
        let heard = life.word(robot, line, DetailKind::Heard, "heard_0");
        let state = life.word(robot, line, DetailKind::Memory(Kind::Controller), "state") as usize;
        let others: Vec<String> = (0..12)
            .filter(|other| heard >> other & 1 == 1)
            .map(|other| other.to_string())
            .collect();
        let others = if others.is_empty() {
            "nobody".to_owned()
        } else {
            format!("robot {}", others.join(", "))
        };
        assert_eq!(
            shown["robot"],
            format!("Robot {robot}: {}; hears {others}", ["0 exploration", "1 stop"][state])
        );
        assert_eq!(shown["hears"][robot], heard.count_ones().to_string());
        assert_eq!(shown["scores"][robot], (line * (robot + 1)).to_string());
        let fitness: f32 = shown["fitness"]
            .as_str()
            .unwrap()
            .rsplit(' ')
            .next()
            .unwrap()
            .replace(',', "")
            .parse()
            .unwrap();
        let fitness_there = life.robots[0][line].fitness;
        assert!(
            (fitness - fitness_there).abs() <= 1e-5 * fitness_there.abs(),
            "{fitness}, not {fitness_there}"
        );
    }
    let nobody = &told["shown"][3];
    assert!(nobody["robot"].as_str().unwrap().starts_with("Click a robot"));
    assert!(nobody["values"].as_array().unwrap().iter().all(|value| value == ""));
}

#[test]
fn robots_without_messages_and_machines_have_a_page() {
    let eye = Sensor {
        name: "eye".into(),
        kind: SensorKind::Proximity,
        range: Some(60.0),
        ..Sensor::default()
    };
    let mut spec = epucks(Model::Vectors, 3);
    spec.robot.build = Build::Differential(Differential {
        count: Some(3),
        sensors: vec![eye],
        ..Differential::new(53.0, 120.0)
    });
    spec.controller = Controller::Perceptron;
    spec.arena = Arena::rectangle(500.0, 400.0);
    let genes = vec![0.5; World::new(spec.clone()).unwrap().genes()];
    let life = Life::of(spec, &genes);
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        window.oneiro.drawn(1);\n\
        return { robot: at('robot').textContent, legend: at('legend').children.length,\n\
            messages: at('messages').parentElement.hidden, heads: at('robots').rows[0].textContent,\n\
            note: at('note').textContent };";
    let Some(told) = browser::told("mission-plain", &life.page(), ask) else {
        return;
    };
    assert_eq!(
        told,
        json!({ "robot": "Robot 0", "legend": 0, "messages": true, "heads": "RobotScore", "note": "" })
    );
}

/// The saved drawing shows what the canvas shows.
#[test]
fn a_moment_is_saved_as_a_drawing() {
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        let saved = null;\n\
        URL.createObjectURL = (blob) => { saved = blob; return '#'; };\n\
        at('sensors').checked = true;\n\
        await new Promise((then) => setTimeout(then, 200));\n\
        window.oneiro.drawn(3);\n\
        at('save-drawing').click();\n\
        const text = await saved.text();\n\
        const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');\n\
        const image = new Image();\n\
        await new Promise((then, no) => { image.onload = then; image.onerror = no;\n\
            image.src = 'data:image/svg+xml,' + encodeURIComponent(text); });\n\
        const arena = at('arena');\n\
        const sizes = [image.width, image.height, arena.width, arena.height];\n\
        const pixels = (source) => { const own = document.createElement('canvas'); own.width = arena.width; own.height = arena.height;\n\
            const pen = own.getContext('2d'); pen.drawImage(source, 0, 0, own.width, own.height);\n\
            return pen.getImageData(0, 0, own.width, own.height).data; };\n\
        const [drawing, canvas] = [image, arena].map(pixels);\n\
        let other = 0;\n\
        for (let i = 0; i < canvas.length; i += 4) {\n\
            other += [0, 1, 2].some((part) => Math.abs(canvas[i + part] - drawing[i + part]) > 40) ? 1 : 0;\n\
        }\n\
        return { broken: parsed.querySelector('parsererror') !== null, title: parsed.querySelector('title').textContent,\n\
            circles: (text.match(/A[\\d.]+ /g) || []).length, other: other / (canvas.length / 4), sizes };";
    let Some(told) = browser::told("episode-drawing", &Life::machines().page(), ask) else {
        return;
    };
    assert_eq!(told["broken"], false);
    assert_eq!(told["title"], "a <life>");
    // At least twelve robots.
    assert!(told["circles"].as_u64().unwrap() >= 24, "{told}");
    // Edges of text differ.
    assert!(told["other"].as_f64().unwrap() < 0.005, "{told}");
}

#[test]
fn a_single_robot_has_a_page_with_its_sensors() {
    let life = Life::khepera(0.5);
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const soon = () => new Promise((then) => setTimeout(then, 100));\n\
        const drawn = window.oneiro.drawn(3);\n\
        const picture = () => at('arena').toDataURL();\n\
        const before = picture(); at('sensors').click(); await soon();\n\
        const sensors = picture() !== before;\n\
        const fitness = at('chart').getAttribute('aria-label');\n\
        at('charted').selectedIndex = 3; at('charted').dispatchEvent(new Event('change')); await soon();\n\
        return { drawn, sensors, fitness, chart: at('chart').getAttribute('aria-label'), each: at('each').hidden,\n\
            speed: at('speed').value, trails: at('trails').checked,\n\
            names: [...at('readings').querySelectorAll('dt')].map((node) => node.textContent),\n\
            values: [...at('readings').querySelectorAll('dd')].map((node) => Number(node.textContent)) };";
    let Some(told) = browser::told("episode-alone", &life.page(), ask) else {
        return;
    };
    assert_eq!(told["names"].as_array().unwrap()[..8], SENSOR_NAMES.map(Value::from));
    for (sensor, value) in told["values"].as_array().unwrap()[..8].iter().enumerate() {
        let word = life.word(0, 30, DetailKind::Perceived, &sensor.to_string());
        assert!(
            (value.as_f64().unwrap() - f64::from(f32::from_bits(word))).abs() < 7e-4,
            "sensor {sensor}"
        );
    }
    assert_eq!([&told["sensors"], &told["each"], &told["trails"]], [true, true, true]);
    assert!(
        told["fitness"]
            .as_str()
            .unwrap()
            .starts_with("Fitness over time, 0 to ")
    );
    assert!(told["chart"].as_str().unwrap().starts_with("left_10 over time, 0 to "));
    // Six seconds.
    assert_eq!(told["speed"], "1\u{d7}");
    let (drawn, record) = (&told["drawn"]["robots"][0], &life.robots[0][30]);
    assert!((drawn["x"].as_f64().unwrap() - f64::from(record.x)).abs() < 0.055);
}

#[test]
fn bests_of_generations_are_on_one_page() {
    let lives = [0.5, -0.25].map(Life::khepera);
    let robots = lives.each_ref().map(|life| life.robots[0].clone());
    let genes = lives.each_ref().map(|life| &*life.genome);
    let page = episode_page(&EpisodeReplay {
        robots: robots.to_vec(),
        compared: Compared::Generations(&[0, 30]),
        earned: Vec::new(),
        genes: genes.to_vec(),
        ..lives[0].replay()
    });
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const drawn = window.oneiro.drawn(3);\n\
        return { drawn, light: at('light').textContent, heads: at('robots').rows[0].textContent,\n\
            legend: [...at('legend').children].map((node) => node.textContent),\n\
            scores: [...document.querySelectorAll('td.score')].map((node) => Number(node.textContent)) };";
    let Some(told) = browser::told("episode-generations", &page, ask) else {
        return;
    };
    assert_eq!(told["legend"], json!(["generation 0", "generation 30"]));
    assert_eq!(told["heads"], "GenerationScore");
    assert!(told["light"].as_str().unwrap().starts_with("Generation 30: fitness if"));
    for (index, trace) in robots.iter().enumerate() {
        let drawn = &told["drawn"]["robots"][index];
        assert_eq!(drawn["name"], [0, 30][index]);
        assert!((drawn["x"].as_f64().unwrap() - f64::from(trace[30].x)).abs() < 0.055);
        let score = told["scores"][index].as_f64().unwrap();
        assert!(
            (score - f64::from(trace[30].fitness)).abs() <= 1e-5 * score.abs(),
            "{score}"
        );
    }
}

#[test]
fn robots_of_two_realities_are_on_one_page_by_name() {
    let life = Life::khepera(0.5);
    let robots = [life.robots[0].clone(), life.robots[0].clone()];
    let page = episode_page(&EpisodeReplay {
        robots: robots.to_vec(),
        compared: Compared::Realities(&["simulator", "surrogate"]),
        earned: Vec::new(),
        genes: vec![&life.genome; 2],
        ..life.replay()
    });
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const soon = () => new Promise((then) => setTimeout(then, 100));\n\
        const drawn = window.oneiro.drawn(3).robots.map((robot) => robot.name);\n\
        document.querySelectorAll('.who')[0].click(); await soon();\n\
        return { drawn, light: at('light').textContent, heads: at('robots').rows[0].textContent,\n\
            buttons: [...document.querySelectorAll('.who')].map((node) => node.textContent),\n\
            titles: ['robot', 'diagram-title', 'readings-title', 'robots-title', 'said'].map((id) => at(id).textContent),\n\
            legend: [...at('legend').children].map((node) => node.textContent) };";
    let Some(told) = browser::told("episode-realities", &page, ask) else {
        return;
    };
    let names = json!(["simulator", "surrogate"]);
    assert_eq!(
        [&told["drawn"], &told["buttons"], &told["legend"]],
        [&names, &names, &names]
    );
    assert_eq!(told["heads"], "RobotScore");
    assert!(told["light"].as_str().unwrap().starts_with("The simulator: fitness if"));
    let titles = [
        "The simulator",
        "The simulator computes",
        "The simulator reads",
        "Robots",
        "Following the simulator.",
    ];
    assert_eq!(told["titles"], json!(titles));
}

#[test]
fn swarms_of_several_generations_take_turns_on_a_page() {
    let stops = Machine {
        states: vec![MachineState {
            behaviour: Behaviour::Stop,
            transitions: Vec::new(),
        }],
    };
    let lives = [Life::machines(), Life::of(epucks(Model::Vectors, 12), &stops.genome())];
    let robots: Vec<Trace> = lives.iter().flat_map(|life| life.robots.clone()).collect();
    let earned: Vec<_> = lives.iter().flat_map(|life| life.earned.clone()).collect();
    let genes = lives.iter().flat_map(|life| life.replay().genes).collect();
    let page = episode_page(&EpisodeReplay {
        robots,
        compared: Compared::Generations(&[3, 40]),
        earned,
        genes,
        ..lives[0].replay()
    });
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const soon = () => new Promise((then) => setTimeout(then, 100));\n\
        const texts = (what) => [...document.querySelectorAll(what)]\n\
            .filter((node) => !node.closest('tr').hidden).map((node) => node.textContent);\n\
        const told = (time) => ({ drawn: window.oneiro.drawn(time).robots, fitness: at('light').textContent,\n\
            hears: texts('td.hears'), scores: texts('td.score'), robot: at('robot').textContent,\n\
            numbers: texts('#robots .who'), boxes: document.querySelectorAll('#diagram .box').length,\n\
            pressed: [...at('worlds').children].map((button) => button.getAttribute('aria-pressed')) });\n\
        document.querySelectorAll('#robots .who')[12 + 5].click(); await soon();\n\
        const last = told(5.9);\n\
        const [first, second] = at('worlds').children; first.click(); await soon();\n\
        const box = at('arena').getBoundingClientRect();\n\
        const [x, y] = window.oneiro.shown(7);\n\
        const others = told(5.9);\n\
        at('arena').dispatchEvent(new MouseEvent('click', { clientX: box.left + x, clientY: box.top + y })); await soon();\n\
        return { last, others, clicked: at('robot').textContent, lead: document.querySelector('.lead').textContent,\n\
            worlds: [...at('worlds').children].map((button) => button.textContent) };";
    let Some(told) = browser::told("episode-swarms", &page, ask) else {
        return;
    };
    assert_eq!(told["worlds"], json!(["3", "40"]));
    assert!(
        told["lead"]
            .as_str()
            .unwrap()
            .starts_with("The bests of 2 generations, each with 12 robots in one world,")
    );
    for (shown, world) in [("last", 1), ("others", 0)] {
        let (shown, life) = (&told[shown], &lives[world]);
        assert_eq!(
            shown["pressed"],
            json!([world == 0, world == 1].map(|own| own.to_string()))
        );
        let fitness = format!(
            "Generation {}: fitness if the episode ended now: {}",
            [3, 40][world],
            life.robots[0][59].fitness
        );
        assert_eq!(shown["fitness"], fitness);
        assert_eq!(shown["boxes"], [2, 1][world], "states of its machine");
        assert_eq!(
            shown["numbers"],
            json!((0..12).map(|robot| robot.to_string()).collect::<Vec<_>>())
        );
        let drawn = shown["drawn"].as_array().unwrap();
        assert_eq!(drawn.len(), 12);
        let mut heard = 0;
        for (robot, drawn) in drawn.iter().enumerate() {
            assert_eq!(drawn["name"], robot);
            assert!((drawn["x"].as_f64().unwrap() - f64::from(life.robots[robot][59].x)).abs() < 0.055);
            let hears = life.word(robot, 59, DetailKind::Heard, "heard_0");
            assert_eq!(shown["hears"][robot], hears.count_ones().to_string());
            assert_eq!(shown["scores"][robot], (59 * (robot + 1)).to_string());
            heard += hears.count_ones();
        }
        assert!(heard > 0);
        // The followed robot is the same in the other world.
        assert!(shown["robot"].as_str().unwrap().starts_with("Robot 5: "), "{shown}");
    }
    assert!(told["clicked"].as_str().unwrap().starts_with("Robot 7: "));
}

#[test]
fn the_script_has_types_of_all_facts() {
    let life = Life::khepera(0.5);
    let keys: Vec<_> = life.replay().facts().into_keys().collect();
    assert_eq!(keys, typed_keys(&["PoseFacts", "RobotFacts", "EpisodeOnly"]));
}

#[test]
fn robots_with_machines_of_their_own_show_the_states_of_all() {
    let mut spec = epucks(Model::Vectors, 3);
    if let Build::Differential(differential) = &mut spec.robot.build {
        differential.genomes = Genomes::Teams(vec![1, 0, 1]);
    }
    let state = |behaviour, transitions| MachineState { behaviour, transitions };
    let leave = Transition {
        to: 0,
        condition: Condition::FixedProbability(0.5),
    };
    let stops = Machine {
        states: vec![state(Behaviour::Stop, Vec::new())],
    };
    let alternates = Machine {
        states: vec![
            state(Behaviour::Phototaxis, vec![leave]),
            state(Behaviour::Stop, vec![leave]),
        ],
    };
    let genes = [alternates.genome(), stops.genome()].concat();
    let life = Life::of(spec, &genes);
    let replay = life.replay();
    let acts = replay.facts().remove("acts").unwrap();
    let names: Vec<&str> = acts
        .as_array()
        .unwrap()
        .iter()
        .map(|state| state["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["0 stop", "0 phototaxis", "1 stop"]);
    let states = replay.machine_states();
    let of =
        |robot: usize| -> std::collections::BTreeSet<u16> { states.iter().skip(robot).step_by(3).copied().collect() };
    assert_eq!([of(0), of(1), of(2)], [[0].into(), [1, 2].into(), [0].into()]);
}

#[test]
fn a_page_needs_nothing_else_and_twenty_robots_for_two_minutes_fit_in_five_megabytes() {
    let spec = epucks(Model::Rm11, 20);
    let genes = vec![0.5; World::new(spec.clone()).unwrap().genes()];
    let mut life = Life::of(spec, &genes);
    for trace in &mut life.robots {
        let short = trace.clone();
        (1..20).for_each(|_| trace.append(&short));
        assert_eq!(trace.len(), 1200);
    }
    life.earned = vec![vec![0.0; 1200]; 20];
    let page = life.page();
    let record = bytes_of_record(&life.world) as f64;
    assert!(
        (page.len() as f64) < 60_000.0 + 1.01 * record * 1200.0 * 20.0,
        "{}",
        page.len()
    );
    assert!(page.len() < 5_000_000, "{}", page.len());
    // Drawings name their own parts.
    let outside = page.replace("url(#", "");
    for reference in ["http", "//cdn", " src=", "@import", "url(", "fetch(", "import(", "{{"] {
        assert!(!outside.contains(reference), "{reference}");
    }
}
