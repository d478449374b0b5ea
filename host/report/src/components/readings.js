// A robot's readings: a bar and a number for each.
import { element, made, set } from './dom.js';

export class Readings {
  /** @param {import('./facts.js').Reading[]} readings */
  constructor(readings) {
    this.readings = readings;
    this.bars = readings.map(({ name, from, to }) => {
      const box = made('div', element('readings', HTMLElement));
      made('dt', box, { textContent: name, title: `${name}, ${from} to ${to}` });
      const cell = made('dd', box);
      return { bar: made('u', made('i', cell)), number: made('b', cell) };
    });
  }

  /** @param {string} title @param {((reading: number) => number) | null} value null: of no robot */
  show(title, value) {
    set(element('readings-title', HTMLElement), 'textContent', title);
    this.bars.forEach(({ bar, number }, index) => {
      const { from, to, whole } = this.readings[index];
      if (!value) {
        bar.style.width = '0';
        set(number, 'textContent', '');
        return;
      }
      /** @param {number} place */
      const share = (place) => (100 * (place - from)) / (to - from);
      const now = value(index);
      const [left, right] = [share(Math.min(now, 0)), share(Math.max(now, 0))];
      bar.style.left = `${left}%`;
      bar.style.width = `${right - left}%`;
      // No minus before a zero.
      set(number, 'textContent', (now + 0).toFixed(whole ? 0 : 3).replace(/^-(0\.0+)$/, '$1'));
    });
  }
}
