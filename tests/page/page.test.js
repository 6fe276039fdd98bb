// The page in Chromium, fed by the real service on a simulated rig. Waiting is for what must come, never for a time.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Bench, openBrowser, PATIENCE_MS, SIZES } from './bench.js';
import { dwellOf, idleOf, settlingOf, warningOf } from './sample.js';

let browser;
let bench;
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(), Bench.begin()]);
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

// A page of this size, shown; whatever the browser complains of (the policy, a file, our own code) fails the test.
// before: run in the browser before the page's own code.
async function openPage(at, { size = 'desk', query = '', before: first = () => {} } = {}) {
  const page = await browser.newPage({ viewport: SIZES[size] });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.addInitScript(first);
  page.complaints = [];
  page.on('pageerror', (error) => page.complaints.push(error.message));
  page.on('console', (message) => {
    // A service that is gone or tells of its trouble (503) is the situation, not a fault of the page. One that has begun
    // anew does not know a dwell of before (404).
    const { url } = message.location();
    if (message.type() !== 'error' || /status of 503|ERR_CONNECTION|ERR_INCOMPLETE|ERR_EMPTY|ERR_SOCKET/.test(message.text())) return;
    if (!(/status of 404/.test(message.text()) && /[/]api[/]v1[/]dwells[/][0-9]+$/.test(url))) page.complaints.push(`${message.text()} ${url}`);
  });
  await page.goto(`${at.url}/${query}`);
  return page;
}

async function closePage(page) {
  assert.deepEqual(page.complaints, []);
  await page.close();
}

const kind = (page, wanted) => page.waitForSelector(`#state[data-kind=${wanted}]`);
const textOf = (page, selector) => page.locator(selector).first().innerText();
const texts = (page, selector) => page.locator(selector).allInnerTexts();

// In the browser: when something of the service first stood on the page, ms after the page was asked for; a picture of the
// page without a number comes before. null: not yet.
function noteFirst() {
  window.firsts = { state: null, coefficient: null, traces: null };
  const is = { state: '#state[data-kind]:not([data-kind=connecting])', coefficient: '.coefficient .value:not(:empty)', traces: '#traces:not([hidden])' };
  new MutationObserver(() => requestAnimationFrame((at) => {
    for (const [what, selector] of Object.entries(is))
      if (window.firsts[what] === null && document.querySelector(selector)) window.firsts[what] = at;
  })).observe(document, { subtree: true, childList: true, attributes: true, characterData: true });
}

// Opens the page anew and tells its times and bytes.
async function timesOf(...wanted) {
  const page = await openPage(bench, { before: noteFirst });
  await page.waitForFunction((all) => all.every((what) => window.firsts[what] !== null), wanted);
  if (wanted.includes('traces')) await page.locator('#trace-what', { hasText: /least and greatest in/ }).waitFor(); // an answer has come
  const times = await page.evaluate(() => ({ ...window.firsts, picture: performance.getEntriesByName('first-contentful-paint')[0].startTime,
    bytes: [...performance.getEntriesByType('resource'), ...performance.getEntriesByType('navigation')]
      .reduce((sum, entry) => sum + entry.transferSize, 0) }));
  console.log(`first picture after ${times.picture.toFixed(0)} ms, state in words after ${times.state.toFixed(0)} ms, first coefficient ${
    times.coefficient === null ? 'not yet' : `after ${times.coefficient.toFixed(0)} ms`}, ${(times.bytes / 1000).toFixed(0)} kB transferred so far`);
  await closePage(page);
  return times;
}

test('the page and the state in words are there within a few hundred milliseconds and kilobytes', async () => {
  const { state, bytes } = await timesOf('state');
  assert.ok(bytes > 10_000 && bytes < 300_000, `${bytes} bytes`);
  assert.ok(state < 10_000, 'asked for: 1 s; a busy machine takes longer');
});

