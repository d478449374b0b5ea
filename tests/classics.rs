//! Tasks of well-known experiments: rewards in traces beside those of the rules that `docs/classics` gives, written again in
//! double precision.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use oneiro::random::pcg4d;

mod place;
use place::Place;

const GENOMES: usize = 30;

/// A row of a trace.
struct Row {
    /// Pose before the cycle: mm, and the heading in turns.
    pose: [f64; 3],
    /// Mean speed of both wheels, as a share of the greatest.
    speed: f64,
    collided: bool,
    reward: f64,
}

/// Traces of [`GENOMES`] random genomes, one life each, with genes between minus and plus `range`.
fn traces(name: &str, genes: u32, range: f64) -> Vec<Vec<Row>> {
    let place = Place::new(name);
    let mut genomes = String::new();
    for genome in 0..GENOMES as u32 {
        let genes = (0..genes).map(|gene| {
            let [word, ..] = pcg4d([genome, gene, 5, 3]);
            (range * (f64::from(word) / f64::from(u32::MAX) * 2.0 - 1.0)).to_string()
        });
        let _ = writeln!(genomes, "{}", genes.collect::<Vec<_>>().join(","));
    }
    place.write("genomes.csv", genomes);
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../experiments/{name}.toml"));
    let experiment = experiment.display().to_string();
    let checked = place.good(&["check", &experiment]);
    assert!(checked.contains(&format!("; {genes} genes")), "{checked}");
    let evaluated = place.run(&[
        "evaluate",
        &experiment,
        "--genomes",
        "genomes.csv",
        "--trials",
        "1",
        "--seed",
        "1",
        "--traces",
        "traces",
        "--backend",
        "cpu",
    ]);
    evaluated.exits(0).says(&[&format!("{GENOMES} genomes, 1 trial,")]);
    (0..GENOMES)
        .map(|genome| rows(&place.text(format!("traces/trace-{genome}-0.csv"))))
        .collect()
}

fn rows(trace: &str) -> Vec<Row> {
    let mut lines = trace.lines();
    let head: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let numbers = line.split(',').map(|number| number.parse::<f64>().unwrap());
            let row: HashMap<_, _> = head.iter().copied().zip(numbers).collect();
            Row {
                pose: ["x_mm", "y_mm", "heading_turns"].map(|column| row[column]),
                speed: 0.5 * (row["speed_left"] + row["speed_right"]),
                collided: row["collided"] != 0.0,
                reward: row["reward"],
            }
        })
        .collect()
}

/// A cycle near the cylinder earns 1 once the robot has been away from it, and a collision is the last thing in a life.
#[test]
fn discrimination_earns_near_the_cylinder() {
    let (mut earned, mut unearned, mut collisions) = (0, 0, 0);
    for life in traces("discrimination", 742, 1.0) {
        let near = |row: &Row| (row.pose[0] - 200.0).hypot(row.pose[1] - 150.0) < 100.0;
        let mut was_away = !near(&life[0]);
        for cycle in life.windows(2) {
            let near = near(&cycle[1]);
            let expected = near && was_away && !cycle[0].collided;
            assert_eq!(cycle[0].reward, f64::from(u8::from(expected)), "{:?}", cycle[0].pose);
            assert!(!cycle[0].collided, "a life goes on after a collision");
            earned += u32::from(expected);
            unearned += u32::from(near && !was_away);
            was_away |= !near;
        }
        let last = life.last().unwrap();
        assert!(last.collided || life.len() == 500, "a life of {} cycles", life.len());
        collisions += u32::from(last.collided);
    }
    println!("{earned} cycles earn, {unearned} near the cylinder don't; {collisions} lives end by collisions");
    assert!(earned > 100 && unearned > 100 && collisions > 10);
}

/// Distance along a ray in the arena of `wall-following.toml`, at most 120 mm.
fn distance([x, y]: [f64; 2], turns: f64) -> f64 {
    let (sine, cosine) = (turns * std::f64::consts::TAU).sin_cos();
    // Sides of the field and of both blocks: the axis that they are square to, where they are on it, and their ends.
    let sides = [
        (0, 0.0, [0.0, 900.0]),
        (0, 1200.0, [0.0, 900.0]),
        (1, 0.0, [0.0, 1200.0]),
        (1, 900.0, [0.0, 1200.0]),
        (0, 300.0, [0.0, 200.0]),
        (0, 600.0, [0.0, 200.0]),
        (1, 200.0, [300.0, 600.0]),
        (0, 900.0, [600.0, 900.0]),
        (1, 600.0, [900.0, 1200.0]),
    ];
    sides.iter().fold(120.0_f64, |least, &(axis, place, [from, to])| {
        let [(at, along), (other, aside)] = if axis == 0 {
            [(x, cosine), (y, sine)]
        } else {
            [(y, sine), (x, cosine)]
        };
        let far = (place - at) / along;
        let is_hit = far >= 0.0 && (from..=to).contains(&(other + far * aside));
        if is_hit { least.min(far) } else { least }
    })
}

/// A cycle earns the speed forward times how near the wall on the right is to the set distance, and nothing in a collision. A
/// distance that is off by a hundredth of a millimetre is noticed.
#[test]
fn wall_following_earns_speed_at_the_distance() {
    let (mut earned, mut noticed, mut collisions) = (0, 0, 0);
    for life in traces("wall-following", 12, 5.0) {
        for cycle in life.windows(2) {
            let [x, y, heading] = cycle[1].pose;
            let aside = distance([x, y], heading - 0.25);
            let error = |set: f64| {
                let near = (1.0 - (aside - set).abs() / 40.0).max(0.0);
                let earned = near * cycle[0].speed.max(0.0) / 600.0;
                (cycle[0].reward - if cycle[0].collided { 0.0 } else { earned }).abs()
            };
            assert!(error(80.0) < 2e-8, "{} {aside} {}", cycle[0].reward, error(80.0));
            earned += u32::from(cycle[0].reward > 0.0);
            noticed += u32::from(cycle[0].reward > 0.0 && error(80.01) > 2e-8);
            collisions += u32::from(cycle[0].collided);
        }
        assert_eq!(life.len(), 600);
    }
    println!("{earned} cycles earn, of which {noticed} notice; {collisions} collisions");
    assert!(earned > 200 && noticed > 200 && collisions > 200);
}
