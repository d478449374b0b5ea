//! The page without a server: as a file, or in parts for a program that shows them.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro_base::exit::Result;
use oneiro_lab::engine::handle::Engine;
use oneiro_report::numbers::significant;

use crate::pages;
use crate::scenes::engine;
use crate::server::give_way;
use crate::sources::Sources;

/// The width of the curve in pixels.
const WIDTH: u32 = 1000;

/// Folders, unchanged until the next look.
pub struct View {
    sources: Sources,
    engine: Engine,
}

impl View {
    /// # Errors
    /// Errors of the evaluator.
    pub fn new(folders: Vec<PathBuf>, stop: &Arc<AtomicBool>) -> Result<Self> {
        Ok(Self {
            sources: Sources::new(folders),
            engine: engine(stop)?,
        })
    }

    /// Looks at all directories, from now on with a low priority of this thread. Returns whether all have ended: each folder is a finished
    /// run or sweep, or a run that has stopped since the first look.
    pub fn look(&mut self) -> bool {
        give_way();
        self.sources.look();
        self.sources.have_ended()
    }

    /// The newest run's curve as SVG; empty if there is none.
    pub fn curve(&self) -> String {
        let newest = self.sources.newest_run();
        newest.map_or_else(String::new, |(_, run)| pages::curve(&self.sources, run, WIDTH))
    }

    /// The newest run's newest best in words, and its episode's page; `None` if there is none.
    ///
    /// # Errors
    /// Exit 5 if its files are damaged; exit 75 if it was stopped.
    pub fn episode(&self) -> Result<Option<(String, String)>> {
        let Some((_, run)) = self.sources.newest_run() else {
            return Ok(None);
        };
        Ok(run.saved.scene(None, &self.engine)?.map(|scene| {
            let fitness = significant(scene.fitness.into(), 6);
            let words = format!(
                "Generation {}: individual {}, fitness {fitness}",
                scene.generation, scene.individual
            );
            (words, scene.page)
        }))
    }

    /// Sweeps' cells, and the list of all directories, as HTML.
    pub fn tables(&self) -> String {
        pages::tables(&self.sources)
    }
}

/// The page about some folders as one file.
///
/// # Errors
/// As [`View`].
pub fn snapshot(folders: Vec<PathBuf>, stop: &Arc<AtomicBool>) -> Result<String> {
    let mut view = View::new(folders, stop)?;
    view.look();
    let (curve, episode) = (view.curve(), view.episode()?);
    Ok(pages::snapshot(&curve, episode.as_ref(), &view.tables()))
}
