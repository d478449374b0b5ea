//! A self-contained HTML page of an archive of elites: a map of its cells, and an episode of each elite.

use std::collections::BTreeMap;
use std::fmt::Write;

use oneiro::arena::Arena;
use serde_json::{Value, json};

use super::episode::{COLOURS, FRONT, arena, halves, pose_facts, view};
use super::player::{self, Player, filled, packed};
use super::svg::{escaped, number, ramp};
use crate::numbers::significant;

/// The panel next to the arena.
const PANEL: &str = include_str!("../components/elites.html");
/// Colours of tiles from the minimum to the maximum fitness.
const FITNESS: [[u8; 3]; 3] = [[0x2b, 0x3a, 0x8f], [0x2a, 0x9d, 0x8f], [0xf4, 0xd0, 0x3f]];
/// Side of the map.
const SIDE: f64 = 1000.0;
/// Side of an elite's square where cells can't be drawn.
const SQUARE: f64 = 16.0;
/// Cells of a grid up to which empty ones are drawn, and centroids up to which regions are.
const CELLS: usize = 10_000;
const REGIONS: usize = 2000;

/// An archive, to be shown.
pub struct ElitesReplay<'a> {
    pub title: &'a str,
    /// The text below the title.
    pub lead: &'a str,
    /// Name of the run's directory.
    pub directory: &'a str,
    pub arena: &'a Arena,
    pub body_radius: f32,
    /// What describes behaviour.
    pub axes: Vec<Axis<'a>>,
    /// Centroids of cells, one after the other, as fractions of the axes; none of a grid.
    pub centroids: Option<Vec<f64>>,
    /// Names of the elites' values.
    pub columns: Vec<&'a str>,
    /// At least one.
    pub elites: Vec<ShownElite<'a>>,
    /// Cycles between poses.
    pub every: u32,
}

/// A measure of behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    pub name: &'a str,
    pub least: f64,
    pub greatest: f64,
    /// Cells that a grid divides the range into.
    pub cells: u32,
}

/// An elite, with its values and its episode.
#[derive(Clone, Debug)]
pub struct ShownElite<'a> {
    pub cell: u32,
    pub fitness: f64,
    pub behaviour: &'a [f64],
    /// A value for each column, the cell first.
    pub row: Vec<String>,
    /// x and y in mm, and the heading in turns.
    pub poses: &'a [[f32; 3]],
    /// The episode's fitness up to each pose.
    pub earned: &'a [f32],
}

/// A polygon on the map.
type Tile = Vec<[f64; 2]>;

/// Makes the page.
pub fn elites_page(replay: &ElitesReplay<'_>) -> String {
    let tiles: Vec<Tile> = replay.elites.iter().map(|elite| replay.tile(elite)).collect();
    player::page(&Player {
        title: replay.title,
        lead: replay.lead,
        drawn: "The arena from above, with the robot of the chosen elite and its path",
        switches: "",
        strip: "",
        panel: &replay.panel(&tiles),
        facts: &replay.facts(&tiles),
        script: "elites",
    })
}

