// Makes the README's picture: the page beside a healthy rig, in its third dwell, its model verified.
//   node tests/page/picture.js docs/page.png
import { join } from 'node:path';
import { Bench, openBrowser, TOKEN, until } from './bench.js';

const SIZE = { width: 1440, height: 1380 };
const DWELL_S = 45; // of data, of each dwell before the one in the picture
const SHOWN_S = 60;
const PATIENCE_MS = 300_000;

const LIMIT = `
[[limit]]
element = 2
stiffness = [7.5e3, 8.5e3]
`;
const edit = (text, folder) => `${text.replace(/^# token_file .*/m, 'token_file = "token"')}
[recording]\ndirectory = "${join(folder, 'runs')}"\n${LIMIT}`;

const [browser, bench] = await Promise.all([openBrowser(), Bench.begin({ edit, files: { token: `${TOKEN}\n` } })]);
try {
  const dwell = () => bench.get('/api/v1/dwell');
  // The index of the next dwell, once it has so many seconds of data. A busy computer ends one early, and another begins.
  const measured = async (before, seconds) => {
    let d;
    await until(async () => {
      d = await dwell();
      return d.index > before && d.settled_s !== null && d.end_s - d.settled_s >= seconds;
    }, PATIENCE_MS);
    return d.index;
  };
  const page = await browser.newPage({ viewport: SIZE, extraHTTPHeaders: { Authorization: `Bearer ${TOKEN}` } });
  await page.goto(bench.url);
  bench.rig.say('start');
  const first = await measured(0, DWELL_S);
  bench.rig.say('amplitude 0.004');
  const second = await measured(first, DWELL_S);
  bench.rig.say('amplitude 0.005');
  await measured(second, SHOWN_S);
  const { model } = await dwell();
  if (model?.verdict !== 'adequate') throw new Error(`no picture: the model is ${model?.verdict}; this computer may be too busy`);
  // This computer's clock may be synchronized by nobody: no trouble of the rig.
  for (const button of await page.locator('#alarm-rows button:visible').all()) await button.click();
  await page.waitForFunction(() => document.querySelectorAll('#alarm-rows button:not([hidden])').length === 0);
  const { warnings, doubts } = await dwell();
  if (warnings.length + doubts.length > 0) console.error(`the rig does not look healthy; this computer may be too busy: ${JSON.stringify([warnings, doubts])}`);
  await page.screenshot({ path: process.argv[2] });
} finally {
  await Promise.all([browser.close(), bench.end()]);
}
