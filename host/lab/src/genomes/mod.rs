//! Genomes from files: `.npy`, `.csv` and `.json`, and state machines and behaviour trees from `.txt`.

mod npy;

use std::collections::BTreeSet;
use std::path::Path;

use oneiro::automode::Form;
use oneiro::batch::GREATEST_GENE;
use oneiro::world::GeneLayout;
use oneiro_base::columns;
use oneiro_base::console::counted;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_evolve::Population;
use serde::{Deserialize, Serialize};

/// Reads genomes of a controller:
/// - `.npy`: float32 or float64, of the shape rows x genes, or genes alone for one genome, in the order of the controller's genes;
/// - `.csv`: one genome per line. If there is a header, it has the controller's [gene names](GeneLayout::names), in any order and in
///   upper or lower case; other columns are ignored. Without one, columns are in the order of the controller's genes;
/// - `.json`: one genome, in the format of a run's `champion.json`: by `gene_names`, in any order, or without these in the order of the
///   controller's genes;
/// - `.txt`, of state machines and behaviour trees: one on each line, in `AutoMoDe`'s form; empty lines are ignored. A genome with
///   a controller for each robot or team has a line for each.
///
/// `say` receives a message if the file has no names, so that genes go by position, and about ignored columns.
///
/// # Errors
/// Exit 3: there is no such file, no genome in it, another shape, other names of genes, or a gene that isn't a number or is beyond
/// [`GREATEST_GENE`]; with the file and the row, counted from 1.
pub fn read(path: &Path, layout: &GeneLayout, say: impl FnMut(String)) -> Result<Population> {
    parse(path, &files::bytes(path)?, layout, say)
}

