// web-page.mjs ADDRESS PICTURE FRAGMENT HASH..: lets the page evolve in Chromium, for each fragment of its address until it shows a result hash, which
// must be HASH; nothing is on the console but that the report's scripts are off. Takes a picture of the last.
import assert from 'node:assert';
import puppeteer from 'puppeteer-core';

const [address, picture, ...runs] = process.argv.slice(2);
const browser = await puppeteer.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
const said = [];
for (let at = 0; at < runs.length; at += 2) {
    const page = await browser.newPage();
    page.on('console', (message) => said.push(message.text()));
    page.on('pageerror', (error) => said.push(error.message));
    const began = performance.now();
    await page.goto(`${address}#${runs[at]}`);
    await page.waitForFunction(() => document.getElementById('hash').textContent !== '', { timeout: 120_000 });
    const seconds = (performance.now() - began) / 1e3;
    assert.equal(await page.$eval('#hash', (element) => element.textContent), runs[at + 1]);
    await page.screenshot({ path: picture, fullPage: true });
    await page.close();
    console.log(`Chromium, #${runs[at]}: the program's hash after ${seconds.toFixed(1)} s`);
}
await browser.close();
const others = said.filter((text) => !text.includes("'allow-scripts'"));
assert.deepEqual(others, []);
