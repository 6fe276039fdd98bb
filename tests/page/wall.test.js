// A wall display has no hands to scroll: what stands on it, and what the note at its foot names.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { check } from './accessible.js';
import { SIZES, until } from './bench.js';
import { dwellOf, warningOf } from './sample.js';
import { scriptedPages } from './scripted_page.js';

const openScripted = scriptedPages();

// Channels of a clamped chain with this many elements.
const channelsOf = (elements) => [...Array.from({ length: elements }, (_, i) => `y${i}`), 'reaction'];
function measured(elements, changes = {}) {
  const element = dwellOf().elements[0];
  return dwellOf({ elements: Array.from({ length: elements }, (_, i) => ({ ...element, k: i + 1 })),
    phasors: channelsOf(elements).map((channel, c) => ({ channel, unit: channel === 'reaction' ? 'N' : 'm', valid: true, mean: 1e-3, harmonics: [2e-3, 7e-4],
      amplitude: 5e-3, phase_rad: 0.3 * c, u_amplitude: 1e-6, u_relative_phase_rad: 1e-4 })), ...changes });
}
// It is told again and again: shown.dwell may be set anew.
async function open(dwell) {
  const shown = await openScripted({ dwell, traced: channelsOf(dwell.elements.length), size: 'wall', query: '?kiosk',
    rights: { read: true, change: false, token: true }, options: { bypassCSP: true } });
  await shown.page.waitForSelector('.element');
  return shown;
}
const withheld = (k, reason) => ({ k, identifiable: false, budget: [], reason });

test('the coefficients of a usual rig are read from across the room, without scrolling', async () => {
  const shown = await open(measured(4));
  const { page } = shown;
  await page.waitForSelector('#traces:not([hidden])');
  const [overflow, letters] = await page.evaluate(() => [document.querySelector('#coefficients').getBoundingClientRect().bottom - window.innerHeight,
    parseFloat(getComputedStyle(document.querySelector('.coefficient .value')).fontSize)]);
  assert.ok(overflow <= 0, `${overflow} px of the coefficients are below the screen`);
  assert.ok(letters >= 28, `the numbers are ${letters} px high`);
  await shown.close();
});

// The traces had no room, for one verdict took a row of its own, and a scroll bar showed.
test('four elements with two limits, an alarm, the traces and the shape of the motion fit on a wall display', async () => {
  const model = { verdict: 'not verified yet', consistent: false, asked: 0.05, seen: 0.009, U: 0.071 };
  const limits = [2, 4].map((element) => ({ element, coefficient: 'stiffness', low: 7500, high: 8500, unit: 'N/m', verdict: 'kept' }));
  const shown = await open(measured(4, { model, limits }));
  const { page } = shown;
  const now = new Date().toISOString();
  const alarm = { name: 'clock', text: 'the computer\'s clock is not synchronized: dates may be wrong', state: 'unacknowledged', since: now, changed: now, count: 1, acknowledged_by: null, comment: null };
  await page.route('**/api/v1/alarms', (route) => route.fulfill({ json: { unacknowledged: 1, left_out: 0, alarms: [alarm] } }));
  await page.route('**/api/v1/channels', (route) => route.fulfill({ json: { channels: channelsOf(4).map((name, i) => ({ name, measures: i < 4 ? 'displacement' : 'force',
    at: i < 4 ? i : 'ground', relative_to: null, unit: 'mm', value: 1, status: 'ok', text: 'ok', age_s: 0.01 })) } }));
  await page.waitForFunction(() => document.querySelectorAll('.limit:not([hidden])').length === 2);
  for (const part of ['#alarm-line', '#traces', '#chain', '#phasors']) await page.waitForSelector(`${part}:not([hidden])`);
  await page.waitForFunction(() => document.documentElement.scrollHeight <= window.innerHeight && document.querySelector('#beyond').hidden);
  const seen = await page.evaluate(() => ['#trace-plot', '#shape-picture', '#polar', '#legend'].map((part) => {
    const node = document.querySelector(part);
    return getComputedStyle(node).visibility === 'visible' && node.getBoundingClientRect().height > 20 && node.getBoundingClientRect().bottom <= window.innerHeight;
  }));
  assert.deepEqual(seen, [true, true, true, true]);
  await check(page, 'usual-wall');
  await shown.close();
});

// The note said that there was no room for element 4, which it covered itself.
test('where the note at the foot would cover an element of a wall display, the elements are set closer', async () => {
  const shown = await open(measured(4));
  const { page } = shown;
  await page.waitForSelector('#traces:not([hidden])');
  assert.equal(await page.locator('html.compact').count(), 0);
  await page.evaluate(() => {
    const elements = document.querySelector('#elements');
    elements.style.marginTop = `${window.innerHeight - 4 - elements.getBoundingClientRect().bottom}px`;
  });
  await page.waitForSelector('html.compact, #beyond:not([hidden])');
  assert.equal(await page.locator('html.compact').count(), 1);
  assert.doesNotMatch(await page.locator('#beyond').innerText(), /element/); // nothing where the note is hidden
  await shown.close();
});