impl ElitesReplay<'_> {
    /// All data for the script.
    fn facts(&self, tiles: &[Tile]) -> BTreeMap<&'static str, Value> {
        let elites = &self.elites;
        let poses: Vec<[f32; 3]> = elites.iter().flat_map(|elite| elite.poses).copied().collect();
        let earned = elites.iter().flat_map(|elite| elite.earned);
        let fitter = |best: usize, other: usize| {
            if elites[other].fitness > elites[best].fitness {
                other
            } else {
                best
            }
        };
        let axis = |axis: &Axis<'_>| json!({ "name": axis.name, "least": axis.least, "greatest": axis.greatest, "cells": axis.cells });
        let mut facts = pose_facts(&poses, self.body_radius);
        facts.extend([
            ("arena", arena(self.arena)),
            ("view", json!(view(self.arena, self.body_radius, &poses))),
            ("axes", self.axes.iter().map(axis).collect()),
            ("grid", json!(self.centroids.is_none())),
            ("columns", json!(self.columns)),
            ("rows", elites.iter().map(|elite| json!(elite.row)).collect()),
            ("centres", tiles.iter().map(|tile| json!(centre(tile))).collect()),
            ("best", json!((0..elites.len()).reduce(fitter))),
            ("lengths", elites.iter().map(|elite| elite.poses.len()).collect()),
            ("every", json!(self.every)),
            (
                "fitness",
                json!(packed(earned.flat_map(|fitness| halves(fitness.to_bits())))),
            ),
            ("look", json!({ "colour": COLOURS[0], "front": FRONT })),
        ]);
        facts
    }

    /// The map and what is below it.
    fn panel(&self, tiles: &[Tile]) -> String {
        let finite = || {
            self.elites
                .iter()
                .map(|elite| elite.fitness)
                .filter(|own| own.is_finite())
        };
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let [low, high] = if low <= high { [low, high] } else { [0.0, 0.0] };
        let text = |value: f64| escaped(&significant(value, 4));
        let (across, up) = (self.axes.first(), self.axes.get(1));
        let name = |axis: Option<&Axis<'_>>| axis.map_or_else(String::new, |axis| escaped(axis.name));
        let least = |axis: Option<&Axis<'_>>| axis.map_or_else(String::new, |axis| text(axis.least));
        let greatest = |axis: Option<&Axis<'_>>| axis.map_or_else(String::new, |axis| text(axis.greatest));
        filled(
            PANEL,
            &[
                ("shape", if up.is_none() { "flat" } else { "" }),
                ("tiles", &self.tiles(tiles, [low, high])),
                ("across", &name(across)),
                ("across_low", &least(across)),
                ("across_high", &greatest(across)),
                ("up", &name(up)),
                ("up_low", &least(up)),
                ("up_high", &greatest(up)),
                ("about", &self.about()),
                (
                    "stops",
                    &(0..3)
                        .map(|stop| ramp(&FITNESS, f64::from(stop) / 2.0))
                        .collect::<Vec<_>>()
                        .join(","),
                ),
                ("low", &text(low)),
                ("middle", &text(0.5 * (low + high))),
                ("high", &text(high)),
                ("directory", &escaped(self.directory)),
            ],
        )
    }

    /// How to read the map, as HTML.
    fn about(&self) -> String {
        let tile = if self.has_regions() {
            "Each tile is a cell; grey ones have no elite."
        } else {
            "Each square is an elite."
        };
        let inner = |index: usize, side: &str| {
            let names: Vec<_> = self
                .axes
                .iter()
                .skip(index)
                .step_by(2)
                .map(|axis| escaped(axis.name))
                .collect();
            if names.is_empty() {
                String::new()
            } else {
                format!("{side} by {}", names.join(", then "))
            }
        };
        let inner = [inner(2, "across"), inner(3, "up")]
            .into_iter()
            .filter(|text| !text.is_empty());
        let inner = inner.collect::<Vec<_>>().join(" and ");
        let inner = match self.centroids {
            None if !inner.is_empty() => format!(" Within each step of the axes, cells are ordered {inner}."),
            _ => String::new(),
        };
        format!("{tile}{inner} Choose an elite by a click or the arrow keys.")
    }

    /// Whether cells can be drawn.
    fn has_regions(&self) -> bool {
        let count = self.axes.len();
        self.centroids
            .as_ref()
            .is_none_or(|points| count <= 2 && points.len() <= REGIONS * count)
    }

    /// The SVG elements of all cells, those of elites in their order after empty ones.
    fn tiles(&self, tiles: &[Tile], [low, high]: [f64; 2]) -> String {
        let mut svg = String::new();
        let path = |tile: &Tile| {
            let points = tile.iter().map(|[x, y]| format!("{} {}", number(*x), number(*y)));
            format!("M{}z", points.collect::<Vec<_>>().join("L"))
        };
        for cell in (0..self.cells() as u32).filter(|cell| self.elites.iter().all(|elite| elite.cell != *cell)) {
            if let Some(tile) = self.region(cell) {
                // Writing to a string can't fail.
                let _ = writeln!(svg, "<path data-cell=\"{cell}\" d=\"{}\"/>", path(&tile));
            }
        }
        for (index, (elite, tile)) in self.elites.iter().zip(tiles).enumerate() {
            let share = if high > low {
                (elite.fitness - low) / (high - low)
            } else {
                1.0
            };
            let _ = writeln!(
                svg,
                "<path role=\"option\" id=\"elite-{index}\" aria-selected=\"false\" data-cell=\"{}\" data-elite=\"{index}\" \
                 style=\"fill:{}\" d=\"{}\"/>",
                elite.cell,
                ramp(&FITNESS, share),
                path(tile)
            );
        }
        svg
    }

    /// The number of drawn cells, if empty ones are drawn.
    fn cells(&self) -> usize {
        let count = match &self.centroids {
            None => self.axes.iter().map(|axis| axis.cells as usize).product(),
            Some(points) => points.len() / self.axes.len().max(1),
        };
        if self.has_regions() && count <= CELLS { count } else { 0 }
    }

    /// The tile of an elite: its cell, or a square at its behaviour.
    fn tile(&self, elite: &ShownElite<'_>) -> Tile {
        self.region(elite.cell).unwrap_or_else(|| {
            let place = |axis: usize| {
                let Axis { least, greatest, .. } = self.axes[axis];
                (SIDE * (elite.behaviour[axis] - least) / (greatest - least)).clamp(0.0, SIDE)
            };
            rectangle([place(0) - 0.5 * SQUARE, SIDE - place(1) - 0.5 * SQUARE], [SQUARE; 2])
        })
    }

    /// The place of a cell on the map, if cells are drawn.
    fn region(&self, cell: u32) -> Option<Tile> {
        let Some(points) = &self.centroids else {
            return Some(self.grid_cell(cell));
        };
        self.has_regions().then(|| match self.axes.len() {
            1 => nearest_region(cell as usize, &points.iter().map(|x| [*x, 0.5]).collect::<Vec<_>>()),
            _ => nearest_region(cell as usize, points.as_chunks().0),
        })
    }

    /// The place of a grid's cell: axes go across and up in turns, each within a step of the one before.
    fn grid_cell(&self, cell: u32) -> Tile {
        let mut rest = cell;
        let mut digits: Vec<(u32, u32)> = Vec::new();
        for axis in self.axes.iter().rev() {
            digits.push((rest % axis.cells, axis.cells));
            rest /= axis.cells;
        }
        let along = |side: usize| {
            let own = digits.iter().rev().skip(side).step_by(2);
            own.fold((0, 1), |(place, count), (digit, cells)| {
                (place * cells + digit, count * cells)
            })
        };
        let [(column, columns), (row, rows)] = [0, 1].map(along);
        let size = [SIDE / f64::from(columns), SIDE / f64::from(rows)];
        rectangle([f64::from(column) * size[0], SIDE - f64::from(row + 1) * size[1]], size)
    }
}

