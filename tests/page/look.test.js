// The page at a phone's, a desk's and a wall's size: what accessible.js checks holds, and everything can be reached by
// keyboard.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { check } from './accessible.js';
import { joined, numberText } from '../../daemon/page/number.mjs';
import { dwellOf } from './sample.js';
import { Bench, openBrowser, PATIENCE_MS, SIZES, TOKEN, until } from './bench.js';

function recordingWithToken(text, folder) {
  writeFileSync(join(folder, 'token'), TOKEN, { mode: 0o600 });
  return `${text.replace(/^# token_file .*/m, 'token_file = "token"')}\n[recording]\ndirectory = "${folder}/runs"\n`;
}

let browser;
let bench;
let wrong; // a spring that the chain does not have
before(async () => {
  [browser, bench, wrong] = await Promise.all([openBrowser(),
    Bench.begin({ edit: recordingWithToken }),
    Bench.begin({ rig: ['--side-spring', '2:ground:3000'] })]);
  wrong.rig.say('start');
  bench.rig.say('start');
});
after(async () => {
  await Promise.all([browser?.close(), bench?.end(), wrong?.end()]);
});

async function open(size, query = '', at = bench) {
  const page = await browser.newPage({ viewport: SIZES[size], bypassCSP: true });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(`${at.url}/${query}`);
  return page;
}

test('a model fault: the first line says not to rely on the numbers, and each of them as well', async () => {
  const page = await open('desk', '', wrong);
  await page.waitForSelector('#state[data-kind=measuring][data-tone=alarm]');
  assert.match(await page.locator('#detail').innerText(), /; do not rely on /);
  await page.locator('#troubles li, .notes li', { hasText: /^do not rely on / }).first().waitFor();
  assert.match(await page.locator('.coefficient .number').first().innerText(), /\?$/);
  await check(page, 'fault-desk');
  await page.close();
});

for (const [size, query] of [['phone', ''], ['desk', ''], ['wall', '?kiosk']]) {
  test(`measured, at the size of a ${size}`, async () => {
    const page = await open(size, query);
    await page.waitForSelector('#state[data-kind=measuring]');
    await page.waitForSelector('.arrow');
    if (size !== 'wall') await page.locator('#event-rows li').first().waitFor();
    // However long a number is, and old: neither it nor its trend reaches into the neighbour.
    const crossed = await page.evaluate(() => [...document.querySelectorAll('.coefficient')].flatMap((cell) => {
      const [number, trend] = [cell.querySelector('.number'), cell.querySelector('.trend')];
      return [['7.99978', ' ± 0.00099', false], ['24.001', ' ± 0.025', true]].filter(([value, pm, struck]) => {
        number.children[0].textContent = value;
        number.children[1].textContent = pm;
        number.children[4].textContent = struck ? ' 7.3 s old' : '';
        number.classList.toggle('struck', struck);
        const right = Math.max(number.getBoundingClientRect().right, trend.getBoundingClientRect().right);
        return right > cell.getBoundingClientRect().right + 1;
      }).map(([value]) => `${cell.innerText}: ${value}`);
    }));
    assert.deepEqual(crossed, []);
    await page.waitForFunction(() => !document.querySelector('.coefficient .struck'));
    await check(page, `measured-${size}`);
    if (size === 'desk') {
      await page.waitForSelector('#chain:not([hidden])');
      const [chain, coefficients, phasors] = await page.evaluate(() => ['chain', 'coefficients', 'phasors'].map((id) => document.getElementById(id).getBoundingClientRect()));
      assert.ok(chain.top < phasors.bottom && chain.top > coefficients.bottom && chain.right < phasors.left, 'the shape fills the room beside the phasors');
    }
    await page.close();
  });
}

test('a dwell is opened and left by keyboard, events are filtered', async () => {
  const page = await open('desk');
  await page.waitForSelector('#state[data-kind=measuring]');
  bench.rig.say('stop');
  await page.waitForSelector('#state[data-kind=idle]');
  await page.locator('#dwell-rows button').first().focus();
  await page.keyboard.press('Enter');
  await page.locator('#dwell-content li', { hasText: /c₁ = .* ± .* kN\/m/ }).waitFor();
  await check(page, 'dwell-desk');
  await page.keyboard.press('Escape');
  assert.equal(await page.evaluate(() => document.activeElement.closest('#dwell-rows') !== null), true, 'the focus is back');
  const all = await page.locator('#event-rows li').count();
  await page.locator('#event-words').fill('-> idle');
  await page.waitForFunction((before) => document.querySelectorAll('#event-rows li').length < before, all);
  assert.match(await page.locator('#event-rows li').first().innerText(), /state \w+ -> idle/);
  bench.rig.say('start');
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.locator('.deviation:not(:empty)').first().waitFor({ state: 'attached' });
  await page.close();
});

