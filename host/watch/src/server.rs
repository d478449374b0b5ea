//! Connections: each has a thread and one request, and there are at most so many.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, LazyLock, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::foragers_script;
use sha2::{Digest, Sha256};

use crate::edit::Editor;
use crate::pages::{self, FILES, PAGE};
use crate::request::{Door, HEAD, Request, is_secret};
use crate::scenes::Scenes;
use crate::sources::{FLEET, Kind, LIVE_PAGE, LIVE_SCRIPT, Sources};

/// Connections at a time, and those of them that receive events.
const MOST: usize = 48;
const LISTENERS: usize = 12;
/// Time for a request to arrive, and for a client to take bytes.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often directories are looked at. A browser that has gone is noticed when it is told something.
const PAUSE: Duration = Duration::from_millis(150);
/// Time after which a page that was shown is closed: it may be loaded again.
const CLOSING: Duration = Duration::from_secs(3);
const HEARTBEAT: Duration = Duration::from_secs(3);
/// The first port that is tried unless one is given, and how many others.
const PORT: u16 = 8645;
const PORTS: u16 = 20;
/// Bytes of a page in a directory.
const LARGEST: u64 = 64 << 20;

/// What connections share.
struct Shared {
    door: Door,
    sources: Mutex<Sources>,
    scenes: Mutex<Scenes>,
    editor: Option<Editor>,
    /// The newest summary of all sources, and its number.
    news: Mutex<(u64, String)>,
    changed: Condvar,
    connections: AtomicUsize,
    listeners: AtomicUsize,
    /// Whether somebody has asked for anything since the last look.
    was_asked: AtomicBool,
}

/// A server of the page.
pub struct Server {
    listener: TcpListener,
    shared: Arc<Shared>,
}

impl Server {
    /// Opens a port of this machine for nobody else: the given one, or the first that is free. The page may change and run an `edited`
    /// experiment.
    ///
    /// # Errors
    /// Exit 3 if the given port is taken, or the experiment can't be read; exit 1 if there is none, or no random secret.
    pub fn open(
        folders: Vec<PathBuf>,
        port: Option<u16>,
        edited: Option<&Path>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self> {
        let bind = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        let listener = if let Some(port) = port {
            bind(port)
                .map_err(|error| Failure::input(format_args!("--port {port}: {error}; allowed: a free port, or 0")))?
        } else {
            let found = (PORT..=PORT + PORTS).find_map(|port| bind(port).ok());
            let any = || bind(0).map_err(|error| Failure::failed(format_args!("no port can be opened: {error}")));
            found.map_or_else(any, Ok)?
        };
        let address = listener.local_addr().map_err(|error| Failure::failed(&error))?;
        let editor = match edited {
            Some(experiment) => Some(Editor::new(experiment, secret()?)?),
            None => None,
        };
        Ok(Self {
            listener,
            shared: Arc::new(Shared {
                door: Door {
                    address,
                    secret: secret()?,
                    may_edit: editor.is_some(),
                },
                editor,
                sources: Mutex::new(Sources::new(folders)),
                scenes: Scenes::new(stop)?,
                news: Mutex::new((0, String::new())),
                changed: Condvar::new(),
                connections: AtomicUsize::new(0),
                listeners: AtomicUsize::new(0),
                was_asked: AtomicBool::new(false),
            }),
        })
    }

    /// The link to the page, with its secret.
    pub fn link(&self) -> String {
        let Door { address, secret, .. } = &self.shared.door;
        let edit = self.shared.editor.as_ref();
        let edit = edit.map_or_else(String::new, |editor| format!("&edit={}", editor.secret));
        format!("http://{address}/?token={secret}{edit}")
    }

    pub fn port(&self) -> u16 {
        self.shared.door.address.port()
    }

    /// Serves until `stop` is set, or until `over` is set and no browser shows the page.
    ///
    /// # Errors
    /// Exit 1 if there is no thread for it.
    pub fn serve(self, stop: &AtomicBool, over: &AtomicBool, grace: Duration) -> Result {
        let Self { listener, shared } = self;
        let others = Arc::clone(&shared);
        let accept = move || {
            for stream in listener.incoming() {
                let Ok(stream) = stream else {
                    thread::sleep(PAUSE);
                    continue;
                };
                let shared = Arc::clone(&others);
                if shared.connections.fetch_add(1, Ordering::Relaxed) >= MOST {
                    shared.connections.fetch_sub(1, Ordering::Relaxed);
                    continue;
                }
                let own = Arc::clone(&shared);
                let work = move || {
                    // A client that goes away is none of our business.
                    let _ = converse(&own, stream);
                    own.connections.fetch_sub(1, Ordering::Relaxed);
                };
                if thread::Builder::new().spawn(work).is_err() {
                    shared.connections.fetch_sub(1, Ordering::Relaxed);
                }
            }
        };
        let thread = thread::Builder::new().name("accept".into()).spawn(accept);
        thread.map_err(|error| Failure::failed(format_args!("the server has no thread: {error}")))?;
        give_way();
        // A browser that is being opened, or opens the page again, gets some time.
        let (mut shown, mut was_shown) = (Instant::now(), false);
        while !stop.load(Ordering::Relaxed) {
            let is_asked =
                shared.connections.load(Ordering::Relaxed) > 0 || shared.was_asked.swap(false, Ordering::Relaxed);
            // A page without a reader takes nothing from the run.
            if is_asked {
                shared.look();
            }
            if is_asked || !over.load(Ordering::Relaxed) {
                shown = Instant::now();
                was_shown |= is_asked;
            } else if shown.elapsed() >= grace.max(if was_shown { CLOSING } else { Duration::ZERO }) {
                break;
            }
            thread::sleep(PAUSE);
        }
        // Connections may hold what they share a little longer.
        if let Some(editor) = &shared.editor {
            editor.stop();
        }
        Ok(())
    }
}

/// Gives this thread a low priority, since runs come first; a run that the page starts has a thread without it.
pub(crate) fn give_way() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, 10);
}

