// A page that is told what a test says, instead of a rig: what stands where does not depend on how the rig is doing.
import { PATIENCE_MS, SIZES } from './bench.js';

const RETRY_MS = 200; // the stream ends after each event, and is asked for again
const STEP_S = 0.02;
const BINS = 50;

// Traces of these channels that go on at each telling.
function tracesOf(names, telling) {
  const wave = names.map((name, c) => Array.from({ length: BINS }, (_, i) => Math.sin(0.5 * (telling * BINS + i) + c)));
  return { step_s: STEP_S, first: telling * BINS, bins: BINS,
    channels: names.map((name, c) => ({ name, unit: 'mm', min: wave[c], max: wave[c].map((v) => v + 0.01), breaks: [] })) };
}

// Resolves to { page, dwell, close }. browser, service: of openBrowser() and ScriptedService, which answers whatever is not told here. dwell: told again and
// again; told.dwell may be set anew. told.close() ends it. traced: names of channels with traces. health: what differs in it. rights: of who reads. options: more of
// the browser's newPage().
export async function openTold(browser, service, { dwell, traced = [], health = {}, rights, size = 'desk', query = '', options = {} }) {
  const page = await browser.newPage({ viewport: SIZES[size], ...options });
  page.setDefaultTimeout(PATIENCE_MS);
  const told = { page, dwell,
    async close() {
      await page.unrouteAll({ behavior: 'ignoreErrors' }); // answers under way
      await page.close();
    } };
  let telling = 0;
  const event = (name, data) => `event: ${name}\ndata: ${JSON.stringify(data)}\n\n`;
  await page.route('**/api/v1/stream*', (route) => {
    ++telling;
    const age = telling * RETRY_MS / 1000; // of a dwell that goes on: numbers that grew old would add a line to the head
    const body = `retry: ${RETRY_MS}\n` + event('dwell', { ...told.dwell, end_s: told.dwell.end_s + age }) +
      (traced.length > 0 ? event('traces', tracesOf(traced, telling)) : '');
    return route.fulfill({ contentType: 'text/event-stream', body });
  });
  await page.route('**/api/v1/health', async (route) => route.fulfill({ json: { ...await (await route.fetch()).json(), ...health } }));
  if (rights) await page.route('**/api/v1/rights', (route) => route.fulfill({ json: rights }));
  await page.goto(`${service.url}/${query}`);
  return told;
}