test('every control is reached with the tabulator, the first is the way past the head', async () => {
  const page = await open('desk');
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.keyboard.press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement.className), 'skip');
  const unreachable = await page.evaluate(() => [...document.querySelectorAll('a, button, select, input, summary')]
    .filter((node) => node.tabIndex < 0).map((node) => node.outerHTML));
  assert.deepEqual(unreachable, []);
  await page.close();
});

test('an operator logs in, starts a run, labels and stops it and logs out, by keyboard', async () => {
  const page = await open('phone');
  const said = (text) => page.locator('#operate-said', { hasText: text }).waitFor();
  const type = async (field, text) => {
    await page.locator(field).waitFor();
    await page.locator(field).focus();
    await page.keyboard.type(text);
    await page.keyboard.press('Enter');
  };
  const press = async (button) => {
    await page.locator(button).waitFor();
    await page.locator(button).focus();
    await page.keyboard.press('Enter');
  };
  await page.waitForSelector('#operate-token');
  assert.equal(await page.locator('#operate-acts').isVisible(), false);
  await type('#operate-token', 'not the token');
  await said('Not done: this is not the token');
  await check(page, 'operate-login-phone');
  await page.locator('#operate-token').fill('');
  await type('#operate-token', TOKEN);
  await said('Logged in.');
  assert.equal(await page.evaluate(() => document.cookie), '', 'no script reads the cookie');
  // The run of the drive: both buttons are there, and the Enter key would start another one.
  await page.locator('#operate-begin').waitFor();
  await page.locator('#operate-label').fill('as found');
  await press('#operate-relabel');
  await said('The run is "as found" now.');
  await page.locator('#facts', { hasText: 'as found' }).waitFor();
  await type('#operate-label', 'sweep 3');
  await said('Run "sweep 3" started.');
  await page.locator('#facts', { hasText: 'sweep 3' }).waitFor();
  await page.locator('#operate-relabel').waitFor();
  await check(page, 'operate-phone');
  await page.waitForSelector('#operate-begin', { state: 'hidden' });
  await type('#operate-label', 'oil film');
  await said('The run is "oil film" now.');
  await page.locator('#facts', { hasText: 'oil film' }).waitFor();

  let asked = '';
  page.on('dialog', (dialog) => {
    asked = dialog.message();
    dialog.accept();
  });
  await press('#operate-stop');
  await said('Run stopped.');
  assert.match(asked, /^Stop the run\?/);
  await press('#operate-logout');
  await page.waitForSelector('#operate-login:not([hidden])');
  const refused = await page.request.post(`${bench.url}/api/v1/rearm`, { data: {} });
  assert.equal(refused.status(), 401);
  await page.close();
});

test('a closed run is downloaded as it lies on the disk, with its audit beside it; one that goes on is not offered', async () => {
  const page = await open('desk');
  const order = (verb, data) => page.request.post(`${bench.url}/api/v1/${verb}`, { data, headers: { authorization: `Bearer ${TOKEN}` } });
  assert.equal((await order('start', { label: 'to download' })).status(), 200);
  const row = page.locator('#run-rows tr', { hasText: 'to download' });
  await row.locator('td', { hasText: '– not audited: the run goes on' }).waitFor();
  assert.equal(await row.locator('a').count(), 0);
  assert.match(await page.locator('#dwells-none').innerText(), /^(No dwell of this run has ended yet\. To see those of an earlier run|$)/);
  assert.equal((await order('stop', {})).status(), 200);
  await row.locator('td', { hasText: '✓ intact' }).waitFor();
  const [download] = await Promise.all([page.waitForEvent('download'), row.locator('a').click()]);
  const name = download.suggestedFilename();
  assert.match(name, /^clamped-bench-three-masses-\d+-\d{8}T\d{6}Z\.dwell$/);
  assert.ok((await readFile(await download.path())).equals(await readFile(join(bench.folder, 'runs', name))));
  await check(page, 'runs-desk');
  await page.setViewportSize(SIZES.phone);
  await check(page, 'runs-phone');
  await page.close();
});

