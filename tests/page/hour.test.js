// The page open for long, which passes as fast as the page takes it: what it keeps does not grow.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, SIZES } from './bench.js';
import { ScriptedService, STEP_S } from './scripted.js';

// Half an hour shows what grows as well as a whole one, which DWELL_PAGE_MINUTES=60 plays.
const MINUTES = Number(process.env.DWELL_PAGE_MINUTES ?? 30);
const SIXTH = MINUTES / 6;
// Until the lists have come that are asked for each 10 s, and what was needed to begin is gone.
const FIRST_MINUTES = 2;
// The smallest thing that can be kept for nothing: a number, in V8's heap. One at each step is to be found.
const NUMBER_BYTES = 12;
const STEPS = 60 * (MINUTES - SIXTH) / STEP_S; // from the first sixth to the last

let browser;
let service;
before(async () => {
  // Without V8's compilers: their code grows for half an hour and would hide what the page keeps.
  [browser, service] = await Promise.all([openBrowser(['--js-flags=--jitless']), ScriptedService.begin()]);
});
after(async () => {
  await Promise.all([browser?.close(), service?.end()]);
});

test('being open costs no heap: after forced collection the last sixth of the time has what the first had', async () => {
  const complaints = [];
  const page = await service.open(browser, SIZES.desk);
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  const session = await page.context().newCDPSession(page);
  await service.play(60 * FIRST_MINUTES);
  // The least heap of each sixth counts: answers under way are gone by then. V8 still makes bytecode late, once. So the
  // test fails only if the heap grows in two attempts in a row.
  let growth = Infinity;
  let attempts = 0;
  for (; attempts < 2 && growth >= NUMBER_BYTES * STEPS; ++attempts) {
    const heaps = [];
    const nodes = [];
    for (let minute = 0; minute < MINUTES; ++minute) {
      await service.play(60);
      await session.send('HeapProfiler.collectGarbage');
      const { usedSize, backingStorageSize } = await session.send('Runtime.getHeapUsage');
      heaps.push(usedSize + backingStorageSize); // typed arrays lie beside V8's heap
      nodes.push((await session.send('Memory.getDOMCounters')).nodes);
    }
    const [first, last] = [Math.min(...heaps.slice(0, SIXTH)), Math.min(...heaps.slice(-SIXTH))];
    console.log(`heap ${(first / 1e6).toFixed(3)} MB in the first ${SIXTH} minutes, ${(last / 1e6).toFixed(3)} MB in the last ${SIXTH}; ${nodes[0]} and ${nodes.at(-1)} nodes`);
    assert.ok(nodes.at(-1) <= Math.max(...nodes.slice(0, SIXTH)), `${nodes.at(-1)} nodes, ${Math.max(...nodes.slice(0, SIXTH))} at first`);
    growth = last - first;
  }
  assert.ok(growth < NUMBER_BYTES * STEPS, `${(growth / 1e3).toFixed(1)} kB more, twice`);

  assert.deepEqual(complaints, []);
  // That it was measuring, with all that moves.
  assert.match(await page.locator('#word').innerText(), /^measuring$/);
  assert.match(await page.locator('#detail').innerText(), new RegExp(`^${60 * (FIRST_MINUTES + attempts * MINUTES) - STEP_S}\\.0 s of data$`));
  assert.equal(await page.locator('.struck').count(), 0);
  assert.equal(await page.locator('.trend .middle[d^=M]').count(), 14);
});
