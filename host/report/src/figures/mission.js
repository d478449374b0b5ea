// Plays a life of robots that live together: what player.js leaves to it. What each array holds stands in mission.rs.

const MESSAGE = '#8a3fa0';
const PLAIN = { name: '', colour: '#2a9d8f', marks: ['#ffffff', '#ffffff'] };

const { acts, arena, readings } = data;
unpackPoses({});
const states = new Uint16Array(bytes(data.state));
const values = new Uint16Array(bytes(data.values));
const senders = new Uint16Array(bytes(data.senders));
const fitness = new Float32Array(bytes(data.fitness));
const earned = new Float32Array(bytes(data.earned));
const hears = senders.length > 0;
const scoresEach = earned.length > 0;
const everyone = names.map((_, robot) => robot);
time = first;
followed = 0;

const act = (robot, line) => acts[states[line * robots + robot]] || PLAIN;
const number = (value) => Number(value.toPrecision(6)).toLocaleString('en', { maximumFractionDigits: 6 });

function reading(robot, line, index) {
  const { low, high } = readings[index];
  return low + ((high - low) * values[(line * robots + robot) * readings.length + index]) / 65535;
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
    drawTrails(where, TRAIL, everyone, INK, Math.max(1.4, 5 * view.scale), 0.4);
    if (followed >= 0) drawTrails(where, LONG_TRAIL, [followed], FOLLOWED, 2.4, 0.8);
  }
  if (hears && element('messages').checked) drawMessages(where.line, poses);
  for (const robot of everyone) drawBody(robot, poses[robot], act(robot, where.line));
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
  set(element('readings-title'), 'textContent', followed < 0 ? 'Readings: click a robot' : `Robot ${names[followed]} reads`);
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
    set(value, 'textContent', (own + 0).toFixed(3).replace(/^-(0\.0+)$/, '$1'));
  });
}

function buildTable() {
  const table = element('robots');
  if (acts.length === 0 && !hears && !scoresEach) table.className = 'bare';
  const head = made('tr', made('thead', table));
  made('th', head, { textContent: 'Robot', scope: 'col' });
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

function buildChart() {
  const [low, high] = [Math.min, Math.max].map((of) => fitness.reduce((most, own) => of(most, own), 0));
  chartView.step = rounded(high - low || 1, 4);
  chartView.low = Math.floor(low / chartView.step) * chartView.step;
  chartView.most = Math.ceil((high > low ? high : low + 1) / chartView.step) * chartView.step;
  chartView.whole = Math.max(last, 0.1);
  chartView.left = 56;
  chart.setAttribute('aria-label', `Fitness over time, ${number(fitness[0])} to ${number(fitness[lines - 1])}`);
}

function drawChart(when) {
  drawLevels(chartView.step);
  drawTimes();
  const curve = (to, colour, width) => {
    chartPen.beginPath();
    for (let line = 0; line <= to; line++) chartPen.lineTo(chartX(timeOf(line)), chartY(fitness[line]));
    chartPen.strokeStyle = colour;
    chartPen.lineWidth = width;
    chartPen.lineJoin = 'round';
    chartPen.stroke();
  };
  curve(lines - 1, '#c9ccd3', 1.5);
  curve(locate(when).line, FOLLOWED, 2.2);
  drawNow(when);
}

function buildLegend() {
  for (const { name, colour } of acts) {
    legendEntry(`<circle r="7.5" fill="${colour}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="#ffffff"/>`, name);
  }
  if (hears) legendEntry(`<path d="M-8 4L8 -4" stroke="${MESSAGE}" stroke-width="2.4" stroke-linecap="round"/>`, 'heard in this line');
  if (arena.lamps.length > 0) legendEntry('<circle r="5" fill="#f2b01e" stroke="#a87400"/>', 'lamp');
}

function showWords(line) {
  set(element('light'), 'textContent', `Fitness if the life ended now: ${number(fitness[line])}`);
  let text = 'Click a robot, or its number in the table, to follow it.';
  if (followed >= 0) {
    const others = heardBy(followed, line).map((other) => names[other]).join(', ');
    const parts = [act(followed, line).name, hears && `hears ${others || 'nobody'}`].filter((part) => part);
    text = `Robot ${names[followed]}${parts.length > 0 ? ': ' : ''}${parts.join('; ')}`;
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
for (const id of ['trails', 'messages']) element(id).addEventListener('change', ask);
buildLegend();
buildReadings();
buildTable();
spreadTime();
buildChart();
const isAt = begin();
if (!isAt && !calm.matches) play(true);