test('a run that was stopped while the drive is on: its numbers are those of a dwell that has ended', async () => {
  const order = (verb, data) => fetch(`${bench.url}/api/v1/${verb}`, { method: 'POST', body: JSON.stringify(data),
    headers: { authorization: `Bearer ${TOKEN}`, 'content-type': 'application/json' } });
  const page = await open('desk');
  assert.equal((await order('start', { label: 'to stop' })).status, 200);
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  assert.equal((await order('stop', {})).status, 200);
  await page.waitForSelector('#state[data-kind=complete]');
  assert.match(await page.locator('#detail').innerText(), /^the run was stopped: the next one begins/);
  const later = await open('desk'); // opened only now: both count from the end of the data
  for (const shown of [page, later]) {
    await shown.locator('#coefficients[data-source=last] #coefficients-from', { hasText: /^not of now · last dwell: \d+, ended (?:[4-9]\.\d|\d\d+) s ago: the run was stopped: / }).waitFor();
    assert.match(await shown.locator('#facts').innerText(), /since\s+[\d:]+ \([\d.]+ s\)/);
    assert.match(await shown.locator('#phasors-note').innerText(), /^Of dwell \d+, which has ended: not of now\.$/);
    assert.equal(await shown.locator('.coefficient .struck').count(), 0, 'data are not expected');
    assert.doesNotMatch(await shown.locator('#troubles').innerText(), /old numbers/);
  }
  await check(page, 'stopped-desk');
  await later.close();
  bench.rig.signal('SIGSTOP');
  await page.locator('#troubles li', { hasText: /^channels y0, y1, y2, y3, reaction: / }).waitFor();
  await page.waitForFunction(() => !document.querySelector('.coefficient .number:not(.struck)'));
  bench.rig.signal('SIGCONT');
  await page.waitForFunction(() => !document.querySelector('.coefficient .number.struck'));
  await page.close();
});

