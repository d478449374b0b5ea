//! Small sweeps whose figures were computed with `SciPy`.

use std::fs;
use std::path::PathBuf;

use oneiro_report::page::check::{outside, part, unbalanced};

use super::levels::Factor;
use super::*;

/// Tables of a sweep on disk, for one test.
struct Example {
    directory: PathBuf,
    factors: Vec<String>,
    others: Vec<String>,
}

impl Drop for Example {
    fn drop(&mut self) {
        // A leftover in the temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.directory);
    }
}

/// A run: levels, seed and outcome.
type Run = (Vec<String>, u64, f64);

/// A row of `generations.csv`: run, time and value.
type Generation = (u64, u64, String);

impl Example {
    /// Writes tables of runs, each with three generations that rise to its outcome.
    fn new(name: &str, factors: &[&str], runs: &[Run]) -> Self {
        let rises =
            |(number, run): (u64, &Run)| [1, 2, 3].map(|i| (number, i - 1, (run.2 * i as f64 / 3.0).to_string()));
        let generations: Vec<Generation> = (0..).zip(runs).flat_map(rises).collect();
        Self::with(name, factors, runs, &generations)
    }

    fn with(name: &str, factors: &[&str], runs: &[Run], generations: &[Generation]) -> Self {
        let directory = std::env::temp_dir().join(format!("oneiro-sweep-report-{name}-{}", std::process::id()));
        fs::create_dir_all(&directory).expect("a directory");
        let mut results = csv::Writer::from_path(directory.join("results.csv")).expect("a file");
        let columns = ["run", "id"].iter().chain(factors);
        results
            .write_record(columns.chain(&["seed", "fitness", "generation_of_best", "result"]))
            .expect("a row");
        for (number, (levels, seed, outcome)) in runs.iter().enumerate() {
            let mut row = vec![number.to_string(), format!("{number:016x}")];
            row.extend_from_slice(levels);
            row.extend([
                seed.to_string(),
                outcome.to_string(),
                (number % 3).to_string(),
                format!("{number:064x}"),
            ]);
            results.write_record(&row).expect("a row");
        }
        results.flush().expect("a file");
        let mut text = String::from("run,generation,best\n");
        text.extend(
            generations
                .iter()
                .map(|(run, time, value)| format!("{run},{time},{value}\n")),
        );
        let this = Self {
            directory,
            factors: factors.iter().map(|&factor| factor.into()).collect(),
            others: vec!["generation_of_best".into()],
        };
        this.write("generations.csv", &text);
        this
    }

    fn write(&self, file: &str, text: &str) {
        fs::write(self.directory.join(file), text).expect("a file");
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.directory.join(file)).expect("a file")
    }

    /// Calls a function with the tables.
    fn tables<T>(&self, use_them: impl FnOnce(&Tables<'_>) -> T) -> T {
        let [results, generations] = ["results.csv", "generations.csv"].map(|file| self.directory.join(file));
        use_them(&Tables {
            title: "Noise & <size>",
            results: &results,
            generations: &generations,
            factors: &self.factors,
            compared: Compared::Levels,
            outcome: ("fitness", "fitness of the champion"),
            is_less_better: false,
            others: &self.others,
            unfinished: None,
            time: ("generation", "generation"),
            value: ("best", "best fitness"),
            spent: None,
        })
    }

    fn report(&self) -> Report {
        self.tables(report).unwrap_or_else(|failure| panic!("{failure}"))
    }

    /// Exit code and message of a failing report.
    fn failure(&self) -> (u8, String) {
        let failure = self.tables(report).map(|_| ()).expect_err("a failure");
        (failure.code(), failure.to_string())
    }
}

/// Variation of outcomes apart from levels.
fn noise(run: u32) -> u32 {
    (37 * run * run + 11 * run + 5) % 401
}

fn one_of<const N: usize>(texts: [&str; N]) -> [String; N] {
    texts.map(str::to_owned)
}

/// Three factors with unsorted levels, 4 seeds per cell, and one run without a number.
fn three(name: &str) -> Example {
    let mut runs = Vec::new();
    for (size, of_size) in [("20", 300), ("10", 0), ("40", 100)] {
        for (kind, of_kind) in [("hidden", 150), ("perceptron", 0)] {
            for (noisy, of_noise) in [("[0.0, 0.0]", 0), ("[0.0, 0.4]", 400), ("[0.0, 0.2]", 200)] {
                for seed in 1..=4 {
                    let run = runs.len() as u32;
                    let outcome = f64::from(3000 + of_size + of_kind + of_noise + noise(run)) / 10.0;
                    let outcome = if run == 33 { f64::NAN } else { outcome };
                    runs.push((one_of([size, kind, noisy]).into(), seed, outcome));
                }
            }
        }
    }
    Example::new(name, &["size", "kind", "noise.sensor"], &runs)
}

