// A recording in place of a rig does not pass for one, and its end for no fault.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { check } from './accessible.js';
import { Bench, openBrowser, PATIENCE_MS, SIZES } from './bench.js';

const rigs = new URL('../../config/rigs/', import.meta.url);
let browser;
let bench;
before(async () => {
  browser = await openBrowser();
  const [rig, csv] = await Promise.all([readFile(new URL('replay.toml', rigs), 'utf8'), readFile(new URL('mount.csv', rigs))]);
  bench = await Bench.begin({ edit: () => rig.replace(/^\[server\][^]*$/m, '[server]\nlisten = "127.0.0.1:0"\n'), files: { 'mount.csv': csv } });
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

test('a recording that is played is told as such, and its end is no alarm', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk, bypassCSP: true });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(bench.url);
  await page.waitForSelector('#state[data-kind=measuring]');
  const source = page.locator('#facts [data-tone=care]', { hasText: 'recording, not live' });
  await source.waitFor();
  assert.match(await page.locator('#detail').innerText(), /^a recording, not live: [\d.]+ m?s of data/);
  await page.locator('#trace-what', { hasText: 'in view, a recording as it is played: readings' }).waitFor();
  await page.waitForSelector('#state[data-kind=complete][data-tone=calm]');
  assert.equal(await page.locator('#word').innerText(), 'recording ended');
  await source.waitFor();
  await page.locator('#coefficients-from', { hasText: /^not of now · last dwell: 1, ended .* ago: the recording ended$/ }).waitFor();
  assert.equal(await page.locator('.coefficient .struck').count(), 0, 'a result');
  assert.equal(await page.locator('#troubles li').count(), 0);
  await new Promise((done) => setTimeout(done, 2500)); // an alarm would be there by now
  const { alarms } = await bench.get('/api/v1/alarms');
  assert.deepEqual(alarms.map((a) => a.name).filter((name) => name !== 'clock'), []);
  await check(page, 'replay-desk');
  await page.close();
});
