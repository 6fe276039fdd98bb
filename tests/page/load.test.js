// What the page costs a browser: eight traces, fourteen coefficients and the shape, all live at 20 Hz. It prints its figures,
// which depend on the machine. What is far beyond the budget fails. So does a stream that is far slower than a timer of the
// same period in this process, and a drawing that is far slower than the browser asks for: these wait for the same processors.
// DWELL_HEAP_MINUTES=60 watches the heap for an hour. It is collected by force each minute. The least size in the first sixth
// of the time is compared with the least in the last sixth.
// DWELL_JITLESS=1: without V8's compilers, whose code would hide what the page itself keeps.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Bench, chainOf, openBrowser, PATIENCE_MS, SIZES } from './bench.js';

const UPDATE_S = 0.05; // between estimates, and between two events of traces
const MEASURED_S = 5; // of the stream: a stream that stands still never gets there
// The least rate of each, over the rate of the timer. The browser may draw two events in one picture.
const LEAST = { traces: 0.75, dwells: 0.75, pictures: 0.5 };
const BUDGET = 0.25; // of the renderer's time, s per second
const LOOSE = 3; // a busy machine takes somewhat more of the thread's own time: its caches are shared
const HEAP_MINUTES = Number(process.env.DWELL_HEAP_MINUTES ?? 0);
const JITLESS = process.env.DWELL_JITLESS === '1';

// Counts what the stream brings and what is drawn, before the page's own code runs. to_s: how far the traces have come, on
// their axis. The data tell how many events are due: by a clock, a machine that was suspended would be due some.
function countInBrowser() {
  const count = { traces: 0, dwells: 0, pictures: 0, to_s: 0 };
  window.count = count;
  const { EventSource: Stream, CanvasRenderingContext2D: Context } = window;
  window.EventSource = class extends Stream {
    constructor(url) {
      super(url);
      this.addEventListener('traces', ({ data }) => {
        const { first, bins, step_s } = JSON.parse(data);
        count.to_s = (first + bins) * step_s;
        count.traces += 1;
      });
      for (const name of ['dwell', 'change']) this.addEventListener(name, () => (count.dwells += 1));
    }
  };
  const { setTransform } = Context.prototype; // once for each picture
  Context.prototype.setTransform = function (...numbers) {
    count.pictures += 1;
    return setTransform.apply(this, numbers);
  };
}

let browser;
let bench;
let page;
let session;
before(async () => {
  const chain = chainOf(6);
  const edit = (text) => chain.edit(text).replace(/^update .*/m, `update = ${UPDATE_S}`);
  [browser, bench] = await Promise.all([openBrowser(JITLESS ? ['--js-flags=--jitless'] : []), Bench.begin({ ...chain, edit })]);
  bench.rig.say('start');
  page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.addInitScript(countInBrowser);
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

// Pictures a second that the browser asks for beside all else that the machine does.
const framesAsked = () => page.evaluate(() => new Promise((done) => {
  let frames = 0;
  const began = performance.now();
  const next = () => {
    frames += 1;
    if (performance.now() - began < 2000) requestAnimationFrame(next);
    else done(frames / 2);
  };
  requestAnimationFrame(next);
}));

test('the renderer draws eight traces and all coefficients, 20 times a second', async () => {
  assert.equal((await bench.get('/api/v1/channels')).channels.length, 8);
  const counted = () => page.evaluate(() => ({ ...window.count }));
  let ticks = 0;
  const timer = setInterval(() => (ticks += 1), 1e3 * UPDATE_S);
  const [from, before, began] = [await metrics(), await counted(), performance.now()];
  await page.waitForFunction((to_s) => window.count.to_s >= to_s, before.to_s + MEASURED_S, { polling: 500 }); // at each picture it would be a load of its own
  const [to, now, seconds] = [await metrics(), await counted(), (performance.now() - began) / 1e3];
  clearInterval(timer);
  const timer_hz = Math.min(1 / UPDATE_S, ticks / seconds);
  const share = (name) => ((to[name] - from[name]) / seconds).toFixed(3);
  const rate = (what) => (now[what] - before[what]) / (now.to_s - before.to_s);
  console.log(`renderer with 8 traces at 20 Hz: tasks ${share('TaskDuration')}, of these scripts ${share('ScriptDuration')}, layout ${
    share('LayoutDuration')}, style ${share('RecalcStyleDuration')} s per second; a second had ${
    ['traces', 'dwells', 'pictures'].map((what) => `${rate(what).toFixed(1)} ${what}`).join(', ')}; the timer ${timer_hz.toFixed(1)} turns`);
  for (const [what, least] of Object.entries(LEAST)) {
    let due = timer_hz;
    if (what === 'pictures' && rate(what) < least * due) due = Math.min(due, await framesAsked());
    assert.ok(rate(what) >= least * due, `${rate(what).toFixed(1)} ${what} a second of the data, ${due.toFixed(1)} are due`);
  }
  assert.ok(Number(share('TaskDuration')) < LOOSE * BUDGET, `${share('TaskDuration')} s per second, ${BUDGET} are allowed`);
});

test('the heap does not grow but for compiled code', { skip: HEAP_MINUTES < 1 }, async () => {
  const sizes = [];
  for (let minute = 0; minute < HEAP_MINUTES; ++minute) {
    await wait(60_000);
    await session.send('HeapProfiler.collectGarbage');
    sizes.push((await metrics()).JSHeapUsedSize / 1e6);
    // The page keeps the newest events: on a busy machine the rig has more of them as the hour goes on.
    console.log(`minute ${minute + 1}: ${sizes.at(-1).toFixed(2)} MB, ${(await bench.get('/api/v1/events')).total} events`);
  }
  const sixth = Math.max(1, Math.floor(sizes.length / 6));
  // The least: some collections come while an answer is being read.
  const [first, last] = [Math.min(...sizes.slice(0, sixth)), Math.min(...sizes.slice(-sixth))];
  // V8 compiles what runs often: 0.3 MB in an hour.
  assert.ok(last - first < (JITLESS ? 0.05 : 0.5), `${first.toFixed(2)} MB at first, ${last.toFixed(2)} MB at last`);
});
