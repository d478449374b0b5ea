// Plays an episode: what player.js leaves to it. What each array holds stands in episode.rs.

const MESSAGE = '#8a3fa0';
const SENSOR = '193, 18, 31';
// An episode takes about so many seconds to play.
const PLAYED = 25;

const { acts, arena, readings, sensors, plain } = data;
unpackPoses({});
const states = new Uint16Array(bytes(data.state));
const values = new Uint16Array(bytes(data.values));
const senders = new Uint16Array(bytes(data.senders));
const fitness = new Float32Array(bytes(data.fitness));
const earned = new Float32Array(bytes(data.earned));
const hears = senders.length > 0;
const scoresEach = earned.length > 0;
const everyone = names.map((_, robot) => robot);
const alone = robots === 1;
// Whether each robot is alone in its world, and has a fitness of its own.
const apart = who === 'generation';
time = first;
// The last one that was named.
followed = apart ? robots - 1 : 0;
speed = SPEEDS.find((times) => last / times <= 1.2 * PLAYED) || SPEEDS[SPEEDS.length - 1];
// The reading that the chart shows; -1: fitness.
let charted = -1;

const act = (robot, line) => acts[states[line * robots + robot]] || plain[robot];
const number = (value) => Number(value.toPrecision(6)).toLocaleString('en', { maximumFractionDigits: 6 });

function reading(robot, line, index) {
  const { low, high, whole } = readings[index];
  const value = low + ((high - low) * values[(line * robots + robot) * readings.length + index]) / 65535;
  return whole ? Math.round(value) : value;
}

// Robots whose messages this one has heard.
function heardBy(robot, line) {
  const words = hears ? Math.ceil(robots / 16) : 0;
  const at = (line * robots + robot) * words;
  return everyone.filter((other) => words > 0 && (senders[at + (other >> 4)] >> (other & 15)) & 1);
}

// ---- The arena.

function fit() {
  const { left, right, bottom, top } = data.view;
  const room = 0.04 * Math.max(right - left, top - bottom);
  // Below there is room for the scale.
  fitTo({ left: left - room, right: right + room, bottom: bottom - 2 * room, top: top + room });
}

function outline(points) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(...place(x, y));
  pen.closePath();
}

// A shape of corners, or of a middle and a radius.
function shape({ corners, middle, radius }) {
  if (corners) outline(corners);
  else disc(...place(...middle), radius * view.scale);
}

function drawGround() {
  const grey = (share) => {
    const level = Math.floor(70 + 185 * share);
    return `rgb(${level} ${level} ${level})`;
  };
  pen.save();
  shape(arena.ground);
  pen.fillStyle = arena.floor === null ? '#f5f3ee' : grey(arena.floor);
  pen.fill();
  pen.clip();
  for (const patch of arena.patches) {
    shape(patch);
    pen.fillStyle = grey(patch.grey);
    pen.fill();
  }
  pen.restore();
  if (arena.open) {
    shape(arena.ground);
    pen.setLineDash([6, 5]);
    pen.strokeStyle = SOFT_INK;
    pen.lineWidth = 1.2;
    pen.stroke();
    pen.setLineDash([]);
  }
  for (const object of arena.objects) {
    shape(object);
    pen.fillStyle = '#c9ccd3';
    pen.fill();
    pen.strokeStyle = '#7c818c';
    pen.lineWidth = 2;
    pen.stroke();
  }
  pen.strokeStyle = INK;
  pen.lineWidth = 4;
  pen.lineCap = 'round';
  pen.beginPath();
  for (const [from, to] of arena.walls) {
    pen.moveTo(...place(...from));
    pen.lineTo(...place(...to));
  }
  pen.stroke();
  for (const lamp of arena.lamps) {
    const [x, y] = place(...lamp);
    const glow = pen.createRadialGradient(x, y, 0, x, y, 60);
    glow.addColorStop(0, 'rgba(255, 196, 60, 0.5)');
    glow.addColorStop(1, 'rgba(255, 196, 60, 0)');
    pen.fillStyle = glow;
    disc(x, y, 60);
    pen.fill();
    drawSun(x, y, 9);
  }
}

// The sensors of the robot that is followed: where they are and look, and how much each reads.
function drawSensors(line, { x, y, heading }) {
  const body = data.body * view.scale;
  pen.save();
  pen.translate(...place(x, y));
  pen.rotate(-2 * Math.PI * heading);
  for (const { reading: index, bearing, heading: looks, offset, range, width } of sensors) {
    const { to } = readings[index];
    const share = Math.min(Math.max(reading(followed, line, index) / to, 0), 1);
    const colour = `rgba(${SENSOR}, ${(0.25 + 0.75 * share).toFixed(3)})`;
    pen.strokeStyle = colour;
    pen.fillStyle = colour;
    if (width !== undefined) {
      const half = Math.PI * width;
      pen.lineWidth = 2 + 3 * share;
      pen.beginPath();
      pen.arc(0, 0, body + 2, -2 * Math.PI * looks - half, -2 * Math.PI * looks + half);
      pen.stroke();
      continue;
    }
    const turned = (turns) => [Math.cos(2 * Math.PI * turns), -Math.sin(2 * Math.PI * turns)];
    const [[right, down], [ahead, aside]] = [turned(bearing), turned(looks)];
    const [left, top] = [right * offset * view.scale, down * offset * view.scale];
    if (range) {
      pen.lineWidth = 1 + 2.5 * share;
      pen.beginPath();
      pen.moveTo(left, top);
      pen.lineTo(left + ahead * range * view.scale, top + aside * range * view.scale);
      pen.stroke();
    }
    disc(left, top, 2 + 2 * share);
    pen.fill();
  }
  pen.restore();
}

