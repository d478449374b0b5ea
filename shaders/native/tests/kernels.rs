//! Machine code of the hand-written kernels and of those that ship; endless loops are stopped, and unsuitable buffers,
//! arrays and numbers of lanes are refused.

use std::fs;
use std::path::Path;
use std::time::Instant;

use oneiro_shader_compiler::{generate, trees};
use oneiro_shader_native::{Cache, Error, Key, LANES, Native, Stopped, Target, Words};

#[path = "../../catalogue.rs"]
#[allow(dead_code, reason = "these tests need no host structs")]
mod catalogue;
mod common;
use common::{Extent, TURNS, meaning, native, program, run};

const EXTENT: Extent = Extent {
    workgroups: 0..2,
    lanes: generate::WORKGROUP,
};

/// The shader compiler's hand-written kernels, by name.
fn corpus() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus/wgsl");
    let files = fs::read_dir(folder).expect("the corpus is there");
    let read = |path: &Path| {
        let name = path.file_stem().expect("it has a name").to_string_lossy();
        (name.into_owned(), fs::read_to_string(path).expect("it is text"))
    };
    files
        .map(|file| read(&file.expect("it can be listed").path()))
        .collect()
}

#[test]
fn the_corpus_does_what_it_means() {
    let corpus = corpus();
    assert!(corpus.len() >= 9);
    for (name, text) in corpus {
        let trees = program(&text).expect("it is exact");
        let buffers = generate::buffers(0, EXTENT.workgroups.end);
        let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
        assert_ne!(expected, buffers, "{name} does nothing");
        for lanes in LANES {
            let found = run(&native(&trees, lanes), buffers.clone(), &EXTENT, TURNS).expect("it ends");
            for (binding, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert_eq!(found, expected, "{name}, {lanes} lanes, binding {binding}");
            }
        }
    }
}

#[test]
fn a_changed_constant_is_noticed() {
    let (_, text) = corpus()
        .into_iter()
        .find(|(name, _)| name == "folding")
        .expect("it is there");
    let changed = text.replacen("0.3f", &format!("{:?}f", 0.3_f32.next_up()), 1);
    assert_ne!(changed, text);
    let results = |text: &str| {
        let trees = program(text).expect("it is exact");
        let buffers = generate::buffers(0, EXTENT.workgroups.end);
        run(&native(&trees, 16), buffers, &EXTENT, TURNS).expect("it ends")
    };
    assert_ne!(results(&changed), results(&text));
}

/// They compile, and load from the cache. Both times are printed.
#[test]
fn the_kernels_that_ship_compile() {
    let wgsl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../wgsl");
    let cache = Cache::new(Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels/shipped"));
    let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
    for entry in catalogue::CATALOGUE {
        let parts = catalogue::parts(&wgsl, entry);
        let start = Instant::now();
        let target = Target::host().expect("this machine has machine code");
        let trees = trees(&parts).expect("it is exact");
        let front = milliseconds(start);
        let code = target.compile(&trees, 16).expect("it compiles");
        let native = Native::new(&code).expect("there is memory");
        let all = milliseconds(start);
        assert_eq!(native.lanes(), 16);

        let text: String = parts.iter().map(|part| part.text.as_str()).collect();
        let key = Key::new(&text, 16, &target);
        cache.save(&key, &code).expect("the folder can be written");
        let start = Instant::now();
        let target = Target::host().expect("this machine has machine code");
        let kept = cache.load(&Key::new(&text, 16, &target)).expect("it was saved");
        Native::new(&kept).expect("there is memory");
        let from_cache = milliseconds(start);
        assert_eq!(kept, code);
        let (name, bytes) = (entry.name, code.size());
        eprintln!(
            "{name:20} {bytes:7} bytes; {front:5.1} ms for the tree, {all:5.1} in all, {from_cache:4.1} from the cache"
        );
    }
}

/// Stores to the same element under different masks.
#[test]
fn stores_keep_to_their_masks() {
    let text = "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
            let slot = workgroup.x * 64u + lane;
            notes[slot].third = 1i;
            if (lane % 2u == 0u) {
                notes[slot].second = 2.0f;
                if (lane % 3u == 0u) {
                    notes[slot].third = 3i;
                    return;
                }
                notes[slot].second = 4.0f;
            }
            notes[slot].third = 5i;
        }";
    let trees = program(text).expect("it is exact");
    let buffers = generate::buffers(0, EXTENT.workgroups.end);
    let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
    for lanes in LANES {
        assert!(
            run(&native(&trees, lanes), buffers.clone(), &EXTENT, TURNS) == Ok(expected.clone()),
            "{lanes} lanes"
        );
    }
}

