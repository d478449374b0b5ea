//! What a cycle costs a GPU, and how many of them cards can do at most.

use oneiro::batch::Worlds;
use oneiro_base::answer::Answer;
use oneiro_base::console::Bars;
use oneiro_base::exit::Result;
use serde::Serialize;

/// A card, and the operations of single lanes that it issues in a second: its lanes times its boost clock.
struct Card {
    name: &'static str,
    lanes: f64,
    /// GHz
    clock: f64,
}

/// Cards by their makers' data sheets.
const CARDS: [Card; 8] = [
    Card::new("NVIDIA H100 or H200 (SXM)", 132.0 * 128.0, 1.98),
    Card::new("NVIDIA L40S", 142.0 * 128.0, 2.52),
    Card::new("NVIDIA GeForce RTX 4090", 128.0 * 128.0, 2.52),
    Card::new("NVIDIA GeForce RTX 3090", 82.0 * 128.0, 1.695),
    Card::new("NVIDIA GeForce RTX 3060", 28.0 * 128.0, 1.777),
    Card::new("AMD Radeon RX 7900 XTX", 96.0 * 64.0, 2.5),
    Card::new("AMD Radeon RX 6800 XT", 72.0 * 64.0, 2.25),
    Card::new("Intel Arc A770", 32.0 * 128.0, 2.1),
];

impl Card {
    const fn new(name: &'static str, lanes: f64, clock: f64) -> Self {
        Self { name, lanes, clock }
    }
}

/// What a card can do at most.
#[derive(Debug, Serialize)]
pub(crate) struct Ceiling {
    pub(crate) card: &'static str,
    /// Robot-steps per second if it issued an operation of every lane in every tick of its clock, and waited for nothing.
    pub(crate) steps_per_second: f64,
}

/// The most that cards can do in the first of these worlds; nothing if this program has no compiler to count with.
///
/// # Errors
/// A mistake of the compiler.
#[cfg_attr(
    not(all(feature = "gpu", feature = "compose")),
    expect(clippy::unnecessary_wraps, reason = "nothing is counted that could fail")
)]
pub(super) fn at_most(worlds: &Worlds) -> Result<Vec<Ceiling>> {
    #[cfg(all(feature = "gpu", feature = "compose"))]
    return Ok(ceilings(counted::operations(worlds)?));
    #[cfg(not(all(feature = "gpu", feature = "compose")))]
    {
        let _ = worlds;
        Ok(Vec::new())
    }
}

/// The most that cards can do if a robot-step takes this number of operations of a lane.
#[cfg_attr(
    not(all(feature = "gpu", feature = "compose")),
    expect(dead_code, reason = "nothing counts")
)]
fn ceilings(operations: f64) -> Vec<Ceiling> {
    let of = |card: &Card| Ceiling {
        card: card.name,
        steps_per_second: card.lanes * card.clock * 1e9 / operations,
    };
    CARDS.iter().map(of).collect()
}

#[cfg(all(feature = "gpu", feature = "compose"))]
mod counted {
    use std::collections::BTreeMap;

    use oneiro::batch::Worlds;
    use oneiro::gpu::{Class, Cost, Counted, cost};
    use serde_json::json;

    use super::ceilings;
    use oneiro_base::answer::Answer;
    use oneiro_base::console::{Bars, columns};
    use oneiro_base::exit::{Failure, Result};
    use oneiro_base::progress::meanwhile;
    use oneiro_lab::workload;

    /// Lives that are counted together: those of a workgroup.
    const LIVES: u32 = 64;
    /// Cycles of which operations are counted, after those at the beginning of a life that are left out.
    const COUNTED: u32 = 8;
    const LEFT_OUT: u32 = 4;
    /// Lines that are printed.
    const DEAREST: usize = 12;

    /// Counts the operations of lives of random genomes in the first of these worlds.
    fn counted(worlds: &Worlds) -> Result<Cost> {
        let genes = worlds.genes()[0];
        let genomes: Vec<Vec<f32>> = (0..LIVES).map(|index| workload::genome(genes, 1.0, 1, index)).collect();
        let batch = worlds.stretch(&workload::rollouts(&genomes), 0..LEFT_OUT + COUNTED, &[], None)?;
        let left_out = LEFT_OUT.min(batch.cycles().end - 1);
        cost(&batch.all(), left_out).map_err(Failure::failed)
    }

    /// Operations of a robot-step of a kernel that is specialised to the first of these worlds.
    pub(super) fn operations(worlds: &Worlds) -> Result<f64> {
        let cost = counted(worlds)?;
        Ok(cost.specialised.operations.sum() as f64 / f64::from(cost.cycles))
    }