/// Five levels of one factor.
fn one(name: &str, seeds: u32) -> Example {
    let mut runs = Vec::new();
    for (level, effect) in [(1, 0), (2, 60), (3, 200), (4, 300), (5, 330)] {
        for seed in 0..seeds {
            let outcome = f64::from(1000 + effect + noise(runs.len() as u32)) / 10.0;
            runs.push((vec![level.to_string()], u64::from(seed), outcome));
        }
    }
    Example::new(name, &["parents"], &runs)
}

/// Where less is better, as of times, everything that is ranked is the other way round: the same runs with their outcomes' signs changed
/// have the same order.
#[test]
fn less_may_be_better() {
    let example = one("less", 8);
    let negated: Vec<_> = rows(&example.read("results.csv"))
        .iter()
        .map(|row| {
            (
                vec![row["parents"].clone()],
                row["seed"].parse().unwrap(),
                -row["fitness"].parse::<f64>().unwrap(),
            )
        })
        .collect();
    let more = Example::new("more", &["parents"], &negated).report();
    let less = example.tables(|tables| {
        report(&Tables {
            is_less_better: true,
            unfinished: None,
            spent: None,
            ..*tables
        })
    });
    let less = less.unwrap();
    assert!(less.html.contains("less is better") && less.html.contains("has the lowest mean"));
    assert!(more.html.contains("more is better") && more.html.contains("has the highest mean"));
    assert_eq!(less.json["best_cell"]["levels"], more.json["best_cell"]["levels"]);
    assert_eq!(less.json["best_cell"]["levels"]["parents"], "1");
    let numbers = |report: &Report| -> Vec<_> {
        let champions = report.json["champions"].as_array().unwrap();
        champions.iter().map(|run| run["run"].clone()).collect()
    };
    assert_eq!(numbers(&less), numbers(&more));
    assert_eq!(less.best, more.best);
    let order = |report: &Report| -> Vec<_> {
        rows(&report.cells_csv)
            .iter()
            .map(|row| row["parents"].clone())
            .collect()
    };
    assert_eq!(order(&less), order(&more));
    assert_eq!(order(&less)[0], "1");
    // The one with the best mean is also so by ranks.
    assert!(less.html.contains("lower end") && !less.html.contains("other way round"));
}

/// Keys that change together, as in a sweep's list, are tested once: the correction has no more tests than there are questions.
#[test]
fn keys_of_a_list_are_one_factor() {
    let mut runs = Vec::new();
    for (population, generations) in [("20", "200"), ("100", "40"), ("400", "10")] {
        for noise_of in ["0.1", "0.2"] {
            for seed in 1..=4 {
                let outcome = f64::from(noise(runs.len() as u32));
                runs.push((one_of([population, noise_of, generations]).into(), seed, outcome));
            }
        }
    }
    let names = ["population", "noise", "generations"];
    let report = Example::new("list", &names, &runs).report();
    let effects = rows(&report.effects_csv);
    let of = |factor: &str| {
        effects
            .iter()
            .filter(|row| row["factor"] == factor && row["family"] == "levels")
            .count()
    };
    assert_eq!([of("population"), of("noise"), of("generations")], [3, 1, 0]);
    let html = &report.html;
    assert!(html.contains("changes with population") && html.contains("It changes only together with population"));
    // What is drawn at random changes in each run, and yet not together.
    let drawn = |run: u32, by: u32| format!("{:.3}", f64::from(by * run * run % 101) / 101.0);
    let runs: Vec<_> = (0..40)
        .map(|run| {
            (
                vec![drawn(run, 7), drawn(run, 13)],
                u64::from(run),
                f64::from(noise(run)),
            )
        })
        .collect();
    let report = Example::new("drawn", &["a", "b"], &runs).report();
    assert!(!report.html.contains("changes with"));
}

/// Fifty levels drawn at random, one run each.
fn random(name: &str) -> Example {
    let run = |run: u32| {
        let level = f64::from((7 * run * run + 13 * run + 3) % 1009) / 1009.0;
        (
            vec![format!("{level:.6}")],
            u64::from(run),
            f64::from(500 + noise(run)) / 10.0,
        )
    };
    Example::new(name, &["scale"], &(0..50).map(run).collect::<Vec<_>>())
}

/// Rows of a CSV file by column name.
fn rows(text: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.deserialize().map(|row| row.expect("as many cells as columns"));
    rows.collect()
}

/// Asserts that numbers equal the expected ones in the six printed digits.
fn agree(found: &std::collections::BTreeMap<String, String>, expected: &[(&str, f64)]) {
    for &(name, expected) in expected {
        let number: f64 = found[name].parse().unwrap_or(f64::NAN);
        assert!(
            (number - expected).abs() <= 6e-6 * expected.abs().max(1e-9),
            "{name}: {number}, not {expected}"
        );
    }
}

fn row_of<'a>(
    rows: &'a [std::collections::BTreeMap<String, String>],
    names: [(&str, &str); 4],
) -> &'a std::collections::BTreeMap<String, String> {
    let is = |row: &&std::collections::BTreeMap<String, String>| names.iter().all(|&(name, cell)| row[name] == cell);
    rows.iter().find(is).unwrap_or_else(|| panic!("no row {names:?}"))
}

