// Shows an archive of elites and plays a life of the one that is chosen. Its data are in the element `elites`: rows of a table, and the
// poses of all lives, one after the other, as Base64 of little-endian 16-bit integers: x and y as shares of the arena, and the
// heading in 1/65536 turn. A fragment such as #cell=1275 opens the page with that cell's elite.
(() => {
  'use strict';

  const SECONDS = 4;
  const PATH = '#8a3fa0';
  const element = (id) => document.getElementById(id);
  const data = JSON.parse(element('elites').textContent);
  const bytes = Uint8Array.from(atob(data.poses), (c) => c.charCodeAt(0));
  const poses = new Uint16Array(bytes.buffer);
  // Where each life's poses begin.
  const first = [0];
  for (const length of data.lengths) first.push(first[first.length - 1] + length);
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  const squares = [...document.querySelectorAll('[data-elite]')];
  let chosen = -1;
  let began = 0;

  // A pose of the chosen life in pixels, and its heading in degrees, clockwise.
  function pose(index) {
    const at = 3 * (first[chosen] + index);
    const [left, top, width, height] = data.place;
    const x = left + (poses[at] / 65535) * width;
    const y = top + (poses[at + 1] / 65535) * height;
    return [x, y, (-360 * poses[at + 2]) / 65536];
  }

  // Draws the path up to a pose, and the robot there.
  function draw(index) {
    const points = [];
    for (let i = 0; i <= index; i++) points.push(pose(i).slice(0, 2).map((own) => own.toFixed(1)).join(','));
    const [x, y, turn] = pose(index);
    element('robots').innerHTML =
      `<polyline points="${points.join(' ')}" fill="none" stroke="${PATH}" stroke-width="2"/>` +
      `<g transform="translate(${x} ${y}) rotate(${turn})" stroke="${PATH}" stroke-width="2">` +
      `<circle r="${data.radius}" fill="${PATH}" fill-opacity="0.2"/><line x2="${data.radius}"/></g>`;
    element('clock').textContent = `${(index * data.every * 0.1).toFixed(1)} s`;
  }

  function frame(now) {
    const last = data.lengths[chosen] - 1;
    if (chosen < 0 || last < 0) return;
    const share = calm.matches ? 1 : Math.min((now - began) / 1000 / SECONDS, 1);
    draw(Math.floor(share * last));
    if (share < 1) requestAnimationFrame(frame);
  }

  function play() {
    began = performance.now();
    requestAnimationFrame(frame);
  }

  function choose(index) {
    const rows = element('table').tBodies[0].rows;
    if (chosen >= 0) rows[chosen].classList.remove('chosen');
    chosen = index;
    rows[index].classList.add('chosen');
    for (const square of squares) square.classList.toggle('chosen', Number(square.dataset.elite) === index);
    const row = data.elites[index];
    element('which').textContent = row[0];
    element('said').textContent = data.columns.map((name, i) => `${name} ${row[i]}`).join(', ');
    element('robots').innerHTML = '';
    if (data.lengths[index] === 0) element('clock').textContent = 'the episode ended before its first cycle';
    play();
  }

  const cell = (kind, text) => {
    const own = document.createElement(kind);
    own.textContent = text;
    own.className = 'number';
    return own;
  };
  const head = element('table').createTHead().insertRow();
  for (const name of data.columns) head.append(cell('th', name));
  const body = element('table').createTBody();
  data.elites.forEach((values, index) => {
    const row = body.insertRow();
    values.forEach((value, i) => row.append(cell('td', i === 0 ? '' : value)));
    // Rows can be reached by the keyboard.
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = values[0];
    row.cells[0].append(button);
    row.addEventListener('click', () => choose(index));
  });
  for (const square of squares) square.addEventListener('click', () => choose(Number(square.dataset.elite)));
  element('play').addEventListener('click', () => chosen >= 0 && play());
  const asked = new URLSearchParams(location.hash.slice(1)).get('cell');
  const opened = data.elites.findIndex((row) => row[0] === asked);
  if (opened >= 0) choose(opened);
})();
