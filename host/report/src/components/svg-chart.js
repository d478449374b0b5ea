// Makes the charts of `figures/plot.rs` answer: a pointer or the arrow keys read values, a click on a line's name hides
// or shows it and gives its room to the others, a drag or a double click zooms, Escape shows the whole range again. Charts remain complete figures without it.
// Where a chart has several axes across, a click on a name exchanges those of all charts of the page.
// A page that replaces its charts calls `attach` again: hidden lines and zooms are kept by the figure's id or title.

/**
 * @typedef {[number, number]} Pair
 * @typedef {{ name: string, colour: string, lines: Pair[][], bands: { highs: Pair[], lows: Pair[] }[] }} Series
 * @typedef {{ hidden: Set<string>, zooms: Map<number, Pair>, fits: boolean }} Kept what a redrawn chart keeps; `fits`: the range is that
 *   of the shown lines
 * @typedef {{ reset: () => void, hide: () => void, choose: () => void, svg: SVGSVGElement }} Chart
 */

const SVG = 'http://www.w3.org/2000/svg';
/** Distance in pixels from which a press is a drag. */
const DRAG = 6;
/** The narrowest zoom, as a fraction of the whole range. */
const NARROWEST = 0.002;

const STYLE = `
[data-plot] { cursor: crosshair; outline-offset: 2px; }
text[role=button] { cursor: pointer; }
.chart-axis[aria-pressed=false] { text-decoration: underline; }
text[data-series][aria-pressed=false] { opacity: .6; text-decoration: line-through; }
.chart-values { position: fixed; z-index: 9; pointer-events: none; padding: 6px 10px; border-radius: 8px;
  width: max-content; max-width: 90vw;
  font: 13px/1.4 system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif; font-variant-numeric: tabular-nums;
  color: var(--ink); background: var(--paper); border: 1px solid var(--rule); box-shadow: 0 2px 8px #0003; }
.chart-values i { display: inline-block; width: .72em; height: .72em; border-radius: 50%; margin-right: .5em; }
@media print { .chart-values { display: none; } }`;

/** @type {Map<string, Kept>} */
const kept = new Map();
/** @type {Chart[]} */
let charts = [];
/** The chosen axis; empty for the first of each chart. */
let axis = '';
/** @type {HTMLElement | null} */
let box = null;

/** The box of values, made at its first use.
 * @returns {HTMLElement} */
function valuesBox() {
  if (!box) {
    const style = document.createElement('style');
    style.textContent = STYLE;
    document.head.append(style);
    box = document.createElement('div');
    box.className = 'chart-values';
    box.setAttribute('role', 'status');
    box.hidden = true;
    document.body.append(box);
    document.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') charts.forEach((chart) => chart.reset());
    });
    document.addEventListener('pointerdown', (event) => {
      charts.filter((chart) => !chart.svg.contains(/** @type {Node} */ (event.target))).forEach((chart) => chart.hide());
    });
  }
  return box;
}

/** @param {string | null} text @returns {number[]} */
const numbers = (text) => (text || '').split(/[ ,]+/).map(Number);

/** @param {Element} element @returns {Pair[]} */
function pointsOf(element) {
  const all = numbers(element.getAttribute('points'));
  return all.flatMap((x, i) => (i % 2 ? [] : [/** @type {Pair} */ ([x, all[i + 1]])]));
}

/** The line's height at a place, or nothing beside it.
 * @param {Pair[]} points by ascending x
 * @param {number} x
 * @returns {number | undefined} */
function heightAt(points, x) {
  const next = points.findIndex((point) => point[0] >= x - 0.01);
  if (next < 0) return undefined;
  const [right, high] = points[next];
  if (Math.abs(right - x) <= 0.01) return high;
  if (next === 0) return undefined;
  const [left, low] = points[next - 1];
  return low + ((high - low) * (x - left)) / (right - left);
}

/** A value with the decimals that a hundredth of a pixel has.
 * @param {number} value
 * @param {number} pixel values of one pixel
 * @returns {string} */
