//! Evolutions that are asked and told.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use oneiro_host::api::experiment as api;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};

use crate::experiment::Experiment;
use crate::{class, done, raised};

/// An evolution, between two generations.
#[pyclass(module = "oneiro._native")]
pub(crate) struct Evolution {
    own: api::Evolution,
    seed: u64,
}

/// What Python gets of an archive.
type Archive<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f32>>,
    f64,
    f64,
);

#[pymethods]
impl Evolution {
    #[new]
    fn new(py: Python<'_>, experiment: &Bound<'_, Experiment>, seed: u64) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        let own = done(py, || api::Evolution::new(experiment, seed))?;
        Ok(Self { own, seed })
    }

    #[classmethod]
    fn _restored(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        seed: u64,
        state: &[u8],
    ) -> PyResult<Self> {
        let mut own = Self::new(py, experiment, seed)?;
        own.restore(py, state)?;
        Ok(own)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let experiment = Experiment(self.own.experiment().clone());
        let arguments = (experiment, self.seed, self.state(py)).into_pyobject(py)?;
        Ok((class::<Self>(py).getattr("_restored")?, arguments.into_any()))
    }

    #[getter]
    fn experiment(&self) -> Experiment {
        Experiment(self.own.experiment().clone())
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.own.kind()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }

    #[getter]
    fn generation(&self) -> u32 {
        self.own.generation()
    }

    #[getter]
    fn is_finished(&self) -> bool {
        self.own.is_finished()
    }

    /// Generation, individual, score and genes of the luckiest so far.
    fn luckiest<'py>(&self, py: Python<'py>) -> Option<(u32, u32, f32, Bound<'py, PyArray1<f32>>)> {
        let (generation, individual, score, genes) = self.own.luckiest()?;
        Some((generation, individual, score, PyArray1::from_slice(py, genes)))
    }

    /// Cells, fitness, behaviours and genomes of its elites, their coverage and their quality; None without an archive.
    fn archive<'py>(&self, py: Python<'py>) -> PyResult<Option<Archive<'py>>> {
        let Some(own) = self.own.elites().map_err(|error| raised(py, &error))? else {
            return Ok(None);
        };
        let count = own.cells.len();
        let described = self.own.descriptor_names().map_err(|error| raised(py, &error))?.len();
        let genes = self.own.ask().0;
        Ok(Some((
            PyArray1::from_vec(py, own.cells),
            PyArray1::from_vec(py, own.fitness),
            PyArray1::from_vec(py, own.behaviour).reshape([count, described])?,
            PyArray1::from_vec(py, own.genomes).reshape([count, genes])?,
            own.coverage,
            own.quality,
        )))
    }

    /// The genome around which a strategy samples, and its step size; None of others.
    fn distribution<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f32>>, f64)> {
        let (mean, sigma) = self.own.distribution()?;
        Some((PyArray1::from_vec(py, mean), sigma))
    }

    fn ask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (genes, values) = self.own.ask();
        PyArray1::from_slice(py, values).reshape([values.len() / genes, genes])
    }

    /// The generation and the number of each genome, one after the other.
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u64>>> {
        let keys = self.own.keys().map_err(|error| raised(py, &error))?;
        PyArray1::from_slice(py, keys.as_flattened()).reshape([keys.len(), 2])
    }

    #[getter]
    fn descriptor_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.own.descriptor_names().map_err(|error| raised(py, &error))
    }

    fn tell(
        &mut self,
        py: Python<'_>,
        fitness: PyReadonlyArray1<'_, f32>,
        behaviour: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (fitness, behaviour) = (fitness.as_slice()?, behaviour.as_slice()?);
        done(py, || self.own.tell(fitness, behaviour))
    }

    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.own.state())
    }

    fn restore(&mut self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        self.own.restore(state).map_err(|error| raised(py, &error))
    }
}