#[test]
fn levels_are_compared_as_scipy_does() {
    let report = three("levels").report();
    let effects = rows(&report.effects_csv);
    let pair = |factor, first, second| {
        row_of(
            &effects,
            [
                ("family", "levels"),
                ("factor", factor),
                ("first", first),
                ("second", second),
            ],
        )
    };
    agree(
        pair("size", "20", "10"),
        &[
            ("n_first", 24.0),
            ("n_second", 23.0),
            ("difference", 30.729_710_144_927_65),
            ("a", 0.811_594_202_898_550_8),
            ("delta", 0.623_188_405_797_101_6),
            ("u", 448.0),
            ("p", 0.000_262_483_003_012_9),
            ("p_holm", 0.001_574_898_071_477),
            ("shared_seeds", 4.0),
        ],
    );
    agree(
        pair("size", "40", "20"),
        &[("p", 0.040_203_162_030_082), ("p_holm", 0.066_640_537_159_179)],
    );
    agree(
        pair("size", "40", "10"),
        &[("p", 0.033_320_268_579_594), ("p_holm", 0.066_640_537_159_179)],
    );
    agree(
        pair("kind", "perceptron", "hidden"),
        &[("a", 0.303_174_603_174_603), ("p_holm", 0.017_678_631_914_813)],
    );
    // Wider ranges are later levels.
    agree(
        pair("noise.sensor", "[0.0, 0.4]", "[0.0, 0.0]"),
        &[
            ("difference", 43.525),
            ("a", 0.951_388_888_888_889),
            ("p", 8.756_634_554e-8),
            ("p_holm", 6.129_644_188e-7),
        ],
    );
    agree(
        pair("noise.sensor", "[0.0, 0.2]", "[0.0, 0.0]"),
        &[("p", 0.005_481_176_550_1)],
    );
    assert_eq!(effects.iter().filter(|row| row["family"] == "levels").count(), 7);
    // NumPy's bootstrap of 20,000 resamples gives 0.355 to 0.837.
    let bounds = pair("size", "20", "10");
    for (end, expected) in [("delta_low", 0.355), ("delta_high", 0.837)] {
        let found: f64 = bounds[end].parse().expect("a number");
        assert!((found - expected).abs() < 0.03, "{end} {found}");
    }
}

#[test]
fn cells_are_ranked_and_compared_with_the_best() {
    let report = three("cells").report();
    let cells = rows(&report.cells_csv);
    assert_eq!(cells.len(), 18);
    let levels =
        |row: &std::collections::BTreeMap<String, String>| ["size", "kind", "noise.sensor"].map(|key| row[key].clone());
    assert_eq!(levels(&cells[0]), one_of(["20", "hidden", "[0.0, 0.4]"]));
    assert_eq!(levels(&cells[17]), one_of(["10", "perceptron", "[0.0, 0.0]"]));
    agree(
        &cells[0],
        &[
            ("cell", 1.0),
            ("runs", 4.0),
            ("n", 4.0),
            ("mean", 407.85),
            ("sd", 4.803_123_983_409_14),
            ("median", 407.0),
            ("min", 403.3),
            ("max", 414.1),
            ("mean_generation_of_best", 1.0),
        ],
    );
    agree(
        &cells[17],
        &[("mean", 316.45), ("sd", 5.059_973_649_47), ("median", 315.4)],
    );
    let lacking: Vec<_> = cells.iter().filter(|row| row["n"] == "3").collect();
    assert_eq!((lacking.len(), lacking[0]["runs"].as_str()), (1, "4"));
    let effects = rows(&report.effects_csv);
    let against = |second| {
        row_of(
            &effects,
            [("family", "cells"), ("factor", ""), ("first", "1"), ("second", second)],
        )
    };
    agree(
        against("2"),
        &[
            ("difference", 15.05),
            ("a", 1.0),
            ("a_low", 1.0),
            ("u", 16.0),
            ("p", 0.028_571_428_571),
        ],
    );
    agree(
        against("3"),
        &[
            ("difference", 23.2),
            ("a", 0.9375),
            ("delta", 0.875),
            ("p", 0.057_142_857_143),
        ],
    );
    agree(against("18"), &[("difference", 91.4), ("p_holm", 0.485_714_285_714)]);
    assert_eq!(effects.iter().filter(|row| row["family"] == "cells").count(), 17);
    // 17 tests, each with p of at least 2 / 70.
    let section = part(&report.html, "section", "effects");
    assert!(section.contains("no corrected p can be below 0.486"), "{section}");
    assert!(
        section.contains("have the same seeds") && section.contains("r = \u{2212}0.00465"),
        "{section}"
    );
}