function drawMessages(line, poses) {
  pen.strokeStyle = MESSAGE;
  pen.lineCap = 'round';
  for (const hearer of everyone) {
    const own = hearer === followed;
    pen.globalAlpha = followed < 0 || own ? 0.9 : 0.45;
    pen.lineWidth = own ? 3 : 1.6;
    pen.beginPath();
    for (const sender of heardBy(hearer, line)) {
      pen.moveTo(...place(poses[hearer].x, poses[hearer].y));
      pen.lineTo(...place(poses[sender].x, poses[sender].y));
    }
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

function drawArena(when) {
  clear();
  drawGround();
  drawScale(Math.max(10, Math.min(13, 0.02 * view.width)), 0.2 * (data.view.right - data.view.left));
  const where = locate(when);
  const poses = everyone.map((robot) => pose(robot, where));
  if (element('trails').checked) {
    const wide = Math.max(1.4, 5 * view.scale);
    if (apart) everyone.forEach((robot) => drawTrails(where, LONG_TRAIL, [robot], plain[robot].colour, wide, 0.6));
    else drawTrails(where, TRAIL, everyone, INK, wide, 0.4);
    if (!apart && followed >= 0) drawTrails(where, LONG_TRAIL, [followed], FOLLOWED, 2.4, 0.8);
  }
  if (hears && element('messages').checked) drawMessages(where.line, poses);
  for (const robot of everyone) drawBody(robot, poses[robot], act(robot, where.line));
  if (followed >= 0 && element('sensors').checked) drawSensors(where.line, poses[followed]);
}

// ---- What stands beside it.

const bars = [];
const rows = [];

function buildReadings() {
  for (const { name, from, to } of readings) {
    const box = made('div', element('readings'));
    made('dt', box, { textContent: name, title: `${name}, ${from} to ${to}` });
    const bar = made('u', made('i', box));
    bars.push({ bar, value: made('dd', box) });
  }
}

function showReadings(line) {
  const whose = alone ? 'Readings' : `${Who} ${names[followed]} reads`;
  set(element('readings-title'), 'textContent', followed < 0 ? 'Readings: click a robot' : whose);
  bars.forEach(({ bar, value }, index) => {
    if (followed < 0) {
      bar.style.width = 0;
      set(value, 'textContent', '');
      return;
    }
    const { from, to } = readings[index];
    const share = (own) => (100 * (own - from)) / (to - from);
    const own = reading(followed, line, index);
    const [left, right] = [share(Math.min(own, 0)), share(Math.max(own, 0))];
    bar.style.left = `${left}%`;
    bar.style.width = `${right - left}%`;
    // No minus before a zero.
    set(value, 'textContent', (own + 0).toFixed(readings[index].whole ? 0 : 3).replace(/^-(0\.0+)$/, '$1'));
  });
}

function buildTable() {
  const table = element('robots');
  element('each').hidden = alone;
  element('robots-title').textContent = `${Who}s`;
  if (acts.length === 0 && !hears && !scoresEach) table.className = 'bare';
  const head = made('tr', made('thead', table));
  made('th', head, { textContent: Who, scope: 'col' });
  if (acts.length > 0) made('th', head, { textContent: 'State', scope: 'col' });
  if (hears) made('th', head, { textContent: 'Hears', scope: 'col', className: 'hears', title: 'robots whose messages it hears' });
  if (scoresEach) made('th', head, { textContent: 'Score', scope: 'col', className: 'own', title: 'what the task has given it so far' });
  const body = made('tbody', table);
  for (const robot of everyone) {
    const row = made('tr', body);
    rows.push({
      row,
      ...followButton(robot, made('th', row, { scope: 'row' })),
      does: acts.length > 0 && made('td', row),
      heard: hears && made('td', row, { className: 'hears' }),
      score: scoresEach && made('td', row, { className: 'own' }),
    });
  }
  element('note').textContent = scoresEach ? '' : 'The mission scores the swarm as a whole, and no robot by itself.';
}

function showTable(line) {
  rows.forEach((own, robot) => {
    const { name, colour } = act(robot, line);
    showButton(own, robot, colour);
    if (own.does) set(own.does, 'textContent', name);
    if (own.heard) set(own.heard, 'textContent', String(heardBy(robot, line).length));
    if (own.score) set(own.score, 'textContent', number(earned[line * robots + robot]));
  });
}

// What the chart shows of a line; null without a robot that is followed.
function valueAt(line) {
  if (charted < 0) return apart ? earned[line * robots + Math.max(followed, 0)] : fitness[line];
  return followed < 0 ? null : reading(followed, line, charted);
}

function buildChoice() {
  const choice = element('charted');
  ['fitness', ...readings.map(({ name }) => name)].forEach((name) => made('option', choice, { textContent: name }));
  choice.addEventListener('change', () => {
    charted = choice.selectedIndex - 1;
    buildChart();
    ask();
  });
}

function buildChart() {
  const scores = Array.from(apart ? earned : fitness);
  const own = charted < 0 ? scores : [readings[charted].low, readings[charted].high];
  const [low, high] = [Math.min, Math.max].map((of) => own.reduce((most, value) => of(most, value), 0));
  chartView.step = rounded(high - low || 1, 4);
  chartView.low = Math.floor(low / chartView.step) * chartView.step;
  chartView.most = Math.ceil((high > low ? high : low + 1) / chartView.step) * chartView.step;
  chartView.whole = Math.max(last, 0.1);
  chartView.left = 56;
  const shown = charted < 0 ? 'Fitness' : readings[charted].name;
  chart.setAttribute('aria-label', `${shown} over time, ${number(low)} to ${number(high)}`);
}

function drawChart(when) {
  drawLevels(chartView.step);
  drawTimes();
  const curve = (to, colour, width) => {
    chartPen.beginPath();
    for (let line = 0; line <= to && valueAt(line) !== null; line++) chartPen.lineTo(chartX(timeOf(line)), chartY(valueAt(line)));
    chartPen.strokeStyle = colour;
    chartPen.lineWidth = width;
    chartPen.lineJoin = 'round';
    chartPen.stroke();
  };
  if (apart && charted < 0) {
    everyone.forEach((robot) => {
      chartPen.beginPath();
      for (let line = 0; line < lines; line++) chartPen.lineTo(chartX(timeOf(line)), chartY(earned[line * robots + robot]));
      chartPen.strokeStyle = plain[robot].colour;
      chartPen.lineWidth = 1.5;
      chartPen.stroke();
    });
  } else {
    curve(lines - 1, '#c9ccd3', 1.5);
  }
  curve(locate(when).line, apart && followed >= 0 ? plain[followed].colour : FOLLOWED, 2.4);
  drawNow(when);
}

function buildLegend() {
  for (const { name, colour } of acts) {
    legendEntry(`<circle r="7.5" fill="${colour}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="#ffffff"/>`, name);
  }
  const kinds = new Map(plain.filter(({ name }) => (apart || acts.length === 0) && name).map(({ name, colour }) => [name, colour]));
  for (const [name, colour] of kinds) {
    legendEntry(`<circle r="7.5" fill="${colour}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="#ffffff"/>`, name);
  }
  if (hears) legendEntry(`<path d="M-8 4L8 -4" stroke="${MESSAGE}" stroke-width="2.4" stroke-linecap="round"/>`, 'hears now');
  if (arena.lamps.length > 0) legendEntry('<circle r="5" fill="#f2b01e" stroke="#a87400"/>', 'lamp');
}

function showWords(line) {
  const whose = apart ? `${Who} ${names[Math.max(followed, 0)]}: fitness` : 'Fitness';
  const now = apart ? earned[line * robots + Math.max(followed, 0)] : fitness[line];
  set(element('light'), 'textContent', `${whose} if the episode ended now: ${number(now)}`);
  let text = alone ? 'Click the robot to see its sensors.' : `Click a ${apart ? 'robot' : who}, or its number in the table, to follow it.`;
  if (followed >= 0) {
    const others = heardBy(followed, line).map((other) => names[other]).join(', ');
    const parts = [!apart && act(followed, line).name, hears && `hears ${others ? `robot ${others}` : 'nobody'}`].filter((part) => part);
    text = `${Who} ${names[followed]}${parts.length > 0 ? ': ' : ''}${parts.join('; ')}`;
  }
  set(element('robot'), 'textContent', text);
}

function show() {
  drawArena(time);
  const { line } = locate(time);
  showReadings(line);
  showTable(line);
  drawChart(time);
  showWords(line);
  showClock(time);
}

// For tests. `drawn` draws a time, and tells where robots were drawn, mm and turns, taken back from the canvas, and the colour of
// their side; `shown` tells where a robot is on the canvas now.
window.oneiro = {
  shown(robot) {
    const { x, y } = pose(robot, locate(time));
    return place(x, y);
  },
  drawn(when) {
    play(false);
    seek(when);
    show();
    const colours = sideColours();
    return { time, robots: put.robots.map((robot, i) => ({ ...robot, colour: colours[i] })) };
  },
};

element('messages').parentElement.hidden = !hears;
element('sensors').parentElement.hidden = sensors.length === 0;
element('trails').checked = alone || apart;
for (const id of ['trails', 'sensors', 'messages']) element(id).addEventListener('change', ask);
buildLegend();
buildChoice();
buildReadings();
buildTable();
spreadTime();
buildChart();
const isAt = begin();
if (!isAt && !calm.matches) play(true);
