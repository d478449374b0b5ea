//! Evolutions that are asked and told.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use oneiro_host::api::experiment as api;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};

use crate::experiment::Experiment;
use crate::{Shared, class, done};

/// An evolution, between two generations.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct Evolution {
    own: Shared<api::Evolution>,
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
        let own = Shared::new(own);
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
        let own = Self::new(py, experiment, seed)?;
        own.restore(py, state)?;
        Ok(own)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = (self.experiment(py), self.seed, self.state(py)).into_pyobject(py)?;
        Ok((class::<Self>(py).getattr("_restored")?, arguments.into_any()))
    }

    #[getter]
    fn experiment(&self, py: Python<'_>) -> Experiment {
        Experiment(self.own.with(py, |own| own.experiment().clone()))
    }

    #[getter]
    fn kind(&self, py: Python<'_>) -> &'static str {
        self.own.with(py, |own| own.kind())
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }

    #[getter]
    fn generation(&self, py: Python<'_>) -> u32 {
        self.own.with(py, |own| own.generation())
    }

    #[getter]
    fn is_finished(&self, py: Python<'_>) -> bool {
        self.own.with(py, |own| own.is_finished())
    }

    /// Generation, individual, score and genes of the luckiest so far.
    fn luckiest<'py>(&self, py: Python<'py>) -> Option<(u32, u32, f32, Bound<'py, PyArray1<f32>>)> {
        let (generation, individual, score, genes) = self.own.with(py, |own| {
            let (generation, individual, score, genes) = own.luckiest()?;
            Some((generation, individual, score, genes.to_vec()))
        })?;
        Some((generation, individual, score, PyArray1::from_vec(py, genes)))
    }

    /// Cells, fitness, behaviours and genomes of its elites, their coverage and their quality; None without an archive.
    fn archive<'py>(&self, py: Python<'py>) -> PyResult<Option<Archive<'py>>> {
        let found = self.own.done(py, |own| {
            let described = own.descriptor_names()?.len();
            Ok(own.elites()?.map(|elites| (elites, described, own.ask().0)))
        })?;
        let Some((own, described, genes)) = found else {
            return Ok(None);
        };
        let count = own.cells.len();
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
        let (mean, sigma) = self.own.with(py, |own| own.distribution())?;
        Some((PyArray1::from_vec(py, mean), sigma))
    }

    fn ask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (genes, values) = self.own.with(py, |own| {
            let (genes, values) = own.ask();
            (genes, values.to_vec())
        });
        let count = values.len() / genes;
        PyArray1::from_vec(py, values).reshape([count, genes])
    }

    /// The generation and the number of each genome, one after the other.
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u64>>> {
        let keys = self.own.done(py, |own| own.keys())?;
        PyArray1::from_slice(py, keys.as_flattened()).reshape([keys.len(), 2])
    }

    #[getter]
    fn descriptor_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.own.done(py, |own| own.descriptor_names())
    }

    fn tell(
        &self,
        py: Python<'_>,
        fitness: PyReadonlyArray1<'_, f32>,
        behaviour: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (fitness, behaviour) = (fitness.as_slice()?, behaviour.as_slice()?);
        self.own.done(py, |own| own.tell(fitness, behaviour))
    }

    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.own.with(py, |own| own.state()))
    }

    fn restore(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        self.own.done(py, |own| own.restore(state))
    }
}
