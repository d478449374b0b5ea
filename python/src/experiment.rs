//! Experiments, and the evaluation of genomes.

use std::ffi::CString;
use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray2};
use oneiro::compose::Scalar;
use oneiro_host::api::Task;
use oneiro_host::api::evaluate::{Outcome, Request};
use oneiro_host::api::experiment::{self as api, Portable};
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};

use crate::{SHORT, class, done, raised, watched};

/// A checked experiment. It can be pickled, with the files that it names.
#[pyclass(frozen, module = "oneiro", name = "Experiment", skip_from_py_object)]
#[derive(Clone)]
pub(crate) struct Experiment(pub(crate) api::Experiment);

/// A result, or the exception that it is in Python.
fn ok<T>(py: Python<'_>, result: oneiro_host::api::Result<T>) -> PyResult<T> {
    result.map_err(|error| raised(py, &error))
}

/// Values by their keys, as the command line takes them.
fn settings(py: Python<'_>, set: Option<Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let settings = py.import("oneiro._experiment")?.getattr("settings")?;
    settings.call1((set,))?.extract()
}

/// A row for each object.
fn rows<'py, const N: usize>(py: Python<'py>, objects: &[[f32; N]]) -> PyResult<Bound<'py, PyArray2<f32>>> {
    PyArray1::from_slice(py, objects.as_flattened()).reshape([objects.len(), N])
}

/// What a function of `oneiro._policy` makes of an experiment and something more.
fn of_policies<'py>(
    experiment: &Bound<'py, Experiment>,
    function: &str,
    argument: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let module = experiment.py().import("oneiro._policy")?;
    module.getattr(function)?.call1((experiment, argument))
}

