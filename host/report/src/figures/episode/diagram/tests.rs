use oneiro::automode::{Branch, Crowd, MachineState, Modules, Transition};
use oneiro::compose::{DetailKind, Kind};
use oneiro::differential::{Build, Differential, Sensor, SensorKind};
use oneiro::network::Network;
use oneiro::reference::Model;
use oneiro::world::{Robot, WorldSpec};

use super::super::super::browser;
use super::super::tests::{CYCLES, Life, epucks};
use super::*;

/// A robot without noise, so that its wheels have the commanded speeds.
fn exact(controller: Controller) -> WorldSpec {
    let eye = |name: &str, heading| Sensor {
        name: name.into(),
        kind: SensorKind::Proximity,
        range: Some(150.0),
        heading,
        ..Sensor::default()
    };
    let build = Differential {
        sensors: vec![eye("left_eye", 0.1), eye("right_eye", -0.1)],
        ..Differential::new(53.0, 120.0)
    };
    WorldSpec {
        robot: Robot {
            build: Build::Differential(build),
            ..Robot::khepera()
        },
        controller,
        cycles: CYCLES,
        ..WorldSpec::miglino1995()
    }
}

/// Different genes, from -3 to 3.
fn genes(spec: &WorldSpec) -> Vec<f32> {
    let count = World::new(spec.clone()).unwrap().genes();
    (0..count).map(|index| (index * 7 % 13) as f32 / 2.0 - 3.0).collect()
}

fn layer(kind: LayerKind, units: u32) -> Layer {
    Layer {
        kind,
        units,
        ..Layer::default()
    }
}

/// Networks of all kinds.
fn networks() -> [Controller; 8] {
    let tanh = Some(Activation::Tanh);
    [
        Controller::Perceptron,
        Controller::Hidden { units: 3 },
        Controller::Recurrent,
        Controller::Network(Network {
            activation: Some(Activation::Linear),
            slope: Some(0.5),
            interleaved: Some(true),
            ..Network::default()
        }),
        Controller::Network(Network {
            layers: vec![
                layer(LayerKind::Lstm, 2),
                layer(LayerKind::Ctrnn, 3),
                Layer {
                    activation: Some(Activation::Relu),
                    slope: Some(0.3),
                    biases: Some(false),
                    ..layer(LayerKind::Dense, 4)
                },
            ],
            activation: tanh,
            ..Network::default()
        }),
        Controller::Network(Network {
            layers: vec![layer(LayerKind::Lstm, 3)],
            activation: tanh,
            ..Network::default()
        }),
        Controller::Network(Network {
            layers: vec![Layer {
                activation: tanh,
                ..layer(LayerKind::Elman, 3)
            }],
            outputs: Some(Outputs::FirstTwo),
            ..Network::default()
        }),
        Controller::Network(Network {
            layers: vec![layer(LayerKind::Plastic, 3)],
            activation: tanh,
            ..Network::default()
        }),
    ]
}

#[test]
fn a_browser_computes_the_speeds_that_wheels_had() {
    for (index, controller) in networks().into_iter().enumerate() {
        let spec = exact(controller);
        let life = Life::of(spec.clone(), &genes(&spec));
        let ask = "\
            const at = (id) => document.getElementById(id);\n\
            const told = (node) => {\n\
                node.dispatchEvent(new PointerEvent('pointerover', { bubbles: true })); return at('diagram-told').textContent; };\n\
            const outputs = () => [...document.querySelectorAll('#diagram .node')]\n\
                .filter((node) => ['left', 'right'].includes(node.lastElementChild.textContent)).map(told);\n\
            const filled = () => [...document.querySelectorAll('#diagram .node > :nth-child(2)')]\n\
                .map((disc) => [disc.getAttribute('class'), Number(disc.getAttribute('fill-opacity'))]);\n\
            return [0, 1.5, 4.2].map((time) => { window.oneiro.drawn(time); return [outputs(), filled()]; });";
        let Some(told) = browser::told(&format!("network-{index}"), &life.page(), ask) else {
            return;
        };
        let is_tanh = |told: &str| index > 2 || told.contains("speed");
        for (at, line) in told.as_array().unwrap().iter().zip([0, 15, 42]) {
            let record = &life.robots[0][line];
            let outputs = at[0].as_array().unwrap();
            assert_eq!(outputs.len(), 2, "{index}");
            for (output, speed) in outputs.iter().zip([record.speed_left, record.speed_right]) {
                let output = output.as_str().unwrap();
                let value: f64 = output.rsplit(' ').next().unwrap().parse().unwrap();
                let commanded = if is_tanh(output) {
                    value.clamp(-1.0, 1.0)
                } else {
                    2.0 * value - 1.0
                };
                assert!(
                    (commanded - f64::from(speed)).abs() < 3e-3,
                    "{index}, line {line}: {output}, not {speed}"
                );
                let is_filled = |disc: &Value| {
                    let sign = if speed < 0.0 { "minus" } else { "plus" };
                    disc[0] == sign && (disc[1].as_f64().unwrap() - f64::from(speed.abs())).abs() < 0.008
                };
                assert!(
                    at[1].as_array().unwrap().iter().any(is_filled),
                    "{index}, line {line}: {speed}"
                );
            }
        }
    }
}

