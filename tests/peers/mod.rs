//! Robots that are scripted here, by their protocols and firmware. None of them has a time-out: each keeps its last speeds
//! for ever.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Listens, and gives each connection to `serve`. Returns the address.
pub(crate) fn listen(serve: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp:{}", listener.local_addr().unwrap());
    thread::spawn(move || listener.incoming().for_each(|stream| serve(stream.unwrap())));
    address
}

/// Gives the calling thread a processor whenever it needs one, as a robot has: before the program under test, where the system allows
/// it.
pub(crate) fn with_a_processor_of_its_own() {
    #[cfg(target_os = "linux")]
    {
        use libc::{SCHED_FIFO, sched_param, sched_setscheduler};

        let parameters = sched_param { sched_priority: 2 };
        // SAFETY: the system reads the parameters during the call.
        unsafe { sched_setscheduler(0, SCHED_FIFO, &raw const parameters) };
    }
}

/// Random bytes (a linear congruential generator of Numerical Recipes).
pub(crate) struct Noise(u32);

impl Noise {
    pub(crate) fn new() -> Self {
        Self(1)
    }

    pub(crate) fn bytes(&mut self, count: usize) -> Vec<u8> {
        let mut byte = || {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 24) as u8
        };
        (0..count).map(|_| byte()).collect()
    }
}

/// Waits until something has happened.
#[track_caller]
pub(crate) fn wait(what: &str, limit: Duration, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < limit, "{what} did not happen within {limit:?}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// How late a thread is that waits for its next turn, 10 ms, and does nothing else, until it is over: the machine's own delay.
pub(crate) fn machine_is_late(is_over: &AtomicBool) -> Duration {
    let (mut next, mut late) = (Instant::now(), Duration::ZERO);
    while !is_over.load(Ordering::Relaxed) {
        next += Duration::from_millis(10);
        thread::sleep(next.saturating_duration_since(Instant::now()));
        late = late.max(next.elapsed());
        next = next.max(Instant::now());
    }
    late
}

/// How a robot answers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Manner {
    #[default]
    Plain,
    /// It obeys, and sends nothing.
    Silent,
    /// It answers so much later.
    Late(Duration),
    /// It says its last answer again and again.
    Endless,
}

/// What a robot says, in its manner.
pub(crate) struct Mouth {
    body: Body,
    due: VecDeque<(Instant, Vec<u8>)>,
    last: Vec<u8>,
    noise: Noise,
    spoke: Instant,
}

impl Mouth {
    /// Between two words of nonsense, or of a stream that does not end.
    const PAUSE: Duration = Duration::from_millis(2);

    pub(crate) fn of(body: &Body) -> Self {
        Self {
            body: body.clone(),
            due: VecDeque::new(),
            last: Vec::new(),
            noise: Noise::new(),
            spoke: Instant::now(),
        }
    }

    /// Answers, unless it is mad or silent.
    pub(crate) fn say(&mut self, bytes: &[u8]) {
        let late = match self.body.manner() {
            Manner::Plain => Duration::ZERO,
            Manner::Late(time) => time,
            Manner::Silent | Manner::Endless => return,
        };
        if !Body::is(&self.body.is_mad) && !bytes.is_empty() {
            self.due.push_back((Instant::now() + late, bytes.to_vec()));
            self.last = bytes.to_vec();
        }
    }

