//! A picture and a film of a replayed episode, where they are asked for.

use std::path::{Path, PathBuf};

use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::{self, EpisodeReplay, Film, Frames};

use super::Replay;

/// The longer side of the arena in a picture and in a film, in pixels.
const PICTURE: f64 = 880.0;
const FILM: f64 = 480.0;
/// Seconds that a film lasts by default, if the episode isn't shorter, and frames of a second.
#[cfg(feature = "film")]
const LASTING: f64 = 20.0;
#[cfg(feature = "film")]
const RATE: f64 = 25.0;
/// Frames of a film: a frame is about 5 kB.
#[cfg(feature = "film")]
const FRAMES: f64 = 3000.0;

/// Refuses files that can't be made.
pub(super) fn check(replay: &Replay<'_>) -> Result {
    let is = |file: &Path, ending: &str| file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
    for (option, file, endings) in [
        ("--picture", replay.picture, &["svg", "png"][..]),
        ("--film", replay.film, &["gif"]),
    ] {
        let Some(file) = file else { continue };
        let shown = file.display();
        if !endings.iter().any(|ending| is(file, ending)) {
            let allowed = endings
                .iter()
                .map(|ending| format!("FILE.{ending}"))
                .collect::<Vec<_>>();
            let allowed = allowed.join(" or ");
            return Err(Failure::input(format_args!(
                "{option} {shown}: its ending says no kind of file; allowed: {allowed}"
            )));
        }
        if cfg!(not(feature = "film")) && !is(file, "svg") {
            return Err(Failure::input(format_args!(
                "{option} {shown}: this build draws no pixels; allowed: --picture FILE.svg, or a build with the feature `film`"
            )));
        }
        if let Some(folder) = file.parent().filter(|own| !own.as_os_str().is_empty() && !own.is_dir()) {
            return Err(Failure::input(format_args!(
                "{option} {shown}: there is no folder {}; allowed: a file in a folder that exists",
                folder.display()
            )));
        }
    }
    Ok(())
}

/// Refuses a moment after the last of so many records.
pub(super) fn check_moment(replay: &Replay<'_>, every: u32, records: usize) -> Result {
    let cycles = u64::from(every) * records.saturating_sub(1) as u64;
    let last = cycles as f64 / 10.0;
    match replay.at {
        Some(at) if at > last => Err(Failure::input(format_args!(
            "--at {at}: is after the end of the episode; allowed: 0 to {last}"
        ))),
        _ => Ok(()),
    }
}

/// Writes the files; returns their paths, the picture's and the film's.
pub(super) fn write<F: Film>(replay: &Replay<'_>, frames: impl Fn(f64) -> F) -> Result<[Option<PathBuf>; 2]> {
    let written = |file: &Path, content: &[u8]| disk::write(file, content).map(|()| file.to_owned());
    let picture = replay.picture.map(|file| {
        let svg = frames(PICTURE).at(replay.at.unwrap_or(f64::INFINITY));
        match file.extension() {
            Some(ending) if ending.eq_ignore_ascii_case("svg") => written(file, svg.as_bytes()),
            _ => written(file, &png(&svg)),
        }
    });
    let film = replay.film.map(|file| written(file, &film(&frames(FILM), replay)?));
    Ok([picture.transpose()?, film.transpose()?])
}

/// Writes the page of several episodes too, and returns the other files' paths as text.
pub(super) fn write_with_page(
    replay: &Replay<'_>,
    episodes: &EpisodeReplay<'_>,
    page: &Path,
) -> Result<[Option<String>; 2]> {
    if !episodes.is_one_picture() && (replay.picture.is_some() || replay.film.is_some()) {
        return Err(Failure::input(
            "--generations: swarms of several generations are not in one picture or film; allowed: --generation N",
        ));
    }
    check_moment(replay, episodes.every, episodes.robots[0].len())?;
    plain::make_directory(replay.out).map_err(|error| Failure::unreadable(replay.out, &error))?;
    disk::write(page, figures::episode_page(episodes).as_bytes())?;
    Ok(write(replay, |side| Frames::new(episodes, side))?.map(|file| file.map(|file| file.display().to_string())))
}

#[cfg(feature = "film")]
use oneiro_report::raster::png;

/// The film, at the wanted speed.
#[cfg(feature = "film")]
fn film(frames: &impl Film, replay: &Replay<'_>) -> Result<Vec<u8>> {
    let speed = replay.speed.unwrap_or((frames.seconds() / LASTING).max(1.0));
    // GIF counts hundredths of a second. No two frames are of one record.
    let hundredths = (100.0 * (frames.step() / speed).max(1.0 / RATE)).round();
    let step = speed * 0.01 * hundredths;
    let count = (frames.seconds() / step).ceil() + 1.0;
    if count > FRAMES {
        return Err(Failure::input(format_args!(
            "--speed {speed}: the film has {count} frames; allowed: {FRAMES}, such as --speed {}",
            (speed * count / FRAMES).ceil()
        )));
    }
    Ok(oneiro_report::raster::gif(count as usize, hundredths as u16, |frame| {
        frames.at(frame as f64 * step)
    }))
}

#[cfg(not(feature = "film"))]
fn png(_: &str) -> Vec<u8> {
    unreachable!("it was refused")
}

#[cfg(not(feature = "film"))]
fn film(_: &impl Film, _: &Replay<'_>) -> Result<Vec<u8>> {
    unreachable!("it was refused")
}