/// A synapse that learns is as wide as its weight at the time, and says its strength.
#[test]
fn a_browser_shows_strengths_as_they_are_learnt() {
    let spec = exact(Controller::Network(Network {
        layers: vec![Layer {
            initial_strengths: Some([0.2, 0.9]),
            ..layer(LayerKind::Plastic, 2)
        }],
        ..Network::default()
    }));
    let mut genes = genes(&spec);
    genes.fill(1.0);
    let life = Life::of(spec, &genes);
    let ask = "\
        const line = document.querySelector('#diagram .line');\n\
        const told = () => {\n\
            line.dispatchEvent(new PointerEvent('pointerover', { bubbles: true }));\n\
            return document.getElementById('diagram-told').textContent; };\n\
        return [0, 4.2].map((time) => { window.oneiro.drawn(time); return [Number(line.getAttribute('stroke-width')), told()]; });";
    let Some(told) = browser::told("network-learns", &life.page(), ask) else {
        return;
    };
    let [first, later] = [0, 1].map(|at| {
        let said = told[at][1].as_str().unwrap();
        assert!(
            said.starts_with("left_eye to layer_0_unit_0: 1.000 by the covariance rule, rate 1.000, times strength "),
            "{said}"
        );
        let strength: f64 = said.rsplit(' ').next().unwrap().parse().unwrap();
        let width = told[at][0].as_f64().unwrap();
        // Lines are from 0.3 to 5 wide, here of the weights 0 and 1.
        assert!((width - (0.3 + 4.7 * strength)).abs() < 0.01, "{width}, {said}");
        strength
    });
    assert!((first - later).abs() > 0.05, "{first}, {later}");
}

/// The diagram of a controller in its world.
fn of(spec: &WorldSpec, genes: &[f32]) -> Option<Value> {
    let life = Life::of(spec.clone(), genes);
    let facts = life.replay().facts();
    assert_eq!(
        facts["diagram"].as_array().unwrap().len(),
        facts["diagrams"].as_array().unwrap().len()
    );
    facts["diagrams"].get(0).cloned()
}

#[test]
fn a_networks_lines_have_all_weights() {
    for controller in networks() {
        let spec = exact(controller);
        let drawn = of(&spec, &genes(&spec)).unwrap();
        let lines = drawn["lines"].as_array().unwrap().iter();
        // A synapse that learns has a rule and a rate.
        let genes_of =
            |line: &Value| line["weights"].as_array().unwrap().len() + if line["learns"].is_null() { 0 } else { 2 };
        let weights: usize = lines.map(genes_of).sum();
        let nodes = drawn["nodes"].as_array().unwrap().iter();
        let times = nodes.filter(|node| node["name"].as_str().unwrap().contains("time constant"));
        assert_eq!(weights + times.count(), genes(&spec).len());
    }
    // 0.1 s (5 s / 0.1 s)^0.5
    let mut spec = exact(Controller::Network(Network {
        layers: vec![layer(LayerKind::Ctrnn, 1)],
        ..Network::default()
    }));
    let mut genes = genes(&spec);
    genes[4] = 0.5;
    assert_eq!(
        of(&spec, &genes).unwrap()["nodes"][3]["name"],
        "layer_0_unit_0, time constant 0.707 s"
    );
    // Two readings, a bias and two outputs.
    for (units, is_drawn) in [(55, true), (56, false)] {
        spec.controller = Controller::Network(Network {
            layers: vec![layer(LayerKind::Dense, units)],
            ..Network::default()
        });
        assert_eq!(of(&spec, &self::genes(&spec)).is_some(), is_drawn);
    }
}

