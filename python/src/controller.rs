//! Controllers that are stepped with readings from elsewhere.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use oneiro_host::api::controller as api;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::experiment::Experiment;
use crate::{class, done, raised};

/// The controllers of some robots.
#[pyclass(module = "oneiro._native")]
pub(crate) struct Controllers(api::Controllers);

#[pymethods]
impl Controllers {
    #[new]
    fn new(
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        genomes: PyReadonlyArray2<'_, f32>,
        number: u32,
        robots: usize,
    ) -> PyResult<Self> {
        let (experiment, genomes) = (&experiment.get().0, genomes.as_slice()?);
        done(py, || api::Controllers::new(experiment, genomes, number, robots)).map(Self)
    }

    #[classmethod]
    fn _restored(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        genomes: Vec<f32>,
        number: u32,
        robots: usize,
        states: Vec<u32>,
    ) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        let mut own = done(py, || api::Controllers::new(experiment, &genomes, number, robots))?;
        own.restore(&states).map_err(|error| raised(py, &error))?;
        Ok(Self(own))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (experiment, genomes, number) = self.0.parts();
        let arguments = (
            Experiment(experiment.clone()),
            genomes,
            number,
            self.0.robots(),
            self.0.states(),
        );
        Ok((
            class::<Self>(py).getattr("_restored")?,
            arguments.into_pyobject(py)?.into_any(),
        ))
    }

    #[getter]
    fn experiment(&self) -> Experiment {
        Experiment(self.0.parts().0.clone())
    }

    #[getter]
    fn kind(&self) -> &str {
        self.0.kind()
    }

    #[getter]
    fn robots(&self) -> usize {
        self.0.robots()
    }

    /// Name, and unit, range and meaning of each reading.
    #[getter]
    fn inputs(&self) -> Vec<(String, String)> {
        let all = self.0.inputs().iter();
        all.map(|input| (input.name.clone(), input.about.clone())).collect()
    }

    #[getter]
    fn cycles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_vec(py, self.0.cycles())
    }

    fn reset(&mut self, seed: u64, numbers: PyReadonlyArray2<'_, u64>, life: usize) -> PyResult<()> {
        self.0.reset(seed, numbers.as_slice()?.as_chunks().0, life);
        Ok(())
    }

    fn step<'py>(
        &mut self,
        py: Python<'py>,
        readings: PyReadonlyArray1<'_, f32>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let readings = readings.as_slice()?;
        let outputs = done(py, || self.0.step(readings))?;
        PyArray1::from_vec(py, outputs).reshape([self.0.robots(), 2])
    }

    fn wheels<'py>(&self, py: Python<'py>, outputs: PyReadonlyArray1<'_, f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let outputs = outputs.as_slice()?;
        let speeds = done(py, || self.0.wheels(outputs))?;
        PyArray1::from_vec(py, speeds).reshape([self.0.robots(), 2])
    }
}
