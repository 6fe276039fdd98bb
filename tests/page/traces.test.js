// The traces in Chromium, fed by the real service on a simulated rig: live, paused, zoomed, cursors, CSV.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { Bench, openBrowser, PATIENCE_MS, SIZES, until } from './bench.js';

let browser;
let bench;
let page;
const complaints = []; // of the browser: the policy, a file, our own code
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(), Bench.begin()]);
  bench.rig.say('start');
  page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  await page.goto(bench.url);
  await page.waitForSelector('#traces:not([hidden])');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

const said = (pattern) => page.waitForFunction((p) => new RegExp(p).test(document.querySelector('#trace-what').innerText), pattern);
const newest = async () => (await bench.get('/api/v1/traces?points=1')).newest_s;
// What is drawn, as a number that changes with it.
const picture = () => page.evaluate(() => {
  const canvas = document.querySelector('#trace-plot');
  const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let sum = 0;
  for (let i = 0; i < pixels.length; i += 4) sum = (sum * 31 + pixels[i]) % 1e9;
  return sum;
});
// The CSV that the page saves, as rows of text.
async function saved() {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#trace-save')]);
  return (await readFile(await download.path(), 'utf8')).trimEnd().split('\n').map((line) => line.split(','));
}

test('off the screen they go on as well: who prints the page, or takes a picture of all of it, finds what is', async () => {
  await said('in view, live: readings, least and greatest in ');
  // A window that ends above the traces, however much stands there already.
  const top = await page.evaluate(() => {
    window.scrollTo(0, 0);
    return document.querySelector('#trace-plot').getBoundingClientRect().top;
  });
  await page.setViewportSize({ ...SIZES.desk, height: Math.floor(top / 2) });
  const before = await picture();
  await until(async () => await picture() !== before);
  assert.ok(await page.evaluate(() => document.querySelector('#trace-plot').getBoundingClientRect().top > window.innerHeight), 'it was off the screen');
  await page.setViewportSize(SIZES.desk);
});

test('they move while they are live, and stand still while paused', async () => {
  await said('in view, live: readings, least and greatest in ');
  await page.locator('#trace-plot').scrollIntoViewIfNeeded(); // off the screen it is drawn once a second
  const before = await picture();
  await until(async () => await picture() !== before);
  await page.click('#trace-pause');
  await said('paused');
  // A second of the stream later, and again. The answer that the pause asks for may come late on a busy machine.
  const later = async () => {
    const from = await newest();
    await until(async () => await newest() > from + 1);
    return picture();
  };
  let still = await picture();
  await until(async () => {
    const last = still;
    still = await later();
    return still === last;
  });
  assert.equal(await later(), still);
});

test('what came during a pause is there afterwards, without a hole', async () => {
  const from = await newest();
  await until(async () => await newest() > from + 3);
  await page.focus('#trace-plot');
  await page.keyboard.press('End');
  await said('live');
  await page.keyboard.press('Space');
  await said('paused');
  const rows = await saved();
  assert.ok(Number(rows.at(-1)[0]) > from + 3 && Number(rows[1][0]) < from, 'the pause is in view');
  const step = Number(rows[2][0]) - Number(rows[1][0]);
  if (step >= 0.01) for (const row of rows.slice(1, -1)) assert.ok(row.every((cell) => cell !== ''), row.join());
  const reading = rows.filter((row) => row[1] !== '').map((row) => Number(row[0]));
  // The rig is polled 200 times a second; a machine that tests share may be late, but not by a piece of the trace.
  assert.ok(reading.slice(2).every((t, i) => t - reading[i + 1] < 0.5), 'no piece is missing');
});

