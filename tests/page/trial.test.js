// Whether the page alone tells an operator new to it if the numbers may be used, and why not. Ten situations were tried by
// eye; where each is kept:
//   settling, measuring, drive stopped, device dead, service killed   page.test.js
//   limit violated, clock not synchronized                            alarms.test.js
//   a recording in place of a rig                                     replay.test.js
//   logged out                                                        honest.test.js
//   recording stopped                                                 wording.test.js
//   wrong mass, stuck transducer, registers refreshed slowly          here
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Bench, openBrowser, PATIENCE_MS, recordingOf, SIZES } from './bench.js';

let browser;
before(async () => {
  browser = await openBrowser();
});
after(() => browser?.close());

async function situation(options, act) {
  const bench = await Bench.begin(options);
  try {
    bench.rig.say('start');
    const page = await browser.newPage({ viewport: SIZES.desk });
    page.setDefaultTimeout(PATIENCE_MS);
    await page.goto(bench.url);
    await page.waitForSelector('#coefficients[data-source=measured] .element');
    try {
      await act(page, bench);
    } catch (error) {
      // What the page told instead is what a person would look at.
      error.message += `\nin:\n${await page.innerText('body')}`;
      throw error;
    }
    await page.close();
  } finally {
    await bench.end();
  }
}
const numbers = (page) => page.locator('.coefficient .number').allInnerTexts();

test('a mass is wrong by 10 %: no, do not rely on them, and the mass is named; the end of the dwell changes nothing', () =>
  // Little damping: the transient, which alone tells of the mass, lasts long enough for a busy machine.
  situation({ rig: ['--damping', '20,15,10,13'], edit: (text) => text.replace('masses   = [12.0, 8.0, 5.0]', 'masses   = [12.0, 8.8, 5.0]') }, async (page, bench) => {
    await page.waitForSelector('#state[data-kind=measuring][data-tone=alarm]');
    await page.locator('#detail', { hasText: /; do not rely on any element$/ }).waitFor();
    await page.locator('#troubles li', { hasText: /possible causes: .*mass 2 stated \d/ }).waitFor();
    for (const number of await numbers(page)) assert.match(number, /\?$/);
    bench.rig.say('stop');
    await page.waitForSelector('#coefficients[data-source=last] .element');
    await page.locator('#coefficients-from', { hasText: /^not of now · last dwell: / }).waitFor();
    await page.locator('#last-notes li[data-tone=alarm]', { hasText: /^do not rely on any element: mode at .*possible causes: .*mass 2 stated \d/ }).waitFor();
    for (const number of await numbers(page)) assert.match(number, /\?$/);
  }));

test('a transducer is stuck: the elements beside it have no numbers, the others may be used', () =>
  situation({}, async (page, bench) => {
    bench.rig.say('stuck y2 on');
    await page.locator('#detail', { hasText: /; no coefficients of elements 1, 2, 3$/ }).waitFor();
    await page.locator('#troubles li', { hasText: /^channel y2: stuck at one reading/ }).waitFor();
    await page.waitForFunction(() => document.querySelectorAll('.coefficient .number.struck').length === 6);
    const usable = (await numbers(page)).filter((number) => !/old$/.test(number));
    assert.equal(usable.length, 2);
  }));

// A recording: where the computer is too busy to poll evenly, the service rightly has no numbers.
test('registers are refreshed more slowly than they are polled: the numbers may be used, and what their ± is made of is said', async () =>
  situation(await recordingOf(['--refresh', '0.02', '--duration', '120']), async (page) => {
    await page.locator('#phasor-notes li', { hasText: /^y1: refreshed every 20(\.\d)? ms, polled every 5 ms; each new value counts once/ }).waitFor();
    // The ± shrinks as the dwell goes on. What makes it up does not: the refreshing is the largest part, after a second.
    const budget = page.locator('.element').first().locator('.budget');
    await budget.locator('summary').click();
    await budget.locator('p', { hasText: /^± of c₁: first have y[01] refreshed more often$/ }).waitFor();
    const shown = (await numbers(page))[0], number = shown.match(/^([\d.]+) ± ([\d.]+) kN\/m$/);
    assert.ok(number, shown);
    const [value, U] = number.slice(1).map(Number);
    assert.ok(Math.abs(value - 24) < 2 * U, `${value} ± ${U}`);
    assert.equal(await page.locator('#state').getAttribute('data-tone'), 'calm');
  }));
