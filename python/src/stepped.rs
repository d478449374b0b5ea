//! Episodes that are commanded cycle by cycle.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use oneiro_host::api::{Task, stepped as api};
use pyo3::prelude::*;

use crate::done;
use crate::experiment::Experiment;

/// Episodes in an experiment's world.
#[pyclass(module = "oneiro._native")]
pub(crate) struct Stepped(api::Stepped);

/// Readings, rewards, fitness, cycles, and whether episodes have ended early.
type State<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<bool>>,
);

#[pymethods]
impl Stepped {
    #[new]
    fn new(py: Python<'_>, experiment: &Bound<'_, Experiment>, lives: usize, backend: &str) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        done(py, || api::Stepped::new(experiment, lives, backend)).map(Self)
    }

    #[getter]
    fn names(&self) -> Vec<String> {
        self.0.names()
    }

    /// How many of the first readings are 0 to 1.
    #[getter]
    fn bounded(&self) -> usize {
        self.0.bounded()
    }

    #[getter]
    fn length(&self) -> u32 {
        self.0.length()
    }

    /// Begins episodes, by their numbers, with seeds and two more numbers each.
    fn begin(
        &mut self,
        py: Python<'_>,
        who: PyReadonlyArray1<'_, usize>,
        seeds: PyReadonlyArray1<'_, u64>,
        numbers: PyReadonlyArray2<'_, u64>,
    ) -> PyResult<()> {
        let numbers = numbers.as_slice()?.as_chunks().0;
        let each = who.as_slice()?.iter().zip(seeds.as_slice()?).zip(numbers);
        let lives: Vec<_> = each.map(|((&life, &seed), &numbers)| (life, seed, numbers)).collect();
        done(py, || self.0.begin(&lives, &Task::default()))
    }

    /// Steps episodes, by their numbers or all, by one cycle.
    fn step(
        &mut self,
        py: Python<'_>,
        who: Option<PyReadonlyArray1<'_, usize>>,
        commands: PyReadonlyArray2<'_, f32>,
    ) -> PyResult<()> {
        let who = match who {
            Some(who) => who.as_slice()?.to_vec(),
            None => (0..self.0.state().cycles().len()).collect(),
        };
        let commands = commands.as_slice()?;
        done(py, || self.0.step(&who, commands, &Task::default()))
    }

    /// The state of episodes, in new arrays.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<State<'py>> {
        let state = self.0.state();
        let lives = state.cycles().len();
        let rewards: Vec<f64> = state.rewards().iter().map(|&reward| reward.into()).collect();
        Ok((
            PyArray1::from_slice(py, state.readings()).reshape([lives, state.readings().len() / lives])?,
            PyArray1::from_vec(py, rewards),
            PyArray1::from_slice(py, state.fitness()),
            PyArray1::from_slice(py, state.cycles()),
            PyArray1::from_slice(py, state.ended()),
        ))
    }
}

/// The arena of a swarm.
#[pyclass(module = "oneiro._native")]
pub(crate) struct Arena(api::Arena);

/// Readings, and rewards.
type Robots<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f32>>);

#[pymethods]
impl Arena {
    #[new]
    fn new(py: Python<'_>, experiment: &Bound<'_, Experiment>, backend: &str) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        done(py, || api::Arena::new(experiment, backend)).map(Self)
    }

    #[classattr]
    fn names() -> [&'static str; api::ROBOT_READINGS.len()] {
        api::ROBOT_READINGS
    }

    #[getter]
    fn robots(&self) -> usize {
        self.0.robots()
    }

    #[getter]
    fn length(&self) -> u32 {
        self.0.length()
    }

    #[getter]
    fn cycle(&self) -> u32 {
        self.0.cycle()
    }

    fn begin(&mut self, py: Python<'_>, seed: u64, life: u64) -> PyResult<()> {
        done(py, || self.0.begin(seed, life))
    }

    fn step(&mut self, py: Python<'_>, speeds: PyReadonlyArray2<'_, f32>) -> PyResult<()> {
        let speeds = speeds.as_slice()?;
        done(py, || self.0.step(speeds))
    }

    /// The state of robots, in new arrays.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Robots<'py>> {
        let readings = PyArray1::from_vec(py, self.0.readings());
        Ok((
            readings.reshape([self.0.robots(), api::ROBOT_READINGS.len()])?,
            PyArray1::from_slice(py, self.0.rewards()),
        ))
    }
}
