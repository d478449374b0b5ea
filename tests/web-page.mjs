// web-page.mjs ADDRESS HASH PICTURE: lets the page evolve in Chromium until it shows a result hash, which must be HASH; nothing is on the console but that
// the report's scripts are off. Takes a picture.
import assert from 'node:assert';
import puppeteer from 'puppeteer-core';

const [address, hash, picture] = process.argv.slice(2);
const browser = await puppeteer.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
const page = await browser.newPage();
const said = [];
page.on('console', (message) => said.push(message.text()));
page.on('pageerror', (error) => said.push(error.message));
const began = performance.now();
await page.goto(`${address}#seed=1&go`);
await page.waitForFunction(() => document.getElementById('hash').textContent !== '', { timeout: 120_000 });
const seconds = (performance.now() - began) / 1e3;
assert.equal(await page.$eval('#hash', (element) => element.textContent), hash);
await page.screenshot({ path: picture, fullPage: true });
await browser.close();
const others = said.filter((text) => !text.includes("'allow-scripts'"));
assert.deepEqual(others, []);
console.log(`Chromium: the program's hash after ${seconds.toFixed(1)} s`);
