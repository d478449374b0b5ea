//! Lane code that a Rust toolchain compiles: it does what the program means, is found in the cache by its own key only, and is
//! not used where it is damaged or another user could have written it. Compilers that are no good are refused.

use std::path::{Path, PathBuf};
use std::{fs, io};

use oneiro_shader_compiler::generate;
use oneiro_shader_native::{Cache, Key, Library, Target, Toolchain, ToolchainError, Words};

use crate::common::{Extent, corpus, meaning, program};

const EXTENT: Extent = Extent {
    workgroups: 0..2,
    lanes: generate::WORKGROUP,
};

/// An empty cache for one test, and its directory.
fn cache(test: &str) -> (Cache, PathBuf) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("toolchain").join(test);
    let _ = fs::remove_dir_all(&folder);
    (Cache::new(&folder), folder)
}

fn key(text: &str) -> Key {
    Key::of_library(text, &Target::host().expect("this machine has machine code"))
}

/// Compiles a kernel that follows the generator's prelude into the cache, and loads it.
fn compiled(cache: &Cache, text: &str) -> Library {
    let trees = program(text).expect("it is exact");
    let toolchain = Toolchain::find().expect("tests are compiled by one");
    let (library, draft) = cache.compile(&key(text), &toolchain, &trees).expect("it compiles");
    assert!(
        cache.library(&key(text)).expect("there is no other").is_none(),
        "it is kept too early"
    );
    draft.keep().expect("the folder can be written");
    let found = cache
        .library(&key(text))
        .expect("it can be loaded")
        .expect("it is kept");
    assert_eq!(found.instances(), library.instances());
    assert_eq!(found.compiler(), toolchain.version());
    found
}

/// Buffers after an instance has run.
fn run(library: &Library, instance: usize, mut buffers: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let words: Vec<_> = buffers
        .iter_mut()
        .map(|buffer| Words {
            start: buffer.as_mut_ptr(),
            len: buffer.len(),
        })
        .collect();
    for (workgroup, first) in EXTENT.calls(library.instances()[instance].lanes()) {
        // SAFETY: the buffers are whole, and used by this call only; the corpus' loops end.
        unsafe { library.run(instance, &words, workgroup, first) };
    }
    buffers
}

#[test]
fn the_corpus_does_what_it_means() {
    let (cache, folder) = cache("corpus");
    let corpus = corpus();
    for (name, text) in &corpus {
        let library = compiled(&cache, text);
        let buffers = generate::buffers(0, EXTENT.workgroups.end);
        let trees = program(text).expect("it is exact");
        let expected = meaning(&trees, buffers.clone(), &EXTENT).expect("it ends");
        assert!(!library.instances().is_empty());
        for (index, instance) in library.instances().iter().enumerate() {
            let found = run(&library, index, buffers.clone());
            assert!(found == expected, "{name}, {}", instance.name());
        }
    }
    // Nothing is left of compiling.
    assert_eq!(fs::read_dir(folder).expect("it is there").count(), corpus.len());
}

#[test]
fn a_changed_constant_is_noticed() {
    let (cache, _) = cache("constant");
    let (_, text) = corpus()
        .into_iter()
        .find(|(name, _)| name == "folding")
        .expect("it is there");
    let changed = text.replacen("0.3f", &format!("{:?}f", 0.3_f32.next_up()), 1);
    assert_ne!(changed, text);
    let buffers = generate::buffers(0, EXTENT.workgroups.end);
    let libraries = [&text, &changed].map(|text| compiled(&cache, text));
    for instance in 0..libraries[0].instances().len() {
        let [exact, other] = [0, 1].map(|index: usize| run(&libraries[index], instance, buffers.clone()));
        assert_ne!(exact, other);
    }
}

const SMALL: &str = "@compute @workgroup_size(64)
    fn main(@builtin(local_invocation_index) lane: u32) {
        results[lane] = lane;
    }";

#[test]
fn damaged_libraries_are_refused() {
    let (cache, folder) = cache("damaged");
    drop(compiled(&cache, SMALL));
    assert!(cache.library(&key("other text")).expect("it can be searched").is_none());
    let entry = fs::read_dir(&folder).expect("it is there").next().expect("it is kept");
    let path = entry.expect("it can be listed").path();
    let whole = fs::read(&path).expect("it can be read");
    let mut changed = whole.clone();
    changed[whole.len() / 2] ^= 1;
    fs::remove_file(&path).expect("it is ours");
    fs::write(&path, changed).expect("it is ours");
    let error = cache.library(&key(SMALL)).expect_err("it is damaged").to_string();
    assert!(
        error.contains("is damaged") && error.contains(&path.display().to_string()),
        "{error}"
    );
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::write(&path, whole).expect("it is ours");
        let allow = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("it is ours");
        allow(0o622);
        let error = cache.library(&key(SMALL)).expect_err("others can write it").to_string();
        assert!(error.contains("another user"), "{error}");
        allow(0o600);
        assert!(cache.library(&key(SMALL)).expect("it is whole").is_some());
    }
}

/// A program that answers as a compiler would.
#[cfg(unix)]
fn compiler(folder: &Path, answers: &str) -> Result<Toolchain, ToolchainError> {
    use std::os::unix::fs::PermissionsExt;
    fs::create_dir_all(folder).expect("it can be written");
    let path = folder.join("rustc");
    fs::write(&path, format!("#!/bin/sh\n{answers}\n")).expect("it can be written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o700)).expect("it is ours");
    loop {
        match Toolchain::at(path.clone()) {
            // A program that another test started just then still has the file open.
            Err(ToolchainError::Missing(_, error)) if error.kind() == io::ErrorKind::ExecutableFileBusy => {}
            found => return found,
        }
    }
}

#[cfg(unix)]
#[test]
fn compilers_that_are_no_good_are_refused() {
    let (cache, folder) = cache("compilers");
    let programs = folder.with_extension("programs");
    let of = |answers: &str| compiler(&programs, answers);
    let old = of("echo 'rustc 1.80.1 (a 2024-08-04)'; echo 'release: 1.80.1'").unwrap_err();
    assert!(matches!(old, ToolchainError::TooOld(..)), "{old}");
    assert!(old.to_string().contains("1.80.1; allowed: 1.95 or newer"), "{old}");
    let unknown = of("echo hello").unwrap_err();
    assert!(matches!(unknown, ToolchainError::Unknown(_)), "{unknown}");
    let failing =
        "echo 'rustc 1.99.0 (a)'; echo 'release: 1.99.0'; [ \"$1\" = -vV ] || { echo 'no linker' >&2; exit 1; }";
    let failing = of(failing).expect("it says what it is");
    let failed = cache.compile(&key(SMALL), &failing, &program(SMALL).expect("it is exact"));
    let failed = failed.expect_err("it fails");
    assert!(matches!(failed, ToolchainError::Failed(..)), "{failed}");
    assert!(failed.to_string().ends_with("no linker"), "{failed}");
    // Its output is no library.
    let wrong = "echo 'rustc 1.99.0 (a)'; echo 'release: 1.99.0'; [ \"$1\" = -vV ] || echo nothing >library";
    let wrong = of(wrong).expect("it says what it is");
    let failed = cache.compile(&key(SMALL), &wrong, &program(SMALL).expect("it is exact"));
    let failed = failed.expect_err("it can't be loaded");
    assert!(matches!(failed, ToolchainError::Library(_)), "{failed}");
    assert_eq!(
        fs::read_dir(folder).expect("it is there").count(),
        0,
        "something is left"
    );
}
