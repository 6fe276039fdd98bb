// What the page asks for, and when, without a browser: the service is a function, and time passes as the test says.
import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import { Feed } from '../../daemon/page/feed.mjs';
import { dwellOf, OLD_AFTER } from './sample.js';

const START_MS = Date.parse(dwellOf().start_utc);
const [rightFetch, rightInterval, rightDate] = [globalThis.fetch, globalThis.setInterval, Date.now];

let now; // s since the run began
let ask; // of the feed, as its interval does
let asked; // paths since they were last looked at
let told; // answers by path, each { … }, or a function of the query; an Error: the question fails
let source; // the stream that is open
let opened; // streams so far

class Stream extends EventTarget {
  static CLOSED = 2;
  readyState = 1;
  constructor() {
    super();
    source = this;
    opened += 1;
  }
  close() {
    this.readyState = Stream.CLOSED;
  }
  say(type, value) {
    this.dispatchEvent(Object.assign(new Event(type), { data: JSON.stringify(value) }));
  }
}

beforeEach(() => {
  now = 100;
  asked = [];
  opened = 0;
  Object.assign(globalThis, { EventSource: Stream, location: { reload() {} },
    setInterval: (act) => (ask = act),
    fetch: async (url) => {
      const path = url.replace('/api/v1/', '');
      asked.push(path);
      const [what, query] = path.split('?');
      const answer = typeof told[what] === 'function' ? await told[what](new URLSearchParams(query)) : told[what];
      if (answer instanceof Error || answer === undefined) throw answer ?? new Error(`nobody answers ${path}`);
      return { ok: true, status: 200, json: async () => structuredClone(answer) };
    } });
  Date.now = () => START_MS + 1e3 * now;
  told = { health: () => ({ version: '1', utc: new Date(START_MS + 1e3 * now).toISOString(), uptime_s: now, ...OLD_AFTER }),
    channels: { channels: [] }, alarms: { alarms: [] }, events: { total: 0, next: 1, events: [] },
    dwells: { total: 0, dwells: [], file: null }, runs: { runs: [], total: 0 } };
});
afterEach(() => {
  Object.assign(globalThis, { fetch: rightFetch, setInterval: rightInterval });
  Date.now = rightDate;
});

const settle = () => new Promise((done) => setTimeout(done));
function begin() {
  const feed = new Feed({ now: () => now }, () => {}, { begun() {}, take() {} });
  feed.begin();
  return feed;
}
// So many seconds pass: the page asks once in each.
async function pass(seconds, each = () => {}) {
  for (let s = 0; s < seconds; ++s) {
    now += 1;
    each();
    ask();
    await settle();
  }
}
const askedOf = (what) => asked.splice(0).filter((path) => path.split('?')[0] === what);

const finished = (index, more) => dwellOf({ index, state: 'complete', start_s: 10 * index, settled_s: 10 * index + 2, end_s: 10 * index + 9, ended_by: 'drive changed', ...more });
const verdict = (words) => ({ model: { verdict: words, seen: null, U: null, asked: 0.05, consistent: true } });

test('a verdict or a doubt that comes after the end of a dwell is taken, although newer dwells have ended', async () => {
  const list = [finished(1), finished(2, verdict('not verified yet')), finished(3, verdict('not verified yet'))];
  told.dwells = (query) => ({ total: 3, dwells: list.filter((d) => d.index >= Number(query.get('from') ?? 0)), file: null });
  told['dwells/3'] = () => list[2];
  const feed = begin();
  source.say('dwell', dwellOf({ index: 4, state: 'idle', settled_s: null, elements: [] }));
  await settle();
  assert.deepEqual(feed.dwells.map((d) => d.index), [1, 2, 3]);
  list[1] = finished(2, verdict('adequate'));
  list[2] = finished(3, { ...verdict('not adequate'), doubts: [{ elements: [], what: 'a line lies on the drive' }] });
  await pass(11);
  assert.deepEqual(feed.dwells.map((d) => d.model?.verdict), [undefined, 'adequate', 'not adequate']);
  assert.equal(feed.last.model.verdict, 'not adequate');
  assert.equal(feed.last.doubts().length, 1);
  list[2] = finished(3, verdict('adequate'));
  await pass(11);
  assert.equal(feed.last.model.verdict, 'adequate', 'it is asked for again, whatever its verdict was');
});

test('a seldom question that fails or hangs keeps none of the others from being asked', async () => {
  told.events = new Error('timeout');
  told.runs = { runs: [{ run: 1, dwells_at: null }], total: 1 };
  const feed = begin();
  await settle();
  assert.equal(feed.runsTotal, 1);
  told.events = () => new Promise(() => {}); // no answer comes
  await pass(10);
  asked.length = 0;
  await pass(5);
  assert.equal(askedOf('health').length, 5, 'what is asked for once a second goes on');
});

test('after a restart all events are asked for at once, although their numbers have passed those of before', async () => {
  const events = (from, next) => ({ total: next - 1, next, events: Array.from({ length: next - from }, (_, i) => ({ number: from + i, text: `event ${from + i}` })) });
  let next = 4;
  let began = 0;
  told.events = (query) => events(Number(query.get('from') ?? 1), next);
  const { health } = told;
  told.health = () => ({ ...health(), uptime_s: now - began });
  const feed = begin();
  await settle();
  assert.deepEqual(feed.events.map((e) => e.number), [1, 2, 3]);
  next = 5;
  await pass(11);
  assert.deepEqual(feed.events.map((e) => e.number), [1, 2, 3, 4]);
  assert.deepEqual(askedOf('events'), ['events', 'events?from=4']);
  began = now;
  next = 9;
  await pass(2);
  assert.deepEqual(askedOf('events'), ['events']);
  assert.deepEqual(feed.events.map((e) => e.number), [1, 2, 3, 4, 5, 6, 7, 8]);
  next = 3; // and again, told by the events alone
  told.health = () => ({ ...health(), uptime_s: null });
  await pass(11);
  assert.deepEqual(feed.events.map((e) => e.number), [1, 2]);
});

