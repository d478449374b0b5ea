//! Machine code of the hand-written kernels and of those that ship; endless loops are stopped, and unsuitable buffers,
//! arrays and numbers of lanes are refused.

use std::path::Path;

use oneiro_shader_compiler::{Indices, compile, generate, trees};
use oneiro_shader_native::{Cache, Code, Error, Key, Native, Stopped, Target, Words};

use crate::catalogue;
use crate::common::{Extent, TURNS, corpus, meaning, native, natives, program, run, targets};

const EXTENT: Extent = Extent {
    workgroups: 0..2,
    lanes: generate::WORKGROUP,
};

#[test]
fn the_corpus_does_what_it_means() {
    let corpus = corpus();
    assert!(corpus.len() >= 9);
    for (name, text) in corpus {
        let trees = program(&text).expect("it is exact");
        let buffers = generate::buffers(0, EXTENT.workgroups.end);
        let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
        assert_ne!(expected, buffers, "{name} does nothing");
        for native in natives(&trees) {
            let found = run(&native, buffers.clone(), &EXTENT, TURNS).expect("it ends");
            for (binding, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert_eq!(found, expected, "{name}, {native:?}, binding {binding}");
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
        let results = natives(&trees)
            .into_iter()
            .map(|native| run(&native, buffers.clone(), &EXTENT, TURNS));
        results.collect::<Result<Vec<_>, _>>().expect("it ends")
    };
    for (changed, result) in results(&changed).iter().zip(&results(&text)) {
        assert_ne!(changed, result);
    }
}

/// Milliseconds of this thread's processor time, which others on the machine hardly change; of the clock where that isn't known.
fn milliseconds() -> f64 {
    #[cfg(target_os = "linux")]
    {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: the place is valid.
        let failed = unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
        assert_eq!(failed, 0, "the system has this clock");
        time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
    }
    #[cfg(not(target_os = "linux"))]
    {
        static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
        START.elapsed().as_secs_f64() * 1e3
    }
}

/// They compile, and load from the cache. The processor time is printed.
#[test]
fn the_kernels_that_ship_compile() {
    let cache = Cache::new(Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels/shipped"));
    for entry in catalogue::CATALOGUE {
        let parts = catalogue::parts(entry);
        let text: String = parts.iter().map(|part| part.text.as_str()).collect();
        let start = milliseconds();
        let trees = trees(&parts).expect("it is exact");
        let front = milliseconds() - start;
        let start = milliseconds();
        let compiled = compile(entry.name, &parts, Indices::Clamped).expect("it is exact");
        let spirv = milliseconds() - start;
        assert!(compiled.spirv.len() > 1000);
        let targets = targets();
        for (target, lanes) in targets
            .iter()
            .flat_map(|target| target.lanes().iter().map(move |lanes| (target, *lanes)))
        {
            let start = milliseconds();
            let code = target.compile(&trees, lanes).expect("it compiles");
            let native = Native::new(&code).expect("there is memory");
            let all = front + milliseconds() - start;
            assert_eq!(native.lanes(), lanes);

            let key = Key::new(&text, lanes, target);
            cache.save(&key, &code).expect("the folder can be written");
            let start = milliseconds();
            let kept = cache.load(&Key::new(&text, lanes, target)).expect("it was saved");
            Native::new(&kept).expect("there is memory");
            let from_cache = milliseconds() - start;
            assert_eq!(kept, code);
            let (name, bytes, values) = (entry.name, code.size(), trees.tidied.values.len());
            eprintln!(
                "{name:20} {values:5} values, {lanes:2} lanes, {bytes:7} bytes; {spirv:5.1} ms to SPIR-V; {front:5.1} for the tree, {all:5.1} in all, \
                 {from_cache:4.1} from the cache"
            );
        }
    }
}

/// Compares all machine code of a program with the interpreter.
fn does_what_it_means(text: &str) {
    let trees = program(text).expect("it is exact");
    let buffers = generate::buffers(0, EXTENT.workgroups.end);
    let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
    for native in natives(&trees) {
        let found = run(&native, buffers.clone(), &EXTENT, TURNS);
        assert!(found == Ok(expected.clone()), "{native:?}");
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
    does_what_it_means(text);
}

/// Words that are stored where they say themselves, in all lanes and in some.
#[test]
fn a_word_is_stored_at_its_own_index() {
    let text = "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
            let at = workgroup.x * 64u + ((lane * 7u) & 63u);
            if (lane % 2u == 0u) {
                results[at] = at;
            }
            let other = at ^ 1u;
            results[other] = other;
        }";
    does_what_it_means(text);
}

/// Lanes whose consecutive words lie beyond a buffer's end read and write its last one, if they are active.
#[test]
fn consecutive_words_end_with_the_buffer() {
    let text = "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
            let at = workgroup.x * 64u + lane;
            if (words[at] % 2u == 0u) {
                results[at] = words[at] ^ lane;
            }
        }";
    let trees = program(text).expect("it is exact");
    let one = Extent {
        workgroups: 0..1,
        ..EXTENT
    };
    for length in [1, 15, 16, 17, 40, 63, 64] {
        let mut buffers = generate::buffers(0, 1);
        buffers[2].truncate(length);
        buffers[5].truncate(length);
        let expected = meaning(&trees, buffers.clone(), &one).expect("it ends");
        for native in natives(&trees) {
            let found = run(&native, buffers.clone(), &one, TURNS);
            assert!(found == Ok(expected.clone()), "{length} words, {native:?}");
        }
    }
}

/// Every operand of a division and of a shift may be a constant.
#[test]
fn constants_are_divided_and_shifted() {
    let [a, b] = ["words[slot]", "(words[slot + 1u] | 1u)"];
    let operands = [(a, b), ("4000000000u", b), (a, "7u"), ("3u", b), (a, "4294967295u")];
    let operations = ["/", "%", "<<", ">>"];
    let mut stores = String::new();
    for (at, (a, b)) in operands.iter().enumerate() {
        let terms = operations.map(|op| match op {
            "<<" | ">>" => format!("({a} {op} ({b} & 31u))"),
            op => format!("({a} {op} {b}) * 31u"),
        });
        stores = format!("{stores}results[slot * 16u + {at}u] = {};", terms.join(" ^ "));
    }
    let text = format!(
        "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
            let slot = workgroup.x * 64u + lane;
            {stores}
        }}"
    );
    let trees = program(&text).expect("it is exact");
    let buffers = generate::buffers(0, EXTENT.workgroups.end);
    let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
    for native in natives(&trees) {
        let found = run(&native, buffers.clone(), &EXTENT, TURNS);
        assert!(found == Ok(expected.clone()), "{native:?}");
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
        for target in targets() {
            let native = native(&target, &kernel(endless), 16);
            assert_eq!(
                run(&native, buffers(), &one, TURNS),
                Err(Stopped::TurnsUsedUp(TURNS)),
                "{endless}"
            );
        }
    }
    // Each evaluation of the condition counts as a turn: 101 turns suffice, and 100 don't.
    for target in targets() {
        let native = native(&target, &kernel("while (i < 100u + settings.a * 0u) { i += 1u; }"), 16);
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
        assert_eq!(stopped[5][0], 1, "stores before the stop have happened");
    }
}