#[test]
fn factors_are_explained_as_scipy_does() {
    let json = three("factors").report().json;
    let expected = [
        (
            "size",
            "20",
            Some("inside"),
            0.211_647_066_249_567_9,
            Some((14.815_294_637_469_75, 0.000_606_596_144_447)),
        ),
        ("kind", "hidden", None, 0.116_222_659_243_166, None),
        (
            "noise.sensor",
            "[0.0, 0.4]",
            Some("upper end"),
            0.475_515_972_793_798,
            Some((33.286_118_095_565, 1.183_154_04e-7)),
        ),
    ];
    for (factor, (name, best, place, explained, test)) in
        json["factors"].as_array().expect("factors").iter().zip(expected)
    {
        let is_near = |found: &serde_json::Value, expected: f64| {
            let found = found.as_f64().expect("a number");
            assert!(
                (found - expected).abs() < 1e-7 * expected,
                "{name}: {found}, not {expected}"
            );
        };
        assert_eq!(
            (
                factor["name"].as_str(),
                factor["best"].as_str(),
                factor["best_is"].as_str()
            ),
            (Some(name), Some(best), place)
        );
        is_near(&factor["epsilon_squared"], explained);
        match test {
            Some((h, p_holm)) => {
                is_near(&factor["kruskal_wallis"]["h"], h);
                is_near(&factor["kruskal_wallis"]["p_holm"], p_holm);
            }
            None => assert!(factor["kruskal_wallis"].is_null(), "two levels"),
        }
    }
    assert_eq!(
        (&json["runs"], &json["not_numbers"], &json["cells"]),
        (&72.into(), &1.into(), &18.into())
    );
    assert_eq!(json["champions"].as_array().map(Vec::len), Some(20));
    let best: Vec<_> = json["champions"]
        .as_array()
        .into_iter()
        .flatten()
        .take(3)
        .map(|run| run["run"].clone())
        .collect();
    assert_eq!(best, [7, 4, 6]);
}

#[test]
fn the_page_says_what_the_tables_hold() {
    let html = three("page").report().html;
    let overview = part(&html, "section", "factors");
    assert!(overview.contains(">inside<") && overview.contains(">upper end<"));
    let levels = part(&html, "table", "table-1");
    for words in [
        "<td class=\"short\">10</td><td class=\"number\">23 <span class=\"small\">(+1 NaN)</span></td>",
        ">344.9<",
        ">334.5 to 355.3<",
    ] {
        assert!(levels.contains(words), "{words} in {levels}");
    }
    let curves = part(&html, "section", "curves");
    assert!(
        curves.contains(
            "The best of 3 levels is <b>20</b>, with a mean of 375.6, <b>inside</b> what was swept, 10 to 40."
        )
    );
    assert!(curves.contains("Against 40, the better of the two ends: A\u{a0}=\u{a0}0.674 (95\u{a0}%: 0.51 to 0.825), corrected p\u{a0}=\u{a0}0.0666, undecided: no significant difference."));
    assert!(curves.contains(
        "the <b>upper end</b> of what was swept, [0.0, 0.0] to [0.0, 0.4], by width: what lies above was not tried"
    ));
    assert!(
        curves.contains("The best of 2 levels is <b>hidden</b>")
            && curves.contains("Against perceptron, the other: A\u{a0}=\u{a0}0.697")
    );
    // Size and noise: 8 runs, of both kinds; one has no number.
    let pair = part(&html, "figure", "pair-2");
    assert!(
        pair.contains(">396.2<") && pair.matches(">7 runs<").count() == 1 && pair.matches(">8 runs<").count() == 8,
        "{pair}"
    );
    let champions = part(&html, "section", "champions");
    assert!(champions.contains("oneiro sweep extract DIR 7</code>") && champions.contains("<code>000000000000</code>"));
    assert_eq!(champions.matches("<tr>").count(), 1 + 20);
    assert!(!html.contains("were run at all"));
    assert!(html.contains("<dt>NaN</dt><dd>1 run has an outcome that is no number, left out of all else</dd>"));
}

#[test]
fn pages_are_well_formed_and_need_nothing_else() {
    let hostile = |name| {
        let levels = ["a\"b", "<i>", "x, y\nz", "&amp;"];
        let runs = (0..40_u32).map(|run| {
            let [first, second] = [run % 4, run / 4 % 3].map(|level| levels[level as usize].to_owned());
            (vec![first, second], u64::from(run / 12), f64::from(noise(run)) - 200.0)
        });
        Example::new(name, &["<b>", "\"c\"&d"], &runs.collect::<Vec<_>>())
    };
    for example in [
        three("well"),
        one("well-one", 4),
        random("well-random"),
        hostile("well-hostile"),
    ] {
        let report = example.report();
        let html = &report.html.replace("<dt>NaN</dt>", "");
        assert_eq!(unbalanced(html), None);
        let (before, after) = html.split_once("<script>").unwrap_or((html, ""));
        let after = after.split_once("</script>").map_or("", |(_, after)| after);
        assert_eq!(outside(before).or(outside(after)), None);
        assert!(
            !html.contains("NaN,") && !html.contains(">NaN<") && !html.contains("inf"),
            "no number stays unsaid"
        );
        let ids = html.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let mut ids: Vec<&str> = ids.collect();
        let all = ids.len();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), all, "an id stands twice");
        assert!(html.contains("Noise &amp; &lt;size&gt;") && !html.contains("<i>"));
        assert_eq!(report, example.report(), "the same each time");
    }
}

