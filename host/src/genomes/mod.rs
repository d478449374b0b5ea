//! Genomes from files: `.npy`, `.csv` and `.json`, and state machines and behaviour trees from `.txt`.

mod npy;

use std::path::Path;

use oneiro::automode::Form;
use oneiro::batch::GREATEST_GENE;
use oneiro::world::GeneLayout;
use serde::Deserialize;

use crate::columns;
use crate::evolve::Population;
use crate::exit::{Failure, Result};
use crate::files;

/// Reads genomes of a controller:
/// - `.npy`: float32 or float64, of the shape rows x genes, or genes alone for one genome;
/// - `.csv`: one genome per line. There may be a header; if it has the controller's [gene names](GeneLayout::names),
///   columns are found by name, and other columns are ignored;
/// - `.json`: one genome, in the format of a run's `champion.json`;
/// - `.txt`, of state machines and behaviour trees: one on each line, in `AutoMoDe`'s form; empty lines are ignored. A genome with
///   a controller for each robot or team has a line for each.
///
/// # Errors
/// Exit 3: there is no such file, no genome in it, another shape, or a gene that isn't a number or is beyond
/// [`GREATEST_GENE`]; with the file and the row, counted from 1.
pub(crate) fn read(path: &Path, layout: &GeneLayout) -> Result<Population> {
    let bytes = files::bytes(path)?;
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .map(str::to_ascii_lowercase);
    let genes = layout.genes();
    let genomes = match extension.as_deref() {
        Some("npy") => npy::parse(&bytes, genes),
        Some("csv") => {
            columns::read(&bytes, &layout.names(), |gene, shown| checked(gene, &shown)).map(|(values, _)| values)
        }
        Some("json") => from_json(&bytes, genes),
        Some("txt") => match Form::of(layout) {
            Some(form) => from_text(form, &bytes, layout),
            None => Err(
                "is a text, which only state machines and behaviour trees have; allowed: .npy, .csv, .json, or controller.kind = \
                 \"state-machine\" or \"behaviour-tree\""
                    .to_owned(),
            ),
        },
        _ => Err(
            "has an unknown extension; allowed: .npy, .csv, .json, and .txt of state machines and behaviour trees"
                .to_owned(),
        ),
    };
    let values = genomes.map_err(|problem| Failure::input(format_args!("{}: {problem}", path.display())))?;
    if values.is_empty() {
        return Err(Failure::input(format_args!(
            "{}: holds no genome; allowed: one or more rows",
            path.display()
        )));
    }
    Ok(Population::new(genes, values))
}

/// Refuses genomes whose number of genes differs from the controller's.
pub(crate) fn other_size(path: &Path, genes: usize, allowed: usize) -> Failure {
    Failure::input(format_args!(
        "{}: its genomes have {genes} genes; allowed: {allowed}, as the experiment's controller takes",
        path.display()
    ))
}

/// Checks a gene, or says why it isn't allowed; `shown` is the text in the file.
fn checked(gene: f32, shown: &dyn std::fmt::Display) -> std::result::Result<f32, String> {
    if gene.abs() <= GREATEST_GENE {
        return Ok(gene);
    }
    Err(format!(
        "{shown} is not a valid gene; allowed: -{GREATEST_GENE} to {GREATEST_GENE}"
    ))
}

/// The genome in a champion's file, or in another file with such a list.
fn from_json(bytes: &[u8], genes: usize) -> std::result::Result<Vec<f32>, String> {
    #[derive(Deserialize)]
    struct Champion {
        genome: Vec<f32>,
    }
    let allowed = format!("allowed: an object with the key genome, a list of {genes} numbers, as champion.json is");
    let Champion { genome } = serde_json::from_slice(bytes).map_err(|error| format!("{error}; {allowed}"))?;
    if genome.len() != genes {
        return Err(format!("genome: has {} numbers; {allowed}", genome.len()));
    }
    let place =
        |(index, &gene): (usize, &f32)| checked(gene, &gene).map_err(|problem| format!("genome[{index}]: {problem}"));
    genome.iter().enumerate().map(place).collect()
}

/// State machines or behaviour trees, one on each line: as many for a genome as it has controllers.
fn from_text(form: Form, bytes: &[u8], layout: &GeneLayout) -> std::result::Result<Vec<f32>, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| format!("{error}; allowed: UTF-8"))?;
    let lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let genomes = lines.map(|(line, number)| form.genome(line).map_err(|bad| format!("line {number}, {bad}")));
    let genomes = genomes.collect::<std::result::Result<Vec<_>, String>>()?;
    let controllers = layout.genes() / layout.controller().len();
    if genomes.len() % controllers != 0 {
        return Err(format!(
            "has {} lines; allowed: {controllers} for each genome, one for each robot or team with genes of its own",
            genomes.len()
        ));
    }
    Ok(genomes.concat())
}

#[cfg(test)]
mod tests {
    use oneiro::automode::Modules;
    use oneiro::world::Controller;

    use super::*;

    #[test]
    fn a_text_has_a_machine_on_each_line() {
        let one = Controller::StateMachine(Modules::DEFAULT).layout();
        let good = "--nstates 1 --s0 1\n\n  --nstates 1 --s0 4 --att0 2.5\n";
        let genes = from_text(Form::StateMachine, good.as_bytes(), &one).unwrap();
        assert_eq!(genes.len(), 2 * 97);
        assert_eq!(Form::StateMachine.text(&genes[97..]), "--nstates 1 --s0 4 --att0 2.5");
        assert_eq!(
            from_text(Form::StateMachine, b"--nstates 1 --s0 1\n--nstates 1 --s0 7", &one).unwrap_err(),
            "line 2, word 4: `--s0` is `7`; allowed: 0 to 5, whole"
        );
        assert!(
            from_text(Form::StateMachine, b"\xff", &one)
                .unwrap_err()
                .ends_with("allowed: UTF-8")
        );
        assert!(from_text(Form::BehaviourTree, b"\n", &one).unwrap().is_empty());
    }

    #[test]
    fn a_champions_file_has_one_genome() {
        let good = br#"{"fitness": 3.5, "genome": [1.5, -2.0], "seed": 7}"#;
        assert_eq!(from_json(good, 2).unwrap(), [1.5, -2.0]);
        let refusal = |text: &str| from_json(text.as_bytes(), 2).unwrap_err();
        assert!(refusal("{\n\"genome\": [1, true]}").contains("line 2 column"));
        assert!(refusal("{}").contains("`genome`"));
        assert!(refusal("[1, 2]").contains("allowed"));
        assert!(refusal(r#"{"genome": [1, 2, 3]}"#).contains("has 3 numbers"));
        assert!(refusal(r#"{"genome": [1, 2e6]}"#).contains("genome[1]: 2000000 is not a valid gene"));
    }
}
