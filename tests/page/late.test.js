// Answers that come late, or no longer.
import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { openBrowser, PATIENCE_MS, SIZES } from './bench.js';
import { ScriptedService } from './scripted.js';

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

async function open() {
  const page = await service.open(browser, SIZES.desk);
  page.setDefaultTimeout(PATIENCE_MS);
  await service.play(4);
  await page.waitForSelector('#dwell-rows tr');
  return page;
}

test('the late answer for a dwell that was opened before does not replace the one that is open', async () => {
  const page = await open();
  const { dwells } = await (await fetch(`${service.url}/api/v1/dwells`)).json();
  let release = null;
  await page.route(/\/api\/v1\/dwells\/\d+$/, async (route) => {
    const index = Number(route.request().url().split('/').at(-1));
    if (index === 11) await new Promise((done) => (release = done));
    await route.fulfill({ json: { ...dwells.find((d) => d.index === index), ended_by: `end of ${index}` } });
  });
  const show = (index) => page.locator('#dwell-rows button', { hasText: new RegExp(`^${index}$`) }).click();
  await show(11);
  await page.locator('#dwell-close').click();
  await show(12);
  await page.locator('#dwell-content', { hasText: 'end of 12' }).waitFor();
  const late = page.waitForResponse(/dwells\/11$/);
  release();
  await (await late).finished();
  await service.play(2); // waits until all answers are taken and drawn
  assert.match(await page.locator('#dwell-content').innerText(), /end of 12/);
  await page.close();
});

// The row was made once, and its numbers stood there as good.
test('a doubt that is told after the end of a dwell marks its row', async () => {
  const page = await open();
  const row = page.locator('#dwell-rows tr', { has: page.locator('button', { hasText: /^12$/ }) });
  assert.doesNotMatch(await row.innerText(), /\?/);
  await page.route(/\/api\/v1\/dwells\?/, async (route) => {
    const answer = await (await route.fetch()).json();
    const doubts = [{ elements: [], what: 'the mass is wrong' }];
    await route.fulfill({ json: { ...answer, dwells: answer.dwells.map((d) => (d.index === 12 ? { ...d, doubts } : d)) } });
  });
  await service.play(12);
  await page.locator('#dwell-rows tr', { has: page.locator('button', { hasText: /^12$/ }), hasText: '?' }).waitFor();
  await page.close();
});

test('a table of dwells and a list of events say how many they leave out', async () => {
  const page = await open();
  await page.locator('#events-none', { hasText: /^The newest 100 of 500 events\.$/ }).waitFor();
  assert.equal(await page.locator('#dwells-none').innerText(), '');
  await page.route(/\/api\/v1\/dwells\?/, async (route) => route.fulfill({ json: { ...await (await route.fetch()).json(), total: 40 } }));
  await service.play(12);
  await page.locator('#dwells-none', { hasText: /^The newest 12 of 40 dwells of this run\.$/ }).waitFor();
  await page.close();
});

test('lists that the service no longer tells of are marked as old, with their age', async () => {
  const page = await open();
  await page.waitForSelector('#event-rows li');
  const marks = () => page.evaluate(() => ['dwells', 'events', 'runs'].map((id) => document.getElementById(id).classList.contains('old')));
  const old = page.locator('#events-old');
  assert.deepEqual(await marks(), [false, false, false]);
  assert.equal(await old.isVisible(), false);
  await page.route('**/api/v1/events*', (route) => route.abort());
  await service.play(30);
  assert.deepEqual(await marks(), [false, true, false]);
  assert.match(await old.innerText(), /^\d\d s old: the service does not tell of them$/);
  await page.unroute('**/api/v1/events*');
  await service.play(12);
  assert.deepEqual(await marks(), [false, false, false]);
  await page.close();
});
