// The head stays on the screen and hides nothing that the keyboard or a link goes to (WCAG 2.2, 2.4.11).
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Bench, openBrowser, PATIENCE_MS, SIZES, TOKEN } from './bench.js';

let browser;
let bench;
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(), Bench.begin({ files: { token: `${TOKEN}\n` },
    edit: (text) => `${text.replace(/^# token_file .*/m, 'token_file = "token"')}\n[[limit]]\nelement = 2\nstiffness = [12e3, 13e3]\n` })]);
  bench.rig.say('start');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

async function open(viewport) {
  const page = await browser.newPage({ viewport });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(bench.url);
  await page.locator('#alarm-rows li', { hasText: 'limit violated' }).waitFor();
  return page;
}
const box = (page, selector) => page.evaluate((s) => {
  const { top, bottom, height } = document.querySelector(s).getBoundingClientRect();
  return { top, bottom, height };
}, selector);

test('what the links of the head lead to is below the head', async () => {
  const page = await open(SIZES.desk);
  for (const [link, target] of [['#alarm-link', '#alarms'], ['.skip', '#coefficients']]) {
    await page.locator(link).focus();
    await page.keyboard.press('Enter');
    await page.waitForFunction((id) => location.hash === id, target);
    const [head, section] = [await box(page, '#head'), await box(page, target)];
    assert.ok(section.top >= head.bottom, `${target} begins at ${section.top}, the head ends at ${head.bottom}`);
    assert.ok(section.top < SIZES.desk.height - 100, `${target} is on the screen`);
  }
  await page.close();
});

test('backwards by keyboard, nothing that has the focus is under the head', async () => {
  const page = await open(SIZES.desk);
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
  await page.close();
});

test('a head that would take more than a third of the window scrolls away', async () => {
  const page = await open({ width: 1024, height: 400 });
  const head = await box(page, '#head');
  assert.ok(head.height > 400 / 3, `it takes ${head.height} px`);
  await page.evaluate(() => window.scrollTo(0, 800));
  assert.ok((await box(page, '#head')).bottom <= 0);
  await page.setViewportSize({ width: 1024, height: 900 });
  await page.waitForFunction(() => document.querySelector('#head').getBoundingClientRect().top === 0);
  await page.close();
});
