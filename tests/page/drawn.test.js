// What stands in the page's elements, where the numbers that it is told are known: ellipses of phasors, rows of devices, the chain.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dwellOf } from './sample.js';
import { scriptedPages } from './scripted_page.js';

const openScripted = scriptedPages();

const open = (dwell, health) => openScripted({ dwell, health });

// By hand. The largest amplitude, 4 mm, is 100 in the picture. So y1 has 50 at 30°: x = 43.30, and y = −25, since y points
// down. Its u are 0.1 mm along the arrow, 2.5 in the picture, and 0.02 rad · 50 = 1 across it. With e = (cos 30°, −sin 30°)
// its covariance is 1² · I + (2.5² − 1²) · e eᵀ: the variances are 1 + 5.25 · 3/4 and 1 + 5.25 · 1/4, the covariance is
// −5.25 · √3/4. Each point of the ellipse is 2.45 from the middle, in the measure of this covariance.
const COVARIANCE = { xx: 4.9375, yy: 2.3125, xy: -2.27332 };

test('the ellipse of a phasor is where its correlated uncertainty puts it: 2.45 standard uncertainties around its end', async () => {
  const phasor = (channel, amplitude, phase_rad, u_amplitude, u_relative_phase_rad) =>
    ({ channel, unit: 'm', valid: true, mean: 0, harmonics: [], amplitude, phase_rad, u_amplitude, u_relative_phase_rad });
  const shown = await open(dwellOf({ phasors: [phasor('y0', 4e-3, 0.4, 1e-5, 0), phasor('y1', 2e-3, 0.4 + Math.PI / 6, 1e-4, 0.02)] }));
  const { page } = shown;
  await page.locator('#arrows .arrow').nth(1).waitFor();
  const [middle, ...points] = await page.evaluate(() => {
    const ellipse = document.querySelectorAll('#arrows .ellipse')[1];
    const toPicture = document.querySelector('#arrows').getCTM().inverse().multiply(ellipse.getCTM());
    const [rx, ry] = ['rx', 'ry'].map((name) => ellipse[name].baseVal.value);
    const at = (x, y) => {
      const point = new DOMPoint(x, y).matrixTransform(toPicture);
      return { x: point.x, y: point.y };
    };
    return [at(0, 0), ...Array.from({ length: 12 }, (_, i) => at(rx * Math.cos(i * Math.PI / 6), ry * Math.sin(i * Math.PI / 6)))];
  });
  assert.ok(Math.abs(middle.x - 43.30) < 0.06 && Math.abs(middle.y + 25) < 0.06, JSON.stringify(middle));
  const { xx, yy, xy } = COVARIANCE;
  for (const point of points) {
    const [x, y] = [point.x - middle.x, point.y - middle.y];
    const distance = Math.sqrt((yy * x * x - 2 * xy * x * y + xx * y * y) / (xx * yy - xy * xy));
    assert.ok(Math.abs(distance - 2.45) < 0.02, `${distance} u at ${x}, ${y}`);
  }
  assert.equal(await page.locator('#arrows .ellipse').nth(1).isVisible(), true);
  await shown.close();
});

test('each device has its driver, whether it delivers, and its faults', async () => {
  const device = (name, more) => ({ name, driver: 'modbus', up: true, ended: false, faults: {}, ...more });
  const shown = await open(dwellOf(), { devices: [device('amplifier', { faults: { timeout: 1234, 'missed deadline': 5 } }),
    device('bus', { driver: 'can', up: false }), device('tape', { driver: 'replay', up: false, ended: true })] });
  const { page } = shown;
  await page.locator('#device-rows tr').nth(2).waitFor();
  const rows = await page.locator('#device-rows tr').evaluateAll((all) => all.map((row) => [row.dataset.tone, ...[...row.children].map((cell) => cell.innerText)]));
  assert.deepEqual(rows, [['calm', 'amplifier', 'modbus', 'delivers', 'timeout: 1\u202f234, missed deadline: 5'],
    ['alarm', '▲ bus', 'can', 'does not deliver', 'none'], ['calm', 'tape', 'replay', 'recording ended', 'none']]);
  await shown.close();
});

test('the chain rests where less motion is asked for, and can be moved and halted', async () => {
  const phasors = Array.from({ length: 7 }, (_, i) => ({ channel: `y${i}`, unit: 'm', valid: true, mean: 0, harmonics: [],
    amplitude: 4e-3, phase_rad: 0.4 * i, u_amplitude: 1e-6, u_relative_phase_rad: 1e-4 }));
  const shown = await openScripted({ dwell: dwellOf({ phasors }), options: { reducedMotion: 'reduce' } });
  const { page } = shown;
  await page.waitForSelector('#chain:not([hidden])');
  const button = page.locator('#shape-pause');
  const place = () => page.locator('#shape-masses').innerHTML();
  // Presses the button after so many pictures, if so asked. Of the pictures of the masses from then on, how many differ from the first.
  const moves = (pressAfter) => page.evaluate(async (pressAfter) => {
    const html = () => document.querySelector('#shape-masses').innerHTML;
    for (let i = 0; i < pressAfter; ++i) await new Promise((drawn) => requestAnimationFrame(drawn));
    if (pressAfter !== null) document.querySelector('#shape-pause').click();
    const first = html();
    let others = 0;
    for (let i = 0; i < 30; ++i) {
      await new Promise((drawn) => requestAnimationFrame(drawn));
      others += html() !== first;
    }
    return others;
  }, pressAfter);
  assert.equal(await button.innerText(), 'Move');
  assert.equal(await moves(null), 0);
  for (let pressAfter = 0; pressAfter < 10; ++pressAfter) { // between two places of the masses, and just when the next is due
    const before = await place();
    await button.click();
    assert.equal(await button.innerText(), 'Halt');
    await page.waitForFunction((was) => document.querySelector('#shape-masses').innerHTML !== was, before);
    assert.equal(await moves(pressAfter), 0);
    assert.equal(await button.innerText(), 'Move');
  }
  await shown.close();
});