function words(value, pixel) {
  const digits = Math.floor(-Math.log10(0.02 * Math.abs(pixel) || 1));
  const unit = 10 ** -digits;
  const rounded = digits < 0 ? Math.round(value / unit) * unit : value;
  const fraction = Math.min(12, Math.max(0, digits));
  return (Number(rounded.toFixed(fraction)) || 0).toLocaleString('en-GB', { maximumFractionDigits: fraction });
}

/** @param {string} name @param {Record<string, string | number>} attributes @returns {SVGElement} */
function svgElement(name, attributes) {
  const made = document.createElementNS(SVG, name);
  Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, String(value)));
  return made;
}

/** The colour of a line, band or name.
 * @param {Element} own
 * @returns {string} */
const colourOf = (own) => own.getAttribute('stroke') || own.getAttribute('fill') || '';

/** One plot of a chart, with the means to show values and to zoom.
 * @param {SVGSVGElement} svg
 * @param {SVGGElement} group
 * @param {Kept} keep
 * @param {number} place its number in the chart */
function plotOf(svg, group, keep, place) {
  const [left, right, top, bottom] = numbers(group.getAttribute('data-plot'));
  const across = numbers(group.getAttribute('data-across'));
  const up = numbers(group.getAttribute('data-up'));
  const [acrossName, upName] = (group.getAttribute('data-names') || '|').split('|');
  /** @type {Map<string, Series>} */
  const all = new Map();
  const drawn = [...group.querySelectorAll('[data-series]:not(text)')];
  for (const own of drawn) {
    const colour = colourOf(own);
    // A dashed line is another series than the full one of its colour; a band has the colour alone.
    const dash = own.getAttribute('stroke-dasharray') || '';
    const named = own.getAttribute('data-series') || '';
    const key = `${colour} ${dash}`;
    const series = all.get(key) || { name: '', colour, lines: [], bands: [] };
    series.name ||= named;
    if (own.localName === 'circle') {
      series.lines.push([[Number(own.getAttribute('cx')), Number(own.getAttribute('cy'))]]);
    } else if (own.localName === 'polygon') {
      const points = pointsOf(own);
      const half = points.length / 2;
      series.bands.push({ highs: points.slice(0, half), lows: points.slice(half).reverse() });
    } else {
      series.lines.push(pointsOf(own));
    }
    all.set(key, series);
  }
  for (const [key, series] of all) {
    const sibling = svg.querySelector(`[data-series]:not([data-series=""])[fill="${series.colour}"]`);
    const full = key.endsWith(' ') ? '' : ' (dashed)';
    series.name ||= sibling ? sibling.getAttribute('data-series') + full : upName + (all.size > 1 ? full : '');
  }
  const moving = [...group.querySelectorAll('[data-x], [data-series]:not(text)')].map((own) => ({
    own,
    points: own.hasAttribute('points') ? pointsOf(own) : [],
    before: ['x', 'x1', 'x2', 'cx'].filter((name) => own.hasAttribute(name)).map((name) => [name, Number(own.getAttribute(name))]),
    width: own.hasAttribute('width') ? Number(own.getAttribute('width')) : null,
  }));
  const ticks = [...group.querySelectorAll('[data-tick]')];
  const whole = /** @type {Pair} */ ([left, right]);
  /** The shown stretch, in the figure's pixels. */
  let shown = whole;
  /** @type {number | null} */
  let cursor = null;
  const clip = svgElement('clipPath', { id: `plot-${place}-${Math.random().toString(36).slice(2)}` });
  // Above the plot a change has its names.
  clip.append(svgElement('rect', { x: left, y: top - 16, width: right - left, height: bottom - top + 18 }));
  const marks = svgElement('g', { 'pointer-events': 'none' });
  const zoomed = svgElement('g', {});
  group.append(clip, zoomed, marks);

  /** @param {number} x @returns {number} */
  const moved = (x) => left + ((x - shown[0]) / (shown[1] - shown[0])) * (right - left);
  /** @param {number} x @returns {number} */
  const original = (x) => shown[0] + ((x - left) / (right - left)) * (shown[1] - shown[0]);
  const perPixel = { x: (across[1] - across[0]) / (right - left), y: (up[1] - up[0]) / (bottom - top) };
  /** @param {number} x @returns {number} */
  const valueAcross = (x) => across[0] + (x - left) * perPixel.x;
  /** @param {number} y @returns {number} */
  const valueUp = (y) => up[0] + (bottom - y) * perPixel.y;
  const visible = () => [...all.values()].filter((series) => !keep.hidden.has(series.colour));

  function drawTicks() {
    const isWhole = shown === whole;
    ticks.forEach((tick) => tick.setAttribute('display', isWhole ? 'inline' : 'none'));
    zoomed.replaceChildren();
    const [line, text] = ['line', 'text'].map((name) => ticks.find((tick) => tick.localName === name));
    if (isWhole || !line || !text) return;
    const [low, high] = shown.map(valueAcross);
    const power = 10 ** Math.floor(Math.log10((high - low) / 6));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((own) => own >= (high - low) / 6) || power;
    for (let i = Math.ceil(low / step); i * step <= high; i += 1) {
      const x = moved(left + (i * step - across[0]) / perPixel.x);
      const [tick, name] = [line, text].map((own) => /** @type {Element} */ (own.cloneNode(true)));
      ['x1', 'x2'].forEach((end) => tick.setAttribute(end, String(x)));
      name.setAttribute('x', String(x));
      name.textContent = words(i * step, step * 10);
      [tick, name].forEach((own) => own.removeAttribute('display'));
      zoomed.append(tick, name);
    }
    const note = svgElement('text', { x: right, y: top - 6, 'font-size': 11, 'text-anchor': 'end', fill: '#6b6e76' });
    note.textContent = 'Esc: the whole range';
    zoomed.append(note);
  }

  /** Shows the range of the visible lines. */
  function fit() {
    const xs = visible().flatMap((series) => series.lines.flat().map(([x]) => x));
    const [low, high] = [Math.min(...xs), Math.max(...xs)];
    zoom(xs.length && (low > left + 1 || high < right - 1) ? [low, high] : undefined);
  }

  /** @param {Pair | undefined} stretch in the figure's pixels; none for all */
  function zoom(stretch) {
    shown = whole;
    if (stretch) {
      const [low, high] = [Math.max(left, Math.min(...stretch)), Math.min(right, Math.max(...stretch))];
      if (high - low >= NARROWEST * (right - left)) shown = [low, high];
    }
    if (shown === whole) keep.zooms.delete(place);
    else keep.zooms.set(place, shown);
    for (const { own, points, before, width } of moving) {
      if (shown === whole) own.removeAttribute('clip-path');
      else own.setAttribute('clip-path', `url(#${clip.id})`);
      if (points.length) own.setAttribute('points', points.map(([x, y]) => `${moved(x)},${y}`).join(' '));
      before.forEach(([name, x]) => own.setAttribute(String(name), String(moved(Number(x)))));
      if (width !== null) own.setAttribute('width', String((width * (right - left)) / (shown[1] - shown[0])));
    }
    drawTicks();
    hide();
  }

  function hide() {
    cursor = null;
    marks.replaceChildren();
    valuesBox().hidden = true;
  }

  /** Places across at which visible lines have a value, in the figure's pixels.
   * @returns {number[]} */
  const places = () => {
    const xs = visible().flatMap((series) => series.lines.flat().map(([x]) => x));
    return [...new Set(xs)].filter((x) => x >= shown[0] - 0.01 && x <= shown[1] + 0.01).sort((a, b) => a - b);
  };

  /** Shows the values at the nearest place.
   * @param {number} near in the figure's pixels */
  function show(near) {
    const xs = places();
    if (!xs.length) return hide();
    const at = xs.reduce((best, x) => (Math.abs(x - near) < Math.abs(best - near) ? x : best));
    cursor = at;
    const x = moved(at);
    const upright = { x1: x, x2: x, y1: top, y2: bottom, stroke: '#33363f', 'stroke-dasharray': '3 3' };
    marks.replaceChildren(svgElement('line', upright));
    const head = document.createElement('b');
    head.textContent = `${acrossName} ${words(valueAcross(at), perPixel.x)}`;
    const rows = [head];
    for (const { name, colour, lines, bands } of visible()) {
      const y = lines.map((line) => heightAt(line, at)).find((height) => height !== undefined);
      if (y === undefined) continue;
      const mark = svgElement('circle', { cx: x, cy: y, r: 3.5, fill: colour, stroke: '#ffffff', 'stroke-width': 1.5 });
      marks.append(mark);
      const row = document.createElement('div');
      const dot = document.createElement('i');
      dot.style.background = getComputedStyle(mark).fill;
      let text = `${name}: ${words(valueUp(y), perPixel.y)}`;
      for (const { highs, lows } of bands) {
        const [low, high] = [heightAt(lows, at), heightAt(highs, at)];
        if (low !== undefined && high !== undefined) {
          text += ` (${words(valueUp(low), perPixel.y)} to ${words(valueUp(high), perPixel.y)})`;
          break;
        }
      }
      row.append(dot, text);
      rows.push(row);
    }
    const values = valuesBox();
    values.replaceChildren(...rows);
    values.hidden = false;
    const matrix = svg.getScreenCTM();
    if (!matrix) return undefined;
    const corner = new DOMPoint(x, top).matrixTransform(matrix);
    const { width, height } = values.getBoundingClientRect();
    // Beside the line, on the side that has room.
    const beside = corner.x + 14 + width > innerWidth ? corner.x - 14 - width : corner.x + 14;
    values.style.left = `${Math.max(4, Math.min(beside, innerWidth - width - 4))}px`;
    values.style.top = `${Math.max(4, Math.min(corner.y, innerHeight - height - 4))}px`;
    return undefined;
  }

  group.setAttribute('tabindex', '0');
  group.setAttribute('role', 'group');
  group.setAttribute('aria-label', `${upName} by ${acrossName}: arrow keys read values`);
  group.addEventListener('keydown', (event) => {
    const xs = places();
    const now = xs.findIndex((x) => cursor !== null && x >= cursor);
    const steps = { ArrowLeft: now - 1, ArrowRight: now + 1, Home: 0, End: xs.length - 1 };
    if (event.target !== group || !(event.key in steps)) return;
    event.preventDefault();
    const step = steps[/** @type {keyof typeof steps} */ (event.key)];
    show(xs[Math.max(0, Math.min(xs.length - 1, step))]);
  });
  group.addEventListener('blur', hide);
  const before = keep.zooms.get(place);
  if (keep.fits) fit();
  else if (before) zoom(before);
  const isShown = () => !group.closest('[display=none]');
  return { left, right, top, bottom, marks, show, hide, zoom, fit, original, isShown };
}