/// 32 random hexadecimal digits.
fn secret() -> Result<String> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes).map_err(|error| Failure::failed(format_args!("no random numbers: {error}")))?;
    Ok(format!("{:032x}", u128::from_ne_bytes(bytes)))
}

impl Shared {
    /// Looks at all directories, and tells all that listen if something has changed.
    fn look(&self) {
        let summary = {
            let mut sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner);
            sources.look();
            sources.summary().to_string()
        };
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        if news.1 != summary {
            *news = (news.0 + 1, summary);
            self.changed.notify_all();
        }
    }

    /// The answer to a request.
    fn answer(&self, request: &Request) -> Answer {
        let parts: Vec<&str> = request.path.split('/').skip(1).collect();
        match parts[..] {
            [""] => Answer::new("text/html; charset=utf-8", PAGE),
            ["watch.js"] => Answer::new("text/javascript; charset=utf-8", pages::script()),
            ["watch.css"] => Answer::new("text/css; charset=utf-8", pages::style()),
            ["edit"] => {
                let form = self.editor.as_ref().map(Editor::form);
                Answer::new("application/json", serde_json::json!(form).to_string())
            }
            ["values", id] => self.of_source(id, |_, source| match (&self.editor, &source.kind) {
                (Some(editor), Kind::Run(run)) => {
                    Some(Answer::new("application/json", editor.values(&run.saved).to_string()))
                }
                _ => None,
            }),
            ["curve", id] => self.of_source(id, |sources, source| match &source.kind {
                Kind::Run(run) => Some(Answer::new(
                    "image/svg+xml",
                    pages::curve(sources, run, request.width.unwrap_or(1000)),
                )),
                _ => None,
            }),
            ["sweep", id] => self.of_source(id, |_, source| match &source.kind {
                Kind::Sweep(cells) => Some(Answer::new("text/html; charset=utf-8", cells.table())),
                _ => None,
            }),
            ["links", id] => self.of_source(id, |_, source| {
                Some(Answer::new("text/html; charset=utf-8", pages::links(source)))
            }),
            ["scene", id] => self.scene(id, request.generation, |scene| {
                Answer::new("application/json", pages::scene(scene))
            }),
            ["episode", id, generation] => match generation.parse() {
                Ok(generation) => self.scene(id, Some(generation), |scene| {
                    scene.map_or_else(Answer::missing, |scene| Answer::page(scene.page.clone().into_bytes()))
                }),
                Err(_) => Answer::missing(),
            },
            ["file", id, name] if FILES.contains(&name) => self.file(id, name),
            ["fleet", id, name] if FLEET.contains(&name) => self.file(id, name),
            _ => Answer::missing(),
        }
    }

    /// The answer to a wish.
    fn fulfil(&self, path: &str, secret: &str, body: &[u8]) -> Answer {
        let Some(editor) = &self.editor else {
            return Answer::missing();
        };
        if !is_secret(&editor.secret, secret) {
            return Answer::failed(
                403,
                "no token to change anything: open the address that oneiro watch --edit has printed",
            );
        }
        match path {
            // A refused value is also an answer.
            "/evolve" => {
                let problem = editor.evolve(body).err();
                Answer::new(
                    "application/json",
                    serde_json::json!({ "problem": problem }).to_string(),
                )
            }
            "/stop" => {
                editor.stop();
                Answer::new("application/json", "{}")
            }
            _ => Answer::missing(),
        }
    }

    fn of_source(&self, id: &str, answer: impl Fn(&Sources, &crate::sources::Source) -> Option<Answer>) -> Answer {
        let sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner);
        let source = sources.find(id);
        source
            .and_then(|source| answer(&sources, source))
            .unwrap_or_else(Answer::missing)
    }

    fn scene(
        &self,
        id: &str,
        generation: Option<u32>,
        answer: impl Fn(Option<&oneiro_lab::runs::Scene>) -> Answer,
    ) -> Answer {
        let saved = {
            let sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner);
            match sources.find(id).map(|source| &source.kind) {
                Some(Kind::Run(run)) => Arc::clone(&run.saved),
                _ => return Answer::missing(),
            }
        };
        match Scenes::of(&self.scenes, id, &saved, generation) {
            Ok(scene) => answer(scene.as_deref()),
            Err(failure) => Answer::failed(500, &failure.to_string()),
        }
    }

    /// A file of a source, whose name is in a list.
    fn file(&self, id: &str, name: &str) -> Answer {
        let directory = {
            let sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner);
            match sources.find(id) {
                Some(source) => source.directory.clone(),
                None => return Answer::missing(),
            }
        };
        let Ok(bytes) = plain::read(&directory.join(name), LARGEST) else {
            return Answer::missing();
        };
        match name {
            // It runs as this server's.
            LIVE_SCRIPT if is_live_script(&bytes) => Answer::new("text/javascript; charset=utf-8", bytes),
            LIVE_SCRIPT => Answer::missing(),
            LIVE_PAGE if scripts(&bytes) == *LIVE_SCRIPTS => Answer::page(bytes),
            _ => Answer::foreign(bytes),
        }
    }
}

