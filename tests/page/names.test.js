// Channel names of the greatest length that the rig file allows, alike but for a few letters: all stay in view, and no two
// look the same.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { check } from './accessible.js';
import { Bench, openBrowser, PATIENCE_MS, SIZES } from './bench.js';

const CHANNELS = ['y0', 'y1', 'y2', 'y3', 'reaction'];
// 64 letters, the only difference in the middle.
const long = (name) => `${'transducer_of_the_test_bench'.padEnd(31, '_')}${name.slice(0, 2)}${'_calibrated'.padEnd(31, '_')}`;

let browser;
let bench;
before(async () => {
  [browser, bench] = await Promise.all([openBrowser(),
    Bench.begin({ edit: (text) => text.replace(/^(name +=) "(y\d|reaction)"/gm, (_, head, name) => `${head} "${long(name)}"`) })]);
  bench.rig.say('start');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end()]);
});

for (const [size, query] of [['phone', ''], ['desk', ''], ['wall', '?kiosk']]) {
  test(`at the size of a ${size} nothing reaches beyond the screen, and names in the picture are told apart`, async () => {
    assert.equal(long('y0').length, 64);
    const page = await browser.newPage({ viewport: SIZES[size], bypassCSP: true });
    page.setDefaultTimeout(PATIENCE_MS);
    await page.goto(`${bench.url}/${query}`);
    await page.waitForSelector('#state[data-kind=measuring]');
    await page.waitForSelector('.arrow');
    // On a loaded machine warnings may take the traces' room; then the note at the foot names the traces.
    await page.waitForFunction(() => document.querySelector('#traces:not([hidden], .beyond)') ||
      / traces/.test(document.querySelector('#beyond:not([hidden])')?.textContent));
    await check(page, `long-names-${size}`);
    const caption = await page.evaluate(() => {
      const scales = document.querySelector('#scales');
      return scales.scrollWidth - scales.clientWidth;
    });
    assert.ok(caption <= 0, `${caption} px of the caption are cut off`);
    const labels = await page.evaluate(() => [...document.querySelectorAll('#arrows .arrow')].map((arrow) => {
      const [label, picture] = [arrow.querySelector('text').getBoundingClientRect(), document.querySelector('#polar').getBoundingClientRect()];
      return { text: arrow.querySelector('text').textContent, title: arrow.querySelector('title')?.textContent,
        inside: label.left >= picture.left - 1 && label.right <= picture.right + 1 };
    }));
    assert.equal(new Set(labels.map((label) => label.text)).size, CHANNELS.length);
    for (const { text, inside } of labels) assert.ok(text.includes('…') && inside, text);
    assert.deepEqual(labels.map((label) => label.title).sort(), CHANNELS.map(long).sort());
    if (size !== 'wall') await page.locator('#trace-plot').scrollIntoViewIfNeeded();
    await page.waitForFunction((title) => document.querySelector('#trace-plot').title === title, `From above: ${CHANNELS.map(long).join(', ')}`);
    if (size !== 'wall') {
      await page.waitForSelector('#channel-rows tr');
      assert.deepEqual(await page.locator('#phasor-rows th').allInnerTexts(), CHANNELS.map(long), 'for those who see no picture');
      const right = await page.evaluate(() => document.querySelector('#channel-rows td:nth-child(3)').getBoundingClientRect().right);
      assert.ok(right <= SIZES[size].width, `status and reading of a channel are in view, up to ${right} px`);
    }
    await page.close();
  });
}
