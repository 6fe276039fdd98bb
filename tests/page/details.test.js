// What is opened or filtered on the page: harmonics, budgets, events, and the columns of the channels.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { check } from './accessible.js';
import { Bench, openBrowser, PATIENCE_MS, SIZES } from './bench.js';

let browser;
let bench;
let page;
before(async () => {
  // y1 has a calibration and a stated uncertainty: the largest part of the budget is known.
  [browser, bench] = await Promise.all([openBrowser(), Bench.begin({ edit: (text) =>
    text.replace(/^name     = "y1"$/m, '$&\nscale_u = 0.01\ncalibration = { id = "K-7", due = 2020-01-31 }') })]);
  bench.rig.say('start');
  page = await browser.newPage({ viewport: SIZES.desk, bypassCSP: true });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(bench.url);
  await page.waitForSelector('#coefficients[data-source=measured] .element');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

test('the harmonics of each channel stand in a table that is opened', async () => {
  await page.waitForSelector('#chain:not([hidden])');
  await page.locator('#harmonics summary').click();
  assert.deepEqual(await page.locator('#harmonic-heads th').allInnerTexts(), ['channel', '2 f', '3 f']);
  const rows = await page.locator('#harmonic-rows tr').allInnerTexts();
  assert.deepEqual(rows.map((row) => row.split(/\s/)[0]), ['y0', 'y1', 'y2', 'y3', 'reaction']);
  for (const row of rows) assert.match(row, /^\S+(\s+[\d.e-]+ %){2}$/);
});

test('the budget of an element has bars that add up, and says what to do first', async () => {
  const budget = page.locator('.element').first().locator('.budget');
  await budget.locator('summary').click();
  await budget.locator('.bars li').first().waitFor();
  assert.match(await budget.locator('div > p').first().innerText(), /^± of c₁: first calibrate the scale of y1$/);
  const bars = await budget.locator('div').first().locator('.bars li').evaluateAll((items) => items.map((item) => ({
    text: item.innerText, part: item.firstChild.getBoundingClientRect().width / item.getBoundingClientRect().width })));
  let sum = 0;
  for (const { text, part } of bars) {
    const percent = Number(text.match(/ ([\d.]+) %$/)[1]);
    assert.ok(Math.abs(part - percent / 100) < 0.02, `${text}: the bar is ${part.toFixed(2)} wide`);
    sum += percent;
  }
  assert.ok(sum > 90 && sum < 101, `${sum} %`);
  assert.match(bars[0].text, /^scale of y1 /);
});

test('channels have their rate, jitter, losses and calibration', async () => {
  await page.waitForSelector('#state[data-kind=measuring]');
  const heads = await page.locator('#channels thead').first().locator('th').allInnerTexts();
  assert.deepEqual(heads.slice(4), ['rate', 'jitter', 'received', 'dropped', 'lost', 'gaps', 'calibration']);
  const rowOf = async (name) => (await page.locator('#channel-rows tr', { has: page.locator('th', { hasText: name }) }).locator('th, td').allInnerTexts());
  const number = (text) => Number(text.replaceAll('\u202f', ''));
  await page.locator('#channel-rows tr:nth-child(2)', { hasText: / Hz/ }).waitFor();
  const before = await rowOf('y1');
  assert.match(before[4], /^\d+ Hz$/);
  assert.match(before[5], /^[\d.]+ ms$|^—$/);
  for (const text of before.slice(6, 10)) assert.ok(Number.isInteger(number(text)), text);
  await page.waitForFunction((was) => document.querySelector('#channel-rows tr:nth-child(2) td:nth-child(7)').innerText !== was, before[6]);
  assert.ok(number((await rowOf('y1'))[6]) > number(before[6]), 'received');
  // Overdue only where the computer's clock is synchronized.
  assert.match(before[10], /^K-7, due 2020-01-31(: overdue)?$/);
  assert.equal((await rowOf('y0'))[10], 'none stated');
});

test('an overdue calibration is marked by word and shape', async () => {
  await page.route('**/api/v1/channels', async (route) => {
    const told = await (await route.fetch()).json();
    told.channels[1].calibration.overdue = true;
    await route.fulfill({ json: told });
  });
  await page.locator('#channel-rows tr[data-tone=care] th', { hasText: '◆ y1' }).waitFor();
  await page.locator('#channel-rows td', { hasText: 'K-7, due 2020-01-31: overdue' }).waitFor();
  await check(page, 'calibration-desk');
  await page.unrouteAll({ behavior: 'ignoreErrors' });
});

test('events are filtered by their gravity and their words', async () => {
  bench.rig.signal('SIGSTOP');
  await page.waitForSelector('#state[data-kind=fault]');
  bench.rig.signal('SIGCONT');
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.locator('#event-rows li[data-level=warning]').first().waitFor();
  const levels = () => page.locator('#event-rows li').evaluateAll((items) => [...new Set(items.map((item) => item.dataset.level))]);
  assert.ok((await levels()).includes('info'));
  await page.selectOption('#event-level', 'warning');
  await page.waitForFunction(() => !document.querySelector('#event-rows li[data-level=info]'));
  assert.ok((await levels()).includes('warning'));
  await page.fill('#event-words', 'AMPLIFIER');
  for (const text of await page.locator('#event-rows li').allInnerTexts()) assert.match(text, /amplifier/);
  await page.fill('#event-words', 'no such words');
  await page.locator('#events-none', { hasText: 'No event fits the filter.' }).waitFor();
  await page.fill('#event-words', '');
  await page.selectOption('#event-level', 'info');
});
