// The trend beside each coefficient in Chromium: wide enough to be read, and it says what it shows.
import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { check } from './accessible.js';
import { openBrowser, PATIENCE_MS, SIZES } from './bench.js';
import { ScriptedService } from './scripted.js';

const LEAST_PX = 56; // 3.5rem: at an hour's width a dwell of a minute is a pixel

let browser;
let service;
before(async () => {
  browser = await openBrowser();
});
after(() => browser?.close());
// One for each page: its time is the page's.
beforeEach(async () => {
  service = await ScriptedService.begin();
});
afterEach(() => service?.end());

for (const size of ['phone', 'desk']) {
  test(`at the size of a ${size} a long number leaves the trend its room, and the height of each trend stands below it`, async () => {
    const page = await service.open(browser, SIZES[size], { bypassCSP: true });
    page.setDefaultTimeout(PATIENCE_MS);
    await service.play(20); // what was answered is drawn
    const cells = await page.evaluate(() => [...document.querySelectorAll('.coefficient')].map((cell, i) => {
      const [value, pm] = [['7.99995', ' ± 0.00029'], ['7.999781', ' ± 0.000099'], ['24.001', ' ± 0.024']][i % 3];
      const number = cell.querySelector('.number');
      number.children[0].textContent = value;
      number.children[1].textContent = pm;
      const [trend, height] = ['.trend', '.height'].map((part) => cell.querySelector(part));
      const [box, below, all] = [trend, height, cell].map((node) => node.getBoundingClientRect());
      return { value, width: box.width, below: below.top >= box.bottom - 1, inside: Math.max(box.right, below.right) <= all.right + 1,
        height: height.textContent, spoken: trend.getAttribute('aria-label') };
    }));
    assert.equal(cells.length, 14);
    for (const { value, width, below, inside, height, spoken } of cells) {
      assert.ok(width >= LEAST_PX, `${width} px beside ${value}`);
      assert.ok(below && inside, value);
      assert.match(height, /^± [\d.]+ %$/);
      assert.equal(spoken.replace(/ [\u2212+][\d.e-]+ %/g, ' # %'), `Trend of the last 60 min: from the newest value # % to # %, height ${height}`);
    }
    assert.match(await page.locator('#trend-legend').innerText(), /^A trend shows the last 60 min\. /);
    await check(page, `trend-${size}`);
    await page.close();
  });
}
