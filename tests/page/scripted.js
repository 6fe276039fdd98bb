// A service for tests of a page that is open for hours. It serves the page's own files and answers as a rig with six
// masses would. Its time passes as fast as the page takes it: the next step is told when the page has taken the last
// one. The page's clocks are the service's: see inBrowser().
import { once } from 'node:events';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { dwellOf, OLD_AFTER } from './sample.js';

const PAGE = new URL('../../daemon/page/', import.meta.url);
const BEGINS_MS = Date.parse('2026-11-23T07:00:00Z');
// s of the service's time: below what makes numbers old.
export const STEP_S = 2;
const BIN_S = 0.02;
const BINS = STEP_S / BIN_S;
const ELEMENTS = 7;
// One dwell is measured all the time. Before it there were these, in an hour.
const DWELLS = 12;
const DWELL_S = 300;
// As many as the page keeps (feed.mjs): its list is full from the beginning, and a new event pushes an old one out.
const EVENTS = 500;
const EVENT_S = 10;

// Runs in the browser before the page's own code. Intervals, frames and clocks wait for the next step of the stream. An
// interval that is due several times in a step comes once, as in a busy browser.
function inBrowser([beginsMs, stepMs]) {
  let now = 0;
  let frames = [];
  const intervals = [];
  window.performance.now = () => now;
  Date.now = () => beginsMs + now;
  window.setInterval = (act, ms) => intervals.push({ act, ms, due: now + ms });
  window.requestAnimationFrame = (act) => frames.push(act);

  const asks = new Set();
  const ask = window.fetch;
  window.fetch = (...question) => {
    const answer = ask(...question).then(async (got) => new Response(await got.text(), { status: got.status }));
    asks.add(answer);
    answer.finally(() => asks.delete(answer));
    return answer;
  };
  const draw = () => frames.splice(0).forEach((act) => act(now));
  const turn = () => new Promise((done) => setTimeout(done));
  async function step() {
    now += stepMs / 2;
    for (const interval of intervals) {
      if (interval.due > now) continue;
      interval.due = now + interval.ms;
      interval.act();
    }
    // One answer may lead to the next question.
    for (await turn(); asks.size > 0; await turn()) await Promise.allSettled(asks);
    draw();
    draw(); // what the first one asked for
    now += stepMs / 2; // so that what comes next may be drawn at once: pictures keep a distance (pictures.mjs)
    ask('/taken', { method: 'POST' });
  }
  const Stream = window.EventSource;
  window.EventSource = class extends Stream {
    constructor(url) {
      super(url);
      this.addEventListener('step', step);
    }
  };
}

// Between 0 and 1, the same in each run.
const noise = (i, k) => Math.abs(Math.sin(12.9898 * i + 78.233 * k) * 43758.5453) % 1;

export class ScriptedService {
  #server;
  #stream = null; // to the page
  #s = 0; // the service's time
  #taken = () => {};

