// What all pages that play robots have in common: time, poses, the canvas, and whom one follows. chart.js and the page's own file stand
// after it in the same function; the latter has `fit` and `show`. Data are in the element `replay`; what each array holds stands in the
// Rust file of the page.
// A fragment such as #t=754&robot=3 opens the page at that second, paused, following that robot.

const INK = '#33363f';
const SOFT_INK = '#74777f';
const FOLLOWED = '#23528f';
const LAMP = '#f2b01e';
const FONT = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";
const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
// Position of a robot whose pose is unknown.
const NOWHERE = -32768;
// Seconds of a trail, and of that of the robot that is followed.
const TRAIL = 20;
const LONG_TRAIL = 60;

const element = (id) => document.getElementById(id);
const calm = matchMedia('(prefers-reduced-motion: reduce)');

// Bytes as they were packed, little-endian, which every machine with a browser is.
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

let data = JSON.parse(element('replay').textContent);
const { names } = data;
// What the names number.
const who = data.who || 'robot';
const Who = who[0].toUpperCase() + who.slice(1);
const robots = names.length;
let xs, ys, headings;
let lines, every, first, last;

function unpackPoses(fresh) {
  data = { ...data, ...fresh };
  xs = new Int16Array(bytes(data.x));
  ys = new Int16Array(bytes(data.y));
  headings = new Uint16Array(bytes(data.heading));
  lines = data.times.length;
  first = lines > 0 ? timeOf(0) : 0;
  last = lines > 0 ? timeOf(lines - 1) : 0;
  every = lines > 1 ? timeOf(1) - first : 1;
}

// In seconds.
const timeOf = (line) => data.times[line] / 10;

let time = 0;
let playing = false;
let speed = 10;
let followed = -1;
// What drawing a frame put where, for tests.
let put = { robots: [], sides: [] };

// The last line up to a time, -1 before the first.
function lineAt(when) {
  let [from, to] = [0, lines];
  while (from < to) {
    const middle = (from + to) >> 1;
    if (data.times[middle] <= when * 10 + 1e-6) from = middle + 1;
    else to = middle;
  }
  return from - 1;
}

// The line at or before a time, and the share of the way to the next.
function locate(when) {
  const line = Math.max(lineAt(when), 0);
  if (line + 1 >= lines) return { line, share: 0 };
  const share = (when - timeOf(line)) / (timeOf(line + 1) - timeOf(line));
  return { line, share: share < 1e-9 ? 0 : share };
}

// Where a robot is: mm, and turns counter-clockwise; null if that is unknown. Between lines it goes straight and turns the
// shorter way.
function pose(robot, { line, share }) {
  const at = line * robots + robot;
  if (xs[at] === NOWHERE) return null;
  let x = xs[at];
  let y = ys[at];
  let heading = headings[at];
  const next = at + robots;
  if (share > 0 && xs[next] !== NOWHERE) {
    x += share * (xs[next] - x);
    y += share * (ys[next] - y);
    heading += share * (((headings[next] - heading + 98304) & 65535) - 32768);
  }
  return { x: x * data.unit, y: y * data.unit, heading: heading / 65536 };
}

function clock(seconds) {
  // Tenths where lines are closer than a second.
  const tenths = every % 1 === 0 ? 0 : 1;
  const whole = Math.floor(seconds * 10 ** tenths + 1e-6) / 10 ** tenths;
  const rest = (whole % 60).toFixed(tenths);
  return `${Math.floor(whole / 60)}:${rest.padStart(tenths === 0 ? 2 : 4, '0')}`;
}

// ---- The arena.

const canvas = element('arena');
const pen = canvas.getContext('2d');
// From mm to the canvas's pixels, y up in the arena and down on the canvas.
const view = { scale: 1, x: 0, y: 0, width: 1, height: 1, ratio: 1 };
const place = (x, y) => [view.x + x * view.scale, view.y - y * view.scale];

// Fits what lies between these places, in mm, into the page.
function fitTo({ left, right, bottom, top }) {
  const room = element('room');
  const width = Math.max(room.clientWidth, 120);
  let height = (width * (top - bottom)) / (right - left);
  // Controls stay in sight below, on a projector of 1024 by 600 too.
  height = Math.min(height, Math.max(260, innerHeight - 298));
  view.ratio = devicePixelRatio || 1;
  view.width = width;
  view.height = Math.round(height);
  view.scale = Math.min(view.width / (right - left), view.height / (top - bottom));
  view.x = view.width / 2 - (view.scale * (left + right)) / 2;
  view.y = view.height / 2 + (view.scale * (bottom + top)) / 2;
  canvas.width = Math.round(view.width * view.ratio);
  canvas.height = Math.round(view.height * view.ratio);
  canvas.style.height = `${view.height}px`;
}

