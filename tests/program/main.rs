//! Tests of the program `oneiro`, from outside: a file each, and first what they share.

mod aseba;
mod contents;
mod disk;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../peers/khepera.rs"]
mod emulated;
#[cfg(feature = "compose")]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../exported/mod.rs"]
mod exported;
mod faults;
mod fixtures;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../hostile/world.rs"]
mod hostile;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../mutations/mod.rs"]
mod mutations;
#[path = "../peers/mod.rs"]
mod peers;
#[path = "../pinned/mod.rs"]
mod pinned;
mod place;
mod robots;
#[path = "../skips/mod.rs"]
mod skips;

mod champions;
#[cfg(feature = "compose")]
mod classics;
mod clients;
#[cfg(feature = "compose")]
mod coevolution;
mod commands;
mod compare;
#[cfg(feature = "native")]
mod documented;
mod elsewhere;
mod ends;
#[cfg(feature = "compose")]
mod evostick;
#[cfg(feature = "compose")]
mod export;
#[cfg(feature = "compose")]
mod extend;
#[cfg(all(feature = "native", feature = "twin"))]
mod foreign;
mod goldens;
#[cfg(all(feature = "native", feature = "twin"))]
mod kills;
mod machines;
#[cfg(feature = "compose")]
mod named;
#[cfg(feature = "compose")]
mod names;
#[cfg(feature = "native")]
mod one_hash;
#[cfg(feature = "compose")]
mod parametric;
#[cfg(feature = "compose")]
mod pictures;
/// `tests/all.sh` runs these at the same time as the others: they wait for robots, and leave the processors idle.
mod real_time;
mod reproduce;
mod run;
#[cfg(feature = "native")]
mod samples;
#[cfg(all(feature = "gpu", feature = "compose"))]
mod shipped;
mod swarm_runs;
mod sweep;
#[cfg(feature = "twin")]
mod twins;
mod watch;