test('a dwell settles and is measured: each coefficient with ± and unit', async () => {
  const page = await openPage(bench);
  await kind(page, 'idle');
  assert.match(await textOf(page, '#coefficients-none'), /^No coefficients: /);
  bench.rig.say('start');
  await kind(page, 'measuring');
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  assert.equal(await textOf(page, '#rig'), 'clamped bench, three masses');
  assert.match(await textOf(page, '#facts'), /frequency\s+[34]\.\d+ ± 0\.\d+ Hz/);
  // In the first second of a dwell a drive may not look steady yet: one in a few hundred on a busy machine.
  await page.waitForFunction(() => !document.querySelector('.coefficient .number.doubted'));
  const numbers = await texts(page, '.coefficient .number');
  assert.equal(numbers.length, 8);
  for (const [i, number] of numbers.entries()) assert.match(number, i % 2 ? /^\d+(\.\d+)? ± \d+(\.\d+)? N·s\/m$/ : /^\d+\.\d+ ± \d\.\d+ kN\/m$/);
  assert.equal(await page.locator('.struck').count(), 0);
  assert.match(await page.title(), /^measuring · clamped bench/);

  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable');
  const metric = async (name) => (await session.send('Performance.getMetrics')).metrics.find((m) => m.name === name).value;
  const dataOf = async () => Number((await textOf(page, '#detail')).match(/^[\d.]+/)[0]);
  const [t0, task0, data0] = [await metric('Timestamp'), await metric('TaskDuration'), await dataOf()];
  await page.waitForFunction((least) => parseFloat(document.querySelector('#detail').innerText) > least, data0 + 5);
  const share = (await metric('TaskDuration') - task0) / (await metric('Timestamp') - t0);
  console.log(`renderer's task time ${share.toFixed(3)} s per second at 10 updates a second`);
  await closePage(page);
});

// Bytes were counted only until the state stood in words: until the coefficients did, 440 kB had come.
test('while it is measured the first coefficient is there as soon, and with the traces the page takes few kilobytes', async () => {
  const { state, coefficient, bytes } = await timesOf('coefficient', 'traces');
  assert.ok(bytes > 10_000 && bytes < 300_000, `${bytes} bytes`);
  assert.ok(coefficient >= state && coefficient < 10_000, 'asked for: 1 s; a busy machine takes longer');
});

test('while it settles, coefficients from the transient are marked as such', async () => {
  // The service's own would come late on a busy machine: here the stream tells of some.
  const page = await browser.newPage({ viewport: SIZES.desk });
  const dwell = settlingOf({ motion: { start_s: 0.6, end_s: 3.9, elements: dwellOf().elements } });
  await page.route('**/api/v1/stream?traces', (route) =>
    route.fulfill({ contentType: 'text/event-stream', body: `event: dwell\ndata: ${JSON.stringify(dwell)}\n\n` }));
  await page.goto(bench.url);
  await page.waitForSelector('#coefficients[data-source=transient] .element');
  assert.match(await textOf(page, '#coefficients-from'), /^provisional · from the transient, 0\.6 to 3\.9 s/);
  assert.match(await textOf(page, '.coefficient .number'), /^24\.000 ± 0\.024 kN\/m$/);
  await page.close();
});

test('the device dies: the numbers are struck through with their age, the cause is named once for all channels', async () => {
  const page = await openPage(bench);
  await kind(page, 'measuring');
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  bench.rig.signal('SIGSTOP');
  await kind(page, 'fault');
  await page.waitForSelector('#coefficients[data-source=last] .coefficient .number.struck');
  const struck = await texts(page, '.coefficient .number');
  assert.equal(struck.length, 8);
  for (const number of struck) assert.match(number, /± .* (\d+|\d\.\d) s old$/);
  await page.locator('#troubles li', { hasText: /^channels y0, y1, y2, y3, reaction: / }).waitFor();
  // Whoever opens the page now sees the same.
  const late = await openPage(bench);
  await kind(late, 'fault');
  bench.rig.signal('SIGCONT');
  await kind(page, 'measuring');
  await page.waitForFunction(() => !document.querySelector('.struck') && document.querySelector('#troubles').hidden);
  await closePage(late);
  await closePage(page);
});

