// A chart over time: its levels, its times, a cursor at the time that is shown, and the value below the pointer.
import { FONT, Theme } from './colours.js';
import { element } from './dom.js';

/**
 * 1, 2 or 5 times a power of ten, so that about so many parts make up the whole.
 * @param {number} whole @param {number} parts
 */
export function rounded(whole, parts) {
  const wanted = Math.max(whole / parts, 1e-3);
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= wanted - 1e-9) || 10 * power;
}

/**
 * A number for readers.
 * @param {number} value
 */
export const shortened = (value) => Number(value.toPrecision(6)).toLocaleString('en', { maximumFractionDigits: 6 });

export class Chart {
  /**
   * @param {Theme} theme
   * @param {import('./player.js').Player} player
   * @param {(seconds: number) => string} told the value at a time in words
   */
  constructor(theme, player, told) {
    this.theme = theme;
    this.told = told;
    this.canvas = element('chart', HTMLCanvasElement);
    this.pen = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext('2d'));
    this.view = { wide: 0, high: 0, left: 34, right: 8, top: 20, bottom: 34, whole: 1, low: 0, most: 1, step: 1, ratio: 1 };
    /**
     * Where the pointer is, in seconds.
     * @type {number | null}
     */
    this.hover = null;
    this.listen(player);
  }

  /** @param {import('./player.js').Player} player */
  listen(player) {
    const { canvas } = this;
    /** @param {PointerEvent} event */
    const move = (event) => {
      const { wide, left, right, whole } = this.view;
      const share = (event.clientX - canvas.getBoundingClientRect().left - left) / (wide - left - right);
      this.hover = Math.min(Math.max(share, 0), 1) * whole;
      if (event.buttons > 0) player.seek(this.hover);
      player.ask();
    };
    canvas.addEventListener('pointermove', move);
    canvas.addEventListener('pointerdown', move);
    canvas.addEventListener('pointerleave', () => {
      this.hover = null;
      player.ask();
    });
  }

  /** Fits the chart into the page. */
  fit() {
    const { canvas, view } = this;
    const room = element('chart-room', HTMLElement);
    view.wide = Math.max(room.clientWidth, 120);
    view.ratio = devicePixelRatio || 1;
    // What is left below the table, where that stands beside the arena.
    const left = innerHeight - room.getBoundingClientRect().top - scrollY - element('dock', HTMLElement).offsetHeight - 24;
    view.high = matchMedia('(min-width: 900px)').matches ? Math.round(Math.min(Math.max(left, 150), 300)) : 190;
    canvas.width = Math.round(view.wide * view.ratio);
    canvas.height = Math.round(view.high * view.ratio);
    canvas.style.height = `${view.high}px`;
  }

  /**
   * Shows times up to `whole`, and values from 0 or `low` to `high` or a little more.
   * @param {number} whole
   * @param {number} low
   * @param {number} high
   */
  span(whole, low, high) {
    const { view } = this;
    view.whole = Math.max(whole, 0.1);
    view.step = rounded(high - low || 1, 4);
    view.low = Math.floor(low / view.step) * view.step;
    view.most = Math.ceil((high > low ? high : low + 1) / view.step) * view.step;
  }

  /** @param {number} seconds */
  x(seconds) {
    const { wide, left, right, whole } = this.view;
    return left + (seconds / whole) * (wide - left - right);
  }

  get base() {
    return this.view.high - this.view.bottom;
  }

  /** @param {number} value */
  y(value) {
    const { top, low, most } = this.view;
    return this.base - ((value - low) / (most - low)) * (this.base - top);
  }

  /** Clears the chart, and draws its levels and times. */
  ground() {
    const { pen, view: { wide, high, left, right, low, most, step, whole, ratio }, theme: { colours } } = this;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, wide, high);
    pen.font = `11px ${FONT}`;
    pen.textBaseline = 'middle';
    pen.textAlign = 'right';
    pen.lineWidth = 1;
    pen.strokeStyle = colours.rule;
    pen.fillStyle = colours.soft;
    for (let value = low; value <= most + 1e-9 * step; value += step) {
      const height = Math.round(this.y(value)) + 0.5;
      pen.beginPath();
      pen.moveTo(left, height);
      pen.lineTo(wide - right, height);
      pen.stroke();
      const label = Math.abs(value) < 1e6 ? Number(value.toPrecision(6)) : value.toExponential(1).replace('+', '');
      pen.fillText(String(label), left - 6, height);
    }
    const unit = whole >= 600 ? 60 : 1;
    const tick = rounded(whole / unit, 7) * unit;
    for (let seconds = 0; seconds <= whole + 1e-9; seconds += tick) {
      // The outermost stay within the chart.
      pen.textAlign = seconds > 0.97 * whole ? 'right' : 'center';
      const aside = pen.textAlign === 'right' ? right - 2 : 0;
      pen.fillText(String(Number((seconds / unit).toFixed(6))), this.x(seconds) + aside, this.base + 11);
    }
    pen.textAlign = 'center';
    pen.fillText(unit === 60 ? 'minutes' : 'seconds', (left + wide - right) / 2, this.base + 26);
  }

  /**
   * @param {import('./record.js').PoseRecord} record
   * @param {number} to the last line
   * @param {(line: number) => number | null} value null: no curve
   * @param {string} colour
   * @param {number} width
   */
  curve(record, to, value, colour, width) {
    const { pen } = this;
    pen.beginPath();
    for (let line = 0; line <= to; line++) {
      const height = value(line);
      if (height === null) return;
      pen.lineTo(this.x(record.timeOf(line)), this.y(height));
    }
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineJoin = 'round';
    pen.stroke();
  }

  /**
   * A line from top to bottom.
   * @param {number} x @param {string} colour @param {number} width
   */
  upright(x, colour, width) {
    const { pen } = this;
    pen.beginPath();
    pen.moveTo(x, this.view.top - 4);
    pen.lineTo(x, this.base);
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.stroke();
  }

  /**
   * Draws the cursor at a time, and the value below the pointer.
   * @param {number} when
   */
  cursor(when) {
    const { pen, hover, view: { top, wide }, theme: { colours } } = this;
    const x = this.x(when);
    this.upright(x, colours.ink, 1.6);
    pen.fillStyle = colours.ink;
    pen.beginPath();
    pen.moveTo(x - 4, top - 8);
    pen.lineTo(x + 4, top - 8);
    pen.lineTo(x, top - 2);
    pen.fill();
    if (hover === null) return;
    this.upright(this.x(hover), colours.soft, 1);
    const text = this.told(hover);
    pen.font = `600 12px ${FONT}`;
    const width = pen.measureText(text).width + 12;
    const left = Math.min(Math.max(this.x(hover) - width / 2, 0), wide - width);
    pen.fillStyle = colours.ink;
    pen.fillRect(left, 0, width, 18);
    pen.fillStyle = colours.page;
    pen.textAlign = 'left';
    pen.fillText(text, left + 6, 9.5);
  }
}
