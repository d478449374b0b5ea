//! Episodes of the newest best, simulated on one thread of this process.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use oneiro::cpu::Cpu;
use oneiro_base::exit::Result;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::record::SavedRun;
use oneiro_lab::runs::Scene;

/// Scenes that are kept; a page has at most 5 MB.
const KEPT: usize = 12;
/// How long the newest generation of a run stays the newest: a generation may take a millisecond.
const FRESH: Duration = Duration::from_secs(1);

/// Scenes, and what makes them.
pub(crate) struct Scenes {
    engine: Engine,
    kept: VecDeque<((String, u32), Arc<Scene>)>,
    newest: BTreeMap<String, (Instant, Option<Arc<Scene>>)>,
}

/// A simulator on one thread.
pub(crate) fn engine(stop: &Arc<AtomicBool>) -> Result<Engine> {
    Ok(Engine::new(Box::new(Cpu::new(Some(1))?), Arc::clone(stop)))
}

impl Scenes {
    pub(crate) fn new(stop: &Arc<AtomicBool>) -> Result<Mutex<Self>> {
        Ok(Mutex::new(Self {
            engine: engine(stop)?,
            kept: VecDeque::new(),
            newest: BTreeMap::new(),
        }))
    }

    /// The scene of a run's generation, or of its newest.
    pub(crate) fn of(
        scenes: &Mutex<Self>,
        id: &str,
        run: &SavedRun,
        generation: Option<u32>,
    ) -> Result<Option<Arc<Scene>>> {
        // A panic of a simulation leaves nothing half done.
        let mut own = scenes.lock().unwrap_or_else(PoisonError::into_inner);
        let known = match generation {
            Some(generation) => own
                .kept
                .iter()
                .find(|(key, _)| key.0 == id && key.1 == generation)
                .map(|(_, scene)| Some(scene)),
            None => own
                .newest
                .get(id)
                .filter(|(at, _)| at.elapsed() < FRESH)
                .map(|(_, scene)| scene.as_ref()),
        };
        if let Some(known) = known {
            return Ok(known.cloned());
        }
        let scene = run.scene(generation, &own.engine)?.map(Arc::new);
        if let Some(scene) = &scene {
            own.kept.retain(|(key, _)| key.0 != id || key.1 != scene.generation);
            own.kept
                .push_front(((id.to_owned(), scene.generation), Arc::clone(scene)));
            own.kept.truncate(KEPT);
        }
        if generation.is_none() {
            own.newest.retain(|_, (at, _)| at.elapsed() < FRESH);
            own.newest.insert(id.to_owned(), (Instant::now(), scene.clone()));
        }
        Ok(scene)
    }
}