// At 1280 × 1024 the upper third of the strip showed above the note that there was no room for traces.
test('a wall display says that it has no room for traces exactly where none are seen', async () => {
  const warned = (count) => measured(4, warningOf(Array.from({ length: count }, (_, i) => ({ kind: 'hum', text: `a warning of the dwell, number ${i}` }))));
  const shown = await open(warned(4));
  const { page } = shown;
  await page.waitForSelector('#traces', { state: 'attached' });
  const seen = () => page.evaluate(() => {
    const [note, strip] = ['beyond', 'trace-plot'].map((id) => document.getElementById(id));
    return { named: !note.hidden && note.innerText.includes('traces'), seen: getComputedStyle(strip).visibility === 'visible',
      whole: strip.getBoundingClientRect().bottom <= (note.hidden ? window.innerHeight : note.getBoundingClientRect().top + 0.5) };
  });
  for (const [width, height, warnings, room] of [[1920, 1080, 4, true], [1920, 1080, 16, false], [1280, 1024, 16, true], [1440, 900, 16, false]]) {
    await page.setViewportSize({ width, height });
    shown.dwell = warned(warnings);
    // The note is looked at once a second.
    await until(async () => JSON.stringify(await seen()) === JSON.stringify({ named: !room, seen: room, whole: room }));
  }
  await shown.close();
});

test('the elements of a wall display are set closer for as long as warnings take their room', async () => {
  const shown = await open(measured(4));
  const reason = 'y2 is stuck: its reading has not changed for 2.4 s, 480 readings, while the others move; what depends on it is withheld';
  const warned = measured(4, warningOf(Array.from({ length: 12 }, (_, i) => ({ kind: 'hum', text: `a warning of the dwell, number ${i}` }))));
  warned.elements = warned.elements.map((element) => (element.k === 1 ? element : withheld(element.k, reason)));
  await shown.page.waitForFunction(() => !document.documentElement.classList.contains('compact'));
  const dwell = shown.dwell;
  shown.dwell = warned;
  await shown.page.waitForSelector('html.compact');
  await shown.page.waitForFunction(() => [...document.querySelectorAll('.element')].every((e) => e.getBoundingClientRect().bottom <= window.innerHeight));
  shown.dwell = dwell;
  await shown.page.waitForFunction(() => !document.documentElement.classList.contains('compact'));
  await shown.close();
});

// Three of the four elements have reasons, and the one that may be used was pushed off the screen.
test('a stuck transducer pushes no element of a usual rig off a wall display', async () => {
  const stuck = 'y2 is stuck: its reading has not changed for 2.4 s, 480 readings, while the others move';
  const dwell = measured(4, warningOf([{ kind: 'stuck', text: stuck, channels: ['y2'] }]));
  dwell.elements = dwell.elements.map((element) => (element.k === 4 ? element : withheld(element.k, `${stuck}; what depends on it is withheld`)));
  const shown = await open(dwell);
  const { page } = shown;
  await page.waitForFunction(() => document.querySelectorAll('.element.withheld').length === 3);
  await page.waitForFunction(() => [...document.querySelectorAll('.element')].every((e) => e.getBoundingClientRect().bottom <= window.innerHeight));
  const usable = await page.evaluate(() => [...document.querySelectorAll('.element:not(.withheld) .number')].map((n) => n.getBoundingClientRect().bottom <= window.innerHeight));
  assert.deepEqual(usable, [true, true]);
  const foot = page.locator('#beyond:not([hidden])');
  if (await foot.count()) assert.doesNotMatch(await foot.innerText(), /element/);
  await check(page, 'stuck-wall');
  await shown.close();
});

// Units ran under the next symbol at 1024 × 600, and three numbers lay on top of each other at 480 × 1200.
test('in a small or narrow window no number of a wall display lies on another one', async () => {
  const stuck = 'y1 is stuck: its reading has not changed for 2.4 s, 480 readings, while the others move';
  const dwell = measured(4, warningOf([{ kind: 'stuck', text: stuck, channels: ['y1'] }]));
  dwell.elements = dwell.elements.map((element) => (element.k > 2 ? element : withheld(element.k, `${stuck}; what depends on it is withheld`)));
  const shown = await open(dwell);
  const { page } = shown;
  const faults = () => page.evaluate(() => {
    const cells = [...document.querySelectorAll('.element:not(.withheld) .coefficient')];
    const boxes = cells.flatMap((cell) => [...cell.querySelectorAll('.symbol, .value, .pm, .unit')].flatMap((part) => [...part.getClientRects()].map((box) => ({ cell, part, box }))));
    const meet = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
    const over = boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) => a.cell !== b.cell && meet(a.box, b.box)).map((b) => `${a.part.innerText} on ${b.part.innerText}`));
    const card = document.querySelector('#coefficients').getBoundingClientRect();
    return [...over, ...boxes.filter(({ box }) => box.right > card.right).map(({ part }) => `${part.innerText} is cut off`)];
  });
  for (const [width, height] of [[1024, 600], [800, 600], [480, 1200], [360, 640]]) {
    await page.setViewportSize({ width, height });
    await until(async () => (await faults()).length === 0).catch(async () => assert.fail(`${width} × ${height}: ${await faults()}`));
  }
  await shown.close();
});

