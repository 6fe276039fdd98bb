// What the page keeps of the traces, and what it saves of them; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { agesOf, csvName, csvOf, cursorTexts, finestOf, savedText, TraceWindow } from '../../daemon/page/trace_window.mjs';

const channel = (min, max, breaks = []) => ({ name: 'y0', unit: 'mm', min, max, breaks });
const answerOf = (changes = {}) => ({ origin_utc: '2026-11-23T07:00:00.000000Z', step_s: 0.02, from_s: 2, bins: 3, less_dwell: null, channels: [channel([1, null, 3], [2, null, 4], [2])], ...changes });
const eventOf = (first, values, breaks = []) => ({ step_s: 0.02, first, bins: values.length, channels: [{ min: values, max: values, breaks }] });
const lows = (window) => Array.from({ length: window.bins }, (_, i) => window.low(0, i));

test('an answer is kept bin by bin: a bin without a reading is none, a break stays one', () => {
  const window = new TraceWindow(answerOf());
  assert.deepEqual(lows(window), [1, NaN, 3]);
  assert.equal(window.high(0, 2), 4);
  assert.deepEqual([0, 1, 2].map((i) => window.broken(0, i)), [false, false, true]);
  assert.equal(window.from_s, 2);
  assert.ok(Math.abs(window.to_s - 2.06) < 1e-12);
});

test('the stream goes on where the answer ends, and what both hold is kept once', () => {
  const window = new TraceWindow(answerOf());
  assert.equal(window.take(eventOf(102, [3, 7], [1])), true);
  assert.deepEqual(lows(window), [1, NaN, 3, 7]);
  assert.equal(window.broken(0, 3), true);
});

test('of wider bins each holds the least and the greatest of what the stream brings', () => {
  const window = new TraceWindow(answerOf({ step_s: 0.08, from_s: 0.08, bins: 1, channels: [channel([5], [6])] }));
  assert.equal(window.take(eventOf(7, [4, 9, 8, 2, 3], [3])), true); // bins 7 | 8 9 10 11
  assert.deepEqual(lows(window), [4, 2]);
  assert.equal(window.high(0, 1), 9);
  assert.equal(window.broken(0, 1), true);
});

test('where an event was lost, the service began anew, or bins are finer than the stream, it says so', () => {
  assert.equal(new TraceWindow(answerOf()).take(eventOf(104, [1])), false);
  assert.equal(new TraceWindow(answerOf()).take(eventOf(99, [1])), false);
  assert.equal(new TraceWindow(answerOf({ step_s: 0.005, from_s: 2 })).take(eventOf(101, [1])), false);
});

test('readings less the steady part are never joined by those of the stream', () => {
  const window = new TraceWindow(answerOf({ less_dwell: 3, less_from_s: 1.5 }));
  assert.equal(window.take(eventOf(103, [7])), false);
  assert.equal(window.bins, 3);
});

test('the newest reading of a channel is that of its newest bin that has one', () => {
  assert.ok(Math.abs(new TraceWindow(answerOf()).last_s(0) - 2.06) < 1e-12);
  assert.ok(Math.abs(new TraceWindow(answerOf({ channels: [channel([1, null, null], [2, null, null])] })).last_s(0) - 2.02) < 1e-12);
  assert.equal(new TraceWindow(answerOf({ channels: [channel([null, null, null], [null, null, null])] })).last_s(0), null);
});

test('a trace is old when its channel has told nothing for 2.5 s, all are when the stream has', () => {
  assert.deepEqual(agesOf([10, 7, null], 10, 0.1, 2.5), [null, 3.1, Infinity]);
  assert.deepEqual(agesOf([10, 9.5], 10, 4, 2.5), [4, 4.5]);
  assert.deepEqual(agesOf([10, 9.5], 10, 1, 2.5), [null, null]);
});

test('it holds a fixed number of bins however long it goes on, the newest ones', () => {
  const window = new TraceWindow(answerOf(), 50);
  for (let i = 0; i < 1000; ++i) assert.equal(window.take(eventOf(103 + i, [i])), true);
  assert.ok(window.bins >= 50 && window.bins <= 100, `${window.bins}`);
  assert.equal(window.low(0, window.bins - 1), 999);
  assert.equal(window.low(0, window.bins - 50), 950);
  assert.ok(Math.abs(window.to_s - (103 + 1000) * 0.02) < 1e-9);
});

test('a cursor reads the bin under it, or the nearest reading beside it', () => {
  const window = new TraceWindow(answerOf());
  assert.deepEqual(window.at(0, 2.001), { low: 1, high: 2 });
  assert.deepEqual(window.at(0, 2.03), { low: 1, high: 2 });
  assert.equal(window.at(0, 2.5), null);
});

test('cursors read value and difference with their ± and unit, the digits as ± has them', () => {
  const [a, b] = [{ low: 5.1234, high: 5.1481 }, { low: 7.2, high: 7.3 }];
  assert.deepEqual(cursorTexts(a, b, 'mm'), { A: '5.136 ± 0.012 mm', B: '7.250 ± 0.050 mm', difference: '2.114 ± 0.062 mm' });
  assert.equal(cursorTexts(b, a, 'mm').difference, '\u22122.114 ± 0.062 mm');
  assert.deepEqual(cursorTexts({ low: -0.3, high: 0.1 }, a, 'N').A, '\u22120.10 ± 0.20 N');
  const one = { low: 5.12345678, high: 5.12345678 }; // one reading: within itself
  assert.deepEqual(cursorTexts(one, b, 'mm'), { A: '5.1235 mm', B: '7.250 ± 0.050 mm', difference: '2.127 ± 0.050 mm' });
  assert.equal(cursorTexts(one, one, 'mm').difference, '0 mm');
  assert.deepEqual(cursorTexts(null, b, 'mm'), { A: '—', B: '7.250 ± 0.050 mm', difference: '—' });
});

