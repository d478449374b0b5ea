// Buttons of robots, in a table's rows.
import { made, set, setAttribute } from './dom.js';

/** @typedef {{ row: HTMLTableRowElement, button: HTMLButtonElement, dot: HTMLSpanElement }} RobotRow */

/**
 * Appends a row for a robot, whose button follows it or lets go of it.
 * @param {HTMLTableSectionElement} body
 * @param {import('./player.js').Player} player
 * @param {number} robot
 * @returns {RobotRow}
 */
export function robotRow(body, player, robot) {
  const { who, record: { names } } = player;
  const row = made('tr', body);
  const button = made('button', made('th', row, { scope: 'row' }), { type: 'button', className: 'who' });
  const dot = made('span', button, { className: 'dot' });
  button.append(String(names[robot]));
  button.title = `follow ${who} ${names[robot]}`;
  button.setAttribute('aria-label', `Follow ${who} ${names[robot]}`);
  button.addEventListener('click', (event) => {
    player.toggle(robot);
    // After a click the space bar is for playing again; who uses the keyboard stays where they are.
    if (event.detail > 0) button.blur();
  });
  return { row, button, dot };
}

/**
 * @param {RobotRow} own
 * @param {boolean} followed
 * @param {import('./facts.js').Act} act
 * @param {string} [ring] the colour of a ring around its dot
 */
export function showRow({ row, button, dot }, followed, { colour, front }, ring = '') {
  set(row, 'className', followed ? 'followed' : '');
  setAttribute(button, 'aria-pressed', String(followed));
  if (dot.dataset.look === colour + ring) return;
  dot.dataset.look = colour + ring;
  dot.style.background = colour;
  dot.style.borderColor = front || 'var(--edge)';
  dot.style.boxShadow = ring && `0 0 0 1.5px var(--page), 0 0 0 4px ${ring}`;
}

/**
 * The table's body below a head with these columns.
 * @param {HTMLTableElement} table
 * @param {{ text: string, className?: string, title?: string }[]} columns
 */
export function tableOf(table, columns) {
  const head = made('tr', made('thead', table));
  const cells = columns.map(({ text: textContent, className = '', title = '' }) =>
    made('th', head, { textContent, scope: 'col', className, title }));
  return { body: made('tbody', table), cells };
}