/// Reads the genomes in the contents of a file.
///
/// # Errors
/// As [`read`].
pub(crate) fn parse(path: &Path, bytes: &[u8], layout: &GeneLayout, mut say: impl FnMut(String)) -> Result<Population> {
    // A mark of the order of bytes, with which some editors begin texts.
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .map(str::to_ascii_lowercase);
    let genomes = match extension.as_deref() {
        Some("npy") => npy::parse(bytes, layout.genes()).map(|values| (values, Some(in_order(layout)))),
        Some("csv") => columns::read(bytes, &layout.names(), |gene, shown| checked(gene, &shown))
            .map(|columns| (columns.values, columns.word)),
        Some("json") => from_json(bytes, layout),
        Some("txt") => match Form::of(layout) {
            Some(form) => from_text(form, bytes, layout),
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
    let path = path.display();
    let (values, word) = genomes.map_err(|problem| Failure::input(format_args!("{path}: {problem}")))?;
    if values.is_empty() {
        return Err(Failure::input(format_args!(
            "{path}: holds no genome; allowed: one or more rows"
        )));
    }
    if let Some(word) = word {
        say(format!("{path}: {word}"));
    }
    Ok(Population::new(layout.genes(), values))
}

/// Reads the genomes of a file of a run's directory, whose genes are those of its experiment.
///
/// # Errors
/// As [`read`], with exit 5.
pub fn recorded(path: &Path, layout: &GeneLayout) -> Result<Population> {
    read(path, layout, drop).map_err(Failure::corrupt)
}

/// Converts genomes of one controller, `own`, to the order of another's genes.
///
/// # Errors
/// As [`check_names`].
pub fn by_name(path: &Path, own: &GeneLayout, genomes: Population, layout: &GeneLayout) -> Result<Population> {
    let order = check_names(path, own, layout)?;
    if order.iter().copied().eq(0..own.genes()) {
        return Ok(genomes);
    }
    let genes = genomes
        .genomes()
        .flat_map(|genome| order.iter().map(|&place| genome[place]));
    Ok(Population::new(layout.genes(), genes.collect()))
}

/// The place of each gene of a controller among those of another, which must have the same names.
///
/// # Errors
/// Exit 3 with the names that differ.
pub(crate) fn check_names(path: &Path, own: &GeneLayout, layout: &GeneLayout) -> Result<Vec<usize>> {
    order(&own.names(), layout).map_err(|problem| Failure::input(format_args!("{}: {problem}", path.display())))
}

/// The place of each of a controller's genes among names, which are the same ones in any order.
fn order(names: &[String], layout: &GeneLayout) -> std::result::Result<Vec<usize>, String> {
    let wanted = layout.names();
    let places = columns::places(names, &wanted)?;
    let found: BTreeSet<usize> = places.iter().copied().flatten().collect();
    let missing = wanted.iter().zip(&places).filter(|(_, place)| place.is_none());
    let missing: Vec<&String> = missing.map(|(name, _)| name).collect();
    let others = names.iter().enumerate().filter(|(place, _)| !found.contains(place));
    let others: Vec<&String> = others.map(|(_, name)| name).collect();
    if missing.is_empty() && others.is_empty() {
        return Ok(places.into_iter().flatten().collect());
    }
    let words = |names: &[&String], words: &str| match names {
        [] => None,
        names => Some(format!("{words} {}", columns::listed(names, columns::LISTED))),
    };
    let differences = [words(&missing, "it lacks"), words(&others, "the controller has no")];
    let differences: Vec<String> = differences.into_iter().flatten().collect();
    Err(format!(
        "has genomes of {} with other names than the experiment's: {}; allowed: {}, all those of the experiment's controller, in any \
         order; a .npy file has no names, and its genes are taken in the controller's order",
        counted(names.len(), "gene", "genes"),
        differences.join(", "),
        layout.genes()
    ))
}

/// The message that a file has no names.
fn in_order(layout: &GeneLayout) -> String {
    let names = columns::listed(&layout.names(), columns::LISTED);
    format!("names no genes; they are taken in the controller's order: {names}")
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

/// Values of genomes, and a message to the user.
type Found = std::result::Result<(Vec<f32>, Option<String>), String>;

/// The genome in a champion's file, or in another file with such a list.
fn from_json(bytes: &[u8], layout: &GeneLayout) -> Found {
    #[derive(Deserialize)]
    struct Champion {
        genome: Vec<f32>,
        #[serde(default)]
        gene_names: Vec<String>,
    }
    let genes = layout.genes();
    let allowed = format!(
        "allowed: an object with the key genome, a list of {}, as champion.json is",
        counted(genes, "number", "numbers")
    );
    let Champion { genome, gene_names } =
        serde_json::from_slice(bytes).map_err(|error| format!("{error}; {allowed}"))?;
    let place =
        |(index, &gene): (usize, &f32)| checked(gene, &gene).map_err(|problem| format!("genome[{index}]: {problem}"));
    let checked: Vec<f32> = genome
        .iter()
        .enumerate()
        .map(place)
        .collect::<std::result::Result<_, _>>()?;
    if !gene_names.is_empty() {
        if gene_names.len() != genome.len() {
            let (names, genes) = (gene_names.len(), genome.len());
            return Err(format!(
                "gene_names: has {}; allowed: {genes}, one for each number of genome",
                counted(names, "name", "names")
            ));
        }
        let order = order(&gene_names, layout)?;
        return Ok((order.into_iter().map(|place| checked[place]).collect(), None));
    }
    if genome.len() != genes {
        return Err(format!(
            "genome: has {}; {allowed}",
            counted(genome.len(), "number", "numbers")
        ));
    }
    Ok((checked, Some(in_order(layout))))
}

/// A file with one genome and the names of its genes, as [`read`] takes it. `result` is the hash of the run that it is of.
pub(crate) fn json(genome: &[f32], names: &[String], result: &str) -> Vec<u8> {
    #[derive(Serialize)]
    struct File<'a> {
        result: &'a str,
        gene_names: &'a [String],
        genome: &'a [f32],
    }
    disk::json(&File {
        result,
        gene_names: names,
        genome,
    })
}

/// State machines or behaviour trees, one on each line: as many for a genome as it has controllers.
fn from_text(form: Form, bytes: &[u8], layout: &GeneLayout) -> Found {
    let text = std::str::from_utf8(bytes).map_err(|error| format!("{error}; allowed: UTF-8"))?;
    let lines = text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty());
    let genomes = lines.map(|(line, number)| form.genome(line).map_err(|bad| format!("line {number}, {bad}")));
    let genomes = genomes.collect::<std::result::Result<Vec<_>, String>>()?;
    let controllers = layout.genes() / layout.controller().len();
    if genomes.len() % controllers != 0 {
        return Err(format!(
            "has {}; allowed: {controllers} for each genome, one for each robot or team",
            counted(genomes.len(), "line", "lines")
        ));
    }
    let word = (controllers > 1)
        .then(|| format!("names no robots; each {controllers} lines are those of a genome, in their order"));
    Ok((genomes.concat(), word))
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
        let (genes, word) = from_text(Form::StateMachine, good.as_bytes(), &one).unwrap();
        assert_eq!(word, None);
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
        assert!(from_text(Form::BehaviourTree, b"\n", &one).unwrap().0.is_empty());
    }

    /// 18 numbers from 0 to 17, by the names of their genes in reverse, in another case.
    fn reversed(change: impl Fn(&mut Vec<String>)) -> String {
        let mut names: Vec<String> = Controller::Perceptron.layout().names();
        names.reverse();
        for name in &mut names {
            name.make_ascii_uppercase();
        }
        change(&mut names);
        let genome: Vec<u32> = (0..18).rev().collect();
        serde_json::json!({"fitness": 3.5, "genome": genome, "gene_names": names, "seed": 7}).to_string()
    }

    #[test]
    fn a_champions_file_has_one_genome() {
        let layout = Controller::Perceptron.layout();
        let read = |text: &str| from_json(text.as_bytes(), &layout);
        let numbers = |count: u32| serde_json::json!({"genome": (0..count).collect::<Vec<_>>()}).to_string();
        let in_order: Vec<f32> = (0_u8..18).map(f32::from).collect();
        let (genome, word) = read(&numbers(18)).unwrap();
        assert_eq!(genome, in_order);
        assert!(
            word.unwrap()
                .starts_with("names no genes; they are taken in the controller's order: `left_90_to_left`, ")
        );
        let refusal = |text: &str| read(text).unwrap_err();
        assert!(refusal("{\n\"genome\": [1, true]}").contains("line 2 column"));
        assert!(refusal("{}").contains("`genome`"));
        assert!(refusal("[1, 2]").contains("allowed"));
        assert!(refusal(&numbers(3)).contains("has 3 numbers"));
        assert!(refusal(r#"{"genome": [1, 2e6]}"#).contains("genome[1]: 2000000 is not a valid gene"));

        assert_eq!(read(&reversed(|_| ())).unwrap(), (in_order, None));
        let other = refusal(&reversed(|names| names[0] = "bias".into()));
        assert!(other.contains("18 genes with other names"), "{other}");
        assert!(
            other.contains("it lacks `bias_right`, the controller has no `bias`; allowed: 18"),
            "{other}"
        );
        assert!(refusal(&reversed(|names| names.truncate(1))).contains("gene_names: has 1 name; allowed: 18"));
        let twice = refusal(&reversed(|names| names[1] = names[0].clone()));
        assert!(twice.contains("2 names are `bias_right`"), "{twice}");
    }
}
