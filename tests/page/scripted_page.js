// A page that shows what a test scripts, not a rig: what stands where does not depend on how a rig is doing.
import { after, before } from 'node:test';
import { openBrowser, PATIENCE_MS, SIZES } from './bench.js';
import { ScriptedService } from './scripted.js';

const TELLING_MS = 200; // the stream ends after each telling, and is asked for again
const STEP_S = 0.02;
const BINS = TELLING_MS / 1e3 / STEP_S; // of a telling

// Bins of these channels from number `first` on, so many.
function tracesOf(names, first, bins) {
  const wave = names.map((name, c) => Array.from({ length: bins }, (_, i) => Math.sin(0.5 * (first + i) + c)));
  return { step_s: STEP_S, first, bins,
    channels: names.map((name, c) => ({ name, unit: 'mm', min: wave[c], max: wave[c].map((v) => v + 0.01), breaks: [] })) };
}

// For a test file: one browser and one service for all its tests. Returns open(what), which resolves to { page, dwell,
// close }: close() ends the page, and `dwell` may be set anew. Of `what`:
//   dwell    is told again and again
//   traced   names of channels with live traces; none: those of the service stand still
//   health   what differs in it
//   rights   of who reads
//   options  more of the browser's newPage()
// Whatever is not scripted here, ScriptedService answers.
export function scriptedPages() {
  let browser;
  let service;
  before(async () => {
    [browser, service] = await Promise.all([openBrowser(), ScriptedService.begin()]);
  });
  after(async () => {
    await Promise.all([browser?.close(), service?.end()]);
  });
  return (what) => open(browser, service.url, what);
}

async function open(browser, url, { dwell, traced = [], health = {}, rights, size = 'desk', query = '', options = {} }) {
  const page = await browser.newPage({ viewport: SIZES[size], ...options });
  page.setDefaultTimeout(PATIENCE_MS);
  const shown = { page, dwell,
    async close() {
      await page.unrouteAll({ behavior: 'ignoreErrors' }); // answers under way
      await page.close();
    } };
  let tellings = 0;
  const answer = (what, change) => page.route(`**/api/v1/${what}`, async (route) => route.fulfill({ json: change(await (await route.fetch()).json()) }));
  const event = (name, data) => `event: ${name}\ndata: ${JSON.stringify(data)}\n\n`;
  await page.route('**/api/v1/stream*', (route) => {
    ++tellings;
    const age_s = tellings * TELLING_MS / 1e3; // the dwell goes on: numbers that grew old would add a line to the head
    const body = `retry: ${TELLING_MS}\n` + event('dwell', { ...shown.dwell, end_s: shown.dwell.end_s + age_s }) +
      (traced.length > 0 ? event('traces', tracesOf(traced, tellings * BINS, BINS)) : '');
    return route.fulfill({ contentType: 'text/event-stream', body });
  });
  await answer('health', (told) => ({ ...told, ...health }));
  if (rights) await answer('rights', () => rights);
  if (traced.length > 0) {
    await answer('traces?*', (told) => ({ ...told, ...tracesOf(traced, 0, (tellings + 1) * BINS), from_s: 0, newest_s: (tellings + 1) * BINS * STEP_S }));
    await answer('channels', ({ channels }) => ({ channels: traced.map((name) => ({ ...channels[0], name })) }));
  }
  await page.goto(`${url}/${query}`);
  return shown;
}
