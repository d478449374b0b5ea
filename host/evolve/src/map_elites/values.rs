//! Values of an archive of elites.

use oneiro::parameter::Allowed::{Any, Number, Whole, WholeUpTo};
use oneiro::parameter::{Choice, Choices, Parameter, row};
use serde::Serialize;

use crate::Kind;
use crate::registry::Table;
use crate::settings::{Checked, Need, Settings, Surroundings, descriptors, refused};

const OURS: &str = "ours";

/// Values of an archive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Values {
    pub cells: Cells,
    /// Cells, if they are not a grid's.
    pub centroids: u32,
    /// Standard deviations of variation: of each gene, in halves of the initial range, and along the line to another elite.
    pub iso: f64,
    pub line: f64,
    /// Elites of each generation that are evaluated again.
    pub reevaluated: u32,
    pub acceptance: Acceptance,
    /// The fitness that counts as nothing in the QD score.
    pub offset: f64,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            cells: Cells::Grid,
            centroids: 1000,
            iso: 0.01,
            line: 0.2,
            reevaluated: 0,
            acceptance: Acceptance::Optimistic,
            offset: 0.0,
        }
    }
}

/// How an archive's cells divide behaviour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Cells {
    Grid,
    Centroidal,
}

impl Choice for Cells {
    const CHOICES: Choices<Self> = &[
        ("grid", Self::Grid, "each descriptor's range is divided evenly"),
        (
            "centroidal",
            Self::Centroidal,
            "regions of equal size around centroids: Vassiliades et al. 2018",
        ),
    ];
}

/// The fitness that compares elites.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Acceptance {
    Optimistic,
    Mean,
}

impl Choice for Acceptance {
    const CHOICES: Choices<Self> = &[
        (
            "optimistic",
            Self::Optimistic,
            "their best score so far, in the cell of that episode",
        ),
        (
            "mean",
            Self::Mean,
            "the mean of all their scores, in the cell of their mean behaviour",
        ),
    ];
}

impl Table for Values {
    #[rustfmt::skip]
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
        vec![
            row("evolution.archive.cells", "", Any, OURS,
                "How an archive divides behaviour.", |values, _| Some(&mut values.as_mut().archive()?.cells)),
            row("evolution.archive.centroids", "", Whole(1, 10_000), "Vassiliades et al. 2018, whose archives have up to 10,000",
                "Cells of a centroidal archive; a grid has those of its descriptors.", |values, _| Some(&mut values.as_mut().archive()?.centroids)),
            row("evolution.archive.iso", "", Number(0.0, 1e6), "Vassiliades and Mouret 2018; pyribs",
                "Standard deviation of the change of each gene of a child, in halves of the initial range.", |values, _| Some(&mut values.as_mut().archive()?.iso)),
            row("evolution.archive.line", "", Number(0.0, 1e6), "Vassiliades and Mouret 2018; pyribs",
                "Standard deviation of a child's move towards a second elite, as a fraction of the distance.", |values, _| Some(&mut values.as_mut().archive()?.line)),
            row("evolution.archive.reevaluated", "", WholeUpTo(0, "evolution.population"), OURS,
                "Re-evaluated elites in each generation, as part of its population.", |values, _| Some(&mut values.as_mut().archive()?.reevaluated)),
            row("evolution.archive.acceptance", "", Any, OURS,
                "The fitness that compares elites.", |values, _| Some(&mut values.as_mut().archive()?.acceptance)),
            row("evolution.archive.offset", "", Number(-1e6, 1e6), OURS,
                "Fitness that counts as 0 in the QD score, the sum over all elites.", |values, _| Some(&mut values.as_mut().archive()?.offset)),
        ]
    }

    // Experiments of other optimisers had these values from the start.
    fn is_left_out(&self) -> bool {
        false
    }
}

impl Settings {
    /// Cells of the archive.
    pub fn cells(&self) -> usize {
        let Values { cells, centroids, .. } = self.tables.archive;
        match cells {
            Cells::Grid => self
                .descriptors
                .iter()
                .map(|descriptor| descriptor.cells as usize)
                .fold(1, usize::saturating_mul),
            Cells::Centroidal => centroids as usize,
        }
    }
}

/// Checks the descriptors, and that a grid of them is not too large.
pub(super) fn check(settings: &Settings, _: &Surroundings<'_>) -> Checked {
    const MOST_CELLS: u64 = 1_000_000;
    descriptors::check(settings)?;
    let cells = settings
        .descriptors
        .iter()
        .try_fold(1_u64, |all, descriptor| all.checked_mul(descriptor.cells.into()));
    if settings.tables.archive.cells == Cells::Grid && cells.is_none_or(|cells| cells > MOST_CELLS) {
        let problem =
            format!("have more than {MOST_CELLS} cells in all; allowed: at most that, or a centroidal archive");
        return refused("evolution.descriptors", problem);
    }
    Ok(())
}

/// What has an effect only with another value.
pub(super) fn needs(settings: &Settings) -> Vec<Need> {
    let is_centroidal = settings.tables.archive.cells == Cells::Centroidal;
    let cells = (0..settings.descriptors.len()).map(|index| format!("evolution.descriptors[{index}].cells"));
    vec![
        Need::new(
            &["evolution.archive.centroids"],
            is_centroidal,
            "with evolution.archive.cells = \"centroidal\"",
            &["evolution.archive.cells"],
        ),
        Need {
            keys: cells.collect(),
            is_met: settings.kind == Kind::MapElites && !is_centroidal,
            only: "with evolution.kind = \"map-elites\" and evolution.archive.cells = \"grid\"",
            by: &["evolution.kind", "evolution.archive.cells"],
        },
    ]
}