#[test]
fn buffers_that_do_not_fit_are_refused() {
    let trees = program(&corpus()[0].1).expect("it is exact");
    let native = native(&Target::host().expect("this machine has machine code"), &trees, 4);
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
        most: u32::MAX,
    };
    assert_eq!(run(&native, buffers, &one, TURNS), Err(size));
    assert_eq!(size.to_string(), "buffer 3 has 3 words; allowed: 4 to 4294967295");
}

/// Conversions give WGSL's results for all inputs, in scalars and in vectors: floats out of range become the smallest or
/// largest float that is an integer of the type.
#[test]
fn conversions_saturate_and_round() {
    const LEAST: i32 = i32::MIN;
    const GREATEST: i32 = 0x7fff_ff80;
    const GREATEST_UNSIGNED: u32 = 0xffff_ff00;
    let floats: [(f32, i32, u32); 26] = [
        (0.0, 0, 0),
        (-0.0, 0, 0),
        (f32::from_bits(1), 0, 0),
        (0.99, 0, 0),
        (-0.5, 0, 0),
        (-0.99, 0, 0),
        (-1.0, -1, 0),
        (-1.5, -1, 0),
        (2.75, 2, 2),
        (8_388_607.5, 8_388_607, 8_388_607),
        (-16_777_215.0, -16_777_215, 0),
        (16_777_216.0, 16_777_216, 16_777_216),
        (2_147_483_520.0, GREATEST, 0x7fff_ff80),
        (2_147_483_648.0, GREATEST, 1 << 31),
        (2_147_483_904.0, GREATEST, (1 << 31) + 256),
        (-2_147_483_520.0, -GREATEST, 0),
        (-2_147_483_648.0, LEAST, 0),
        (-2_147_483_904.0, LEAST, 0),
        (4_294_967_040.0, GREATEST, GREATEST_UNSIGNED),
        (4_294_967_296.0, GREATEST, GREATEST_UNSIGNED),
        (f32::MAX, GREATEST, GREATEST_UNSIGNED),
        (f32::MIN, LEAST, 0),
        (f32::INFINITY, GREATEST, GREATEST_UNSIGNED),
        (f32::NEG_INFINITY, LEAST, 0),
        // `max(NaN, low)` is the lowest number.
        (f32::NAN, LEAST, 0),
        (-f32::NAN, LEAST, 0),
    ];
    let integers = [
        1,
        16_777_216,
        16_777_217,
        16_777_219,
        0x7fff_ffbf,
        0x7fff_ffc0,
        0x7fff_ffff,
        0x8000_0000,
        0x8000_0001,
        0x8000_0080,
        0x8000_0081,
        0x8000_0180,
        0xfeff_ffff,
        0xffff_0000,
        0xffff_fe80,
        0xffff_ff7f,
        0xffff_ff80,
        0xffff_ffff,
    ];
    let conversions = |word: &str| {
        let all = [
            format!("u32(i32(bitcast<f32>({word})))"),
            format!("u32(bitcast<f32>({word}))"),
            format!("bitcast<u32>(f32(i32({word})))"),
            format!("bitcast<u32>(f32({word}))"),
            format!("bitcast<u32>(f32({word} >> 1u))"),
            format!("bitcast<u32>(f32({word} & 0x7fffffffu))"),
            format!("bitcast<u32>(f32({word} & 0xfffffffeu))"),
        ];
        let store = |(at, value): (usize, &String)| format!("results[base + {at}u] = {value};");
        all.iter().enumerate().map(store).collect::<String>()
    };
    let kernel = |word: &str| {
        let text = format!(
            "@compute @workgroup_size(64)
            fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
                let base = lane * 16u;
                {}
            }}",
            conversions(word)
        );
        program(&text).expect("it is exact")
    };
    let (uniform, varying) = (kernel("settings.a"), kernel("words[lane]"));
    let words: Vec<u32> = floats.iter().map(|(x, ..)| x.to_bits()).chain(integers).collect();
    let check = |at: usize, found: &[u32]| {
        let word = words[at];
        if let Some((x, signed, unsigned)) = floats.get(at) {
            assert_eq!(found[..2], [*signed as u32, *unsigned], "{x:e}");
        }
        let of_words = [word, word >> 1, word & 0x7fff_ffff, word & 0xffff_fffe].map(|word| word as f32);
        let expected = [word as i32 as f32, of_words[0], of_words[1], of_words[2], of_words[3]];
        assert_eq!(found[2..7], expected.map(f32::to_bits), "{word:#x}");
    };
    let one = Extent {
        workgroups: 0..1,
        lanes: 64,
    };
    for (native_varying, native_uniform) in natives(&varying).into_iter().zip(natives(&uniform)) {
        let mut buffers = generate::buffers(0, 1);
        buffers[2][..words.len()].copy_from_slice(&words);
        let found = run(&native_varying, buffers, &one, TURNS).expect("it has no loops");
        for (at, found) in found[5].chunks_exact(16).enumerate().take(words.len()) {
            check(at, found);
        }
        for (at, word) in words.iter().enumerate() {
            let mut buffers = generate::buffers(0, 1);
            buffers[0][0] = *word;
            let found = run(&native_uniform, buffers, &one, TURNS).expect("it has no loops");
            check(at, &found[5]);
        }
    }
}