fn rectangle([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Tile {
    vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
}

/// The mean of a polygon's corners.
fn centre(tile: &Tile) -> [f64; 2] {
    let mean = |axis: usize| tile.iter().map(|corner| corner[axis]).sum::<f64>() / tile.len().max(1) as f64;
    [0, 1].map(|axis| mean(axis).round())
}

/// The part of the map that is nearest to one of some points, given as fractions of the axes.
fn nearest_region(index: usize, points: &[[f64; 2]]) -> Tile {
    let place = |[x, y]: [f64; 2]| [SIDE * x, SIDE * (1.0 - y)];
    let point = place(points[index]);
    let mut tile = rectangle([0.0; 2], [SIDE; 2]);
    for other in points.iter().map(|other| place(*other)).filter(|other| *other != point) {
        // Positive on the point's side of the line half-way to the other one.
        let side = |at: [f64; 2]| {
            let axis = |axis: usize| (at[axis] - 0.5 * (point[axis] + other[axis])) * (point[axis] - other[axis]);
            axis(0) + axis(1)
        };
        let mut rest = Vec::with_capacity(tile.len() + 1);
        for (corner, &to) in tile.iter().enumerate() {
            let from = tile[(corner + tile.len() - 1) % tile.len()];
            let (before, after) = (side(from), side(to));
            if (before < 0.0) != (after < 0.0) {
                let share = before / (before - after);
                rest.push([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])));
            }
            if after >= 0.0 {
                rest.push(to);
            }
        }
        tile = rest;
    }
    tile
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::typed_keys;

    const AXIS: Axis<'_> = Axis {
        name: "x",
        least: 0.0,
        greatest: 1.0,
        cells: 2,
    };

    #[test]
    fn points_have_the_regions_nearest_to_them() {
        let left = nearest_region(0, &[[0.25, 0.5], [0.75, 0.5]]);
        let mut corners = left.iter().map(|corner| corner.map(f64::round)).collect::<Vec<_>>();
        corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(corners, [[0.0, 0.0], [0.0, 1000.0], [500.0, 0.0], [500.0, 1000.0]]);
        assert_eq!(centre(&left), [250.0, 500.0]);
    }

    #[test]
    fn the_script_has_types_of_all_facts() {
        let page = ElitesReplay {
            title: "",
            lead: "",
            directory: "",
            arena: &Arena::named("miglino1995").unwrap(),
            body_radius: 27.5,
            axes: vec![AXIS],
            centroids: None,
            columns: vec!["cell"],
            elites: vec![ShownElite {
                cell: 0,
                fitness: 1.0,
                behaviour: &[0.5],
                row: vec!["0".into()],
                poses: &[[1.0, 2.0, 0.5]],
                earned: &[1.0],
            }],
            every: 1,
        };
        let keys: Vec<_> = page.facts(&[page.tile(&page.elites[0])]).into_keys().collect();
        assert_eq!(keys, typed_keys(&["PoseFacts", "ElitesOnly"]));
    }

    #[test]
    fn every_cell_of_a_grid_has_a_place() {
        let axis = |cells| Axis { cells, ..AXIS };
        let mut page = ElitesReplay {
            title: "",
            lead: "",
            directory: "",
            arena: &Arena::named("miglino1995").unwrap(),
            body_radius: 27.5,
            axes: vec![axis(2), axis(3), axis(5)],
            centroids: None,
            columns: Vec::new(),
            elites: Vec::new(),
            every: 1,
        };
        let mut centres: Vec<_> = (0..30).map(|cell| centre(&page.grid_cell(cell))).collect();
        // The first axis goes across, the second up, and the third across within a step of the first.
        assert_eq!(
            [centres[0], centres[1], centres[5], centres[15]],
            [[50.0, 833.0], [150.0, 833.0], [50.0, 500.0], [550.0, 833.0]]
        );
        centres.sort_by(|a, b| a.partial_cmp(b).unwrap());
        centres.dedup();
        assert_eq!(centres.len(), 30);
        page.axes.truncate(1);
        assert_eq!(page.grid_cell(1), rectangle([500.0, 0.0], [500.0, SIDE]));
    }
}
