//! Factors and their levels: their order, and which levels are grouped.

use oneiro_report::numbers::significant;

use super::Compared;

/// Maximum number of a factor's levels that are all shown. If there are more and they have an order, they are grouped in bins.
const MOST: usize = 10;
/// Number of bins, each with about the same number of runs.
const BINS: usize = 5;
/// Significant digits of the ends of a bin.
const DIGITS: usize = 3;

/// Type of a factor's levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Numbers in ascending order.
    Numbers,
    /// Lists of a lower and an upper end, ordered by width, then by lower end.
    Ranges,
    /// Anything else, in the order of the runs.
    Words,
}

/// A level as written in the table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) text: String,
    /// The number, or the range's width; NaN for words.
    pub(super) value: f64,
}

/// One level or several neighbouring ones whose runs are analysed together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    /// The level's text, or the ends of the bin.
    pub(super) label: String,
    /// First and last level.
    pub(super) first: usize,
    pub(super) last: usize,
}

/// A swept key.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// In order.
    pub(super) levels: Vec<Level>,
    pub(super) groups: Vec<Group>,
    /// The group of each level.
    group_of: Vec<usize>,
    compared: Compared,
}

impl Factor {
    /// Makes a factor from the levels of all runs. `runs` has indices into `texts`, which become indices into the
    /// ordered levels.
    pub(super) fn new(name: &str, compared: Compared, texts: Vec<String>, runs: &mut [u32]) -> Self {
        let (kind, mut order) = match compared {
            Compared::Levels => ordered(&texts),
            Compared::Conditions => words(&texts),
        };
        if kind == Kind::Words {
            let mut first = vec![usize::MAX; texts.len()];
            for (run, &place) in runs.iter().enumerate().rev() {
                first[place as usize] = run;
            }
            order.sort_by_key(|&(_, place)| first[place]);
        }
        let mut rank = vec![0; texts.len()];
        for (new, &(_, old)) in (0..).zip(&order) {
            rank[old] = new;
        }
        let mut counts = vec![0; texts.len()];
        for run in runs {
            *run = rank[*run as usize];
            counts[*run as usize] += 1;
        }
        let mut texts: Vec<Option<String>> = texts.into_iter().map(Some).collect();
        let levels: Vec<Level> = order
            .iter()
            .map(|&([value, _], old)| Level {
                text: texts[old].take().unwrap_or_default(),
                value,
            })
            .collect();
        let groups = groups(kind, &levels, &counts);
        let group_of = groups.iter().enumerate();
        let group_of = group_of.flat_map(|(place, group)| (group.first..=group.last).map(move |_| place));
        Self {
            name: name.to_owned(),
            kind,
            group_of: group_of.collect(),
            levels,
            groups,
            compared,
        }
    }

    /// Whether levels have an order.
    pub(super) fn is_ordered(&self) -> bool {
        self.kind != Kind::Words
    }

    /// Whether levels are grouped in bins.
    pub(super) fn is_binned(&self) -> bool {
        self.groups.len() < self.levels.len()
    }

    /// The group of a level.
    pub(super) fn group(&self, level: u32) -> usize {
        self.group_of[level as usize]
    }

    /// Name of its groups, singular and plural.
    pub(super) fn unit(&self) -> [&'static str; 2] {
        if self.is_binned() {
            ["bin", "bins"]
        } else {
            self.compared.names()
        }
    }
}

/// Kind of some texts, and their indices with sort keys, sorted; words keep their order.
fn ordered(texts: &[String]) -> (Kind, Vec<([f64; 2], usize)>) {
    let all = |keys: fn(&str) -> Option<[f64; 2]>| -> Option<Vec<([f64; 2], usize)>> {
        let keys = texts.iter().zip(0..).map(|(text, place)| Some((keys(text)?, place)));
        let mut keys: Vec<_> = keys.collect::<Option<_>>()?;
        keys.sort_by(|([a, c], i), ([b, d], j)| {
            let by_text = || texts[*i].cmp(&texts[*j]);
            a.total_cmp(b).then(c.total_cmp(d)).then_with(by_text)
        });
        Some(keys)
    };
    if let Some(keys) = all(|text| Some([number(text)?, 0.0])) {
        (Kind::Numbers, keys)
    } else if let Some(keys) = all(range) {
        (Kind::Ranges, keys)
    } else {
        words(texts)
    }
}

/// Some texts as words.
fn words(texts: &[String]) -> (Kind, Vec<([f64; 2], usize)>) {
    let places = (0..texts.len()).map(|place| ([f64::NAN; 2], place));
    (Kind::Words, places.collect())
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Width and lower end of a list of two ends.
fn range(text: &str) -> Option<[f64; 2]> {
    let (low, high) = text.strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
    let (low, high) = (number(low.trim())?, number(high.trim())?);
    // Rounded, so that [0.1, 0.4] is as wide as [0.2, 0.5].
    let width: f64 = format!("{:.12e}", high - low).parse().ok()?;
    (width >= 0.0).then_some([width, low])
}

/// One group for each level, or bins if there are too many levels.
fn groups(kind: Kind, levels: &[Level], counts: &[usize]) -> Vec<Group> {
    if kind == Kind::Words || levels.len() <= MOST {
        let label = |text: &str| if text.is_empty() { "not given" } else { text }.to_owned();
        let alone = levels.iter().enumerate().map(|(place, level)| Group {
            label: label(&level.text),
            first: place,
            last: place,
        });
        return alone.collect();
    }
    let all: usize = counts.iter().sum();
    let mut before = 0;
    let mut groups: Vec<(usize, Group)> = Vec::new();
    for (place, count) in counts.iter().enumerate() {
        // Position of the middle of the level's runs among all runs.
        let bin = BINS * (2 * before + count) / (2 * all).max(1);
        before += count;
        match groups.last_mut() {
            Some((last, group)) if *last == bin => group.last = place,
            _ => groups.push((
                bin,
                Group {
                    label: String::new(),
                    first: place,
                    last: place,
                },
            )),
        }
    }
    let labelled = groups.into_iter().map(|(_, mut group)| {
        let ends = [group.first, group.last].map(|end| significant(levels[end].value, DIGITS));
        let what = if kind == Kind::Ranges { "width " } else { "" };
        group.label = if ends[0] == ends[1] {
            format!("{what}{}", ends[0])
        } else {
            format!("{what}{} to {}", ends[0], ends[1])
        };
        group
    });
    labelled.collect()
}
