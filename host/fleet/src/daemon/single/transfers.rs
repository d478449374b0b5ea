//! A robot's measurements: the episodes of the controllers that it has tried, and its next controller.

use oneiro_base::contents::{Column, Entry, head};
use oneiro_base::disk;
use oneiro_base::npy::npy;
use oneiro_evolve::{Champion, by_fitness};
use serde::{Deserialize, Serialize};

use crate::daemon::keeper::{CHECKPOINT, Kept};

/// The table of transfers, and the best controller so far.
pub(crate) const TRANSFERS: &str = "transfers.csv";
pub const BEST: &str = "best.npy";
pub static COLUMNS: [Column; 9] = [
    Column::whole("transfer", "", "its number, from 0"),
    Column::text(
        "why",
        "`new`: the simulator's best; `again`: the best measured so far, once more; `final`: the one that the robot has gone back to",
    ),
    Column::whole(
        "generation",
        "",
        "the simulated generation that the controller comes from",
    ),
    Column::whole("individual", "", "its index in that generation"),
    Column::number("simulated", "", "its score there"),
    Column::number("measured", "", "its fitness in this episode on the robot"),
    Column::text("bits", "the same as its 32 bits, in hex"),
    Column::whole(
        "lives",
        "",
        "episodes that this controller has had on the robot by then",
    ),
    Column::number("mean", "", "their mean fitness, by which controllers are compared"),
];

/// How controllers are transferred to the robot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rules {
    /// Simulated generations from one transfer to the next.
    pub generations: u32,
    /// Every how many transfers the best measured controller is tried again instead of a new one; 0 for never.
    pub(crate) again_every: u32,
    /// Episodes that the best measured controller must have had before the robot returns to it.
    pub(crate) least_lives: u32,
    /// Episodes of the controller that the robot has returned to.
    pub(crate) final_lives: u32,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            generations: 10,
            again_every: 4,
            least_lives: 3,
            final_lives: 1,
        }
    }
}

/// Why a controller is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Why {
    /// It is the simulator's best.
    New,
    /// It is the best measured so far, perhaps by one lucky episode.
    Again,
    /// It is the one that the robot has gone back to.
    Final,
}

impl Why {
    /// For tables and logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Again => "again",
            Self::Final => "final",
        }
    }
}

/// A controller's episode on the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    pub why: Why,
    /// The controller, with its place and score in the simulator.
    pub controller: Champion,
    pub measured: f32,
}

/// A controller's measured fitness.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    pub controller: &'a Champion,
    pub lives: u32,
    pub mean: f32,
}

impl<'a> Standing<'a> {
    /// From a controller's episodes among some.
    fn of(transfers: &[Transfer], controller: &'a Champion) -> Self {
        let of_controller = lives(transfers, controller);
        let (lives, sum) = of_controller.fold((0, 0.0), |(lives, sum), fitness| (lives + 1, sum + f64::from(fitness)));
        Self {
            controller,
            lives,
            mean: (sum / f64::from(lives)) as f32,
        }
    }
}

/// What is saved of a robot between two transfers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Saved {
    /// Times that the daemon has been started.
    pub boots: u32,
    /// The evolution in the simulator, once it has begun.
    pub evolution: Option<Vec<u8>>,
    /// Whether that is over.
    pub(crate) is_evolved: bool,
    /// The simulator's best, if it was not tried yet.
    pub waiting: Option<Champion>,
    /// Every episode on the robot.
    pub transfers: Vec<Transfer>,
}

impl Saved {
    /// The robot's next try; nothing if it has to wait for the simulator, or if all is done.
    pub fn next(&self, rules: &Rules) -> Option<(Why, &Champion)> {
        let best = self.best();
        let is_due = rules.again_every > 0 && (self.transfers.len() as u32 + 1).is_multiple_of(rules.again_every);
        match (&self.waiting, best) {
            // The last one of the evolution is tried in any case.
            (Some(_), Some(best)) if is_due && !self.is_evolved => Some((Why::Again, best.controller)),
            (Some(new), _) => Some((Why::New, new)),
            (None, Some(best)) if self.is_evolved => {
                if best.lives < rules.least_lives {
                    return Some((Why::Again, best.controller));
                }
                let is_final =
                    |transfer: &&Transfer| transfer.why == Why::Final && is_same(&transfer.controller, best.controller);
                let done = self.transfers.iter().filter(is_final).count();
                (done < rules.final_lives as usize).then_some((Why::Final, best.controller))
            }
            (None, _) => None,
        }
    }

    /// The controller with the highest mean; of equals the first that was tried.
    pub fn best(&self) -> Option<Standing<'_>> {
        let is_first = |&transfer: &usize| {
            lives(&self.transfers[..transfer], self.controller(transfer))
                .next()
                .is_none()
        };
        let firsts = (0..self.transfers.len()).filter(is_first);
        let standings = firsts.map(|transfer| Standing::of(&self.transfers, self.controller(transfer)));
        standings.reduce(|best, standing| {
            if by_fitness(standing.mean, best.mean).is_lt() {
                standing
            } else {
                best
            }
        })
    }

    fn controller(&self, transfer: usize) -> &Champion {
        &self.transfers[transfer].controller
    }

    fn table(&self) -> String {
        let row = |(number, transfer): (usize, &Transfer)| {
            let Transfer {
                why,
                controller,
                measured,
            } = transfer;
            let Standing { lives, mean, .. } = Standing::of(&self.transfers[..=number], controller);
            format!(
                "{number},{},{},{},{},{measured},{:08x},{lives},{mean}\n",
                why.word(),
                controller.generation,
                controller.individual,
                controller.fitness,
                measured.to_bits()
            )
        };
        let rows = self.transfers.iter().enumerate().map(row);
        head(&COLUMNS) + &rows.collect::<String>()
    }
}