/** @param {SVGSVGElement} svg */
function enliven(svg) {
  const id = svg.closest('[id]')?.id || svg.querySelector('title')?.textContent || '';
  /** @type {Kept} */
  const keep = kept.get(id) || { hidden: new Set(), zooms: new Map(), fits: false };
  kept.set(id, keep);
  const groups = /** @type {SVGGElement[]} */ ([...svg.querySelectorAll('g[data-plot]')]);
  const plots = groups.map((group, place) => plotOf(svg, group, keep, place));
  // A figure of which parts can be focused is no longer one image.
  svg.setAttribute('role', 'group');

  /** @param {MouseEvent} event @returns {DOMPoint} */
  const place = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM()?.inverse());
  /** @param {DOMPoint} at */
  const under = (at) => plots.find((own) => (
    own.isShown() && at.x >= own.left - 4 && at.x <= own.right + 4 && at.y >= own.top - 12 && at.y <= own.bottom + 26));
  /** @type {{ plot: (typeof plots)[0], from: number } | null} */
  let drag = null;

  svg.addEventListener('pointermove', (event) => {
    const at = place(event);
    if (drag && Math.abs(at.x - drag.from) > DRAG) {
      const { plot } = drag;
      const [low, high] = [drag.from, at.x].sort((a, b) => a - b).map((x) => Math.min(plot.right, Math.max(plot.left, x)));
      plot.hide();
      const size = { x: low, y: plot.top, width: high - low, height: plot.bottom - plot.top };
      plot.marks.append(svgElement('rect', { ...size, fill: 'currentColor', 'fill-opacity': 0.12 }));
      return;
    }
    const plot = under(at);
    plots.filter((own) => own !== plot).forEach((own) => own.hide());
    plot?.show(plot.original(at.x));
  });
  svg.addEventListener('pointerdown', (event) => {
    const at = place(event);
    const plot = under(at);
    // A finger scrolls the page.
    if (event.pointerType === 'touch') plot?.show(plot.original(at.x));
    else if (plot && event.button === 0) {
      drag = { plot, from: at.x };
      svg.style.userSelect = 'none';
      svg.setPointerCapture(event.pointerId);
    }
  });
  svg.addEventListener('pointerup', (event) => {
    if (!drag) return;
    const { plot, from } = drag;
    drag = null;
    svg.style.userSelect = '';
    const to = place(event).x;
    if (Math.abs(to - from) <= DRAG) return;
    keep.fits = false;
    plot.zoom([plot.original(from), plot.original(to)]);
  });
  svg.addEventListener('pointercancel', () => (drag = null));
  svg.addEventListener('dblclick', (event) => {
    const at = place(event);
    const plot = under(at);
    if (!plot) return;
    const quarter = (plot.original(plot.right) - plot.original(plot.left)) / 4;
    const middle = plot.original(at.x);
    keep.fits = false;
    plot.zoom([middle - quarter, middle + quarter]);
  });
  const hide = () => plots.forEach((plot) => plot.hide());
  svg.addEventListener('pointerleave', (event) => {
    if (event.pointerType !== 'touch') hide();
  });

  const names = [...svg.querySelectorAll('[data-plot] text[data-series]')];
  const drawn = [...svg.querySelectorAll('[data-plot] [data-series]:not(text)')];
  const draw = () => {
    drawn.forEach((own) => own.setAttribute('display', keep.hidden.has(colourOf(own)) ? 'none' : 'inline'));
    names.forEach((own) => own.setAttribute('aria-pressed', String(!keep.hidden.has(colourOf(own)))));
  };
  for (const name of names) {
    const colour = colourOf(name);
    press(name, () => {
      if (!keep.hidden.delete(colour)) keep.hidden.add(colour);
      draw();
      keep.fits = true;
      plots.forEach((plot) => plot.fit());
    });
  }
  draw();
  const reset = () => {
    keep.fits = false;
    plots.forEach((plot) => plot.zoom(undefined));
  };
  const choose = choices(svg, plots[0].right);
  choose();
  charts.push({ svg, hide, choose, reset });
}

