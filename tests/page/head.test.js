// The head stays on the screen and hides nothing that the keyboard or a link goes to (WCAG 2.2, 2.4.11).
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { SIZES } from './bench.js';
import { dwellOf, idleOf } from './sample.js';
import { scriptedPages } from './scripted_page.js';

const openScripted = scriptedPages();

// With an alarm, and the controls of one who may change something.
const ALARM = { name: 'limit:stiffness:2', text: 'limit violated: stiffness of element 2 is 7.999 ± 0.018 kN/m, outside 12.00 to 13.00 kN/m',
  state: 'unacknowledged', since: '2026-11-23T07:00:00Z', changed: '2026-11-23T07:00:00Z', count: 1, acknowledged_by: null, comment: null };
async function open(viewport) {
  const shown = await openScripted({ dwell: dwellOf(), rights: { read: true, change: true, token: true } });
  await shown.page.setViewportSize(viewport);
  await shown.page.route('**/api/v1/alarms', (route) => route.fulfill({ json: { unacknowledged: 1, left_out: 0, alarms: [ALARM] } }));
  await shown.page.locator('#alarm-rows li', { hasText: 'limit violated' }).waitFor();
  return shown;
}
const box = (page, selector) => page.evaluate((s) => {
  const { top, bottom, height } = document.querySelector(s).getBoundingClientRect();
  return { top, bottom, height };
}, selector);

// The button did nothing that anybody saw.
test('a run without a label is not started, and the page says what is missing; a stopped run names the button first', async () => {
  const shown = await openScripted({ dwell: idleOf({ settling_reason: 'the run was stopped: the next one begins with "dwellctl start", or with the drive once it has rested' }),
    rights: { read: true, change: true, token: true }, health: { run: { recorded: true, begun_by: null } } });
  const { page } = shown;
  let orders = 0;
  await page.route('**/api/v1/start', (route) => {
    ++orders;
    return route.fulfill({ json: { done: true, recording: true } });
  });
  await page.locator('#detail', { hasText: 'begins with the button "Start a run" below, "dwellctl start", or' }).waitFor();
  await page.click('#operate-begin');
  await page.locator('#operate-said', { hasText: /^Not done: a label is needed\./ }).waitFor();
  assert.equal(await page.evaluate(() => document.activeElement.id), 'operate-label');
  assert.equal(orders, 0);
  await page.keyboard.type('sweep 3');
  await page.keyboard.press('Enter');
  await page.locator('#operate-said', { hasText: 'Run "sweep 3" started.' }).waitFor();
  assert.equal(orders, 1);
  await shown.close();
});

test('what the links of the head lead to is below the head', async () => {
  const shown = await open(SIZES.desk);
  const { page } = shown;
  for (const [link, target] of [['#alarm-link', '#alarms'], ['.skip', '#coefficients']]) {
    await page.locator(link).focus();
    await page.keyboard.press('Enter');
    await page.waitForFunction((id) => location.hash === id, target);
    const [head, section] = [await box(page, '#head'), await box(page, target)];
    assert.ok(section.top >= head.bottom, `${target} begins at ${section.top}, the head ends at ${head.bottom}`);
    assert.ok(section.top < SIZES.desk.height - 100, `${target} is on the screen`);
  }
  await shown.close();
});

test('backwards by keyboard, nothing that has the focus is under the head', async () => {
  const shown = await open(SIZES.desk);
  const { page } = shown;
  await page.waitForFunction(() => [...document.querySelectorAll('#operate button, #operate input')].some((node) => node.offsetParent));
  await page.evaluate(() => {
    window.scrollTo(0, document.body.scrollHeight);
    [...document.querySelectorAll('#operate button, #operate input')].filter((node) => node.offsetParent).at(-1).focus();
  });
  const hidden = [];
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press('Shift+Tab');
    const at = await page.evaluate(() => {
      const node = document.activeElement;
      const head = document.querySelector('#head');
      const [a, b] = [node.getBoundingClientRect(), head.getBoundingClientRect()];
      return { name: node.id || node.className || node.innerText.slice(0, 20), out: head.contains(node) || node === document.body,
        under: a.bottom > 0 && a.top < b.bottom - 1 && getComputedStyle(head).position === 'sticky' };
    });
    if (at.out) break;
    if (at.under && at.name !== 'skip') hidden.push(at.name);
  }
  assert.deepEqual(hidden, []);
  await shown.close();
});

test('a head that would take more than a third of the window scrolls away', async () => {
  const shown = await open({ width: 1024, height: 400 });
  const { page } = shown;
  const head = await box(page, '#head');
  assert.ok(head.height > 400 / 3, `it takes ${head.height} px`);
  await page.evaluate(() => window.scrollTo(0, 800));
  assert.ok((await box(page, '#head')).bottom <= 0);
  await page.setViewportSize({ width: 1024, height: 900 });
  await page.waitForFunction(() => document.querySelector('#head').getBoundingClientRect().top === 0);
  await shown.close();
});
