//! Opens pages in a browser that runs without a display, for tests.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};

use serde_json::Value;

/// A folder for a page and its files.
pub fn folder(name: &str) -> PathBuf {
    let folder = env::temp_dir().join(format!("oneiro-{name}-{}", process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The value that an asynchronous function with the body `ask`, in JavaScript, returns in the page; none without a
/// browser. The page's folder, which is removed, is that of `name`.
pub fn told(name: &str, page: &str, ask: &str) -> Option<Value> {
    let folder = folder(name);
    let Some(browser) = find_browser() else {
        crate::skips::skipped("browser", "the page of a swarm: there is no chromium");
        let _ = fs::remove_dir_all(&folder);
        return None;
    };
    // Without a display there are no frames, so a timer replaces them.
    let frames = "<head><script>\n\
        window.requestAnimationFrame = (then) => setTimeout(() => then(performance.now()), 16);\n\
        </script>";
    // What is returned, or an error, becomes an element's text.
    let ask = format!(
        "<pre id=\"told\"></pre><script>\n\
         (async () => {{ {ask} }})().then(JSON.stringify).catch((problem) => String(problem.stack))\n\
         .then((text) => {{ document.getElementById('told').textContent = text; }});\n\
         </script></body>"
    );
    let page = page.replace("<head>", frames).replace("</body>", &ask);
    let told = |budget: u32| {
        let elements = open_page(&browser, &folder, &page, budget);
        let (_, after) = elements.split_once("<pre id=\"told\">").expect("the page was opened");
        after.split_once("</pre>").unwrap().0.to_owned()
    };
    // On a busy machine the page's time is over before its files are there: then it is given more.
    let budgets = [20_000, 60_000, 180_000].into_iter();
    let text = budgets.map(told).find(|text| !text.is_empty());
    let _ = fs::remove_dir_all(&folder);
    let text = text.expect("the page tells something");
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Some(serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}")))
}

fn find_browser() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|path| path.is_file())
}

/// The page's elements after its scripts have run for some ms of its time, which passes at once while it waits.
fn open_page(browser: &Path, folder: &Path, page: &str, budget: u32) -> String {
    let (file, elements) = (folder.join("page.html"), folder.join("elements.html"));
    fs::write(&file, page).unwrap();
    let mut running = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update"])
        .args(["--disable-sync", "--disable-dev-shm-usage", "--window-size=1280,800"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("--virtual-time-budget={budget}"))
        .arg("--dump-dom")
        .arg(format!("file://{}", file.display()))
        .stdout(fs::File::create(&elements).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while running.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_mins(2) {
            running.kill().unwrap();
            running.wait().unwrap();
            panic!("the browser did not end within two minutes");
        }
        thread::sleep(Duration::from_millis(50));
    }
    fs::read_to_string(elements).unwrap()
}