/// The hashes of the scripts of a fleet's page that this program would write.
static LIVE_SCRIPTS: LazyLock<String> = LazyLock::new(|| scripts(foragers_script().as_bytes()));

/// Whether a script has only newer data for a fleet's page.
fn is_live_script(bytes: &[u8]) -> bool {
    let data = bytes
        .strip_prefix(b"window.oneiro.take(")
        .and_then(|rest| rest.strip_suffix(b");\n"));
    data.is_some_and(|data| serde_json::from_slice::<serde::de::IgnoredAny>(data).is_ok())
}

/// What is sent back.
struct Answer {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
    policy: Policy,
}

/// What a page may do: it runs this server's scripts and those of these hashes.
enum Policy {
    Scripts(String),
    /// It has another origin than this server.
    Sandbox(String),
}

/// Hashes of a page's inline scripts, as a policy has them. Data aren't scripts.
fn scripts(page: &[u8]) -> String {
    let text = String::from_utf8_lossy(page);
    let mut all = String::new();
    let is_code = |piece: &&str| !piece.starts_with(" type=\"application/json\"");
    for piece in text.split("<script").skip(1).filter(is_code) {
        let element = piece.split("</script>").next().unwrap_or_default();
        let script = element.split_once('>').map_or("", |(_, script)| script);
        all.extend([" 'sha256-", &base64(&Sha256::digest(script.as_bytes())), "'"]);
    }
    all
}

impl Answer {
    fn new(kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self {
            status: 200,
            kind,
            body: body.into(),
            policy: Policy::Scripts(String::new()),
        }
    }

    /// A page of this program with its scripts inside. It may run these alone.
    fn page(body: Vec<u8>) -> Self {
        Self {
            policy: Policy::Scripts(scripts(&body)),
            ..Self::new("text/html; charset=utf-8", body)
        }
    }

    /// A page from a directory, which may be somebody else's: its scripts run apart from this server's pages, without cookies and what
    /// windows store.
    fn foreign(body: Vec<u8>) -> Self {
        Self {
            policy: Policy::Sandbox(scripts(&body)),
            ..Self::new("text/html; charset=utf-8", body)
        }
    }

    fn failed(status: u16, problem: &str) -> Self {
        Self {
            status,
            ..Self::new("text/plain; charset=utf-8", problem)
        }
    }

    fn missing() -> Self {
        Self::failed(404, "no such page")
    }

    /// The head, which says what a page may load and who may show it.
    fn head(&self, cookie: Option<String>) -> String {
        let reason = match self.status {
            200 => "OK",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            503 => "Service Unavailable",
            500 => "Internal Server Error",
            _ => "Bad Request",
        };
        let cookie = cookie.map_or_else(String::new, |cookie| {
            format!("Set-Cookie: {cookie}; HttpOnly; SameSite=Strict; Path=/\r\n")
        });
        format!(
            "HTTP/1.1 {} {reason}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{cookie}{}Connection: close\r\n\r\n",
            self.status,
            self.kind,
            self.body.len(),
            guards(&self.policy)
        )
    }
}