function disc(x, y, radius) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
}

// Text with a rim of the ground's colour, to be read on whatever is below it.
function words(text, x, y, size, colour, weight = 400) {
  pen.font = `${weight} ${size}px ${FONT}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.lineJoin = 'round';
  pen.lineWidth = 3;
  pen.strokeStyle = 'rgba(255, 255, 255, 0.85)';
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
}

// A lamp, size in pixels.
function drawSun(x, y, size) {
  pen.strokeStyle = LAMP;
  pen.lineWidth = 2;
  pen.lineCap = 'round';
  for (let ray = 0; ray < 8; ray++) {
    const turn = (ray / 8) * 2 * Math.PI;
    pen.beginPath();
    pen.moveTo(x + 1.35 * size * Math.cos(turn), y + 1.35 * size * Math.sin(turn));
    pen.lineTo(x + 1.8 * size * Math.cos(turn), y + 1.8 * size * Math.sin(turn));
    pen.stroke();
  }
  disc(x, y, size);
  pen.fillStyle = LAMP;
  pen.fill();
  pen.strokeStyle = '#a87400';
  pen.lineWidth = 1.2;
  pen.stroke();
}

// What tests are told: where the pen stands, taken back from pixels to mm.
function standing() {
  const { scale, x, y, ratio } = view;
  const back = new DOMMatrix([scale * ratio, 0, 0, -scale * ratio, x * ratio, y * ratio]).inverse();
  const here = back.multiply(pen.getTransform());
  return { x: here.e, y: here.f, heading: Math.atan2(here.b, here.a) / (2 * Math.PI) };
}

// Ways of the last seconds: all pieces of one age at once, since there may be many robots.
function drawTrails(where, seconds, who, colour, width, strength) {
  const step = Math.max(1, Math.round(0.5 / every));
  const pieces = Math.ceil(seconds / (step * every));
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineCap = 'butt';
  let newer = who.map((robot) => pose(robot, where));
  for (let piece = 0; piece < pieces; piece++) {
    const line = where.line - piece * step - (where.share > 0 ? 0 : step);
    if (line < 0) break;
    const older = who.map((robot) => pose(robot, { line, share: 0 }));
    pen.globalAlpha = strength * (1 - piece / pieces);
    pen.beginPath();
    older.forEach((from, i) => {
      if (!from || !newer[i]) return;
      pen.moveTo(...place(newer[i].x, newer[i].y));
      pen.lineTo(...place(from.x, from.y));
    });
    pen.stroke();
    newer = older;
  }
  pen.globalAlpha = 1;
}

// A robot in a colour, with those of its front and of its number; `under` draws what it carries.
function drawBody(robot, { x, y, heading }, { colour, marks }, under = () => {}) {
  const radius = data.body * view.scale;
  const [front, ink] = marks || ['#ffffff', '#ffffff'];
  pen.save();
  pen.translate(...place(x, y));
  pen.rotate(-2 * Math.PI * heading);
  const here = standing();
  put.robots.push({ name: names[robot], x: here.x, y: here.y, heading: here.heading });
  // On its side, where nothing else is painted on it.
  const { x: left, y: top } = pen.getTransform().transformPoint({ x: 0, y: 0.75 * radius });
  put.sides.push([left, top]);
  under(radius);
  disc(0, 0, radius);
  pen.fillStyle = colour;
  pen.fill();
  pen.strokeStyle = robot === followed ? FOLLOWED : '#ffffff';
  pen.lineWidth = robot === followed ? 2.5 : 1.2;
  pen.stroke();
  // The front.
  pen.beginPath();
  pen.moveTo(0.98 * radius, 0);
  pen.lineTo(0.5 * radius, 0.5 * radius);
  pen.lineTo(0.5 * radius, -0.5 * radius);
  pen.closePath();
  pen.fillStyle = front;
  pen.fill();
  pen.restore();
  const [middle, height] = place(x, y);
  if (robot === followed) {
    // With a white rim, to be seen on dark floors.
    disc(middle, height, radius + 5);
    for (const [colour, width] of [['#ffffff', 5], [FOLLOWED, 2.5]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.stroke();
    }
  }
  if (radius >= 9.5) {
    // Behind the front, where there is room.
    const turn = 2 * Math.PI * heading;
    const size = radius * (names[robot] > 99 ? 0.72 : 0.84);
    pen.font = `700 ${size.toFixed(1)}px ${FONT}`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillStyle = ink;
    const shift = 0.24 * radius;
    pen.fillText(names[robot], middle - shift * Math.cos(turn), height + shift * Math.sin(turn) + 0.06 * size);
  }
}

// A scale of at most `most` mm.
function drawScale(small, most) {
  const long = [1000, 500, 200, 100, 50, 20, 10].find((mm) => mm <= most) || 10;
  const right = view.width - 10;
  const left = right - long * view.scale;
  const bottom = view.height - 8;
  pen.strokeStyle = INK;
  pen.lineWidth = 1.6;
  pen.lineCap = 'butt';
  pen.beginPath();
  pen.moveTo(left, bottom - 4);
  pen.lineTo(left, bottom + 4);
  pen.moveTo(left, bottom);
  pen.lineTo(right, bottom);
  pen.moveTo(right, bottom - 4);
  pen.lineTo(right, bottom + 4);
  pen.stroke();
  words(`${long} mm`, (left + right) / 2, bottom - 10, small, SOFT_INK);
}

function made(name, parent, settings = {}) {
  const child = document.createElement(name);
  Object.assign(child, settings);
  parent.append(child);
  return child;
}

// Sets what changed, and touches nothing else: many frames change little.
function set(node, key, value) {
  if (node[key] !== value) node[key] = value;
}

// Before what is drawn: nothing was put anywhere.
function clear() {
  pen.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
  pen.clearRect(0, 0, view.width, view.height);
  put = { robots: [], sides: [] };
}

// The colour that the canvas has where a robot's side should be.
const sideColours = () => put.sides.map(([x, y]) => {
  const pixel = pen.getImageData(Math.floor(x), Math.floor(y), 1, 1).data;
  return `#${Array.from(pixel.slice(0, 3), (part) => part.toString(16).padStart(2, '0')).join('')}`;
});

