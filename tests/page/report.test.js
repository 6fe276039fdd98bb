// A run's report, as a browser shows and prints it: recorded by the service, made by dwellctl.
import assert from 'node:assert/strict';
import { readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { check } from './accessible.js';
import { Bench, dwellctl, openBrowser, until } from './bench.js';

let browser, bench, file, page;
const asked = [], complaints = [];

before(async () => {
  browser = await openBrowser();
  bench = await Bench.begin({ edit: (text, folder) => `${text}\n[recording]\ndirectory = "${join(folder, 'runs')}"\n` });
  bench.rig.say('start');
  await until(async () => (await bench.get('/api/v1/dwell')).elements.some((element) => element.identifiable));
  await bench.service.end(); // the run is closed
  const runs = join(bench.folder, 'runs');
  file = join(runs, (await readdir(runs)).find((name) => name.endsWith('.dwell')));
  await dwellctl('report', file, '-o', join(bench.folder, 'report.html'));
  page = await browser.newPage({ viewport: { width: 1280, height: 900 }, bypassCSP: true });
  page.on('request', (request) => asked.push(request.url()));
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  await page.goto(pathToFileURL(join(bench.folder, 'report.html')).href);
});
after(async () => {
  await browser?.close();
  await bench?.end();
});

test('it is one file that asks for nothing else and complains of nothing', async () => {
  assert.deepEqual(asked, [page.url()]);
  assert.deepEqual(complaints, []);
  assert.doesNotMatch(await readFile(join(bench.folder, 'report.html'), 'utf8'), /(src|href)="(https?:)?\/\//);
});

test('it shows rig, channels, traces, phasors, coefficients with their budget, events and hashes', async () => {
  const text = await page.locator('body').innerText();
  const audited = JSON.parse(await dwellctl('audit', file, '--json'));
  for (const words of [/clamped bench, three masses/, /y1/, /reaction/, /idle -> settling/, /not signed|signatures/i]) assert.match(text, words);
  assert.match(audited.files[0].head, /^[0-9a-f]{64}$/);
  assert.ok(text.includes(audited.files[0].head), 'the head that the audit verifies');
  // A value with its uncertainty, and a source of it.
  assert.match(text, /\d ±\s*\d.*N\/m/); // kept together by a space that does not break
  assert.match(text, /\d+ % (noise|mass|clock|scale)/);
  const pictures = await page.locator('svg').all();
  assert.ok(pictures.length >= 2, 'time traces and phasors');
  for (const picture of pictures) {
    const { width, height } = await picture.boundingBox();
    assert.ok(width > 100 && height > 50, `a picture of ${width} × ${height} px`);
    assert.ok((await picture.locator('path, line, polyline, polygon, circle').count()) > 0, 'something is drawn');
  }
});

test('it is accessible, and nothing of it is cut off', async () => {
  await check(page, 'report');
});

test('as a PDF it has pages of A4 whose text is the same', async () => {
  const pdf = await page.pdf({ format: 'A4' });
  assert.equal(pdf.subarray(0, 5).toString(), '%PDF-');
  const pages = pdf.toString('latin1').match(/\/Type *\/Page\b/g) ?? [];
  assert.ok(pages.length >= 2 && pages.length < 40, `${pages.length} pages`);
  // On paper nothing is wider than the page: A4 has 210 mm at 96 pixels an inch, less the margins.
  await page.emulateMedia({ media: 'print' });
  await page.setViewportSize({ width: 718, height: 1000 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.ok(wide <= 0, `${wide} px are cut off at the right`);
  await page.emulateMedia({ media: null });
});
