// What the page costs a browser: eight traces, fourteen coefficients and the shape, all live. It prints its figures, which
// depend on the machine; only what is far beyond the budget fails. DWELL_HEAP_MINUTES=60 watches the heap for an hour. It is collected by
// force each minute. The least size in the first sixth of the time is compared with the least in the last sixth.
// DWELL_JITLESS=1: without V8's compilers, whose code would hide what the page itself keeps.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Bench, chainOf, openBrowser, PATIENCE_MS, SIZES } from './bench.js';

const MEASURED_MS = 5000;
const BUDGET = 0.25; // of the renderer's time, s per second
const LOOSE = 3; // a busy machine takes somewhat more of the thread's own time: its caches are shared
const HEAP_MINUTES = Number(process.env.DWELL_HEAP_MINUTES ?? 0);
const JITLESS = process.env.DWELL_JITLESS === '1';

let browser;
let bench;
let page;
let session;
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(JITLESS ? ['--js-flags=--jitless'] : []), Bench.begin(chainOf(6))]);
  bench.rig.say('start');
  page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(3 * PATIENCE_MS);
  session = await page.context().newCDPSession(page);
  // The thread's own time: a busy machine makes nothing dearer.
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  await page.goto(bench.url);
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  await page.waitForSelector('#chain:not([hidden])');
  await page.locator('#trace-plot').scrollIntoViewIfNeeded();
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

const metrics = async () => Object.fromEntries((await session.send('Performance.getMetrics')).metrics.map((m) => [m.name, m.value]));
const wait = (ms) => new Promise((done) => setTimeout(done, ms));

test('the renderer draws eight traces and all coefficients', async () => {
  assert.equal((await bench.get('/api/v1/channels')).channels.length, 8);
  const [from, began] = [await metrics(), performance.now()];
  await wait(MEASURED_MS);
  const [to, seconds] = [await metrics(), (performance.now() - began) / 1e3];
  const share = (name) => ((to[name] - from[name]) / seconds).toFixed(3);
  console.log(`renderer with 8 traces at 20 Hz: tasks ${share('TaskDuration')}, of these scripts ${share('ScriptDuration')}, layout ${
    share('LayoutDuration')}, style ${share('RecalcStyleDuration')} s per second`);
  assert.ok(Number(share('TaskDuration')) < LOOSE * BUDGET, `${share('TaskDuration')} s per second, ${BUDGET} are allowed`);
});

test('the heap does not grow but for compiled code', { skip: HEAP_MINUTES < 1 }, async () => {
  const sizes = [];
  for (let minute = 0; minute < HEAP_MINUTES; ++minute) {
    await wait(60_000);
    await session.send('HeapProfiler.collectGarbage');
    sizes.push((await metrics()).JSHeapUsedSize / 1e6);
    console.log(`minute ${minute + 1}: ${sizes.at(-1).toFixed(2)} MB`);
  }
  const sixth = Math.max(1, Math.floor(sizes.length / 6));
  // The least: some collections come while an answer is being read.
  const [first, last] = [Math.min(...sizes.slice(0, sixth)), Math.min(...sizes.slice(-sixth))];
  // V8 compiles what runs often: 0.3 MB in an hour.
  assert.ok(last - first < (JITLESS ? 0.05 : 0.5), `${first.toFixed(2)} MB at first, ${last.toFixed(2)} MB at last`);
});
