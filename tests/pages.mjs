// pages.mjs PAGE..: opens pages, files and those of a server, in Chromium and Firefox, see pages.sh. Says what is wrong, and ends with 1 then.
import { existsSync, readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename, dirname, resolve } from 'node:path';
import puppeteer from 'puppeteer-core';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const SIZES = [[360, 740], [1024, 600], [1440, 900]];
/** Bytes of a page, seconds to its first frame, and frames of a second. */
const LARGEST = 5e6;
const SOON = 0.5;
const SMOOTH = 55;
const BROWSERS = {
  chrome: { executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu', '--disable-background-networking'] },
  firefox: { executablePath: '/usr/bin/firefox-esr' },
};
const pages = process.argv.slice(2);
const wrong = [];

/** How soon an episode's page is drawn, and how many frames it has in a second while it plays. */
async function measured(page) {
  return page.evaluate(async () => {
    const play = document.getElementById('play');
    if (play && play.textContent === 'Play') play.click();
    let frames = 0;
    const begin = performance.now();
    await new Promise((then) => {
      const step = () => {
        frames += 1;
        if (performance.now() - begin < 3000) requestAnimationFrame(step);
        else then();
      };
      requestAnimationFrame(step);
    });
    const soon = performance.getEntriesByName('first-contentful-paint')[0];
    return { first: soon ? soon.startTime / 1000 : null, frames: (1000 * frames) / (performance.now() - begin) };
  });
}

for (const [browser, settings] of Object.entries(BROWSERS)) {
  const running = await puppeteer.launch({ browser, headless: true, ...settings });
  for (const path of pages) {
    const isServed = path.startsWith('http:');
    const name = isServed ? 'served' : `${basename(dirname(path))}-${basename(path, '.html')}`;
    const page = await running.newPage();
    const say = (problem) => wrong.push(`${browser} ${name}: ${problem}`);
    page.on('console', (message) => say(`console: ${message.text()}`));
    page.on('pageerror', (error) => say(`error: ${error.message}`));
    await page.goto(isServed ? path : `file://${resolve(path)}`);
    if (isServed) {
      await page.waitForSelector('#curve svg');
      await page.waitForSelector('#fields input');
      await page.evaluate(() => document.querySelectorAll('details').forEach((own) => own.setAttribute('open', '')));
    } else if (browser === 'chrome') {
      const size = statSync(path).size;
      const isEpisode = await page.evaluate(() => document.getElementById('dock') !== null);
      const { first, frames } = await measured(page);
      console.log(`${name}: ${(size / 1e6).toFixed(2)} MB, first frame after ${first?.toFixed(2)} s, ${frames.toFixed(0)} frames/s`);
      if (size > LARGEST) say(`${size} bytes`);
      if (isEpisode && !(first <= SOON)) say(`first frame after ${first} s`);
      if (isEpisode && frames < SMOOTH) say(`${frames} frames a second`);
    }
    for (const scheme of ['light', 'dark']) {
      // Firefox has no switch for a page's scheme.
      if (browser === 'chrome') await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
      else if (scheme === 'dark') continue;
      for (const [width, height] of SIZES) {
        await page.setViewport({ width, height });
        await new Promise((then) => setTimeout(then, 300));
        const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        const lowest = await page.evaluate(() => document.querySelector('#curve svg')?.getBoundingClientRect().bottom || 0);
        if (isServed && width >= 1024 && lowest > height) say(`at ${width} x ${height} the curve ends at ${lowest}`);
        if (over > 0) say(`${over} pixels wider than ${width}`);
        await page.screenshot({ path: `pictures/${name}-${browser}-${scheme}-${width}.png` });
        if (browser !== 'chrome' || width === 1024) continue;
        if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(axe);
        const found = await page.evaluate(async () => (await window.axe.run({ iframes: false })).violations
          .map(({ id, impact, nodes }) => ({ id, impact, where: nodes.slice(0, 3).map(({ html }) => html.slice(0, 120)) })));
        for (const { id, impact, where } of found) {
          if (['serious', 'critical'].includes(impact)) say(`axe, ${scheme} ${width}: ${id}: ${where.join(' ')}`);
        }
      }
    }
    await page.close();
  }
  await running.close();
}
wrong.forEach((problem) => console.log(problem));
console.log(`${pages.length} pages, ${wrong.length} problems`);
process.exit(wrong.length > 0 || pages.some((path) => !path.startsWith('http:') && !existsSync(path)) ? 1 : 0);