/// The fitness of a controller's episodes among some.
fn lives<'a>(transfers: &'a [Transfer], controller: &'a Champion) -> impl Iterator<Item = f32> + 'a {
    let of_controller = transfers
        .iter()
        .filter(|transfer| is_same(&transfer.controller, controller));
    of_controller.map(|transfer| transfer.measured)
}

/// Whether two individuals have the same genes.
fn is_same(one: &Champion, other: &Champion) -> bool {
    let [one, other] = [one, other].map(|champion| champion.genome.iter().map(|gene| gene.to_bits()));
    one.eq(other)
}

impl Kept for Saved {
    const NAME: &'static str = "single robot's daemon";

    fn notes(&self) -> Vec<(&'static str, Vec<u8>)> {
        let table = (TRANSFERS, self.table().into_bytes());
        let best = self.best().map(|best| {
            let genome = &best.controller.genome;
            (BEST, npy(&[1, genome.len()], genome))
        });
        std::iter::once(table).chain(best).collect()
    }
}

/// Files of the daemon's directory.
pub fn contents() -> Vec<Entry> {
    vec![
        Entry::table(TRANSFERS, "every episode on the robot: one row per transfer", &COLUMNS),
        Entry::file(
            BEST,
            "the genes of the controller with the highest mean, as `oneiro evaluate --genomes` takes them",
        ),
        Entry::file(
            "lives",
            "the record of those episodes, and of interrupted ones, with its `README.md`",
        ),
        Entry::file(
            CHECKPOINT,
            "the daemon's checkpoint: the evolution between two transfers, and all measurements",
        ),
        Entry::file(
            "log.jsonl",
            "a line of JSON for each event; older ones are in `log-N.jsonl`",
        ),
        Entry::file(disk::LOCK, "keeps a second daemon out of the directory"),
    ]
}

#[cfg(test)]
mod tests {
    use super::Why::{Again, Final, New};
    use super::*;

    fn controller(gene: f32) -> Champion {
        Champion {
            generation: gene as u32,
            individual: 0,
            fitness: gene,
            genome: vec![gene],
        }
    }

    /// A robot on which each controller has these fitnesses in successive episodes tries controllers by the rules.
    fn tried(rules: &Rules, candidates: u32, measure: impl Fn(f32, usize) -> f32) -> (Saved, Vec<(Why, f32)>) {
        let mut saved = Saved::default();
        let mut new = 0;
        let mut all = Vec::new();
        loop {
            let next = saved.next(rules).map(|(why, next)| (why, next.clone()));
            if let Some((why, controller)) = next.clone() {
                let gene = controller.genome[0];
                let measured = measure(gene, lives(&saved.transfers, &controller).count());
                all.push((why, gene));
                saved.transfers.push(Transfer {
                    why,
                    controller,
                    measured,
                });
                saved.waiting = None;
            }
            if !saved.is_evolved {
                new += 1;
                saved.waiting = Some(controller(new as f32));
                saved.is_evolved = new == candidates;
            } else if next.is_none() {
                return (saved, all);
            }
        }
    }

    /// Controller 2 has one lucky episode, and 3 is the best on average.
    #[test]
    fn one_lucky_life_does_not_win() {
        let measure = |gene: f32, life| match (gene, life) {
            (2.0, 0) => 9.0,
            (2.0, _) => 1.0,
            (3.0, _) => 3.0,
            _ => 0.5,
        };
        let rules = Rules {
            generations: 1,
            again_every: 4,
            least_lives: 3,
            final_lives: 2,
        };
        let (saved, all) = tried(&rules, 6, measure);
        let expected = [
            (New, 1.0),
            (New, 2.0),
            (New, 3.0),
            // Instead of 4. Its mean is 5 then, and still the highest.
            (Again, 2.0),
            (New, 5.0),
            (New, 6.0),
            (Again, 2.0),
            // Its mean is 11 / 3 now, of enough episodes.
            (Final, 2.0),
            // As high as that of 3, which was tried later.
            (Final, 2.0),
            // No longer the highest.
            (Again, 3.0),
            (Again, 3.0),
            (Final, 3.0),
            (Final, 3.0),
        ];
        assert_eq!(all, expected);
        let best = saved.best().unwrap();
        assert_eq!((best.controller.genome[0], best.lives, best.mean), (3.0, 5, 3.0));
    }

    #[test]
    fn nothing_is_tried_again_where_nothing_is_due() {
        let rules = Rules {
            generations: 1,
            again_every: 0,
            least_lives: 1,
            final_lives: 0,
        };
        let (saved, all) = tried(&rules, 5, |gene, _| if gene == 4.0 { f32::NAN } else { -gene });
        assert_eq!(all, [1.0, 2.0, 3.0, 4.0, 5.0].map(|gene| (New, gene)));
        let best = saved.best().unwrap();
        assert_eq!((best.lives, best.mean), (1, -1.0));
        let table = saved.table();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(
            lines[0],
            "transfer,why,generation,individual,simulated,measured,bits,lives,mean"
        );
        assert_eq!(lines[2], "1,new,2,0,2,-2,c0000000,1,-2");
        // An episode whose fitness is no number ranks last, also if it is the only one.
        let (saved, _) = tried(&rules, 1, |_, _| f32::NAN);
        assert!(saved.best().unwrap().mean.is_nan());
    }
}