#[test]
fn all_pairs_of_few_cells_are_compared() {
    let report = one("few", 4).report();
    let effects = rows(&report.effects_csv);
    let pair = |first, second| {
        row_of(
            &effects,
            [
                ("family", "cells"),
                ("factor", ""),
                ("first", first),
                ("second", second),
            ],
        )
    };
    agree(
        pair("1", "2"),
        &[
            ("difference", 4.975),
            ("a", 0.6875),
            ("u", 11.0),
            ("p", 0.485_714_285_714),
            ("p_holm", 1.0),
        ],
    );
    agree(
        pair("2", "5"),
        &[
            ("difference", 32.55),
            ("a", 0.9375),
            ("p", 0.057_142_857_143),
            ("p_holm", 0.4),
        ],
    );
    agree(pair("1", "5"), &[("p_holm", 0.285_714_285_714)]);
    assert_eq!(effects.iter().filter(|row| row["family"] == "cells").count(), 10);
    // With one factor, levels are cells: the same tests, but the later level is first.
    let levels = row_of(
        &effects,
        [
            ("family", "levels"),
            ("factor", "parents"),
            ("first", "5"),
            ("second", "4"),
        ],
    );
    agree(
        levels,
        &[("difference", -4.975), ("a", 0.3125), ("u", 5.0), ("p_holm", 1.0)],
    );
    let test = &report.json["factors"][0]["kruskal_wallis"];
    assert!((test["h"].as_f64().expect("a number") - 12.228_571_428_571_428).abs() < 1e-9);
    assert!((test["p"].as_f64().expect("a number") - 0.015_730_073_657_494_53).abs() < 1e-9);
    assert_eq!(report.json["factors"][0]["best_is"], "inside");
    assert!(!report.html.contains("id=\"pairs\""), "one factor is no pair");
}

#[test]
fn many_numbers_are_grouped_in_bins() {
    let report = random("bins").report();
    let factor = &report.json["factors"][0];
    assert_eq!((&factor["levels"], &factor["binned"]), (&50.into(), &true.into()));
    let expected = [
        ("0.000991 to 0.157", 68.1),
        ("0.166 to 0.333", 69.47),
        ("0.343 to 0.543", 71.02),
        ("0.55 to 0.757", 70.72),
        ("0.782 to 0.985", 63.78),
    ];
    for (group, (label, mean)) in factor["groups"].as_array().expect("groups").iter().zip(expected) {
        assert_eq!((&group["label"], &group["outcome"]["n"]), (&label.into(), &10.into()));
        assert!((group["outcome"]["mean"].as_f64().expect("a number") - mean).abs() < 1e-9);
    }
    assert_eq!(
        (&factor["best"], &factor["best_is"]),
        (&"0.343 to 0.543".into(), &"inside".into())
    );
    let h = factor["kruskal_wallis"]["h"].as_f64().expect("a number");
    assert!((h - 2.760_470_588_235_279).abs() < 1e-9, "{h}");
    let effects = rows(&report.effects_csv);
    let names = [
        ("family", "levels"),
        ("factor", "scale"),
        ("first", "0.782 to 0.985"),
        ("second", "0.343 to 0.543"),
    ];
    agree(
        row_of(&effects, names),
        &[("u", 30.0), ("p", 0.143_140_141_592_154), ("p_holm", 1.0)],
    );
    // With one run per cell, none is tested, and the page says so.
    assert_eq!(effects.len(), 10);
    assert!(part(&report.html, "section", "effects").contains("Fewer than two cells have 3 runs"));
    assert_eq!(part(&report.html, "section", "cells").matches("<tr>").count(), 1 + 50);
    let curves = part(&report.html, "section", "curves");
    assert!(curves.contains("The best of 5 bins") && curves.contains(">0.782 to 0.985</text>"));
}

#[test]
fn without_a_factor_there_is_nothing_to_compare() {
    let runs: Vec<Run> = (0..6).map(|run| (vec![], run, 10.0 + run as f64)).collect();
    let report = Example::new("none", &[], &runs).report();
    assert!(report.html.contains("Only the seed was swept") && report.html.contains(">All runs<"));
    assert!(report.html.contains("There are not two cells to compare."));
    assert_eq!(
        (report.effects_csv.lines().count(), rows(&report.cells_csv).len()),
        (1, 1)
    );
    agree(
        &rows(&report.cells_csv)[0],
        &[("n", 6.0), ("mean", 12.5), ("sd", 1.870_828_693_387)],
    );
    assert_eq!(report.html.matches("<circle").count(), 6);
    assert_eq!(unbalanced(&report.html), None);
}

#[test]
fn nothing_may_be_in_the_tables_yet() {
    let report = Example::new("empty", &["a", "b"], &[]).report();
    assert!(report.html.contains("nothing recorded") && report.html.contains(">no data<"));
    assert_eq!(unbalanced(&report.html), None);
    let nothing: Vec<Run> = (0..6).map(|run| (vec![(run % 2).to_string()], run, f64::NAN)).collect();
    let report = Example::new("nothing", &["a"], &nothing).report();
    assert!(report.html.contains("No run has an outcome that is a number.") && !report.html.contains(">NaN</td>"));
    assert_eq!(report.json["not_numbers"], 6);
}