/// Loops that must be stopped: endless, endless in one lane only, or one turn too long.
#[test]
fn turns_are_counted() {
    let kernel = |loops: &str| {
        let text = format!(
            "@compute @workgroup_size(64)
            fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
                let base = (workgroup.x * 64u + lane) * 16u;
                results[base] = 1u;
                var i = 0u;
                {loops}
                results[base] = 2u + i;
            }}"
        );
        program(&text).expect("it is exact")
    };
    let buffers = || generate::buffers(0, EXTENT.workgroups.end);
    let one = Extent { lanes: 16, ..EXTENT };
    for endless in [
        "loop { i += 1u; if (i == 0u && settings.a == 99999u) { break; } }",
        "if (lane == 3u) { while (i < 4000000000u) { i += lane / 3u; } }",
        "loop { i += 1u; loop { i += 2u; if (i > 10u) { break; } } if (lane + i == 7u) { break; } }",
    ] {
        let native = native(&kernel(endless), 16);
        assert_eq!(
            run(&native, buffers(), &one, TURNS),
            Err(Stopped::TurnsUsedUp(TURNS)),
            "{endless}"
        );
    }
    // Each evaluation of the condition counts as a turn: 101 turns suffice, and 100 don't.
    let native = native(&kernel("while (i < 100u + settings.a * 0u) { i += 1u; }"), 16);
    let found = run(&native, buffers(), &one, 101).expect("it may turn so often");
    assert_eq!(found[5][0], 102);
    let words = |buffers: &mut [Vec<u32>]| {
        let words = buffers.iter_mut().map(|buffer| Words {
            start: buffer.as_mut_ptr(),
            len: buffer.len(),
        });
        words.collect::<Vec<_>>()
    };
    let mut stopped = buffers();
    let before_loop = words(&mut stopped);
    // SAFETY: the buffers are whole, and used by this call only.
    let result = unsafe { native.run(&before_loop, 0, 0, 100) };
    assert_eq!(result, Err(Stopped::TurnsUsedUp(100)));
    assert_eq!(stopped[5][0], 1, "what was stored before it stopped is there");
}

#[test]
fn buffers_that_do_not_fit_are_refused() {
    let trees = program(&corpus()[0].1).expect("it is exact");
    let native = native(&trees, 4);
    let mut buffers = generate::buffers(0, 2);
    let expected = buffers.len();
    buffers.pop();
    let one = Extent { lanes: 4, ..EXTENT };
    assert_eq!(
        run(&native, buffers.clone(), &one, TURNS),
        Err(Stopped::Buffers {
            expected,
            found: expected - 1
        })
    );
    buffers.push(Vec::new());
    buffers[3].truncate(3);
    let size = Stopped::Size {
        binding: 3,
        words: 3,
        least: 4,
    };
    assert_eq!(run(&native, buffers, &one, TURNS), Err(size));
    assert_eq!(size.to_string(), "buffer 3 has 3 words; allowed: 4 to 4294967295");
}

#[test]
fn arrays_that_a_stack_does_not_hold_are_refused() {
    let of_length = |length: u32| {
        let text = format!(
            "@compute @workgroup_size(64)
            fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
                var local: array<u32, {length}>;
                for (var i = 0u; i < {length}u; i++) {{ local[i] = lane + i; }}
                results[lane * 16u] = local[settings.a];
            }}"
        );
        let trees = program(&text).expect("it is exact");
        Target::host()
            .expect("this machine has machine code")
            .compile(&trees, 16)
    };
    assert!(of_length(1000).is_ok());
    let error = of_length(5_000).unwrap_err();
    assert!(matches!(error, Error::TooLarge), "{error}");
}

#[test]
fn other_numbers_of_lanes_are_refused() {
    let trees = program(&corpus()[0].1).expect("it is exact");
    let target = Target::host().expect("this machine has machine code");
    for lanes in [0, 1, 6, 32] {
        let error = target.compile(&trees, lanes).unwrap_err();
        assert!(matches!(error, Error::Lanes(_)), "{error}");
        assert_eq!(error.to_string(), format!("{lanes} lanes; allowed: 4, 8, 16"));
    }
}
