// The page open for an hour, which passes as fast as the page takes it: what it keeps does not grow.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, SIZES } from './bench.js';
import { ScriptedService, STEP_S } from './scripted.js';

const MINUTES = 60;
const TEN = 10;
// Until the lists have come that are asked for each 10 s, and what was needed to begin is gone.
const FIRST_MINUTES = 2;
// The smallest thing that can be kept for nothing: a number, in V8's heap. One at each step is to be found.
const NUMBER_BYTES = 12;

let browser;
let service;
before(async () => {
  // V8 compiles what runs often, for half an hour: that is no growth of what the page keeps, and would hide it.
  [browser, service] = await Promise.all([openBrowser(['--js-flags=--jitless']), ScriptedService.begin()]);
});
after(async () => {
  await Promise.all([browser?.close(), service?.end()]);
});

const mean = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;

test('an hour open costs no heap: after forced collection the last ten minutes have what the first ten had', async () => {
  const complaints = [];
  const page = await service.open(browser, SIZES.desk);
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  const session = await page.context().newCDPSession(page);
  await service.play(60 * FIRST_MINUTES);
  const heaps = [];
  const nodes = [];
  for (let minute = 0; minute < MINUTES; ++minute) {
    await service.play(60);
    await session.send('HeapProfiler.collectGarbage');
    const { usedSize, backingStorageSize } = await session.send('Runtime.getHeapUsage');
    heaps.push(usedSize + backingStorageSize); // typed arrays lie beside V8's heap
    nodes.push((await session.send('Memory.getDOMCounters')).nodes);
  }
  assert.deepEqual(complaints, []);
  // That this was an hour of measuring, with all that moves.
  assert.match(await page.locator('#word').innerText(), /^measuring$/);
  assert.match(await page.locator('#detail').innerText(), /^3718\.0 s of data$/);
  assert.equal(await page.locator('.struck').count(), 0);
  assert.equal(await page.locator('.trend .middle[d^=M]').count(), 14);

  const [first, last] = [mean(heaps.slice(0, TEN)), mean(heaps.slice(-TEN))];
  console.log(`heap ${(first / 1e6).toFixed(3)} MB in the first ten minutes, ${(last / 1e6).toFixed(3)} MB in the last ten; ${nodes[0]} and ${nodes.at(-1)} nodes`);
  const steps = 60 * (MINUTES - TEN) / STEP_S; // between the middles of both
  assert.ok(last - first < NUMBER_BYTES * steps, `${((last - first) / 1e3).toFixed(1)} kB more`);
  assert.ok(nodes.at(-1) <= Math.max(...nodes.slice(0, TEN)), `${nodes.at(-1)} nodes, ${Math.max(...nodes.slice(0, TEN))} at first`);
});