#[pymethods]
impl Experiment {
    /// Reads an experiment's file, with other values for some keys, as `--set` does: `{"evolution.population": 50}`.
    #[staticmethod]
    #[pyo3(signature = (path, set = None))]
    fn load(py: Python<'_>, path: PathBuf, set: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let set = settings(py, set)?;
        let experiment = done(py, || api::Experiment::load(&path, &set))?;
        for warning in experiment.warnings() {
            let words = CString::new(warning.as_str())?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &words, 1)?;
        }
        Ok(Self(experiment))
    }

    /// An experiment that ships with Oneiro, with the files that it names: `Experiment.example("khepera-avoidance")`. A wrong name's
    /// error lists all; `oneiro new --example` also says what they are.
    #[staticmethod]
    #[pyo3(signature = (name, set = None))]
    fn example(py: Python<'_>, name: &str, set: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let set = settings(py, set)?;
        done(py, || api::Experiment::example(name, &set)).map(Self)
    }

    #[classmethod]
    fn _made(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        toml: String,
        files: Vec<(String, Vec<u8>)>,
        set: Vec<String>,
    ) -> PyResult<Self> {
        let portable = Portable { toml, files };
        done(py, || api::Experiment::from_portable(&portable, &set)).map(Self)
    }

    /// The experiment of a run whose only generation is these genomes.
    fn _adopting(&self, py: Python<'_>, genomes: PyReadonlyArray2<'_, f32>, trials: u32) -> PyResult<Self> {
        let genomes = genomes.as_slice()?;
        done(py, || self.0.adopting(genomes, trials)).map(Self)
    }

    /// The same experiment with other values for some keys, as `load` takes them.
    fn with_(&self, py: Python<'_>, set: Bound<'_, PyAny>) -> PyResult<Self> {
        let set = settings(py, Some(set))?;
        done(py, || api::Experiment::from_portable(&self.0.portable(), &set)).map(Self)
    }

    /// The same experiment with the values of its table `[test]`.
    fn tested_in(&self, py: Python<'_>) -> PyResult<Self> {
        done(py, || self.0.tested_in()).map(Self)
    }

    fn _with(&self, py: Python<'_>, set: Vec<String>) -> PyResult<Self> {
        done(py, || api::Experiment::from_portable(&self.0.portable(), &set)).map(Self)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let Portable { toml, files } = self.0.portable();
        let files: Vec<_> = files
            .iter()
            .map(|(name, bytes)| (name, PyBytes::new(py, bytes)))
            .collect();
        let arguments = (toml, files, Vec::<String>::new()).into_pyobject(py)?;
        Ok((class::<Self>(py).getattr("_made")?, arguments.into_any()))
    }

    fn __repr__(&self) -> String {
        format!("<oneiro.Experiment {:?} {}>", self.0.name(), &self.0.hash()[..12])
    }

    /// For notebooks: its main values, and all settings to unfold.
    fn _repr_html_(own: &Bound<'_, Self>) -> PyResult<String> {
        let html = own.py().import("oneiro._html")?.getattr("experiment")?.call1((own,))?;
        html.extract()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Self>();
        other.is_ok_and(|other| self.0.portable() == other.get().0.portable())
    }

    fn __hash__(&self) -> u64 {
        u64::from_str_radix(&self.0.hash()[..16], 16).unwrap_or_default()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// The seed in its file, if any.
    #[getter]
    fn seed(&self) -> Option<u64> {
        self.0.seed()
    }

    /// Warnings about its files and values.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings().to_vec()
    }

    /// Genes of a genome.
    #[getter]
    fn genes(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.gene_names(py)?.len())
    }

    /// Name of each gene.
    #[getter]
    fn gene_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        ok(py, self.0.gene_names())
    }

    /// `[genes, 2]`: minimum and maximum of each gene: its range, else `evolution.limits`, else -1e6 to 1e6.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let bounds = ok(py, self.0.bounds())?;
        let genes = bounds.len();
        PyArray1::from_vec(py, bounds.into_flattened()).reshape([genes, 2])
    }

    /// Hash of everything that decides its results, except the seed.
    #[getter]
    fn hash(&self) -> String {
        self.0.hash()
    }

    /// Episodes of each individual in its evolution.
    #[getter]
    fn trials(&self, py: Python<'_>) -> PyResult<u32> {
        ok(py, self.0.trials())
    }

    /// Maximum control cycles of an episode.
    #[getter]
    fn cycles(&self, py: Python<'_>) -> PyResult<u32> {
        ok(py, self.0.cycles())
    }

    /// Names of the measures of an episode, as `oneiro evaluate --measures` has them.
    #[getter]
    fn descriptor_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        ok(py, self.0.descriptor_names())
    }

    /// The place of each gene among the names of a table's columns, and a warning.
    fn _gene_columns(&self, py: Python<'_>, names: Vec<String>) -> PyResult<(Vec<usize>, Option<String>)> {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        ok(py, self.0.gene_columns(&names))
    }

    /// Names and `NumPy`'s types of the columns of traces.
    fn _trace_columns(&self, py: Python<'_>) -> PyResult<Vec<(String, &'static str)>> {
        let kind = |scalar| match scalar {
            Scalar::Float => "<f4",
            Scalar::Unsigned => "<u4",
            Scalar::Signed => "<i4",
        };
        let columns = ok(py, self.0.trace_columns())?.into_iter();
        Ok(columns.map(|(name, scalar)| (name, kind(scalar))).collect())
    }

    /// Every value by the key that `set` takes: `{"evolution.population": 100, ..}`.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?
            .getattr("loads")?
            .call1((ok(py, self.0.settings())?,))
    }

    /// The experiment as TOML with all defaults. `save` also writes the files that it names.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// Writes `to_toml` to a file, and the files that it names to `inputs/` in the same folder: `load` then has an equal experiment.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        done(py, || self.0.save(&path))
    }

    /// The same experiment with the network of a policy as its controller, and `genome_of(policy)` as the genome that is the policy.
    ///
    /// A policy is a trained model of Stable-Baselines3 (PPO, A2C, SAC, TD3, DDPG), a module of torch made of linear layers with tanh,
    /// relu or sigmoid between them, or a list of `Layer`. Its two outputs are an environment's actions: clipped to -1 to 1, or a tanh's.
    fn with_policy<'py>(own: &Bound<'py, Self>, policy: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        of_policies(own, "with_policy", policy)
    }

    /// `[genes]`: the weights of a policy, of the shape of this experiment's network.
    ///
    /// The genome's actions are the policy's up to rounding: other programs add in another order.
    fn genome_of<'py>(own: &Bound<'py, Self>, policy: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        of_policies(own, "genome_of", policy)
    }

    /// The layers of a genome, `[genes]`, whose weights are those of torch's `Linear`; `genome_of` has the same genome for them.
    fn layers_of<'py>(own: &Bound<'py, Self>, genome: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        of_policies(own, "layers_of", genome)
    }

    /// Walls, objects, lights and the floor, as arrays.
    #[getter]
    fn arena<'py>(own: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = own.py();
        let api::Arena {
            field,
            walls,
            circles,
            blocks,
            patches,
            lights,
        } = ok(py, own.get().0.arena())?;
        let made = (
            field,
            rows(py, &walls)?,
            rows(py, &circles)?,
            rows(py, &blocks)?,
            rows(py, &patches)?,
            rows(py, &lights)?,
        );
        py.import("oneiro._arena")?.getattr("made")?.call1(made)
    }
}