test('a table of runs says that there are older ones, and every row names its file', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.route('**/api/v1/runs?*', async (route) => {
    const answer = await (await route.fetch()).json();
    const cutOff = { ...answer.runs[0], run: 7, file: 'bench-7.dwell', state: 'cut off', download: null, no_download: 'the run was cut off: copy both files' };
    await route.fulfill({ json: { ...answer, total: answer.runs.length + 38, runs: [...answer.runs, cutOff] } });
  });
  await page.goto(bench.url);
  await page.locator('#runs-older', { hasText: /^The newest \d+ of \d+ runs\. / }).waitFor();
  const names = await page.locator('#run-rows tr .file').allInnerTexts();
  assert.equal(names.length, await page.locator('#run-rows tr').count());
  for (const name of names) assert.match(name, /\.dwell$/);
  assert.ok(names.includes('bench-7.dwell'));
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

test('a dwell of an earlier run is chosen and opened by keyboard, also after a restart of the service', async () => {
  const page = await open('desk');
  bench.rig.say('stop'); // a run that was stopped by hand is behind us
  await page.waitForSelector('#state[data-kind=idle]');
  bench.rig.say('start');
  await page.waitForSelector('#state[data-kind=measuring]');
  bench.rig.say('stop');
  await page.waitForSelector('#state[data-kind=idle]');
  const { dwells, file } = await bench.get('/api/v1/dwells?brief=1');
  const newest = dwells.at(-1);
  await until(async () => {
    const { runs } = await bench.get('/api/v1/runs?count=1');
    return runs[0].state === 'closed' && runs[0].file === file;
  });
  await bench.service.end();
  await bench.startService();
  await page.reload();
  await page.locator('#dwells-none', { hasText: /^No dwell of this run has ended yet\. To see those of an earlier run, choose it above\.$/ }).waitFor();
  await page.selectOption('#dwells-run', { index: 1 });
  await page.locator('#dwells-of', { hasText: /^From the file of run \d+.*: an earlier run\. Audit: / }).waitFor();
  const row = page.locator('#dwell-rows tr').first();
  await row.waitFor();
  const { value, U95, unit } = newest.elements[0].stiffness;
  const shown = (await row.locator('td').nth(4).innerText()).replace(/^\? /, ''); // so short a dwell may carry a doubt
  assert.equal(shown, joined(numberText(value, U95, unit)), 'c₁, as before the restart');
  await check(page, 'earlier-desk');
  await row.locator('button').focus();
  await page.keyboard.press('Enter');
  await page.locator('#dwell-content li', { hasText: /c₁ = .* ± .* kN\/m/ }).waitFor();
  assert.match(await page.locator('#dwell-title').innerText(), /^Dwell \d+ of run \d+$/);
  await page.locator('#dwell-content li', { hasText: 'an earlier run' }).waitFor();
  await check(page, 'earlier-dwell-desk');
  await page.keyboard.press('Escape');
  await page.setViewportSize(SIZES.phone);
  await check(page, 'earlier-phone');
  await page.setViewportSize(SIZES.desk);
  await page.selectOption('#dwells-run', { index: 0 });
  await page.locator('#dwells-none', { hasText: /^No dwell of this run/ }).waitFor();
  assert.equal(await page.locator('#dwells-of').isVisible(), false);
  bench.rig.say('start');
  await page.waitForSelector('#state[data-kind=measuring]');
  await page.close();
});

test('a page that is opened later draws the trend of the runs before as well', async () => {
  await until(async () => (await bench.get('/api/v1/runs?count=10')).runs.some(({ dwells_at, ended }) => dwells_at && ended));
  const page = await open('desk');
  await page.waitForSelector('#coefficients[data-source=measured] .element');
  // Dwells are not joined: the line begins anew with each.
  await page.waitForFunction(() => (document.querySelector('.trend .middle').getAttribute('d')?.match(/M/g) ?? []).length > 1);
  await page.close();
});

// A child file has the begin and the indices of its parent, with other numbers.
test('two files of one run each show their own numbers', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  const files = { 'bench-98-20261123T031217Z.dwell': 24000, 'bench-99-20261123T031217Z.dwell': 25000 };
  await page.route('**/api/v1/runs?*', async (route) => {
    const answer = await (await route.fetch()).json();
    await route.fulfill({ json: { ...answer, runs: Object.keys(files).map((file, i) => ({ ...answer.runs[0], run: 98 + i, file, state: 'closed', dwells: 1, dwells_at: `/api/v1/runs/${file}/dwells` })) } });
  });
  await page.route('**/api/v1/runs/*/dwells?*', (route) => {
    const [file, c] = Object.entries(files).find(([name]) => route.request().url().includes(name));
    const dwell = dwellOf({ index: 1, state: 'complete', ended_by: 'drive stopped', table: null });
    dwell.elements[0].stiffness.value = c;
    return route.fulfill({ json: { rig: 'bench', run: 98, file, total: 1, forgotten: 0, next: null, dwells: [dwell] } });
  });
  await page.goto(bench.url);
  await page.locator('#dwells-choice:not([hidden])').waitFor();
  for (const [file, c] of Object.entries(files)) {
    await page.selectOption('#dwells-run', file);
    await page.locator('#dwell-rows td', { hasText: new RegExp(`^${c / 1000}\\.000? ±`) }).waitFor();
  }
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

test('a run that cannot be read says why, in place of its dwells', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.route('**/api/v1/runs?*', async (route) => {
    const answer = await (await route.fetch()).json();
    const run = { ...answer.runs[0], run: 99, file: 'bench-99-20261123T031217Z.dwell', state: 'closed', dwells: 3, dwells_at: '/api/v1/runs/bench-99-20261123T031217Z.dwell/dwells' };
    await route.fulfill({ json: { ...answer, runs: [...answer.runs, run] } });
  });
  await page.goto(bench.url);
  await page.locator('#dwells-choice:not([hidden])').waitFor();
  await page.selectOption('#dwells-run', 'bench-99-20261123T031217Z.dwell');
  await page.locator('#dwells-none', { hasText: /^They cannot be shown: there is no run of this name/ }).waitFor();
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

test('an empty table of dwells says where those of earlier runs are', async () => {
  const page = await browser.newPage({ viewport: SIZES.desk });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.route('**/api/v1/dwells?*', async (route) => route.fulfill({ json: { rig: 'x', total: 0, forgotten: 0, file: null, next: null, dwells: [] } }));
  await page.route('**/api/v1/runs?*', async (route) => {
    const answer = await (await route.fetch()).json();
    await route.fulfill({ json: { ...answer, runs: answer.runs.map((run) => ({ ...run, state: 'closed', dwells: 3, dwells_at: '/api/v1/runs/a/dwells' })) } });
  });
  await page.goto(bench.url);
  await page.locator('#dwells-none', { hasText: /^No dwell of this run has ended yet\. To see those of an earlier run, choose it above\.$/ }).waitFor();
  assert.equal(await page.locator('#dwells-table').isVisible(), false);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.close();
});

// Of the rig with the fault: the last one that uses it.
test('fault and a service that is gone, at the size of a phone', async () => {
  const page = await open('phone', '', wrong);
  await page.waitForSelector('#state[data-kind=measuring]');
  wrong.rig.signal('SIGSTOP');
  await page.waitForSelector('#state[data-kind=fault]');
  await page.waitForSelector('.coefficient .struck');
  await check(page, 'stale-phone');
  wrong.service.signal('SIGKILL');
  await page.waitForSelector('#state[data-kind=gone]');
  await check(page, 'gone-phone');
  await page.close();
});