    /// Sends what is due. Unread bytes are lost.
    ///
    /// # Errors
    /// The other end is gone.
    pub(crate) fn speak(&mut self, link: &mut impl Write) -> io::Result<()> {
        let may_babble = self.spoke.elapsed() >= Self::PAUSE;
        let babble = match (Body::is(&self.body.is_mad), self.body.manner()) {
            (true, _) if may_babble => self.noise.bytes(20),
            (_, Manner::Endless) if may_babble => self.last.repeat(1 + 200 / self.last.len().max(1)),
            _ => Vec::new(),
        };
        if !babble.is_empty() {
            self.spoke = Instant::now();
            self.due.push_back((self.spoke, babble));
        }
        while let Some((_, bytes)) = self.due.pop_front_if(|(at, _)| *at <= Instant::now()) {
            match link.write_all(&bytes) {
                Err(error) if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    return Err(error);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// What a robot's wheels do, and what is wrong with it.
#[derive(Clone)]
pub(crate) struct Body {
    /// Speeds in the robot's unit, and since when.
    wheels: Arc<Mutex<([i16; 2], Instant)>>,
    /// How far the wheels had turned when they got these speeds, in the unit of speed times 1 s.
    turned: Arc<Mutex<[f64; 2]>>,
    /// It does not obey: its wheels turn on.
    pub(crate) is_runaway: Arc<AtomicBool>,
    /// It hears and says nothing: the radio is lost.
    pub(crate) is_deaf: Arc<AtomicBool>,
    /// It hangs up.
    pub(crate) is_gone: Arc<AtomicBool>,
    /// It hears, but says nonsense.
    pub(crate) is_mad: Arc<AtomicBool>,
    /// It is held in the air.
    pub(crate) is_lifted: Arc<AtomicBool>,
    /// Its battery is low.
    pub(crate) is_low: Arc<AtomicBool>,
    /// It restarts now, and then its wheels turn: a program of its own drives it.
    pub(crate) restarts: Arc<AtomicBool>,
    /// What its lights were set to, by the bytes of the last command.
    pub(crate) lights: Arc<Mutex<Vec<u8>>>,
    /// How it answers.
    manner: Arc<Mutex<Manner>>,
    /// When it was told to stop.
    pub(crate) stops: Arc<Mutex<Vec<Instant>>>,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            wheels: Arc::new(Mutex::new(([0; 2], Instant::now()))),
            turned: Arc::default(),
            is_runaway: Arc::default(),
            is_deaf: Arc::default(),
            is_gone: Arc::default(),
            is_mad: Arc::default(),
            is_lifted: Arc::default(),
            is_low: Arc::default(),
            restarts: Arc::default(),
            lights: Arc::default(),
            manner: Arc::default(),
            stops: Arc::default(),
        }
    }
}

impl Body {
    /// Speeds of the left and the right wheel, and since when they are these.
    pub(crate) fn wheels(&self) -> ([i16; 2], Instant) {
        *self.wheels.lock().unwrap()
    }

    /// Sets the speeds, as if by somebody else.
    pub(crate) fn set(&self, speeds: [i16; 2]) {
        let mut wheels = self.wheels.lock().unwrap();
        if wheels.0 != speeds {
            let mut turned = self.turned.lock().unwrap();
            *turned = since(*wheels, *turned);
            *wheels = (speeds, Instant::now());
        }
    }

    /// How far the wheels have turned, in the unit of speed times 1 s.
    pub(crate) fn turned(&self) -> [f64; 2] {
        let wheels = self.wheels.lock().unwrap();
        since(*wheels, *self.turned.lock().unwrap())
    }

    /// Sets the speeds by a command.
    pub(crate) fn obey(&self, speeds: [i16; 2]) {
        if speeds == [0; 2] {
            self.stops.lock().unwrap().push(Instant::now());
        }
        if !self.is_runaway.load(Ordering::SeqCst) {
            self.set(speeds);
        }
    }

    /// How it answers.
    pub(crate) fn manner(&self) -> Manner {
        *self.manner.lock().unwrap()
    }

    /// Changes how it answers.
    pub(crate) fn answer(&self, manner: Manner) {
        *self.manner.lock().unwrap() = manner;
    }

    /// Whether the wheels stand.
    pub(crate) fn stands(&self) -> bool {
        self.wheels().0 == [0, 0]
    }

    /// Whether a flag is set.
    pub(crate) fn is(flag: &AtomicBool) -> bool {
        flag.load(Ordering::SeqCst)
    }
}

/// How far wheels that had turned so far before have turned now.
fn since((speeds, since): ([i16; 2], Instant), before: [f64; 2]) -> [f64; 2] {
    let seconds = since.elapsed().as_secs_f64();
    [0, 1].map(|wheel| before[wheel] + f64::from(speeds[wheel]) * seconds)
}

/// An e-puck2 on Wi-Fi. It is silent until the first command; then it sends its sensors every 20 ms, each block from
/// before the last command was obeyed. It keeps its speeds also when the client is gone.
#[derive(Clone, Default)]
pub(crate) struct EPuck2(pub(crate) Body);

impl EPuck2 {
    const CYCLE: Duration = Duration::from_millis(20);
    const RESTART: Duration = Duration::from_secs(1);

    /// Starts it with turning wheels.
    pub(crate) fn start(&self) -> String {
        self.0.set([300, -200]);
        let robot = self.clone();
        listen(move |stream| robot.serve(stream))
    }

    /// Serves one client, until it is gone.
    fn serve(&self, mut stream: TcpStream) {
        with_a_processor_of_its_own();
        let (body, mut commands, mut mouth) = (&self.0, Vec::new(), Mouth::of(&self.0));
        let mut has_begun = false;
        // In 1/1000 of a step.
        let mut counters = [0_i64; 2];
        let mut buffer = [0; 256];
        stream.set_read_timeout(Some(Self::CYCLE)).unwrap();
        stream.set_write_timeout(Some(Self::CYCLE)).unwrap();
        loop {
            if Body::is(&body.is_deaf) {
                thread::sleep(Self::CYCLE);
                continue;
            }
            // The radio says nothing meanwhile, and the counters begin at 0.
            if body.restarts.swap(false, Ordering::SeqCst) {
                thread::sleep(Self::RESTART);
                body.set([50, 50]);
                counters = [0; 2];
            }
            let block = self.block(counters.map(|counter| (counter / 1000) as i16));
            match stream.read(&mut buffer) {
                Ok(0) => return,
                Ok(count) => commands.extend_from_slice(&buffer[..count]),
                Err(_) => {}
            }
            // Of several commands only the last counts.
            let whole = commands.len() / 21 * 21;
            if let Some(command) = commands[..whole].chunks(21).next_back() {
                assert_eq!(command[..2], [0x80, 2]);
                has_begun = true;
                let word = |at: usize| i16::from_le_bytes([command[at], command[at + 1]]);
                body.obey([word(3), word(5)]);
                *body.lights.lock().unwrap() = command[7..20].into();
            }
            commands.drain(..whole);
            for (counter, speed) in counters.iter_mut().zip(body.wheels().0) {
                *counter += i64::from(speed) * Self::CYCLE.as_millis() as i64;
            }
            if has_begun {
                mouth.say(&block);
            }
            if Body::is(&body.is_gone) || mouth.speak(&mut stream).is_err() {
                return;
            }
        }
    }

    /// A header and the sensors: gravity along the third axis unless it is lifted, rotation 21, -22 and 23, proximity 100 to
    /// 107, light 3000 to 3007, 250 mm ahead, sound 71 to 74 and ground 901 to 903, -5 degrees C, 3.9 V or 3.4 V; acceleration
    /// 9.5, orientation 120.25 and inclination 3.75; 1, 8 and 5 from a television's remote control.
    fn block(&self, steps: [i16; 2]) -> Vec<u8> {
        let mut block = vec![0; 105];
        let mut word = |at: usize, value: u16| block[1 + at..][..2].copy_from_slice(&value.to_le_bytes());
        word(if Body::is(&self.0.is_lifted) { 0 } else { 4 }, 768);
        for (axis, rotation) in [21, -22, 23_i16].into_iter().enumerate() {
            word(18 + 2 * axis, rotation as u16);
        }
        for sensor in 0..4 {
            word(71 + 2 * sensor, 71 + sensor as u16);
        }
        for sensor in 0..3 {
            word(90 + 2 * sensor, 901 + sensor as u16);
        }
        for sensor in 0..8 {
            word(37 + 2 * sensor, 100 + sensor as u16);
            word(53 + 2 * sensor, 3000 + sensor as u16);
        }
        word(69, 250);
        word(79, steps[0] as u16);
        word(81, steps[1] as u16);
        word(83, if Body::is(&self.0.is_low) { 2785 } else { 3195 });
        for (at, value) in [(6, 9.5_f32), (10, 120.25), (14, 3.75)] {
            block[1 + at..][..4].copy_from_slice(&value.to_le_bytes());
        }
        block[1 + 36] = -5_i8 as u8;
        block[1 + 86..][..3].copy_from_slice(&[1, 8, 5]);
        block[0] = 2;
        block
    }
}
