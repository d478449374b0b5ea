// What all pages have: an arena, a player below it, and a chart beside it, which are drawn together.
import { Arena } from './arena.js';
import { Chart } from './chart.js';
import { Theme } from './colours.js';
import { element } from './dom.js';
import { Player } from './player.js';
import { listenToRobots } from './robots.js';
import { listenToSaving } from './saving.js';

export class Stage {
  /**
   * @param {import('./record.js').PoseRecord} record
   * @param {number} body radius of robots in mm
   * @param {object} page
   * @param {() => void} page.fit fits the arena into the page
   * @param {() => void} page.show draws everything as it is now
   * @param {(seconds: number) => string} page.told the chart's value at a time in words
   * @param {string} [page.who]
   * @param {number} [page.followed]
   * @param {number} [page.speed]
   */
  constructor(record, body, { fit, told, ...settings }) {
    // In a frame, the page around it says what this is.
    document.body.classList.toggle('embedded', window.parent !== window);
    this.theme = new Theme(() => this.player.show());
    this.arena = new Arena(this.theme);
    this.player = new Player(record, settings);
    this.chart = new Chart(this.theme, this.player, told);
    this.fit = () => {
      // A canvas of a new size is empty: it is drawn at once, so that nothing flickers.
      fit();
      this.chart.fit();
      this.player.show();
    };
    listenToRobots(this.arena, this.player, body);
    listenToSaving(this.arena, this.player);
  }

  /**
   * Once the page has all that it shows.
   * @param {boolean} [plays]
   */
  begin(plays = true) {
    this.fit();
    new ResizeObserver(this.fit).observe(element('room', HTMLElement));
    addEventListener('resize', this.fit);
    this.player.begin(plays);
  }

  /**
   * Shows a time and stops there, for tests.
   * @param {number} when
   */
  stop(when) {
    this.player.play(false);
    this.player.seek(when);
    this.player.show();
    return { time: this.player.time, robots: this.arena.drawn() };
  }
}
