//! Episodes that are commanded cycle by cycle.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use oneiro_host::api::{Task, stepped as api};
use pyo3::prelude::*;

use crate::done;
use crate::experiment::Experiment;

/// Episodes in an experiment's world.
#[pyclass(module = "oneiro._native")]
pub(crate) struct Stepped(api::Stepped);

/// Readings, rewards, fitness, cycles, and whether episodes have ended early.
type State<'py> = (
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<bool>>,
);

/// Numbers of episodes, with seeds and two more numbers each.
type Beginning<'py> = (
    PyReadonlyArray1<'py, usize>,
    PyReadonlyArray1<'py, u64>,
    PyReadonlyArray2<'py, u64>,
);

/// Actions, -1 to 1.
#[derive(FromPyObject)]
pub(crate) enum Actions<'py> {
    Single(PyReadonlyArray3<'py, f32>),
    Double(PyReadonlyArray3<'py, f64>),
}

impl Actions<'_> {
    /// As commands, 0 to 1. In double precision, so that a command from 2^-29 on that was made an action is the same again.
    fn commands(&self) -> PyResult<Vec<f32>> {
        let command = |action: f64| (0.5 * (action + 1.0)) as f32;
        Ok(match self {
            Self::Single(actions) => actions
                .as_slice()?
                .iter()
                .map(|&action| command(action.into()))
                .collect(),
            Self::Double(actions) => actions.as_slice()?.iter().map(|&action| command(action)).collect(),
        })
    }
}

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

    /// Robots of an episode.
    #[getter]
    fn robots(&self) -> usize {
        self.0.state().robots()
    }

    /// Which readings are 0 to 1.
    #[getter]
    fn bounded(&self) -> Vec<bool> {
        self.0.bounded()
    }

    #[getter]
    fn length(&self) -> u32 {
        self.0.length()
    }

    /// Steps episodes, by their numbers or all, by one cycle with `[episodes, robots, 2]` actions, and begins others.
    fn step(
        &mut self,
        py: Python<'_>,
        who: Option<PyReadonlyArray1<'_, usize>>,
        actions: Option<Actions<'_>>,
        begin: Option<Beginning<'_>>,
    ) -> PyResult<()> {
        let commands = actions.map_or_else(|| Ok(Vec::new()), |actions| actions.commands())?;
        let who = match who {
            Some(who) => who.as_slice()?.to_vec(),
            None if commands.is_empty() => Vec::new(),
            None => (0..self.0.state().cycles().len()).collect(),
        };
        let mut lives = Vec::new();
        if let Some((who, seeds, numbers)) = &begin {
            let numbers = numbers.as_slice()?.as_chunks().0;
            let each = who.as_slice()?.iter().zip(seeds.as_slice()?).zip(numbers);
            lives.extend(each.map(|((&life, &seed), &numbers)| (life, seed, numbers)));
        }
        done(py, || self.0.step(&who, &commands, &lives, &Task::default()))
    }

    /// The state of episodes, in new arrays.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<State<'py>> {
        let state = self.0.state();
        let [lives, robots] = [state.cycles().len(), state.robots()];
        let readings = state.readings().len() / lives / robots;
        Ok((
            PyArray1::from_slice(py, state.readings()).reshape([lives, robots, readings])?,
            PyArray1::from_slice(py, state.rewards()).reshape([lives, robots])?,
            PyArray1::from_slice(py, state.fitness()),
            PyArray1::from_slice(py, state.cycles()),
            PyArray1::from_slice(py, state.ended()),
        ))
    }

    /// Poses of all robots: x and y in mm, and the heading in turns.
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let state = self.0.state();
        let [lives, robots] = [state.cycles().len(), state.robots()];
        PyArray1::from_slice(py, state.poses().as_flattened()).reshape([lives, robots, 3])
    }
}

/// The arena of the foraging study.
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

    /// Poses of all robots: x and y in mm, and the heading in turns.
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let poses = self.0.poses();
        PyArray1::from_slice(py, poses.as_flattened()).reshape([poses.len(), 3])
    }
}
