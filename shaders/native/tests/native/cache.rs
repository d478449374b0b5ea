//! Cached code is found by its own key, and by no other; only where nobody else could have written it; and the oldest is
//! deleted when there is too much.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use oneiro_shader_compiler::generate;
use oneiro_shader_native::{Cache, Code, Error, Key, Native, Target};

use crate::common::{Extent, TURNS, program, run};

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

fn compiled(number: u32) -> Code {
    let trees = program(&text(number)).expect("it is exact");
    Target::host()
        .expect("this machine has machine code")
        .compile(&trees, 4)
        .expect("it compiles")
}

fn key(number: u32) -> Key {
    Key::new(
        &text(number),
        4,
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

/// Paths in a directory, in order.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("it is there");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("it is there").path()).collect();
    paths.sort();
    paths
}

#[test]
fn code_is_compiled_once() {
    let cache = Cache::new(folder("once"));
    assert_eq!(cache.load(&key(7)), None);
    let load = || cache.load_or(&key(7), || Ok::<_, Error>(compiled(7)));
    let first = load().expect("it compiles");
    assert_eq!(stored(&first), 7);
    assert_eq!(load().expect("it is there"), first);
    // Other code under this key shows that it is read, and not compiled again.
    cache.save(&key(7), &compiled(8)).expect("the folder can be written");
    assert_eq!(stored(&load().expect("it is there")), 8);
}

/// A damaged entry is compiled and saved again.
#[test]
fn a_damaged_entry_is_replaced() {
    let folder = folder("damaged");
    let cache = Cache::new(&folder);
    cache.save(&key(7), &compiled(7)).expect("the folder can be written");
    let paths = entries(&folder);
    let [entry] = paths.as_slice() else { panic!("{paths:?}") };
    let whole = fs::read(entry).expect("it is there");
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 0x40;
    fs::write(entry, &damaged).expect("it can be written");
    let mut compilations = 0;
    for _ in 0..2 {
        let found = cache.load_or(&key(7), || {
            compilations += 1;
            Ok::<_, Error>(compiled(7))
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
    for number in [7, 8] {
        cache
            .save(&key(number), &compiled(number))
            .expect("the folder can be written");
    }
    let paths = entries(&folder);
    fs::copy(&paths[0], &paths[1]).expect("it can be copied");
    let found = [7, 8].map(|number| cache.load(&key(number)));
    assert_eq!(found.iter().filter(|code| code.is_some()).count(), 1);
}

#[test]
fn the_oldest_entries_are_deleted() {
    let folder = folder("full");
    let size = {
        let cache = Cache::new(&folder);
        cache.save(&key(0), &compiled(0)).expect("the folder can be written");
        fs::metadata(&entries(&folder)[0]).expect("it is there").len()
    };
    // Not an entry, so it neither counts nor is deleted.
    let other = folder.join("other");
    fs::write(&other, vec![0; 10 * size as usize]).expect("it can be written");
    let cache = Cache::new(&folder).with_capacity(3 * size + size / 2);
    let start = SystemTime::now() - Duration::from_secs(1000);
    for number in 0..6 {
        let before = entries(&folder);
        cache
            .save(&key(number), &compiled(number))
            .expect("the folder can be written");
        let age = Duration::from_secs(u64::from(number));
        for path in entries(&folder)
            .iter()
            .filter(|path| !before.contains(path) || number == 0)
        {
            let file = File::options().append(true).open(path).expect("it is there");
            file.set_modified(start + age).expect("it is the user's");
        }
    }
    let found: Vec<_> = (0..6).filter(|number| cache.load(&key(*number)).is_some()).collect();
    assert_eq!(found, [3, 4, 5]);
    assert!(other.exists());
}

/// Neither a directory nor an entry that others can write to, or that belongs to someone else, is read or written.
#[cfg(unix)]
#[test]
fn what_others_can_write_is_not_used() {
    use std::os::unix::fs::{PermissionsExt, chown};
    let folder = folder("others");
    let cache = Cache::new(&folder);
    let save = || cache.save(&key(7), &compiled(7));
    save().expect("the folder can be written");
    let entry = entries(&folder).remove(0);
    let mode = |path: &Path| fs::metadata(path).expect("it is there").permissions().mode() & 0o777;
    assert_eq!((mode(&folder), mode(&entry)), (0o700, 0o600));
    let set_mode = |path: &Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("it is the user's");
    };
    for others in [0o020, 0o002] {
        set_mode(&folder, 0o700 | others);
        assert!(cache.load(&key(7)).is_none());
        assert!(save().is_err());
        set_mode(&folder, 0o755);
        assert!(cache.load(&key(7)).is_some());
        set_mode(&entry, 0o600 | others);
        assert!(cache.load(&key(7)).is_none());
        save().expect("the folder is the user's");
        assert!(cache.load(&key(7)).is_some(), "saving replaces the entry");
    }
    // Only a superuser can give files away.
    if chown(&entry, Some(1), None).is_ok() {
        assert!(cache.load(&key(7)).is_none());
        save().expect("the folder is the user's");
        chown(&folder, Some(1), None).expect("a superuser can");
        assert!(cache.load(&key(7)).is_none());
        assert!(save().is_err());
    }
}

#[test]
fn without_a_folder_nothing_is_kept() {
    let folder = folder("none");
    fs::create_dir_all(folder.parent().expect("it has one")).expect("it can be created");
    // A file where the folder should be: no rights would stop a superuser.
    fs::write(&folder, "").expect("it can be written");
    let cache = Cache::new(folder.join("kernels"));
    assert!(cache.save(&key(7), &compiled(7)).is_err());
    for _ in 0..2 {
        let code = cache
            .load_or(&key(7), || Ok::<_, Error>(compiled(7)))
            .expect("it compiles");
        assert_eq!(stored(&code), 7);
    }
    fs::remove_file(folder).expect("it is there");
}