// Adds a line to the legend: a picture in SVG, 18 by 18 about its middle, and what it means.
function legendEntry(picture, text) {
  const item = made('li', element('legend'));
  item.innerHTML = `<svg width="18" height="18" viewBox="-9 -9 18 18" aria-hidden="true">${picture}</svg>`;
  item.append(text);
}

// ---- Playing.

function say(text) {
  element('said').textContent = text;
}

function showClock(when) {
  const slider = element('when');
  if (Number(slider.value) !== when) slider.value = when;
  const shown = `${clock(when)} of ${clock(last)}`;
  if (slider.getAttribute('aria-valuetext') === shown) return;
  slider.setAttribute('aria-valuetext', shown);
  const box = element('clock');
  box.replaceChildren();
  made('b', box, { textContent: clock(when) });
  box.append(` of ${clock(last)}`);
}

// A button that follows a robot, or lets go of it.
function followButton(robot, parent) {
  const button = made('button', parent, { type: 'button', className: 'who' });
  const dot = made('span', button, { className: 'dot' });
  button.append(names[robot]);
  button.title = `follow ${who} ${names[robot]}`;
  button.setAttribute('aria-label', `Follow ${who} ${names[robot]}`);
  button.addEventListener('click', (event) => {
    follow(followed === robot ? -1 : robot);
    // After a click the space bar is for playing again; who uses the keyboard stays where they are.
    if (event.detail > 0) button.blur();
  });
  return { button, dot };
}

function showButton({ row, button, dot }, robot, colour) {
  set(row, 'className', robot === followed ? 'followed' : '');
  const pressed = String(robot === followed);
  if (button.getAttribute('aria-pressed') !== pressed) button.setAttribute('aria-pressed', pressed);
  if (dot.dataset.colour !== colour) {
    dot.dataset.colour = colour;
    dot.style.background = colour;
  }
}

let due = false;
let before = 0;

function frame(now) {
  due = false;
  if (playing) {
    // After a pause of the page itself it goes on, and does not jump.
    time += (Math.min(now - before, 100) / 1000) * speed;
    if (time >= last) {
      time = last;
      play(false);
    }
  }
  before = now;
  show();
  if (playing) ask();
}