/// A kernel with a local array whose elements all take part in the result, and its result in the first lane.
fn sum_of_array(target: &Target, length: u32) -> (Result<Code, Error>, u32) {
    let text = format!(
        "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
            var local: array<u32, {length}>;
            for (var i = 0u; i < {length}u; i++) {{ local[i] = lane + i; }}
            var sum = 0u;
            for (var i = 0u; i < {length}u; i++) {{ sum += local[i]; }}
            results[lane * 16u] = sum;
        }}"
    );
    let code = target.compile(&program(&text).expect("it is exact"), 16);
    (code, (0..length).sum())
}

#[test]
fn arrays_that_a_stack_does_not_hold_are_refused() {
    for target in targets() {
        let (code, sum) = sum_of_array(&target, 4096);
        let native = Native::new(&code.expect("it fits")).expect("there is memory");
        let one = Extent {
            workgroups: 0..1,
            lanes: 16,
        };
        let found = run(&native, generate::buffers(0, 1), &one, TURNS).expect("it ends");
        for (lane, words) in (0..16).zip(found[5].chunks_exact(16)) {
            assert_eq!(words[0], sum + 4096 * lane);
        }
        let error = sum_of_array(&target, 4097).0.unwrap_err();
        assert_eq!(
            error.to_string(),
            "the kernel's local arrays take 262208 bytes; allowed: at most 262144"
        );
    }
}

#[test]
fn other_numbers_of_lanes_are_refused() {
    let trees = program(&corpus()[0].1).expect("it is exact");
    let target = Target::host().expect("this machine has machine code");
    for lanes in [0, 1, 6, 32] {
        let error = target.compile(&trees, lanes).unwrap_err();
        assert!(matches!(error, Error::Lanes(..)), "{error}");
        assert_eq!(error.to_string(), format!("{lanes} lanes; allowed: [4, 8, 16]"));
    }
}