test('the drive stops: idle, and the last dwell stays with how it ended', async () => {
  const page = await openPage(bench);
  await kind(page, 'measuring');
  bench.rig.say('stop');
  await kind(page, 'idle');
  await page.waitForSelector('#coefficients[data-source=last] .element');
  assert.equal(await page.locator('.coefficient .struck').count(), 0);
  // The live numbers of the last seconds hold data of after the stop: those of the ended dwell have replaced them.
  await page.waitForFunction(() => {
    const plain = (node) => node.textContent.replace(/\s+/g, ' ').trim();
    const numbers = [...document.querySelectorAll('.coefficient .number')].map(plain);
    const row = document.querySelector('#dwell-rows tr');
    return numbers.length === 8 && row !== null && numbers.every((number) => [...row.cells].some((cell) => plain(cell) === number));
  });
  // Whoever opens the page now sees the warnings of that dwell with its numbers, and those of now apart.
  const late = await browser.newPage({ viewport: SIZES.desk });
  const hum = warningOf([{ kind: 'hum', text: 'hum at 50 Hz' }]);
  await late.route('**/api/v1/dwells/*', async (route) => route.fulfill({ json: { ...await (await route.fetch()).json(), ...hum } }));
  const idle = idleOf({ ...warningOf([{ kind: 'readings', text: 'y1 is gated' }]), start_utc: (await bench.get('/api/v1/dwell')).start_utc });
  await late.route('**/api/v1/stream?traces', (route) =>
    route.fulfill({ contentType: 'text/event-stream', body: `event: dwell\ndata: ${JSON.stringify(idle)}\n\n` }));
  await late.goto(bench.url);
  await late.locator('#warnings li', { hasText: /^hum at 50 Hz$/ }).waitFor({ timeout: PATIENCE_MS });
  assert.deepEqual(await texts(late, '#warnings li'), ['hum at 50 Hz']);
  assert.equal(await textOf(late, '#now-warnings-title'), 'Warnings of now, not of that dwell:');
  assert.deepEqual(await texts(late, '#now-warnings li'), ['y1 is gated']);
  await late.unrouteAll({ behavior: 'ignoreErrors' });
  await late.close();
  bench.rig.say('start');
  await kind(page, 'measuring');
  await closePage(page);
});

test('the service hangs or is killed: the page says so by its own clock, and comes back by itself', async () => {
  const page = await openPage(bench);
  await kind(page, 'measuring');
  for (const signal of ['SIGSTOP', 'SIGKILL']) {
    await page.waitForSelector('#coefficients[data-source=measured] .element');
    bench.service.signal(signal);
    const from = Date.now();
    await kind(page, 'gone');
    console.log(`${signal}: shown as gone after ${((Date.now() - from) / 1e3).toFixed(1)} s`);
    // If the dwell ended at that very moment there is no number; none may be left as if it were of now.
    await page.waitForFunction(() => !document.querySelector('.coefficient .number:not(.struck)'));
    for (const number of await texts(page, '.coefficient .number')) assert.match(number, / s old$/);
    if (signal === 'SIGSTOP') bench.service.signal('SIGCONT');
    else await bench.service.ended.then(() => bench.startService());
    await page.waitForFunction(() => document.querySelector('#state').dataset.kind !== 'gone');
    await kind(page, 'measuring');
    await page.waitForFunction(() => !document.querySelector('.coefficient .struck'));
  }
  await closePage(page);
});

// The last one: the table rests afterwards. Withheld coefficients came back as good ones.
test('the service is started again while coefficients are withheld: they stay withheld, with their reason', async () => {
  const page = await openPage(bench);
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  bench.rig.say('stuck y2 on');
  await page.waitForFunction(() => document.querySelectorAll('.element.withheld .number.struck').length === 6);
  const reasons = (await texts(page, '.reason:not([hidden])')).map((text) => text.replace(/\d[\d.]*/g, '#'));
  bench.service.signal('SIGKILL'); // first, so that it never tells how the dwell ended
  bench.rig.say('stop');
  await bench.service.ended;
  await kind(page, 'gone');
  await bench.startService();
  await page.locator('#coefficients[data-source=last] #coefficients-from', { hasText: /^not of now · last dwell: \d+, last seen [\d.]+ s ago$/ }).waitFor();
  assert.deepEqual((await texts(page, '.reason:not([hidden])')).map((text) => text.replace(/\d[\d.]*/g, '#')), reasons);
  assert.equal(await page.locator('.element.withheld .number.struck').count(), 6);
  await closePage(page);
});