function ask() {
  if (due) return;
  due = true;
  requestAnimationFrame(frame);
}

function play(on) {
  if (on && (lines < 2)) return;
  if (on && time >= last) time = first;
  playing = on;
  before = performance.now();
  const button = element('play');
  set(button, 'textContent', on ? 'Pause' : 'Play');
  ask();
}

function seek(to) {
  time = Math.min(Math.max(to, first), last);
  ask();
}

function stepBy(count) {
  play(false);
  const { line, share } = locate(time);
  // From between two lines, back means to the one before.
  const from = share > 0 && count < 0 ? line + 1 : line;
  seek(timeOf(Math.min(Math.max(from + count, 0), Math.max(lines - 1, 0))));
}

function follow(robot) {
  followed = robot;
  say(robot < 0 ? `Following no ${who}.` : `Following ${who} ${names[robot]}.`);
  ask();
}

function setSpeed(index) {
  const at = Math.min(Math.max(index, 0), SPEEDS.length - 1);
  speed = SPEEDS[at];
  element('speed').selectedIndex = at;
}

function robotUnder(event) {
  if (lines === 0) return -1;
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const where = locate(time);
  let best = { robot: -1, distance: Math.max(1.3 * data.body * view.scale, 14) };
  for (let robot = 0; robot < robots; robot++) {
    const at = pose(robot, where);
    if (!at) continue;
    const [left, top] = place(at.x, at.y);
    const distance = Math.hypot(left - x, top - y);
    if (distance < best.distance) best = { robot, distance };
  }
  return best.robot;
}

function listen() {
  element('play').addEventListener('click', () => play(!playing));
  element('back').addEventListener('click', () => stepBy(-1));
  element('forth').addEventListener('click', () => stepBy(1));
  element('when').addEventListener('input', (event) => seek(Number(event.target.value)));
  element('speed').addEventListener('change', (event) => setSpeed(event.target.selectedIndex));
  canvas.addEventListener('click', (event) => {
    const robot = robotUnder(event);
    follow(robot === followed ? -1 : robot);
  });
  canvas.addEventListener('mousemove', (event) => {
    canvas.style.cursor = robotUnder(event) < 0 ? 'default' : 'pointer';
  });
  chart.style.cursor = 'pointer';
  chart.addEventListener('click', (event) => {
    const { wide, left, right } = chartView;
    const share = (event.clientX - chart.getBoundingClientRect().left - left) / (wide - left - right);
    seek(share * chartView.whole);
  });
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const target = event.target;
    const many = event.shiftKey ? 10 : 1;
    const acts = {
      ' ': () => play(!playing),
      ArrowLeft: () => stepBy(-many),
      ArrowRight: () => stepBy(many),
      Home: () => seek(first),
      End: () => seek(last),
      '+': () => setSpeed(SPEEDS.indexOf(speed) + 1),
      '-': () => setSpeed(SPEEDS.indexOf(speed) - 1),
      Escape: () => follow(-1),
    };
    // Buttons and lists keep the keys that they need.
    if ((target.tagName === 'BUTTON' || target.type === 'checkbox') && event.key === ' ') return;
    if (target.tagName === 'SELECT' && event.key !== 'Escape') return;
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
  const refit = () => {
    // A canvas of a new size is empty: it is drawn at once, so that nothing flickers.
    fit();
    fitChart();
    show();
  };
  new ResizeObserver(refit).observe(element('room'));
  addEventListener('resize', refit);
}

// Fits what depends on how long the record is.
function spreadTime() {
  const slider = element('when');
  slider.min = first;
  slider.max = last;
  slider.disabled = lines < 2;
  for (const id of ['play', 'back', 'forth']) element(id).disabled = lines < 2;
}

// Opens the page where its fragment says, and returns whether that says when.
function begin() {
  SPEEDS.forEach((times) => made('option', element('speed'), { textContent: `${times}\u00d7` }));
  setSpeed(SPEEDS.indexOf(speed));
  fit();
  fitChart();
  listen();
  const wanted = new URLSearchParams(location.hash.slice(1));
  if (wanted.has('robot')) followed = names.indexOf(Number(wanted.get('robot')));
  if (wanted.has('t')) seek(Number(wanted.get('t')) || 0);
  show();
  return wanted.has('t');
}