    pub(super) fn answer(worlds: &Worlds, bars: Bars) -> Result<Answer> {
        let cost = meanwhile("counting a cycle's operations", bars, || counted(worlds))?;
        let a_cycle = |count: u64| count as f64 / f64::from(cost.cycles);
        let of =
            |counted: &Counted, class: Class| a_cycle(counted.operations.0.get(&class).copied().unwrap_or_default());
        let all = |counted: &Counted| a_cycle(counted.operations.sum());
        let ceilings = ceilings(all(&cost.specialised));
        let lines: Vec<_> = cost
            .lines
            .iter()
            .map(|line| {
                (
                    format!("{}:{}", line.path, line.line),
                    a_cycle(line.operations),
                    &line.text,
                )
            })
            .collect();
        let classes = |counted: &Counted| -> BTreeMap<&str, f64> {
            Class::ALL
                .iter()
                .map(|class| (class.name(), of(counted, *class)))
                .collect()
        };
        let value = json!({
            "episodes": LIVES,
            "cycles": cost.cycles,
            "any_world": { "operations": all(&cost.any), "by_class": classes(&cost.any) },
            "this_world": { "operations": all(&cost.specialised), "by_class": classes(&cost.specialised) },
            "at_most": ceilings,
            "lines": lines
                .iter()
                .map(|(place, operations, text)| json!({ "place": place, "operations": operations, "text": text }))
                .collect::<Vec<_>>(),
        });
        let row = |name: &str, figures: [f64; 2]| {
            let figures = figures.map(|figure| format!("{figure:.1}"));
            [vec![name.to_owned()], figures.to_vec()].concat()
        };
        let mut rows: Vec<_> = Class::ALL
            .iter()
            .map(|class| row(class.name(), [of(&cost.any, *class), of(&cost.specialised, *class)]))
            .collect();
        rows.push(row("all", [all(&cost.any), all(&cost.specialised)]));
        let cards: Vec<_> = ceilings
            .iter()
            .map(|own| vec![own.card.to_owned(), format!("{:.1}", own.steps_per_second / 1e9)])
            .collect();
        let dearest: Vec<_> = lines
            .iter()
            .take(DEAREST)
            .map(|(place, operations, text)| vec![format!("{operations:.1}"), place.clone(), (*text).clone()])
            .collect();
        let text = format!(
            "Operations per cycle, with {LIVES} episodes of random genomes side by side on a GPU: all wait for what one of them does.\n\n\
             {}\n\
             This world's kernel by lines, most operations first. A line of a custom part includes what it calls.\n\n{}\n\
             This world's maximum in billion steps per second: a card issues one operation per lane and clock tick.\n\
             Real rates are lower: an H100 reached 0.7 of it with the 1995 experiment (docs/gpu.md).\n\n{}",
            columns(&["", "any world", "this world"], &rows),
            columns(&["operations", "line", ""], &dearest),
            columns(&["card", "at most"], &cards),
        );
        Ok(Answer::new(text, value))
    }
}

/// `oneiro check --cost`: what a cycle in the first of these worlds costs.
///
/// # Errors
/// Exit 3: this program has no compiler of kernels. A mistake of the compiler.
pub(super) fn answer(worlds: &Worlds, bars: Bars) -> Result<Answer> {
    #[cfg(all(feature = "gpu", feature = "compose"))]
    return counted::answer(worlds, bars);
    #[cfg(not(all(feature = "gpu", feature = "compose")))]
    {
        let _ = (worlds, bars);
        Err(oneiro_base::exit::Failure::usage(
            "--cost: this program was built without `gpu` or `compose`, and has no compiler to count with",
        ))
    }
}

#[cfg(all(test, feature = "gpu", feature = "compose"))]
mod tests {
    use oneiro::world::{World, WorldSpec};

    use super::*;

    /// An H100 issues 33 million million operations of lanes a second.
    #[test]
    fn ceilings_follow_from_operations() {
        let worlds = Worlds::new(&[World::new(WorldSpec::miglino1995()).unwrap()]).unwrap();
        let operations = counted::operations(&worlds).unwrap();
        assert!((400.0..800.0).contains(&operations), "{operations}");
        let h100 = &at_most(&worlds).unwrap()[0];
        let expected = 33.45e12 / operations;
        assert!((h100.steps_per_second / expected - 1.0).abs() < 0.01, "{h100:?}");
    }
}