#[test]
fn few_runs_are_not_tested() {
    let report = one("untested", 2).report();
    assert_eq!(report.effects_csv.lines().count(), 1);
    let section = part(&report.html, "section", "effects");
    assert!(section.contains("Not tested, for having fewer than 3 runs whose outcome is a number: 5 of the levels."));
    assert!(report.html.contains("too few runs to tell them apart"));
    assert!(report.json["factors"][0]["kruskal_wallis"].is_null());
}

#[test]
fn equal_outcomes_speak_for_no_difference() {
    let runs: Vec<Run> = (0..8).map(|run| (vec![(run % 2).to_string()], run / 2, 7.0)).collect();
    let report = Example::new("equal", &["a"], &runs).report();
    let effects = rows(&report.effects_csv);
    agree(
        &effects[0],
        &[
            ("difference", 0.0),
            ("a", 0.5),
            ("delta", 0.0),
            ("u", 8.0),
            ("p", 1.0),
            ("p_holm", 1.0),
        ],
    );
    assert_eq!(report.json["factors"][0]["best"], "0", "the first of equal ones");
}

#[test]
fn pairs_of_many_factors_are_those_that_explain_the_most() {
    let runs = (0..64_u32).map(|run| {
        let levels: Vec<u32> = (0..5).map(|bit| run >> bit & 1).collect();
        // The fourth factor has no effect.
        let outcome = [1, 4, 16, 0, 64]
            .iter()
            .zip(&levels)
            .map(|(effect, level)| effect * level)
            .sum::<u32>()
            + noise(run) % 3;
        (
            levels.iter().map(u32::to_string).collect(),
            u64::from(run / 32),
            f64::from(outcome),
        )
    });
    let html = Example::new("many", &["f1", "f2", "f3", "f4", "f5"], &runs.collect::<Vec<_>>())
        .report()
        .html;
    let section = part(&html, "section", "pairs");
    assert_eq!(
        (section.matches("<figure").count(), section.matches("<option").count()),
        (6, 6)
    );
    assert!(section.contains("Of 5 factors, the 4 that explain the most,") && !section.contains(">f4<"));
    assert!(section.contains("<option value=\"pair-1\">f1 and f2</option>"));
}

#[test]
fn many_unordered_levels_are_compared_with_the_best() {
    let runs = (0..135_u32).map(|run| {
        let levels = vec![format!("arenas/{}.toml", run % 45), (run % 2).to_string()];
        (levels, u64::from(run / 45), f64::from(run % 45))
    });
    let report = Example::new("words", &["arena", "b"], &runs.collect::<Vec<_>>()).report();
    let effects = rows(&report.effects_csv);
    let of_arena: Vec<_> = effects.iter().filter(|row| row["factor"] == "arena").collect();
    assert_eq!(of_arena.len(), 44);
    assert!(of_arena.iter().all(|row| row["first"] == "arenas/44.toml"));
    let figure = part(&report.html, "figure", "figure-1");
    assert_eq!(figure.matches("<polyline").count(), 10);
    assert!(figure.contains("Of 45 levels, the 10 with") && figure.contains("Of 45 levels, the 40 with"));
    assert!(figure.contains(">arenas/5.toml<") && !figure.contains(">arenas/4.toml<"));
    assert!(!report.html.contains("id=\"pairs\""), "45 columns are too many");
    assert!(part(&report.html, "section", "effects").contains("or, of more than 12, each against the best,"));
}

#[test]
fn squares_without_runs_are_seen() {
    let levels = [["1", "x"], ["1", "y"], ["2", "x"]];
    let runs: Vec<Run> = levels
        .iter()
        .cycle()
        .take(9)
        .zip(0..)
        .map(|(levels, run)| (one_of(*levels).into(), run / 3, run as f64))
        .collect();
    let html = Example::new("holes", &["a", "b"], &runs).report().html;
    let pair = part(&html, "figure", "pair-1");
    assert_eq!(
        (pair.matches(">3 runs<").count(), pair.matches(">no run<").count()),
        (3, 1)
    );
    assert!(html.contains("(3 of 4 were run at all)"));
}

