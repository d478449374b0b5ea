use std::fmt::Write as _;
use std::fs;

use serde_json::{Value, json};

use super::super::super::live::tests::fleet;
use super::*;
use crate::fleet::file::EXPERIMENT;

/// A made-up twin of the ten robots of an experiment, whose robots drive in every other second.
fn twin(name: &str) -> (PathBuf, Plan) {
    let (fleet, _) = fleet(name);
    let directory = fleet.directory.parent().unwrap().join("twin");
    let robots = directory.join("robots");
    fs::create_dir_all(robots.join("3")).unwrap();
    fs::write(robots.join(EXPERIMENT), &fleet.text).unwrap();
    fs::write(
        robots.join("0.toml"),
        format!("{}\n[tracker]\nlisten = \"127.0.0.1:5005\"\n", fleet.robots[0].toml),
    )
    .unwrap();
    let mut arena = String::from("second,robot,x,y,heading,carries,brought,left,right\n");
    for second in 0..5 {
        for robot in 0..10 {
            let (x, speed, brought) = (10 * robot + second, 20 * (second % 2), robot * second);
            writeln!(
                arena,
                "{second},{robot},{x},-1.5,0.25,{},{brought},{speed},0",
                second % 2
            )
            .unwrap();
        }
    }
    // The twin ended in the middle of a row.
    arena += "5,0,1,2,0,0,0,0,0\n5,1,3,";
    fs::write(directory.join(ARENA), arena).unwrap();
    let intervals = "interval,robot,s0,g0,g1,real\n0,3,0.1,0.2,0.3,4\n1,3,0.4,0.5,0.6,7\n";
    fs::write(robots.join("3").join(INTERVALS), intervals).unwrap();
    (directory, fleet.experiment.plan(1))
}

fn data(page: &Path) -> Value {
    let page = fs::read_to_string(page).unwrap();
    let (_, after) = page.split_once("id=\"replay\">").unwrap();
    serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_twin_has_a_page() {
    let (directory, plan) = twin("twin-page");
    let lines = moments(&directory.join(ARENA), 10).unwrap();
    assert_eq!(lines.len(), 5);
    let seen = &lines[3].robots[7];
    assert_eq!((seen.pose, seen.act, seen.carries), (Some([73.0, -1.5, 0.25]), 1, true));
    assert_eq!(
        (seen.brought, lines[2].robots[7].act, lines[0].robots[7].brought),
        (7, 0, 0)
    );

    let page = write(&directory).unwrap();
    assert_eq!(page, directory.join("replay.html"));
    let data = data(&page);
    assert_eq!(data["names"], json!([0, 1, 2, 3, 4, 5, 6, 7, 8, 9]));
    assert_eq!(data["times"], json!([10, 20, 30, 40, 50]));
    assert_eq!(data["lights"], json!([[0, "over"]]));
    let clock = plan.clocks()[3];
    let genes = &data["genes"][3];
    assert_eq!(
        genes[0],
        json!([10 * clock.offset, 0.1_f32, 0.2_f32, 0.3_f32, [0, 0, 0]])
    );
    assert_eq!(genes[1][0], 10 * (clock.offset + clock.interval));
    assert_eq!(data["genes"][4], json!([]));
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("<title>Twin twin, seed 1</title>") && text.contains("5 s, a line each second"));
    fs::remove_dir_all(directory.parent().unwrap()).unwrap();
}

#[test]
fn what_is_no_twin_is_refused() {
    let (directory, _) = twin("no-twin");
    let arena = directory.join(ARENA);
    let whole = fs::read_to_string(&arena).unwrap();
    for (from, to, words) in [
        (
            "2,4,42,",
            "2,5,42,",
            "line 22 and those after it; expected: robots 0 to 9 in a later second",
        ),
        ("2,4,42,", "2,4,many,", "line: 26"),
    ] {
        assert!(whole.contains(from));
        fs::write(&arena, whole.replace(from, to)).unwrap();
        let failure = write(&directory).unwrap_err();
        assert!(failure.code() == 5 && failure.to_string().contains(words), "{failure}");
    }
    fs::remove_file(&arena).unwrap();
    let failure = write(&directory).unwrap_err();
    assert!(
        failure.code() == 3 && failure.to_string().contains("has no twin.csv and robots/0.toml"),
        "{failure}"
    );
    fs::remove_dir_all(directory.parent().unwrap()).unwrap();
}