// The second alarm was readable nowhere: the head has the first one, and the list is below the screen.
test('alarms that find no room on a wall display are named at its foot, and no text of the head ends without a mark', async () => {
  const shown = await open(measured(4));
  const { page } = shown;
  await page.setViewportSize({ width: 800, height: 600 });
  const now = new Date().toISOString();
  const alarm = (name, text) => ({ name, text, state: 'unacknowledged', since: now, changed: now, count: 1, acknowledged_by: null, comment: null });
  const limit = 'limit violated: stiffness of element 2 is 7.999 ± 0.018 kN/m, outside 12.00 to 13.00 kN/m';
  let alarms = [alarm('limit:stiffness:2', limit), alarm('channel:y3', 'channel y3: timeout')];
  await page.route('**/api/v1/alarms', (route) => route.fulfill({ json: { unacknowledged: alarms.length, left_out: 0, alarms } }));
  await page.locator('#beyond', { hasText: /, alarm “channel:y3”$/ }).waitFor();
  const cut = () => page.evaluate(() => {
    const [line, text] = ['alarm-line', 'alarm-link'].map((id) => document.getElementById(id));
    return { cut: line.scrollHeight > line.clientHeight + 1 || text.getBoundingClientRect().right > line.getBoundingClientRect().right, mark: getComputedStyle(line).webkitLineClamp === '2' };
  });
  assert.deepEqual(await cut(), { cut: false, mark: true });
  assert.match(await page.locator('#alarms-how').innerText(), /^To acknowledge: log in to this page on another computer, without \?kiosk, or dwellctl acknowledge NAME/);
  alarms = [alarm('limit:stiffness:2', `${limit}; `.repeat(3)), ...alarms.slice(1)];
  await page.locator('#beyond', { hasText: /, alarms “limit:stiffness:2”, “channel:y3”$/ }).waitFor();
  assert.deepEqual(await cut(), { cut: true, mark: true });
  await shown.close();
});

test('thirteen elements fit on a wall display', async () => {
  const shown = await open(measured(13));
  const { page } = shown;
  await page.waitForSelector('#traces:not([hidden])');
  // All 26 numbers are on the screen, and none reaches into its neighbour.
  await page.waitForFunction(() => {
    const numbers = [...document.querySelectorAll('.coefficient .number')];
    return numbers.length === 26 && document.querySelector('#elements').getBoundingClientRect().bottom <= window.innerHeight &&
      numbers.every((n) => n.getBoundingClientRect().right <= n.closest('.coefficient').getBoundingClientRect().right + 1);
  });
  await check(page, 'many-wall');
  await shown.close();
});

test('thirty elements, all withheld: each is named on a wall display, a longer reason ends with …, what has no room is told', async () => {
  const rest = Array.from({ length: 30 }, (_, i) => withheld(i + 1,
    `the deformation (${i}.2 µm) is less than three times its uncertainty: drive it harder, or nearer to a resonance in which it deforms`));
  const shown = await open(dwellOf({ elements: rest, phasors: [] }));
  const { page } = shown;
  await page.waitForFunction(() => document.querySelectorAll('.element').length === 30);
  await page.waitForSelector('html.compact');
  const boxes = () => page.evaluate(() => [...document.querySelectorAll('.element')].map((e) => {
    const [box, reason] = [e.getBoundingClientRect(), e.querySelector('.reason')];
    return { named: e.querySelector('h3').getBoundingClientRect().width > 20, left: box.left, top: box.top, bottom: box.bottom,
      marked: getComputedStyle(reason).textOverflow === 'ellipsis' && reason.getBoundingClientRect().right <= box.right + 1 };
  }));
  const all = await boxes();
  all.forEach((a, i) => {
    assert.ok(a.named && a.marked && a.bottom <= SIZES.wall.height, `element ${i + 1}`);
    for (const b of all.slice(i + 1)) assert.ok(a.left !== b.left || a.bottom <= b.top + 1, 'none overlaps');
  });
  if (process.env.DWELL_PICTURES) await page.screenshot({ path: join(process.env.DWELL_PICTURES, 'withheld-wall.png') });
  const warnings = Array.from({ length: 30 }, (_, i) => ({ kind: 'hum', text: `a warning of the dwell, number ${i}` }));
  shown.dwell = { ...shown.dwell, ...warningOf(warnings) };
  await page.locator('#beyond', { hasText: /^▼ no room here for: warnings of the dwell/ }).waitFor();
  await shown.close();
});