test('a stream that tells anything is not opened anew, one that is silent is', async () => {
  begin();
  await pass(20, () => source.say('traces', {}));
  assert.equal(opened, 1);
  await pass(7);
  assert.equal(opened, 2);
});

test('the file of an earlier run that could not be read is asked for again, a few times; until then the page says what the trend lacks', async () => {
  const run = (number) => ({ run: number, ended: new Date(START_MS).toISOString(), dwells_at: `/api/v1/runs/${number}/dwells` });
  told.runs = { runs: [run(7), run(8)], total: 2 };
  told['runs/7/dwells'] = new Error('timeout');
  told['runs/8/dwells'] = new Error('timeout');
  const feed = begin();
  await settle();
  assert.deepEqual(feed.trendLacks(), [8, 7]);
  told['runs/7/dwells'] = { dwells: [finished(1)] };
  await pass(11);
  assert.deepEqual(feed.trendLacks(), [8]);
  assert.equal(feed.history.of('stiffness', 1, START_MS + 1e3 * now).length, 1);
  await pass(40);
  assert.equal(askedOf('runs/8/dwells').length, 3);
  assert.deepEqual(feed.trendLacks(), [8]);
  now += 3600;
  assert.deepEqual(feed.trendLacks(), [], 'the trend begins later');
});

// What the service answers of so many dwells of 10 s: at most 100, and no more than `fits` bytes allow.
const listOf = (count, fits = 100) => (query) => {
  const all = Array.from({ length: count }, (_, i) => finished(i + 1));
  const from = query.get('from');
  const most = Math.min(Number(query.get('count')), fits);
  const dwells = from ? all.slice(from - 1, from - 1 + most) : all.slice(-most);
  return { total: count, next: from && dwells.at(-1).index < count ? dwells.at(-1).index + 1 : null, dwells, file: null };
};
const trendOf = (feed) => feed.history.of('stiffness', 1, START_MS + 1e3 * now).map((p) => (p.ms - START_MS) / 1e3);
const endsOf = (first, last) => Array.from({ length: last - first + 1 }, (_, i) => 10 * (first + i) + 9);

test('a page that is opened late asks back until its trend covers the hour; the newest dwells are kept, and how many there are', async () => {
  now = 4510; // 449 dwells of 10 s have ended
  told.dwells = listOf(449);
  const feed = begin();
  source.say('dwell', dwellOf({ index: 450, state: 'idle', settled_s: null, elements: [] }));
  await settle();
  assert.deepEqual(askedOf('dwells').map((path) => path.split('from=')[1]), [undefined, '250', '150', '50']);
  assert.deepEqual(trendOf(feed), endsOf(91, 449));
  assert.deepEqual([feed.dwells.length, feed.dwells[0].index, feed.dwells.at(-1).index, feed.dwellsTotal], [300, 150, 449, 449]);
});

test('where an answer holds fewer dwells than were asked for, none is left out of the trend', async () => {
  now = 1510;
  told.dwells = listOf(149, 30);
  const feed = begin();
  await settle();
  assert.deepEqual(trendOf(feed), endsOf(1, 149));
});

test('a question further back that failed is asked again where it was', async () => {
  now = 3510;
  told.dwells = (query) => (query.get('from') === '150' ? new Error('timeout') : listOf(349)(query));
  const feed = begin();
  await settle();
  assert.deepEqual(trendOf(feed), endsOf(250, 349));
  told.dwells = listOf(349);
  await pass(11);
  assert.deepEqual(trendOf(feed), endsOf(1, 349));
});

test('it asks back seven times at most: the trend has no room for more dwells', async () => {
  now = 10 * 1000;
  told.dwells = (query) => {
    const answer = listOf(999)(query);
    return { ...answer, dwells: answer.dwells.map((d) => ({ ...d, end_s: 9999 - (1000 - d.index), settled_s: 9998 - (1000 - d.index) })) };
  };
  begin();
  await settle();
  assert.equal(askedOf('dwells').length, 8);
});

test('of a run of this hour that has ended, all dwells of the hour are in the trend', async () => {
  now = 2600;
  told.runs = { runs: [{ run: 7, ended: new Date(START_MS + 2.5e6).toISOString(), dwells_at: '/api/v1/runs/7/dwells' }], total: 1 };
  told['runs/7/dwells'] = listOf(249);
  const feed = begin();
  await settle();
  assert.deepEqual(trendOf(feed), endsOf(1, 249));
});

test('a file may take a minute to be read', async (t) => {
  const given = [];
  t.mock.method(AbortSignal, 'timeout', (ms) => given.push(ms) && new AbortController().signal);
  told.runs = { runs: [{ run: 7, ended: new Date(START_MS).toISOString(), dwells_at: '/api/v1/runs/7/dwells' }], total: 1 };
  begin();
  await settle();
  assert.ok(given.at(-1) > 60_000 && given[0] === 2000, given.join());
});