#[test]
fn a_tree_has_its_branches_conditions_and_behaviours() {
    let branch = |condition, behaviour| Branch { condition, behaviour };
    let crowd = Crowd {
        neighbours: 3,
        steepness: 5.0,
    };
    let tree = Tree {
        branches: vec![
            branch(Condition::WhiteFloor(0.8), Behaviour::Exploration { turning: 20 }),
            branch(
                Condition::InvertedNeighbourCount(crowd),
                Behaviour::Repulsion { strength: 2.5 },
            ),
        ],
    };
    let mut spec = epucks(Model::Vectors, 1);
    spec.controller = Controller::BehaviourTree(Modules::DEFAULT);
    let drawn = of(&spec, &tree.genome()).unwrap();
    assert_eq!(drawn["states"][1], json!(["1 repulsion", "repulsion: strength 2.5"]));
    assert_eq!(
        drawn["conditions"][0],
        json!(["white floor 0.80", "on a white floor with probability 0.8"])
    );
    assert_eq!(drawn["conditions"][1][0], "neighbours < 3");
}

/// A robot that explores, stops, or seeks the light, with two transitions from exploration to the light.
fn wanderer() -> Machine {
    let to = |to, p| Transition {
        to,
        condition: Condition::FixedProbability(p),
    };
    let state = |behaviour, transitions| MachineState { behaviour, transitions };
    Machine {
        states: vec![
            state(
                Behaviour::Exploration { turning: 5 },
                vec![to(0, 0.1), to(1, 0.05), to(1, 0.1)],
            ),
            state(Behaviour::Stop, vec![to(1, 0.2)]),
            state(Behaviour::Phototaxis, vec![to(0, 0.2), to(1, 0.2)]),
        ],
    }
}

#[test]
fn a_browser_fills_the_state_that_acts_and_marks_the_transition_that_was_taken() {
    let life = Life::of(epucks(Model::Vectors, 3), &wanderer().genome());
    let ask = "\
        const at = (id) => document.getElementById(id);\n\
        const words = (node) => {\n\
            node.dispatchEvent(new PointerEvent('pointerover', { bubbles: true })); return at('diagram-told').textContent; };\n\
        const soon = () => new Promise((then) => setTimeout(then, 100));\n\
        const arrows = [...document.querySelectorAll('.arrow')];\n\
        const told = arrows.map((arrow) => words(arrow).split(':')[0]);\n\
        const texts = arrows.map((arrow) => arrow.querySelectorAll('text').length);\n\
        document.querySelectorAll('.who')[2].click(); await soon();\n\
        const boxes = [...document.querySelectorAll('#diagram .box')];\n\
        const lines = [];\n\
        for (let line = 0; line < 60; line++) {\n\
            window.oneiro.drawn(line / 10);\n\
            const filled = boxes.map((box) => box.firstElementChild.style.fill !== '');\n\
            const taken = arrows.findIndex((arrow) => arrow.classList.contains('taken'));\n\
            lines.push([filled, taken < 0 ? '' : told[taken]]);\n\
        }\n\
        document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' })); await soon();\n\
        const idle = boxes.every((box) => box.firstElementChild.style.fill === '');\n\
        return { told, texts, lines, idle, title: at('diagram-title').textContent };";
    let Some(told) = browser::told("machine-diagram", &life.page(), ask) else {
        return;
    };
    let arrows = [
        "0 exploration to 1 stop",
        "0 exploration to 2 phototaxis",
        "1 stop to 2 phototaxis",
        "2 phototaxis to 0 exploration",
        "2 phototaxis to 1 stop",
    ];
    assert_eq!(told["told"], json!(arrows));
    assert_eq!(told["texts"], json!([1, 2, 1, 1, 1]));
    assert_eq!(
        [&told["idle"], &told["title"]],
        [&json!(true), &json!("Robot 0 computes")]
    );
    let names = ["0 exploration", "1 stop", "2 phototaxis"];
    let (mut marked, mut last) = (0, None);
    let state = |line| life.word(2, line, DetailKind::Memory(Kind::Controller), "state") as usize;
    for (line, shown) in told["lines"].as_array().unwrap().iter().enumerate() {
        assert_eq!(shown[0], json!([0, 1, 2].map(|own| own == state(line))), "line {line}");
        if line > 0 && state(line - 1) != state(line) {
            last = Some((line, format!("{} to {}", names[state(line - 1)], names[state(line)])));
        }
        // Six seconds play at normal speed, at which it stays for 0.7 s.
        let taken = last.as_ref().filter(|(since, _)| line - since <= 7);
        assert_eq!(shown[1], taken.map_or("", |(_, arrow)| arrow), "line {line}");
        marked += usize::from(taken.is_some());
    }
    assert!(marked > 10, "{marked} lines with a mark");
}