#[test]
fn rows_of_one_time_count_as_their_mean() {
    let runs: Vec<Run> = (0..4)
        .map(|run| (vec![["a", "b"][run as usize % 2].to_owned()], run, 1.0))
        .collect();
    let row = |run, time, value: &str| (run, time, value.to_owned());
    // Two robots; at the first times no robot, or both, have a value.
    let generations = [
        row(1, 5, ""),
        row(1, 5, "3"),
        row(1, 6, "4"),
        row(1, 6, "6"),
        row(0, 5, "NaN"),
        row(0, 5, ""),
        row(0, 6, "1"),
        row(0, 6, "2"),
        row(3, 5, "5"),
        row(3, 5, "7"),
        row(3, 6, "inf"),
        row(3, 6, "9"),
        row(3, 8, "2"),
    ];
    let example = Example::with("robots", &["a"], &runs, &generations);
    let curves = example.tables(|tables| Curves::read(tables, &Runs::read(tables)?));
    let curves = curves.unwrap_or_else(|failure| panic!("{failure}")).remove(0);
    let means = |line: &curves::Line| {
        line.iter()
            .map(|(time, spread)| (*time, spread.mean))
            .collect::<Vec<_>>()
    };
    // Runs 1 and 3: 3 and 6, 5 and 9, and 2 alone.
    assert_eq!(means(&curves.groups[0][1]), [(5.0, 4.5), (6.0, 7.0), (8.0, 2.0)]);
    // Student's t of one degree of freedom is 12.7062.
    let band = curves.groups[0][1][0].1;
    assert!(
        (band.high - 4.5 - 12.706_204_736_432_095 * 1.5).abs() < 1e-9,
        "{band:?}"
    );
    assert_eq!(curves.groups[0][1][2].1.low, 2.0);
    let of_a = means(&curves.groups[0][0]);
    assert!(of_a[0].1.is_nan() && of_a[1].1 == 1.5 && of_a[2].1.is_nan());
    assert_eq!((curves.runs, curves.ends()), ((3, 1), (5.0, 8.0)));
    assert!(example.report().html.contains("means are of 1 to 3 runs in all"));
}

/// Runs of equal generations and unequal budgets, by both axes, in the requested order.
#[test]
fn curves_are_also_by_episodes_spent() {
    let text = |run: u64, scores: [f64; 2]| [0, 1].map(|time| (run, time, scores[time as usize].to_string()));
    let generations = [text(0, [3.0, 1.0]), text(1, [4.0, 8.0])].concat();
    let runs = [(vec!["a".into()], 1, 3.0), (vec!["b".into()], 1, 8.0)];
    let example = Example::with("episodes", &["f"], &runs, &generations);
    let read = |is_first| {
        let ends = [100, 200];
        example.tables(|tables| {
            let spent = Some(Spent { ends: &ends, is_first });
            let (all, html) = {
                let tables = Tables {
                    spent,
                    unfinished: None,
                    ..*tables
                };
                let all = Curves::read(&tables, &Runs::read(&tables).unwrap()).unwrap();
                (all, report(&tables).unwrap().html)
            };
            (all, html)
        })
    };
    let (all, html) = read(false);
    assert_eq!([&*all[0].across, &*all[1].across], ["generation", "episodes spent"]);
    let means = |line: &curves::Line| -> Vec<f64> { line.iter().map(|(_, spread)| spread.mean).collect() };
    let groups: Vec<Vec<f64>> = all[0].groups[0].iter().map(means).collect();
    assert_eq!(groups, [[3.0, 1.0], [4.0, 8.0]]);
    let at = |group: usize, time: f64| {
        let line = &all[1].groups[0][group];
        line.iter().find(|own| own.0 == time).unwrap().1.mean
    };
    // The best so far, from the end of the first generation to that of the budget.
    assert!(at(0, 50.0) == 3.0 && at(0, 100.0) == 3.0 && at(0, 101.0).is_nan());
    assert!(at(1, 99.0).is_nan() && at(1, 100.0) == 4.0 && at(1, 200.0) == 8.0);
    let places = |html: &str| {
        ["generation", "episodes spent"].map(|name| html.find(&format!("<g data-choice=\"{name}\"")).unwrap())
    };
    let [generation, episodes] = places(&html);
    assert!(generation < episodes && html.contains("(or by episodes spent: best score so far)"));
    let [generation, episodes] = places(&read(true).1);
    assert!(episodes < generation);
}

#[test]
fn long_runs_are_thinned_out_and_end_where_they_do() {
    let generations: Vec<Generation> = (0..1000).map(|time| (0, time, time.to_string())).collect();
    let example = Example::with("long", &[], &[(vec![], 1, 1.0)], &generations);
    let curves = example.tables(|tables| Curves::read(tables, &Runs::read(tables)?));
    let curves = curves.unwrap_or_else(|failure| panic!("{failure}")).remove(0);
    assert_eq!((curves.stride, curves.all.len()), (4, 251));
    let (last, spread) = curves.all[250];
    assert_eq!((last, spread.mean), (999.0, 999.0));
}