test('CSV holds the numbers as the service gave them, and its heads say what they are and since when t counts', () => {
  const answer = answerOf({ origin_utc: '2026-11-23T07:00:00.123456Z', channels: [channel([0.1, null, -3e-7], [0.2, null, 4])] });
  assert.equal(csvOf(answer), 't [s since 2026-11-23T07:00:00.123456Z],y0 min in 20 ms [mm],y0 max in 20 ms [mm]\n2,0.1,0.2\n2.02,,\n2.04,-3e-7,4\n');
  assert.equal(savedText(answer), 'the smallest and the largest reading of each 20 ms');
});

const FINEST_S = 0.02 / 64;
// A service that has a reading of y0 in every third of the narrowest bins, and one of y1 in the first; its numbers are those of the bins.
const serviceOf = (changes = () => ({})) => {
  const asked = [];
  const ask = async (from_s, to_s) => {
    asked.push([from_s, to_s]);
    const first = Math.round(from_s / FINEST_S);
    const bins = Math.round(to_s / FINEST_S) - first + 1;
    const list = (of) => Array.from({ length: bins }, (_, i) => of(first + i));
    const channels = [list((n) => (n % 3 === 0 ? n : null)), list((n) => (n === 6400 ? n : null))].map((values, c) => ({ name: `y${c}`, unit: 'mm', min: values, max: values, breaks: [] }));
    return { ...answerOf(), step_s: FINEST_S, from_s, bins, channels, ...changes(asked.length, channels) };
  };
  return { ask, asked };
};
const two = [channel([1], [2]), { ...channel([1], [2]), name: 'y1' }];
const inView = (from_s, to_s, changes) => answerOf({ from_s, bins: Math.round((to_s - from_s) / 0.02), newest_s: to_s, channels: two, ...changes });

test('a file of single readings has a row for each instant with a reading, from as many answers as that takes', async () => {
  const { ask, asked } = serviceOf();
  const readings = await finestOf(inView(2, 5), ask);
  assert.deepEqual(asked, [[2, 10399 * FINEST_S], [10400 * FINEST_S, 14399 * FINEST_S], [14400 * FINEST_S, 5]]);
  const [head, ...rows] = csvOf(readings).trimEnd().split('\n');
  assert.equal(head, 't [s since 2026-11-23T07:00:00.000000Z; readings are up to 0.3125 ms later],y0 [mm],y1 [mm]');
  const wanted = [[2, '', 6400], ...Array.from({ length: 3200 }, (_, i) => [(6402 + 3 * i) * FINEST_S, 6402 + 3 * i, ''])];
  assert.deepEqual(rows, wanted.map(([t, ...cells]) => [Number(t.toFixed(9)), ...cells].join(',')));
  assert.equal(savedText(readings), 'single readings, each within 0.3125 ms after its t');
});

test('where the view is too long, or readings are no longer kept, there are no single ones', async () => {
  const none = async (view, changes) => assert.equal(await finestOf(view, serviceOf(changes).ask), null);
  await none(inView(0, 20.1));
  await none(inView(0, 1.3, { less_dwell: 3 }), () => ({ less_dwell: 3 }));
  await none(inView(0, 5.1, { channels: Array(64).fill(two[0]) }));
  await none(inView(2, 5), () => ({ step_s: 0.02 }));
  assert.equal(await finestOf(inView(2, 5), async () => null), null, 'the service was started again meanwhile');
  assert.notEqual(await finestOf(inView(0, 20 - 0.02), serviceOf().ask), null);
  assert.notEqual(await finestOf(inView(0, 1.22, { less_dwell: 3 }), serviceOf(() => ({ less_dwell: 3 })).ask), null);
});

// One such bin made pairs of all columns.
test('where two readings of a channel are in one of the narrowest bins, the file has the smaller and the larger one of that channel', async () => {
  const twice = ([y0, y1]) => [{ ...y0, max: y0.max.map((value, i) => (i === 4 ? value + 1 : value)) }, y1];
  const finest = await finestOf(inView(2.0004, 2.0024, { bins: 1, step_s: 0.002 }), serviceOf((n, channels) => ({ channels: twice(channels) })).ask);
  assert.equal(csvOf(finest), 't [s since 2026-11-23T07:00:00.000000Z; readings are up to 0.3125 ms later],y0 min in 0.3125 ms [mm],y0 max in 0.3125 ms [mm],y1 [mm]\n' +
    '2.000625,6402,6402,\n2.0015625,6405,6406,\n');
  assert.equal(savedText(finest), 'single readings, each within 0.3125 ms after its t; of y0 the smallest and the largest reading of each 0.3125 ms, for two came within one');
});

test('CSV of readings less the steady part says so in every head and in its name, with the data it was fitted to', () => {
  const answer = answerOf({ less_dwell: 3, less_from_s: 1.5 });
  assert.equal(csvOf(answer).split('\n')[0],
    't [s since 2026-11-23T07:00:00.000000Z],y0 min in 20 ms less steady part of dwell 3 fitted from 1.5 s [mm],y0 max in 20 ms less steady part of dwell 3 fitted from 1.5 s [mm]');
  // The stretch answered may begin later than the one in view: the name is that of the first bin.
  assert.equal(csvName(answer), 'traces-less-steady-part-of-dwell-3-20261123T070002Z.csv');
  assert.equal(csvName(answerOf()), 'traces-20261123T070002Z.csv');
});
