// A finished dwell that is opened from the table: it tells as much of its numbers as the page does of a dwell of now.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { check } from './accessible.js';
import { openBrowser, PATIENCE_MS, SIZES } from './bench.js';
import { ScriptedService } from './scripted.js';

let browser;
let service;
let page;
before(async () => {
  [browser, service] = await Promise.all([openBrowser(), ScriptedService.begin()]);
  page = await service.open(browser, SIZES.desk, { bypassCSP: true });
  page.setDefaultTimeout(PATIENCE_MS);
  await service.play(4);
  const { dwells } = await (await fetch(`${service.url}/api/v1/dwells`)).json();
  const dwell = dwells.find((d) => d.index === 12);
  const [y0, y1] = dwell.phasors;
  Object.assign(y0, { amplitude: 4e-3, phase_rad: 0.2, u_amplitude: 1e-6 });
  Object.assign(y1, { amplitude: 2e-3, phase_rad: 0.2 + Math.PI / 6, u_amplitude: 3e-6, u_relative_phase_rad: 1e-3 });
  dwell.phasors[2] = { channel: 'y2', unit: 'm', valid: false, reason: 'stuck at one reading', harmonics: [] };
  await page.route(/\/api\/v1\/dwells\/12$/, (route) => route.fulfill({ json: dwell }));
  await page.locator('#dwell-rows button', { hasText: /^12$/ }).click();
  await page.waitForSelector('#dwell-content .facts');
});
after(async () => {
  await Promise.all([browser?.close(), service?.end()]);
});

test('both coefficients of each element have what makes up their ±, and what to do first', async () => {
  const budgets = page.locator('#dwell-content .budget');
  assert.equal(await budgets.count(), 7);
  assert.equal(await budgets.nth(1).locator('summary').innerText(), 'What makes up ± of element 2');
  await budgets.nth(1).locator('summary').click();
  const [c, r] = await budgets.nth(1).locator('div').all();
  assert.equal(await c.locator('p').innerText(), '± of c₂: first calibrate the scale of y1');
  assert.deepEqual(await c.locator('li').allInnerTexts(), ['scale of y1 60 %', 'noise of all channels 40 %']);
  assert.equal(await r.locator('p').innerText(), '± of r₂: first measure longer');
  assert.deepEqual(await r.locator('li').allInnerTexts(), ['noise of all channels 90 %', 'scale of y1 10 %']);
});

// ± is 1.96 u: 0.0020 mm, 0.0059 mm and 0.11°.
test('each phasor has its amplitude and its phase with ±, or the reason why there is none', async () => {
  const rows = await page.locator('#dwell-content tbody tr').evaluateAll((all) => all.map((row) => [...row.children].map((cell) => cell.innerText)));
  assert.deepEqual(rows.slice(0, 3), [['y0', '4.0000 ± 0.0020 mm', '0°'], ['y1', '2.0000 ± 0.0059 mm', '30.00 ± 0.11°'], ['y2', 'stuck at one reading']]);
  assert.equal(rows.length, 8);
});

for (const size of ['desk', 'phone']) {
  test(`it fits the screen of a ${size}`, async () => {
    await page.setViewportSize(SIZES[size]);
    await check(page, `opened-dwell-${size}`);
    const wide = await page.locator('#dwell-content .wide').evaluate((node) => node.scrollWidth - node.clientWidth);
    assert.ok(wide <= 0, `${wide} px of the phasors are cut off`);
  });
}