#[test]
fn levels_have_an_order_where_they_are_numbers_or_ranges() {
    let order = |texts: &[&str], runs: &[u32]| {
        let mut runs = runs.to_vec();
        let factor = Factor::new(
            "f",
            Compared::Levels,
            texts.iter().map(|&text| text.to_owned()).collect(),
            &mut runs,
        );
        let levels: Vec<String> = factor.levels.iter().map(|level| level.text.clone()).collect();
        (factor.kind, levels, runs)
    };
    let (kind, levels, runs) = order(&["10", "9.5", "-1e3"], &[0, 1, 2, 0]);
    assert_eq!((kind, runs.as_slice()), (levels::Kind::Numbers, &[2, 1, 0, 2][..]));
    assert_eq!(levels, ["-1e3", "9.5", "10"]);
    let (kind, levels, _) = order(&["[0.2, 0.5]", "[0.0, 0.4]", "[0.1, 0.4]", "[0, 0]"], &[0, 1, 2, 3]);
    assert_eq!(kind, levels::Kind::Ranges);
    assert_eq!(levels, ["[0, 0]", "[0.1, 0.4]", "[0.2, 0.5]", "[0.0, 0.4]"]);
    for words in [
        ["b", "10", "a"],
        ["[1, 2, 3]", "[0, 1]", "[0, 2]"],
        ["NaN", "1", "2"],
        ["[2, 1]", "[0, 1]", "[0, 2]"],
    ] {
        let (kind, levels, runs) = order(&words, &[2, 0, 1]);
        assert_eq!(kind, levels::Kind::Words);
        assert_eq!(levels, [words[2], words[0], words[1]], "in the order of runs");
        assert_eq!(runs, [0, 1, 2]);
    }
}

#[test]
fn a_bin_has_all_runs_of_its_levels() {
    let texts: Vec<String> = (0..11).map(|level| level.to_string()).collect();
    // Half of all runs have level 3: no bin splits them, and one bin is left empty.
    let mut runs: Vec<u32> = (0..11).chain(std::iter::repeat_n(3, 10)).collect();
    let factor = Factor::new("f", Compared::Levels, texts, &mut runs);
    let groups: Vec<(usize, usize)> = factor.groups.iter().map(|group| (group.first, group.last)).collect();
    assert_eq!(groups, [(0, 2), (3, 3), (4, 6), (7, 10)]);
    assert_eq!(factor.groups[1].label, "3");
    assert!(
        (0..11)
            .all(|level| (groups[factor.group(level)].0..=groups[factor.group(level)].1).contains(&(level as usize)))
    );
}

#[test]
fn errors_in_tables_name_their_line() {
    let example = one("corrupt", 3);
    let (results, generations) = (example.read("results.csv"), example.read("generations.csv"));
    let wrong = |file: &str, text: &str| {
        example.write("results.csv", &results);
        example.write("generations.csv", &generations);
        example.write(file, text);
        let (code, words) = example.failure();
        assert_eq!(code, 5, "{words}");
        assert!(words.contains(file), "{words}");
        words
    };
    let contains = |words: &str, part: &str| assert!(words.contains(part), "{words}");
    let results_wrong = |from: &str, to: &str| {
        assert!(results.contains(from));
        wrong("results.csv", &results.replacen(from, to, 1))
    };
    contains(
        &results_wrong(",seed,", ",sead,"),
        "line 1: has no column \u{201c}seed\u{201d}",
    );
    contains(
        &results_wrong("parents", "parent"),
        "line 1: has no column \u{201c}parents\u{201d}",
    );
    contains(
        &results_wrong("\n4,", "\n4,4,"),
        "line 6: has 8 cells; the table has 7 columns",
    );
    contains(
        &results_wrong("\n4,", "\nfour,"),
        "line 6: run: \u{201c}four\u{201d} is no whole number",
    );
    contains(
        &results_wrong("\n4,", "\n3,"),
        "line 6: run 3 stands in the table already",
    );
    contains(
        &results_wrong(",100.5,", ",high,"),
        "line 2: fitness: \u{201c}high\u{201d} is no number",
    );
    contains(&wrong("results.csv", ""), "line 1: is empty");
    contains(&wrong("results.csv", results.trim_end()), "line 16: is cut short");
    contains(&wrong("results.csv", &results[..results.len() - 80]), "line 16: has");
    let generations_wrong = |from: &str, to: &str| {
        assert!(generations.contains(from));
        wrong("generations.csv", &generations.replacen(from, to, 1))
    };
    contains(
        &generations_wrong("best", "least"),
        "line 1: has no column \u{201c}best\u{201d}",
    );
    contains(
        &generations_wrong("\n2,1,", "\n2,one,"),
        "line 9: generation: \u{201c}one\u{201d} is no whole number",
    );
    contains(
        &generations_wrong("\n2,0,", "\n2,2,"),
        "line 9: generation 1 of run 2 comes after 2",
    );
    contains(
        &generations_wrong("\n2,0,", "\n0,3,"),
        "line 8: run 0 has rows in two places",
    );
    contains(&generations_wrong("\n2,0,", "\n99,0,"), "line 8: run 99 is not in");
    contains(
        &wrong("generations.csv", generations.trim_end()),
        "line 46: is cut short",
    );
    example.write("generations.csv", &generations);
    let mut bytes = results.into_bytes();
    let last = bytes.len() - 2;
    bytes[last] = 0xff;
    fs::write(example.directory.join("results.csv"), bytes).expect("a file");
    let (code, words) = example.failure();
    assert_eq!(code, 5);
    contains(&words, "results.csv: line 16: is not UTF-8 text");
    fs::remove_file(example.directory.join("results.csv")).expect("a file");
    assert_eq!(example.failure().0, 3);
}
