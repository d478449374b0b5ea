// Who hears whom.

/** @typedef {import('./record.js').Pose | null} Known */

/**
 * Draws a line for each message, from the robot that heard it to its sender.
 * @param {import('./arena.js').Arena} arena
 * @param {[Known, Known][]} pairs
 * @param {number} alpha
 * @param {number} width
 */
export function drawMessages(arena, pairs, alpha, width) {
  const { pen } = arena;
  pen.lineCap = 'round';
  pen.globalAlpha = alpha;
  pen.beginPath();
  for (const [hearer, sender] of pairs) {
    if (!hearer || !sender) continue;
    pen.moveTo(...arena.place(hearer.x, hearer.y));
    pen.lineTo(...arena.place(sender.x, sender.y));
  }
  arena.stroke(arena.marks.message, width);
  pen.globalAlpha = 1;
}

/** Its picture in the legend. */
export const MESSAGE_PICTURE = '<path d="M-8 4L8 -4" stroke="var(--message)" stroke-width="2.4" stroke-linecap="round"/>';
