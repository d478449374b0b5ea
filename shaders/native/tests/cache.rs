//! Cached code is found by its own key, and by no other.

use std::fs;
use std::path::PathBuf;

use oneiro_shader_compiler::generate;
use oneiro_shader_native::{Cache, Code, Error, Key, Native, Target};

mod common;
use common::{Extent, TURNS, program, run};

const ONE: Extent = Extent {
    workgroups: 0..1,
    lanes: 64,
};

/// A kernel that stores a number.
fn text(number: u32) -> String {
    format!(
        "@compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
            results[lane * 16u] = {number}u;
        }}"
    )
}

fn compiled(number: u32, lanes: u32) -> Code {
    let trees = program(&text(number)).expect("it is exact");
    Target::host()
        .expect("this machine has machine code")
        .compile(&trees, lanes)
        .expect("it compiles")
}

fn key(number: u32, lanes: u32) -> Key {
    Key::new(
        &text(number),
        lanes,
        &Target::host().expect("this machine has machine code"),
    )
}

/// The number that the code stores.
fn stored(code: &Code) -> u32 {
    let native = Native::new(code).expect("there is memory");
    run(&native, generate::buffers(0, 1), &ONE, TURNS).expect("it has no loops")[5][0]
}

/// An empty directory for one test.
fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("kernels").join(test);
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn code_is_compiled_once() {
    let cache = Cache::new(folder("once"));
    let key = key(7, 8);
    assert_eq!(cache.load(&key), None);
    let first = cache
        .load_or(&key, || Ok::<_, Error>(compiled(7, 8)))
        .expect("it compiles");
    let again = cache
        .load_or::<Error>(&key, || panic!("it is kept"))
        .expect("it is there");
    assert_eq!(first, again);
    assert_eq!(stored(&again), 7);
}

#[test]
fn a_key_is_all_that_code_is_made_from() {
    assert_eq!(key(7, 8), key(7, 8));
    assert_ne!(key(7, 8), key(8, 8));
    assert_ne!(key(7, 8), key(7, 16));
}

/// An entry with any changed byte, or cut off anywhere, is compiled and saved again.
#[test]
fn a_damaged_entry_is_replaced() {
    let folder = folder("damaged");
    let (cache, key) = (Cache::new(&folder), key(7, 4));
    let code = compiled(7, 4);
    let whole = code.to_bytes(&key);
    assert_eq!(Code::from_bytes(&whole, &key).as_ref(), Some(&code));
    for at in 0..whole.len() {
        let mut changed = whole.clone();
        changed[at] ^= 1;
        assert_eq!(Code::from_bytes(&changed, &key), None, "byte {at} is changed");
        assert_eq!(Code::from_bytes(&whole[..at], &key), None, "it is cut off at {at}");
    }
    cache.save(&key, &code).expect("the folder can be written");
    let entries: Vec<_> = fs::read_dir(&folder)
        .expect("it is there")
        .map(|entry| entry.expect("it is there").path())
        .collect();
    let [entry] = entries.as_slice() else {
        panic!("{entries:?}")
    };
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 0x40;
    fs::write(entry, &damaged).expect("it can be written");
    let mut compilations = 0;
    for _ in 0..2 {
        let found = cache.load_or(&key, || {
            compilations += 1;
            Ok::<_, Error>(compiled(7, 4))
        });
        assert_eq!(stored(&found.expect("it compiles")), 7);
    }
    assert_eq!(compilations, 1);
    assert_eq!(fs::read(entry).expect("it is there"), whole);
}

/// An entry that was renamed to another kernel's key is not used.
#[test]
fn a_renamed_entry_is_not_found() {
    let folder = folder("renamed");
    let cache = Cache::new(&folder);
    let [seven, eight] = [7, 8].map(|number| key(number, 4));
    for (key, number) in [(seven, 7), (eight, 8)] {
        cache
            .save(&key, &compiled(number, 4))
            .expect("the folder can be written");
    }
    let mut entries: Vec<_> = fs::read_dir(&folder)
        .expect("it is there")
        .map(|entry| entry.expect("it is there").path())
        .collect();
    entries.sort();
    fs::copy(&entries[0], &entries[1]).expect("it can be copied");
    let found = [seven, eight].map(|key| cache.load(&key));
    assert_eq!(found.iter().filter(|code| code.is_some()).count(), 1);
}

#[test]
fn code_for_another_machine_is_refused() {
    let mut code = compiled(7, 4);
    code.target = code.target.replacen('-', "-other-", 1);
    let key = key(7, 4);
    let foreign = Code::from_bytes(&code.to_bytes(&key), &key).expect("it is whole");
    let error = Native::new(&foreign).unwrap_err();
    assert!(matches!(error, Error::Foreign { .. }), "{error}");
}

#[test]
fn without_a_folder_nothing_is_kept() {
    let folder = folder("none");
    fs::create_dir_all(folder.parent().expect("it has one")).expect("it can be created");
    // A file where the folder should be: no rights would stop a superuser.
    fs::write(&folder, "").expect("it can be written");
    let (cache, key) = (Cache::new(folder.join("kernels")), key(7, 4));
    assert!(cache.save(&key, &compiled(7, 4)).is_err());
    for _ in 0..2 {
        let code = cache
            .load_or(&key, || Ok::<_, Error>(compiled(7, 4)))
            .expect("it compiles");
        assert_eq!(stored(&code), 7);
    }
    fs::remove_file(folder).expect("it is there");
}