/// Names of the experiments that ship with a single robot each.
#[pyfunction]
pub(crate) fn examples_of_single_robots(py: Python<'_>) -> PyResult<Vec<&'static str>> {
    ok(py, api::examples_of_single_robots())
}

/// Fitness, measures and traces of genomes, and what they were computed by.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are those of `oneiro.evaluate`")]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    experiment: &Bound<'py, Experiment>,
    genomes: PyReadonlyArray2<'py, f32>,
    seed: u64,
    numbers: Option<PyReadonlyArray2<'py, u64>>,
    as_in_run: bool,
    episodes: usize,
    common_starts: bool,
    backend: &str,
    descriptors: Vec<String>,
    traces: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let experiment = &experiment.get().0;
    let genes = ok(py, experiment.gene_names())?.len();
    let [count, width] = [0, 1].map(|axis| genomes.as_array().shape()[axis]);
    if width != genes {
        let problem = format!("genomes: have {width} genes; allowed: {genes}");
        return Err(raised_input(py, problem));
    }
    let numbers = numbers.as_ref().map(|numbers| numbers.as_slice()).transpose()?;
    let request = Request {
        genomes: genomes
            .as_slice()
            .map_err(|_| PyValueError::new_err("genomes: not contiguous"))?,
        seed,
        numbers: numbers.map(|numbers| numbers.as_chunks().0),
        lives: episodes,
        common_starts,
        backend,
        descriptors: &descriptors,
        as_in_run,
        traces,
    };
    let task = Task::default();
    let work = || oneiro_host::api::evaluate::evaluate(experiment, &request, &task);
    let steps = (count.saturating_mul(episodes) as u64).saturating_mul(ok(py, experiment.cycles())?.into());
    let outcome: Outcome = if steps <= SHORT && !traces && descriptors.is_empty() {
        done(py, work)?
    } else {
        watched(py, &task, progress, work)?
    };
    let result = PyDict::new(py);
    let shape = [count, episodes];
    result.set_item("fitness", PyArray1::from_vec(py, outcome.fitness).reshape(shape)?)?;
    if !descriptors.is_empty() {
        let values: Bound<'_, PyArray3<f64>> =
            PyArray1::from_vec(py, outcome.descriptors).reshape([count, episodes, descriptors.len()])?;
        result.set_item("descriptors", values)?;
    }
    if traces {
        let cycles = ok(py, experiment.cycles())? as usize;
        let each = ok(py, experiment.trace_columns())?.len();
        let words: Bound<'_, PyArray4<u32>> =
            PyArray1::from_vec(py, outcome.traces).reshape([count, episodes, cycles, each])?;
        result.set_item("traces", words)?;
        result.set_item("lengths", PyArray1::from_vec(py, outcome.lengths).reshape(shape)?)?;
    }
    result.set_item("device", outcome.device)?;
    result.set_item("exact", outcome.exact)?;
    result.set_item("warnings", outcome.warnings)?;
    Ok(result)
}

/// An exception for bad input.
fn raised_input(py: Python<'_>, problem: String) -> PyErr {
    raised(py, &oneiro_host::api::Error::input(problem))
}
