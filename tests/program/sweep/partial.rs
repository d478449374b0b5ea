//! Reports of sweeps that have not ended.

use super::*;

/// Stopped half-way by a kill, a sweep is reported on as far as it went, without a trace in its tables.
#[test]
fn a_stopped_sweep_is_reported_on_as_far_as_it_went() {
    let place = Place::with_sweep("killed", &long(150));
    let arguments = sweep("out", &["--threads", "1", "--jobs", "1"]);
    let mut child = place.start(&arguments);
    wait_for(|| place.at("out/shard-1-of-1/sessions.json").exists());
    wait_for(|| place.done("out") >= 2);
    // While it runs, too.
    place.run(&["sweep", "report", "out", "--out", "early"]).exits(0);
    child.kill().unwrap();
    ended(&arguments, child);
    let done = place.done("out");
    assert!((2..LONG_RUNS).contains(&done), "{done}");

    let said = place.run(&["sweep", "report", "out", "--json"]).exits(0);
    let words = format!("warning: out: is unfinished: {done} of {LONG_RUNS} runs; missing: ");
    let said = said.says(&[&words]);
    let report: Value = serde_json::from_str(&said.stdout).unwrap();
    assert_eq!(
        (&report["runs"], &report["planned_runs"]),
        (&done.into(), &LONG_RUNS.into())
    );
    assert_eq!(report["missing"].as_array().unwrap().len() as u64, LONG_RUNS - done);
    let page = place.text("out/report.html");
    assert!(
        page.contains(&format!("Unfinished: {done} of {LONG_RUNS} runs; missing: ")),
        "{page}"
    );
    for file in files(&place.at("out")).keys() {
        let name = file.to_str().unwrap();
        assert!(
            name != "results.csv" && name != "tables.json" && !name.contains("partial"),
            "{name}"
        );
    }

    // Its runs are those that the whole sweep has.
    place.swept("out", &[]);
    place.good(&["sweep", "report", "out", "--out", "whole"]);
    assert!(!place.text("whole/report.html").contains("Unfinished"));
    let whole: BTreeMap<String, String> = place
        .rows("out/results.csv")
        .into_iter()
        .map(|row| (row[0].clone(), row.join(",")))
        .collect();
    for champion in report["champions"].as_array().unwrap() {
        let row = &whole[&champion["run"].to_string()];
        assert!(row.contains(champion["result"].as_str().unwrap()), "{row}");
    }
}

/// A shard's report counts each cell's runs, and says which are too few, and which have none.
#[test]
fn a_shard_is_reported_on_by_itself() {
    let place = Place::with_sweep("shard", SWEEP);
    place.good(&sweep("part", &["--shard", "1/6"]));
    place
        .run(&["sweep", "report", "part"])
        .exits(0)
        .says(&["part: is unfinished: 2 of 12 runs; missing: 1 to 5, 7 to 11"]);
    let page = place.text("part/report.html");
    assert!(
        page.contains("<dt>cells</dt><dd>4</dd>")
            && page.contains("1 of 3 <span class=\"small\">too few to test</span>"),
        "{page}"
    );
    // Runs 0 and 6 are of the first and the third cell.
    let without = page.split("No run is finished yet of these cells:").nth(1).unwrap();
    let without = without.split("</ul>").next().unwrap();
    assert_eq!(without.matches("<li>").count(), 2);
    assert!(
        without.contains("<li>noise.sensor = [0.0, 0.0], evolution.population = 40</li>"),
        "{without}"
    );
    assert_eq!(place.rows("part/cells.csv").len(), 1 + 2);

    // Each figure is a file, as the page has it.
    for figure in ["figure-1", "figure-2"] {
        let svg = place.text(format!("part/figures/{figure}.svg"));
        assert!(svg.starts_with("<svg xmlns=") && page.contains(&svg), "{figure}");
    }
    // Nothing is done: nothing can be reported on.
    place.write("none.toml", SWEEP.replace("twelve", "none"));
    let stopped = [
        "sweep",
        "run",
        "none.toml",
        "--out",
        "none",
        "--backend",
        "cpu",
        "--time-budget",
        "0.000001s",
    ];
    place.run(&stopped).exits(75);
    place.run(&["sweep", "report", "none"]).exits(3).says(&[
        "none: has no results.csv yet: 0 of 12 runs are done here",
        "repeat the `oneiro sweep run` that began it",
    ]);
}
