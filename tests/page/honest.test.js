// What is old, of another run, or read before a logout never passes for what is measured now.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { Bench, openBrowser, PATIENCE_MS, SIZES, TOKEN, until } from './bench.js';
import { dwellOf } from './sample.js';

let browser;
let bench;
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(),
    Bench.begin({ edit: (text) => text.replace(/^# token_file .*/m, 'token_file = "token"'), files: { token: TOKEN } })]);
  bench.rig.say('start');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

async function open() {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(bench.url);
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.waitForSelector('#traces:not([hidden])');
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
  return page;
}
const said = (page, selector, pattern) => page.locator(selector, { hasText: pattern }).waitFor();
async function logIn(page) {
  await page.locator('#operate-token').fill(TOKEN);
  await page.keyboard.press('Enter');
  await page.locator('#operate-acts').waitFor();
}

// How many pixels of the colour that is named the lane of a channel has, in a part of its width; right of its label.
const lanePixels = (page, lane, lanes, name, from = 0.55, part = 0.4) => page.evaluate(([at, count, variable, begin, width]) => {
  const canvas = document.querySelector('#trace-plot');
  const hex = getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
  const wanted = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const height = Math.floor((canvas.height - 22 * devicePixelRatio) / count);
  const left = Math.floor(canvas.width * begin);
  const { data } = canvas.getContext('2d').getImageData(left, at * height + 1, Math.floor(canvas.width * width), height - 2);
  let found = 0;
  for (let i = 0; i < data.length; i += 4) found += wanted.every((c, k) => Math.abs(data[i + k] - c) < 3) ? 1 : 0;
  return found;
}, [lane, lanes, name, from, part]);

// The first one: the service has just begun.
test('a page that was opened as the service began keeps all that is in view', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(bench.url);
  await page.waitForSelector('#traces:not([hidden])');
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
  await until(async () => (await bench.get('/api/v1/traces?points=1')).newest_s >= 14);
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
  await until(async () => await lanePixels(page, 1, 5, '--ink', 0.1, 0.3) > 0); // the older part of the view
  await page.close();
});

test('the trace of a channel that has stopped turns grey and says how old it is, the others go on', async () => {
  const page = await open();
  for (let i = 0; i < 3; ++i) await page.click('#trace-out'); // 80 s: what is old stays in view
  await said(page, '#trace-what', /80 s in view, live/);
  bench.rig.say('stuck y2 on');
  await said(page, '#trace-what', /live: .*; old: y2 \(last reading [\d.]+ s ago\)$/);
  await page.waitForFunction(() => /y2 \((last reading [3-9])/.test(document.querySelector('#trace-what').innerText));
  // Alarms above have pushed the plot down. It is drawn only where it is seen, and a frame after the text.
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
  await until(async () => await lanePixels(page, 2, 5, '--ink') === 0);
  assert.ok(await lanePixels(page, 2, 5, '--old') > 0);
  assert.ok(await lanePixels(page, 1, 5, '--ink') > 0);
  bench.rig.say('stuck y2 off');
  await page.waitForFunction(() => !/old/.test(document.querySelector('#trace-what').innerText));
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.close();
});

test('when the stream of traces ends, all of them turn grey, with their age in place of "now"', async () => {
  const page = await open();
  bench.service.signal('SIGSTOP');
  await said(page, '#trace-what', /in view, old, from [\d.]+ s ago: /);
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
  await until(async () => await lanePixels(page, 1, 5, '--ink') === 0);
  bench.service.signal('SIGCONT');
  await said(page, '#trace-what', /in view, live: /);
  await page.close();
});

test('readings, and readings less the steady part, are never shown under the other name', async () => {
  const page = await open();
  await page.check('#trace-less');
  await said(page, '#trace-what', /live: readings less the steady part of dwell/);
  let release;
  const held = new Promise((done) => (release = done));
  await page.route(/traces\?(?!.*less)/, async (route) => {
    await held;
    await route.continue();
  });
  const [asked] = await Promise.all([page.waitForRequest(/traces\?(?!.*less)/), page.uncheck('#trace-less')]);
  assert.ok(asked);
  assert.match(await page.locator('#trace-what').innerText(), /less the steady part/, 'what is in view still is of that kind');
  release();
  await said(page, '#trace-what', /live: readings, least/);
  await page.unrouteAll({ behavior: 'ignoreErrors' });

  await page.check('#trace-less');
  await said(page, '#trace-what', /less the steady part/);
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#trace-save')]);
  assert.match(download.suggestedFilename(), /^traces-less-steady-part-of-dwell-\d+-\d{8}T\d{6}Z\.csv$/);
  assert.match((await readFile(await download.path(), 'utf8')).split('\n')[0], /y0( min in [\d.]+ m?s)? less steady part of dwell \d+ fitted from [\d.]+ s \[mm\]/);
  await page.close();
});

test('a question for traces is given up, asked again, and the trouble is gone when it is answered', async () => {
  const page = await open();
  await page.click('#trace-pause');
  await page.route('**/api/v1/traces?*', () => {}); // never answered
  await page.click('#trace-back');
  await said(page, '#trace-trouble', /^The traces in view are not complete: no answer of the service/);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.waitForFunction(() => document.querySelector('#trace-trouble').textContent === '');
  await page.close();
});

test('a button is disabled while its order is under way, and keeps the focus', async () => {
  const page = await open();
  await logIn(page);
  let release;
  const held = new Promise((done) => (release = done));
  await page.route('**/api/v1/rearm', async (route) => {
    await held;
    await route.fulfill({ status: 409, json: { error: 'not now', status: 409 } });
  });
  page.on('dialog', (dialog) => dialog.accept());
  await page.focus('#operate-rearm');
  const [sent] = await Promise.all([page.waitForRequest('**/api/v1/rearm'), page.keyboard.press('Enter')]);
  assert.ok(sent);
  assert.equal(await page.locator('#operate button:enabled').count(), 0);
  release();
  await said(page, '#operate-said', /^Not done: not now/);
  assert.equal(await page.locator('#operate button:disabled').count(), 0);
  assert.equal(await page.evaluate(() => document.activeElement.id), 'operate-rearm');
  await page.close();
});

test('when nobody is logged in any longer, everything is old since the last answer, and the state says why', async () => {
  const page = await open();
  await page.locator('#channel-rows tr').first().waitFor();
  await page.route('**/api/v1/**', (route) => route.fulfill({ status: 401, json: { error: 'needs the token', status: 401 } }));
  await page.waitForSelector('#state[data-kind=locked][data-tone=alarm]');
  await said(page, '#detail', /^what is shown is [\d.]+ s old; log in below to read/);
  await page.waitForFunction(() => !document.querySelector('#channel-rows tr:not(.struck), #device-rows tr:not(.struck), .coefficient .number:not(.struck)'));
  await said(page, '#device-rows th', /^amplifier, [\d.]+ s old$/);
  await said(page, '#trace-what', /old, from/);
  await page.locator('#operate-login').waitFor();
  assert.equal(await page.locator('#operate-acts').isVisible(), false);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.waitForFunction(() => !document.querySelector('#channel-rows .struck, #device-rows .struck'));
  await page.close();
});

test('channels that are no longer answered are struck, although the stream goes on', async () => {
  const page = await open();
  await page.locator('#channel-rows tr').first().waitFor();
  await page.route('**/api/v1/channels', (route) => route.fulfill({ status: 500, json: { error: 'no', status: 500 } }));
  await said(page, '#troubles', /channels, devices and alarms are [\d.]+ s old/);
  await page.waitForFunction(() => !document.querySelector('#channel-rows tr:not(.struck)'));
  await page.waitForFunction(() => document.querySelector('.coefficient .number:not(.struck)')); // the stream keeps these fresh
  await page.close();
});

test('after a logout the page begins anew: nothing that was read stays in it', async () => {
  const page = await open();
  await logIn(page);
  await page.evaluate(() => (window.before = true));
  await page.click('#operate-logout');
  await page.waitForFunction(() => window.before === undefined);
  await page.locator('#operate-login').waitFor();
  await page.close();
});

// It said only "logged out": nobody saw why.
test('whoever the restart of the service has logged out is told so', async () => {
  const page = await open();
  await logIn(page);
  await bench.service.end();
  await bench.startService();
  await said(page, '#operate-said', /^The service was started anew: log in again\.$/);
  await page.locator('#operate-login').waitFor();
  await page.waitForSelector('#state[data-kind=measuring]');
  // Where nothing may be read without the token the first line says it.
  await logIn(page);
  let answer = (route) => route.abort('connectionrefused');
  await page.route('**/api/v1/**', (route) => answer(route));
  await said(page, '#troubles', /channels, devices and alarms are [\d.]+ s old/);
  answer = (route) => route.fulfill({ status: 401, json: { error: 'needs the token', status: 401 } });
  await said(page, '#detail', /; the service was started anew: log in again below to read$/);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

const isStruck = (page, selector) => page.evaluate((s) => {
  const nodes = [...document.querySelectorAll(s)].filter((node) => node.innerText !== '');
  const lined = (node) => node !== document.body && (getComputedStyle(node).textDecorationLine === 'line-through' || lined(node.parentElement));
  return nodes.length > 0 && nodes.every(lined);
}, selector);

// The stream sends its first event and then nothing. Every request is answered.
async function openStalled() {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  const moved = { stiffness: { change: 0.011, U95: 0.012, moved: false }, damping: { change: 0.02, U95: 0.03, moved: false } };
  const { start_utc } = dwellOf();
  const dwell = dwellOf({ since: { index: 2, start_utc, end_s: 8, elements: [1, 2].map((k) => ({ k, ...moved })) },
    limits: [{ element: 1, coefficient: 'stiffness', low: 1, high: 2, unit: 'N/m', verdict: 'violated', reason: null }] });
  await page.route('**/api/v1/stream?traces', (route) => route.fulfill({ contentType: 'text/event-stream',
    body: `retry: 600000\nevent: dwell\ndata: ${JSON.stringify(dwell)}\n\n` }));
  await page.goto(bench.url);
  return page;
}

test('when the stream says nothing more, all that it told is marked as old, in the head as well', async () => {
  const page = await openStalled();
  await said(page, '#facts', /limits\s*1 violated/);
  assert.equal(await isStruck(page, '#detail'), false);
  await said(page, '#troubles', /^old numbers, from [\d.]+ s ago: the service answers/);
  for (const fact of ['limits', 'dwell', 'frequency'])
    assert.equal(await page.locator('#facts > .struck', { hasText: new RegExp(`^${fact}`) }).count(), 1, fact);
  assert.equal(await page.locator('#facts > .struck', { hasText: /^run/ }).count(), 0, 'that is asked for');
  assert.equal(await isStruck(page, '#detail'), true);
  assert.match(await page.locator('#state p').innerText(), /^measuring 10\.0 s of data last seen [\d.]+ s ago$/);
  await said(page, '.element:first-child .coefficient:first-child .deviation', /^\+1\.1 ± 1\.2 % since dwell 2$/);
  assert.equal(await isStruck(page, '.deviation'), true);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

test('when the service is gone, the status of a channel is struck as its reading is', async () => {
  const page = await open();
  const status = '#channel-rows td:nth-child(2) span';
  // Where the machine was too busy for a moment, the readings of then are left out, and that is said for the whole dwell.
  await page.locator(status, { hasText: /^(ok$|gated: left out of )/ }).first().waitFor();
  assert.equal(await isStruck(page, status), false);
  bench.service.signal('SIGSTOP');
  await page.waitForSelector('#state[data-kind=gone]');
  await page.waitForFunction(() => !document.querySelector('#channel-rows tr:not(.struck)'));
  assert.equal(await isStruck(page, status), true);
  assert.equal(await isStruck(page, '#channel-rows td:nth-child(4) span'), false, 'the age goes on');
  bench.service.signal('SIGCONT');
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.close();
});

test('a dwell that has ended makes no trace old: less its steady part nothing is shown, and why is said', async () => {
  const page = await open();
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.check('#trace-less');
  await said(page, '#trace-what', /live: readings less the steady part of dwell/);
  bench.rig.say('stop');
  await said(page, '#trace-what', /less the steady part of dwell \d+, which ended [\d.]+ s ago: nothing is shown since then/);
  assert.doesNotMatch(await page.locator('#trace-what').innerText(), /old: /);
  bench.rig.say('start');
  await page.uncheck('#trace-less');
  await said(page, '#trace-what', /in view, live: readings, /);
  await page.close();
});

// The last two: the service begins anew.
test('a paused view of a service that has begun anew says so and is live again', async () => {
  const page = await open();
  await page.click('#trace-pause');
  await said(page, '#trace-what', /paused/);
  await bench.service.end();
  await bench.startService();
  await said(page, '#trace-news', /^The traces begin anew at \d\d:\d\d:\d\d\.\d+ UTC: .* What was in view is of before\.$/);
  await said(page, '#trace-what', /in view, live: /);
  await page.close();
});

test('a service that begins anew with another rig leaves no number of the rig before on an open page', async () => {
  const page = await open();
  bench.rig.say('stop');
  await page.waitForSelector('#coefficients[data-source=last] .element');
  await bench.service.end();
  bench.rigText = bench.rigText.replace(/^masses .*/m, 'masses = [24.0, 16.0, 10.0]');
  await bench.startService();
  await page.waitForSelector('#state[data-kind=idle]');
  await page.waitForSelector('#coefficients[data-source=none]');
  assert.equal(await page.locator('.element').count(), 0);
  await page.close();
});