/** Makes an element a button.
 * @param {Element} own
 * @param {() => void} toggle */
function press(own, toggle) {
  own.setAttribute('tabindex', '0');
  own.setAttribute('role', 'button');
  own.addEventListener('click', toggle);
  own.addEventListener('keydown', (event) => {
    if (event instanceof KeyboardEvent && (event.key === 'Enter' || event.key === ' ')) {
      event.preventDefault();
      toggle();
    }
  });
}

/** Names of a chart's axes across, above its plot, if there are several. Returns what shows the chosen one.
 * @param {SVGSVGElement} svg
 * @param {number} right
 * @returns {() => void} */
function choices(svg, right) {
  const groups = [...svg.querySelectorAll('[data-choice]')];
  let end = right;
  const names = [...groups].reverse().map((group) => {
    const name = svgElement('text', { x: end, y: 24, 'font-size': 13, 'text-anchor': 'end', fill: '#33363f', class: 'chart-axis' });
    name.textContent = group.getAttribute('data-choice');
    press(name, () => {
      axis = name.textContent || '';
      charts.forEach((chart) => [chart.hide, chart.choose].forEach((change) => change()));
    });
    svg.append(name);
    end -= /** @type {SVGTextElement} */ (name).getComputedTextLength() + 18;
    return name;
  });
  return () => {
    const chosen = groups.find((group) => group.getAttribute('data-choice') === axis) || groups[0];
    groups.forEach((group) => group.setAttribute('display', group === chosen ? 'inline' : 'none'));
    names.forEach((name) => name.setAttribute('aria-pressed', String(name.textContent === chosen.getAttribute('data-choice'))));
  };
}

/** Makes all charts below an element answer; those that do already are left alone.
 * @param {ParentNode} [root] */
export function attach(root = document) {
  charts = charts.filter((chart) => chart.svg.isConnected);
  for (const svg of root.querySelectorAll('svg')) {
    if (svg.querySelector('g[data-plot]') && !charts.some((chart) => chart.svg === svg)) {
      valuesBox();
      enliven(svg);
    }
  }
}
