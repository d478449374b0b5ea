//! Episodes that are commanded cycle by cycle.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use oneiro_host::api::{Task, experiment as api_experiment, stepped as api};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::experiment::Experiment;
use crate::{Shared, class, done};

/// Episodes in an experiment's world.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct Stepped {
    own: Shared<api::Stepped>,
    experiment: api_experiment::Experiment,
}

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
    fn new(py: Python<'_>, experiment: &Bound<'_, Experiment>, episodes: usize, backend: &str) -> PyResult<Self> {
        let experiment = experiment.get().0.clone();
        let own = done(py, || api::Stepped::new(&experiment, episodes, backend))?;
        let own = Shared::new(own);
        Ok(Self { own, experiment })
    }

    #[classmethod]
    fn _restored(
        _: &Bound<'_, PyType>,
        py: Python<'_>,
        experiment: &Bound<'_, Experiment>,
        lives: usize,
        backend: &str,
        state: PyReadonlyArray1<'_, u32>,
    ) -> PyResult<Self> {
        let made = Self::new(py, experiment, lives, backend)?;
        let state = state.as_slice()?;
        made.own.done(py, |own| own.restore(state))?;
        Ok(made)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (lives, backend, state) = self.own.with(py, |own| {
            let (lives, backend) = own.parts();
            (lives, backend.to_owned(), own.state().saved())
        });
        let experiment = Experiment(self.experiment.clone());
        let arguments = (experiment, lives, backend, PyArray1::from_vec(py, state));
        Ok((
            class::<Self>(py).getattr("_restored")?,
            arguments.into_pyobject(py)?.into_any(),
        ))
    }

    #[getter]
    fn names(&self, py: Python<'_>) -> Vec<String> {
        self.own.with(py, |own| own.names())
    }

    /// Robots of an episode.
    #[getter]
    fn robots(&self, py: Python<'_>) -> usize {
        self.own.with(py, |own| own.state().robots())
    }

    /// Which readings are 0 to 1.
    #[getter]
    fn bounded(&self, py: Python<'_>) -> Vec<bool> {
        self.own.with(py, |own| own.bounded())
    }

    #[getter]
    fn length(&self, py: Python<'_>) -> u32 {
        self.own.with(py, |own| own.length())
    }

    /// Steps episodes, by their numbers or all, by one cycle with `[episodes, robots, 2]` actions, and begins others.
    fn step(
        &self,
        py: Python<'_>,
        who: Option<PyReadonlyArray1<'_, usize>>,
        actions: Option<Actions<'_>>,
        begin: Option<Beginning<'_>>,
    ) -> PyResult<()> {
        let commands = actions.map_or_else(|| Ok(Vec::new()), |actions| actions.commands())?;
        let who = match &who {
            Some(who) => Some(who.as_slice()?),
            // Without actions none is stepped.
            None => commands.is_empty().then_some(&[][..]),
        };
        let mut lives = Vec::new();
        if let Some((who, seeds, numbers)) = &begin {
            let numbers = numbers.as_slice()?.as_chunks().0;
            let each = who.as_slice()?.iter().zip(seeds.as_slice()?).zip(numbers);
            lives.extend(each.map(|((&life, &seed), &numbers)| (life, seed, numbers)));
        }
        self.own
            .done(py, |own| own.step(who, &commands, &lives, &Task::default()))
    }

    /// The state of episodes, in new arrays.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<State<'py>> {
        let (robots, readings, rewards, fitness, cycles, ended) = self.own.with(py, |own| {
            let state = own.state();
            (
                state.robots(),
                state.readings().to_vec(),
                state.rewards().to_vec(),
                state.fitness().to_vec(),
                state.cycles().to_vec(),
                state.ended().to_vec(),
            )
        });
        let lives = cycles.len();
        let each = readings.len() / lives / robots;
        Ok((
            PyArray1::from_vec(py, readings).reshape([lives, robots, each])?,
            PyArray1::from_vec(py, rewards).reshape([lives, robots])?,
            PyArray1::from_vec(py, fitness),
            PyArray1::from_vec(py, cycles),
            PyArray1::from_vec(py, ended),
        ))
    }

    /// Poses of all robots: x and y in mm, and the heading in turns.
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let (robots, poses) = self.own.with(py, |own| {
            let state = own.state();
            (state.robots(), state.poses().as_flattened().to_vec())
        });
        let lives = poses.len() / robots / 3;
        PyArray1::from_vec(py, poses).reshape([lives, robots, 3])
    }
}

/// The arena of the foraging study.
#[pyclass(frozen, module = "oneiro._native")]
pub(crate) struct Arena(Shared<api::Arena>);

/// Readings, and rewards.
type Robots<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f32>>);

#[pymethods]
impl Arena {
    #[new]
    fn new(py: Python<'_>, experiment: &Bound<'_, Experiment>, backend: &str) -> PyResult<Self> {
        let experiment = &experiment.get().0;
        done(py, || api::Arena::new(experiment, backend)).map(|own| Self(Shared::new(own)))
    }

    #[classattr]
    fn names() -> [&'static str; api::ROBOT_READINGS.len()] {
        api::ROBOT_READINGS
    }

    #[getter]
    fn robots(&self, py: Python<'_>) -> usize {
        self.0.with(py, |own| own.robots())
    }

    #[getter]
    fn length(&self, py: Python<'_>) -> u32 {
        self.0.with(py, |own| own.length())
    }

    #[getter]
    fn cycle(&self, py: Python<'_>) -> u32 {
        self.0.with(py, |own| own.cycle())
    }

    fn begin(&self, py: Python<'_>, seed: u64, episode: u64) -> PyResult<()> {
        self.0.done(py, |own| own.begin(seed, episode))
    }

    fn step(&self, py: Python<'_>, speeds: PyReadonlyArray2<'_, f32>) -> PyResult<()> {
        let speeds = speeds.as_slice()?;
        self.0.done(py, |own| own.step(speeds))
    }

    /// The state of robots, in new arrays.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Robots<'py>> {
        let (readings, rewards) = self.0.with(py, |own| (own.readings(), own.rewards().to_vec()));
        let shape = [rewards.len(), api::ROBOT_READINGS.len()];
        Ok((
            PyArray1::from_vec(py, readings).reshape(shape)?,
            PyArray1::from_vec(py, rewards),
        ))
    }

    /// Poses of all robots: x and y in mm, and the heading in turns.
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let poses = self.0.with(py, |own| own.poses());
        PyArray1::from_slice(py, poses.as_flattened()).reshape([poses.len(), 3])
    }
}
