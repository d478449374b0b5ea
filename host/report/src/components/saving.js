// The arena as a picture, as a drawing and as a film.
import { element, say } from './dom.js';

/** @param {Blob} content @param {string} ending of the file's name, which begins with the page's title */
function save(content, ending) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(content);
  link.download = `${document.title.replace(/[^\p{L}\p{N}]+/gu, '-').replace(/^-|-$/g, '') || 'oneiro'}${ending}`;
  link.click();
  // Browsers read it after the click.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** Films the episode from its beginning to its end at the player's speed. */
class Film {
  /** @param {HTMLCanvasElement} canvas @param {import('./player.js').Player} player @param {() => void} ended */
  constructor(canvas, player, ended) {
    this.player = player;
    this.recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: 'video/webm', videoBitsPerSecond: 6e6 });
    /** @type {Blob[]} */
    const parts = [];
    this.recorder.addEventListener('dataavailable', ({ data }) => parts.push(data));
    this.recorder.addEventListener('stop', () => {
      save(new Blob(parts, { type: 'video/webm' }), '.webm');
      ended();
    });
    player.play(false);
    player.seek(player.record.first);
    this.recorder.start();
    player.play(true);
    this.look();
  }

  /** Stops the film when the player stops. */
  look() {
    if (this.recorder.state !== 'recording') return;
    // The last frame is seen for a moment.
    if (!this.player.playing) setTimeout(() => this.stop(), 500);
    else setTimeout(() => this.look(), 100);
  }

  stop() {
    if (this.recorder.state === 'recording') this.recorder.stop();
    this.player.play(false);
  }
}

/** Films are offered where the browser makes them. */
const canFilm = () => 'captureStream' in HTMLCanvasElement.prototype && 'MediaRecorder' in window
  && MediaRecorder.isTypeSupported('video/webm');

/** @param {import('./arena.js').Arena} arena @param {import('./player.js').Player} player */
export function listenToSaving(arena, player) {
  const { canvas } = arena;
  const moment = () => `-${player.time.toFixed(1)}-s`;
  element('save-picture', HTMLButtonElement).addEventListener('click', () => {
    canvas.toBlob((picture) => picture && save(picture, `${moment()}.png`));
  });
  element('save-drawing', HTMLButtonElement).addEventListener('click', () => {
    save(new Blob([arena.svg(() => player.show())], { type: 'image/svg+xml' }), `${moment()}.svg`);
  });
  const button = element('save-film', HTMLButtonElement);
  button.hidden = !canFilm();
  /** @type {Film | null} */
  let film = null;
  button.addEventListener('click', () => {
    if (film) {
      film.stop();
      return;
    }
    film = new Film(canvas, player, () => {
      film = null;
      button.textContent = 'Save film';
      say('The film is saved.');
    });
    button.textContent = 'Stop film';
    say('The film is recorded while the episode plays.');
  });
}