  static async begin() {
    const service = new ScriptedService();
    service.#server = createServer((question, reply) => service.#answer(question, reply));
    service.#server.listen(0, '127.0.0.1');
    await once(service.#server, 'listening');
    service.url = `http://127.0.0.1:${service.#server.address().port}`;
    return service;
  }

  // Opens the page, which waits for play(). options: more of the browser's newPage().
  async open(browser, viewport, options = {}) {
    const page = await browser.newPage({ viewport, ...options });
    await page.addInitScript(inBrowser, [BEGINS_MS, 1e3 * STEP_S]);
    await page.goto(this.url);
    while (!this.#stream) await once(this.#server, 'request');
    return page;
  }

  // So many seconds pass.
  async play(seconds) {
    for (const until_s = this.#s + seconds; this.#s < until_s;) {
      const taken = new Promise((done) => (this.#taken = done));
      this.#s += STEP_S;
      this.#tell('dwell', this.#dwell());
      this.#tell('traces', this.#traces());
      this.#tell('step', {});
      await taken;
    }
  }

  async end() {
    this.#server.close();
    this.#server.closeAllConnections();
    await once(this.#server, 'close');
  }

  #tell(event, data) {
    this.#stream.write(`event: ${event}\ndata: ${JSON.stringify(data)}\n\n`);
  }

  async #answer(question, reply) {
    const { pathname: path, searchParams } = new URL(question.url, this.url);
    const file = path === '/' ? 'index.html' : path.match(/^\/page\/([\w.]+)$/)?.[1];
    if (file) {
      const type = { html: 'text/html', css: 'text/css', svg: 'image/svg+xml', mjs: 'text/javascript' }[file.split('.').at(-1)];
      reply.setHeader('content-type', `${type}; charset=utf-8`).end(await readFile(new URL(file, PAGE)));
    } else if (path === '/api/v1/stream') {
      this.#stream = reply.writeHead(200, { 'content-type': 'text/event-stream' });
      this.#tell('dwell', this.#dwell());
    } else if (path === '/taken') {
      reply.end();
      this.#taken();
    } else {
      reply.setHeader('content-type', 'application/json').end(JSON.stringify(this.#told(path.split('/').at(-1), Number(searchParams.get('from') ?? 0))));
    }
  }

  #told(what, from) {
    switch (what) {
      case 'health': return { status: 'ok', rig: 'six masses', version: '1', utc: this.#utc(this.#s), ...OLD_AFTER, stale: [], gpio: {}, log: { failing: false, dropped: 0 },
        devices: [{ name: 'amplifier', driver: 'modbus', up: true, faults: {} }], run: { recorded: false, begun_by: null }, recorder: null };
      case 'channels': return { channels: this.#channels() };
      case 'alarms': return { alarms: [], unacknowledged: 0, left_out: 0 };
      case 'rights': return { read: true, change: false, token: false };
      case 'events': return this.#events(from);
      case 'dwells': return { total: DWELLS, next: null, dwells: this.#dwells(from), file: null };
      case 'traces': return { ...this.#traces(), origin_utc: this.#utc(0), from_s: Math.max(0, this.#s - STEP_S), newest_s: this.#s, less_dwell: null };
      default: return { runs: [], total: 0 };
    }
  }

  #utc(s) {
    return new Date(BEGINS_MS + 1e3 * s).toISOString();
  }

  // A dwell as it stands at an instant. Before 0 s the dwells were that had ended when the page was opened.
  #dwellAt(index, s) {
    const dwell = dwellOf();
    const start_s = (index - 1 - DWELLS) * DWELL_S;
    const elements = Array.from({ length: ELEMENTS }, (_, i) => ({ ...structuredClone(dwell.elements[0]), k: i + 1,
      budget: [{ source: 'scale of y1', kind: 'scale', channel: 'y1', stiffness_share: 0.6, damping_share: 0.1 },
        { source: 'noise of y1', kind: 'noise', channel: 'y1', stiffness_share: 0.4, damping_share: 0.9 }] }));
    for (const { k, stiffness, damping } of elements) {
      stiffness.value *= 1 + 1e-4 * noise(s, k);
      damping.value *= 1 + 1e-3 * noise(s, k + ELEMENTS);
    }
    return { ...dwell, index, start_utc: this.#utc(0), start_s, settled_s: start_s + 2, verdict_s: start_s + 3, end_s: s, elements,
      frequency_hz: { value: 4 + 1e-4 * noise(s, 0), u: 2e-5 }, table: { amplitude: 5e-3, unit: 'm' },
      model: { verdict: 'adequate', seen: 0.012, U: 0.004, asked: 0.05, consistent: true },
      phasors: this.#channels().map(({ name, measures }, c) => ({ channel: name, unit: measures === 'force' ? 'N' : 'm', valid: true, mean: 1e-3,
        amplitude: 5e-3 * (1 + 1e-3 * noise(s, c)), phase_rad: 0.3 * c + 1e-3 * noise(s, c), u_amplitude: 1e-6, u_relative_phase_rad: 1e-4, harmonics: [2e-3, 7e-4] })) };
  }
  #dwell() {
    return this.#dwellAt(DWELLS + 1, this.#s);
  }
  #dwells(from) {
    const first = Math.max(from, 1);
    return Array.from({ length: Math.max(0, DWELLS + 1 - first) }, (_, i) => ({ ...this.#dwellAt(first + i, (first + i - DWELLS) * DWELL_S - 1),
      state: 'complete', ended_by: 'drive changed' }));
  }

  #channels() {
    return Array.from({ length: ELEMENTS + 1 }, (_, i) => ({ name: i < ELEMENTS ? `y${i}` : 'reaction', measures: i < ELEMENTS ? 'displacement' : 'force',
      at: i < ELEMENTS ? i : 'ground', relative_to: null, unit: i < ELEMENTS ? 'mm' : 'N', value: noise(this.#s, i), status: 'ok', text: 'ok', age_s: 0.01, rate_hz: 1000,
      jitter_s: 1e-5, received: 1000 * this.#s, dropped: 0, lost: 0, gaps: 0 }));
  }
  #events(from) {
    const next = EVENTS + 1 + Math.floor(this.#s / EVENT_S);
    const first = Math.max(from, next - EVENTS);
    return { total: next - 1, next, events: Array.from({ length: next - first }, (_, i) => ({ number: first + i, utc: this.#utc((first + i - EVENTS) * EVENT_S), level: 'info', state: null,
      text: `sample clock of amplifier: ${first + i} readings late` })) };
  }
  #traces() {
    const first = Math.max(0, Math.round((this.#s - STEP_S) / BIN_S));
    return { step_s: BIN_S, first, bins: BINS, channels: this.#channels().map(({ name, unit }, c) => {
      const min = Array.from({ length: BINS }, (_, i) => Math.sin(0.5 * (first + i) + c));
      return { name, unit, min, max: min.map((v) => v + 0.01), breaks: [] };
    }) };
  }
}
