// watched-day.mjs ADDRESS: shows the page of `oneiro watch` the updates of a day in Chromium, each as soon as the one before is drawn and a
// newer best each time, and says the page's memory. Ends with 1 if it may have more than 100 MB at the day's end. See pages.sh.
import puppeteer from 'puppeteer-core';

// One update a second.
const DAY = 24 * 60 * 60;
/** Updates before memory is compared, and in all. */
const WARM = 250;
const UPDATES = 2000;
const ALLOWED_MB = 100;
/** By what the page's clock is faster. */
const FASTER = 40;

/** Runs in every frame before its scripts: a faster clock, a server that always has news. */
function hurry(faster) {
  const now = performance.now.bind(performance);
  performance.now = () => now() * faster;
  const every = window.setInterval.bind(window);
  window.setInterval = (call, wait) => every(call, wait / faster);
  if (window !== top) return;
  window.updates = 0;
  const fetched = window.fetch.bind(window);
  window.fetch = (path, settings) => {
    if (!/^scene\/[^?]*$/.test(path)) return fetched(path, settings);
    window.updates += 1;
    return fetched(`${path}?generation=${window.updates}`, settings);
  };
  const { addEventListener } = EventSource.prototype;
  EventSource.prototype.addEventListener = function listen(kind, call) {
    if (kind !== 'message') return addEventListener.call(this, kind, call);
    return addEventListener.call(this, kind, (event) => {
      const news = JSON.parse(event.data);
      every(() => {
        news.sources.forEach((source) => { source.version += 1; });
        call({ data: JSON.stringify(news) });
      }, 1000 / faster);
    });
  };
}

const browser = await puppeteer.launch({
  headless: true, executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu', '--disable-background-networking'],
});
const page = await browser.newPage();
page.on('pageerror', (error) => {
  console.log(`error: ${error.message}`);
  process.exit(1);
});
await page.evaluateOnNewDocument(hurry, FASTER);
await page.goto(process.argv[2]);
const session = await page.createCDPSession();

/** The page's memory and what it holds after `updates` of them. */
async function held(updates) {
  await page.waitForFunction((wanted) => window.updates >= wanted, { timeout: 0, polling: 200 }, updates);
  await session.send('HeapProfiler.collectGarbage');
  const { JSHeapUsedSize, Nodes, JSEventListeners, Documents } = await page.metrics();
  const megabytes = JSHeapUsedSize / 1e6;
  console.log(`${updates} updates: ${megabytes.toFixed(2)} MB, ${Nodes} nodes, ${JSEventListeners} listeners, ${Documents} documents`);
  return megabytes;
}

const first = await held(WARM);
let last = first;
let most = first;
for (let updates = 2 * WARM; updates <= UPDATES; updates += WARM) {
  last = await held(updates);
  most = Math.max(most, last);
}
const growth = Math.max(0, (last - first) / (UPDATES - WARM));
const end = most + growth * DAY;
console.log(`a day of a run's page: at most ${end.toFixed(1)} MB (allowed: ${ALLOWED_MB})`);
await browser.close();
process.exit(end > ALLOWED_MB ? 1 : 0);