// On a busy machine two readings of a channel may come within 0.3125 ms: then each row has its smaller and its larger one.
test('the file saved holds the single readings in view, as the service has them', async () => {
  const asked = [];
  const note = (response) => {
    if (response.url().includes('points=4000')) asked.push(response.json());
  };
  page.on('response', note);
  const rows = await saved();
  page.off('response', note);
  const [{ channels, newest_s }, ...parts] = await Promise.all(asked);
  assert.ok(parts.every((part) => part.step_s === 0.02 / 64), 'asked for in the narrowest bins');
  const list = (c, which) => parts.flatMap((part) => part.channels[c][which]);
  const ones = channels.map((_, c) => list(c, 'min').every((value, i) => value === list(c, 'max')[i]));
  const one = ones.includes(true);
  const columns = channels.flatMap(({ name, unit }, c) => (ones[c] ? [[`${name} [${unit}]`, list(c, 'min')]]
    : ['min', 'max'].map((which) => [`${name} ${which} in 0.3125 ms [${unit}]`, list(c, which)])));
  const since = `t [s since ${parts[0].origin_utc}`;
  assert.deepEqual(rows[0], [one ? `${since}; readings are up to 0.3125 ms later]` : `${since}]`, ...columns.map(([head]) => head)]);
  const wanted = columns[0][1].map((_, i) => [parts[0].from_s + 0.02 / 64 * i, ...columns.map(([, values]) => values[i])])
    .filter(([, ...values]) => values.some((value) => value !== null));
  assert.ok(wanted.length > 100 && newest_s - wanted.at(-1)[0] < 60, 'the view has readings');
  assert.deepEqual(rows.slice(1), wanted.map(([t, ...values]) => [String(Number(t.toFixed(9))), ...values.map((value) => String(value ?? ''))]));
  assert.match(await page.locator('#trace-saved').innerText(), one ? /^Saved: single readings, each within 0\.3125 ms after its t[.;]/
    : /^Saved: the smallest and the largest reading of each 0\.3125 ms\.$/);
});

test('zoomed by keyboard the readings are shown one by one', async () => {
  await page.focus('#trace-plot');
  for (let i = 0; i < 5; ++i) await page.keyboard.press('+');
  await said('^31\\d ms in view, paused: readings, least and greatest in (1\\.25|0\\.313) ms');
  await page.keyboard.press('ArrowLeft');
  await said('paused');
});

test('two cursors tell time and value of each channel, and the difference', async () => {
  await page.check('#trace-cursors');
  await page.locator('#trace-A').fill('100');
  await page.locator('#trace-B').fill('900');
  await page.locator('#trace-between', { hasText: 'B − A: 250' }).waitFor();
  const between = await page.locator('#trace-between').innerText();
  const [ms, hz] = between.match(/([\d.]+) ms.* ([\d.]+) Hz/).slice(1).map(Number);
  assert.ok(Math.abs(ms - 0.8 * 312.5) < 0.1, between);
  assert.ok(Math.abs(hz * ms - 1000) < 1, between);
  const rows = await page.locator('#trace-rows tr').evaluateAll((all) => all.map((row) => [...row.querySelectorAll('td')].map((cell) => cell.textContent)));
  assert.equal(rows.length, 5);
  for (const row of rows) {
    const [a, b, difference] = row.map((text) => {
      const [, value, half, unit] = text.replaceAll('\u2212', '-').match(/^(-?[\d.]+)(?: ± ([\d.]+))? (mm|N)$/);
      assert.equal(unit, row === rows.at(-1) ? 'N' : 'mm');
      return { value: Number(value), half: Number(half ?? 0) };
    });
    // Each text is rounded to two digits of its ±, or to five digits.
    assert.ok(Math.abs(b.value - a.value - difference.value) <= 0.05 * (a.half + b.half + difference.half) + 1e-3 * (Math.abs(a.value) + Math.abs(b.value)) + 1e-3, row.join());
    assert.ok(Math.abs(a.half + b.half - difference.half) <= 0.1 * difference.half + 1e-9, row.join());
  }
  // A click moves the nearer one.
  const box = await page.locator('#trace-plot').boundingBox();
  await page.mouse.click(box.x + box.width / 4, box.y + box.height / 2);
  await page.waitForFunction(() => Math.abs(document.querySelector('#trace-A').value - 250) < 20);
  // While live the bins are so wide that several readings are in each: all three numbers have ± and unit.
  await page.focus('#trace-plot');
  for (let i = 0; i < 5; ++i) await page.keyboard.press('-');
  await page.keyboard.press('End');
  const numbers = page.locator('#trace-rows tr', { hasText: 'y1' }).locator('td');
  for (let i = 0; i < 3; ++i) await numbers.nth(i).filter({ hasText: /^\u2212?[\d.]+ ± [\d.]+ mm$/ }).waitFor();
});

test('less the steady part, what is left of a settled dwell is small', async () => {
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.focus('#trace-plot');
  await page.keyboard.press('End');
  await page.check('#trace-less');
  await said('live: readings less the steady part of dwell \\d+');
  await until(async () => {
    const of = async (less) => (await bench.get(`/api/v1/traces?from=-1&points=50&channels=y1${less}`)).channels[0].max;
    // The middle one: on a busy machine some readings come late, and are not the motion of their instant.
    const middle = (values) => values.filter((v) => v !== null).map(Math.abs).sort((a, b) => a - b).at(values.length >> 2);
    return middle(await of('&less=steady')) < 0.02 * middle(await of(''));
  });
  await page.uncheck('#trace-less');
  await said('live: readings, ');
  assert.deepEqual(complaints, []);
});