/// Headers of every answer.
fn guards(policy: &Policy) -> String {
    let (sandbox, scripts) = match policy {
        Policy::Scripts(scripts) => ("", scripts),
        Policy::Sandbox(scripts) => ("sandbox allow-scripts allow-downloads; ", scripts),
    };
    format!(
        "Cache-Control: no-store\r\nContent-Security-Policy: {sandbox}default-src 'none'; script-src 'self'{scripts}; style-src 'self' 'unsafe-inline'; \
         img-src 'self' data: blob:; connect-src 'self'; frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
         X-Frame-Options: SAMEORIGIN\r\n"
    )
}

/// Base64 of RFC 4648.
fn base64(bytes: &[u8]) -> String {
    let words = bytes.chunks(2).map(|two| u16::from_le_bytes([two[0], two[1]]));
    oneiro_report::figures::packed(words)
}

/// Reads a request and answers it.
fn converse(shared: &Shared, mut stream: TcpStream) -> io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    let (head, rest) = read_head(&mut stream)?;
    let (answer, is_head, cookie) = match shared.door.read(&head) {
        Err((status, problem)) => (Answer::failed(status, problem), false, None),
        Ok(Request {
            wish: Some((length, secret)),
            path,
            ..
        }) => {
            let body = read_body(&mut stream, rest, length)?;
            (shared.fulfil(&path, &secret, &body), false, None)
        }
        Ok(request) if request.path == "/events" && !request.is_head => return events(shared, &mut stream),
        Ok(request) => {
            give_way();
            shared.was_asked.store(true, Ordering::Relaxed);
            let Door { secret, .. } = &shared.door;
            let cookie = request.is_link.then(|| format!("{}={secret}", shared.door.cookie()));
            (shared.answer(&request), request.is_head, cookie)
        }
    };
    stream.write_all(answer.head(cookie).as_bytes())?;
    if !is_head {
        stream.write_all(&answer.body)?;
    }
    stream.shutdown(Shutdown::Write)
}

/// Reads up to the empty line, at most [`HEAD`] bytes in [`PATIENCE`]. Returns the head, and what came after it.
fn read_head(stream: &mut TcpStream) -> io::Result<(Vec<u8>, Vec<u8>)> {
    const END: &[u8] = b"\r\n\r\n";
    let begin = Instant::now();
    let mut head = Vec::new();
    loop {
        if let Some(end) = head.windows(END.len()).position(|four| four == END) {
            let rest = head.split_off(end + END.len());
            return Ok((head, rest));
        }
        if head.len() >= HEAD || !read_some(stream, &mut head, begin)? {
            return Ok((head, Vec::new()));
        }
    }
}

/// Reads a body, of which the beginning may be there.
fn read_body(stream: &mut TcpStream, mut body: Vec<u8>, length: usize) -> io::Result<Vec<u8>> {
    let begin = Instant::now();
    while body.len() < length && read_some(stream, &mut body, begin)? {}
    body.truncate(length);
    Ok(body)
}

/// Reads what there is. Returns whether there may be more: not after [`PATIENCE`], or at the end.
fn read_some(stream: &mut TcpStream, bytes: &mut Vec<u8>, begin: Instant) -> io::Result<bool> {
    let Some(left) = PATIENCE.checked_sub(begin.elapsed()).filter(|left| !left.is_zero()) else {
        return Ok(false);
    };
    stream.set_read_timeout(Some(left))?;
    let mut piece = [0; 1024];
    let count = stream.read(&mut piece)?;
    bytes.extend_from_slice(&piece[..count]);
    Ok(count > 0)
}

/// Sends the newest summary whenever it has changed. A slow client gets fewer, never older ones.
fn events(shared: &Shared, stream: &mut TcpStream) -> io::Result<()> {
    if shared.listeners.fetch_add(1, Ordering::Relaxed) >= LISTENERS {
        shared.listeners.fetch_sub(1, Ordering::Relaxed);
        let busy = Answer::failed(503, "too many pages are open");
        stream.write_all(busy.head(None).as_bytes())?;
        return stream.write_all(&busy.body);
    }
    let sent = send_events(shared, stream);
    shared.listeners.fetch_sub(1, Ordering::Relaxed);
    sent
}

fn send_events(shared: &Shared, stream: &mut TcpStream) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{}Connection: close\r\n\r\n",
        guards(&Policy::Scripts(String::new()))
    );
    stream.write_all(head.as_bytes())?;
    let mut sent = 0;
    loop {
        let news = {
            let news = shared.news.lock().unwrap_or_else(PoisonError::into_inner);
            let wait = shared
                .changed
                .wait_timeout_while(news, HEARTBEAT, |news| news.0 == sent);
            let (news, _) = wait.unwrap_or_else(PoisonError::into_inner);
            (news.0 != sent).then(|| news.clone())
        };
        match news {
            Some((number, summary)) => {
                sent = number;
                write!(stream, "data: {summary}\n\n")?;
            }
            None => stream.write_all(b": still here\n\n")?,
        }
    }
}
