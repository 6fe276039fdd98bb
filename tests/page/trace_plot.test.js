// What is drawn of a trace: on a canvas that notes each line; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { TracePlot } from '../../daemon/page/trace_plot.mjs';
import { TraceWindow } from '../../daemon/page/trace_window.mjs';

const WIDTH = 1016; // px: 10 px a bin, 8 px of margin on both sides
const BINS = 100;

// Draws one channel, whose bins reach from min[i] to max[i]. Returns what was drawn, in order: ['move', x, y],
// ['line', x, y] or ['text', x, letters, y, px]. rem: px. cursors: instants with their names.
function penOf({ min, max = min, breaks = [] }, { width = WIDTH, height = 100, rem = 16, cursors = [], view = { from_s: 0, to_s: BINS, end: 'now' } } = {}) {
  globalThis.document = { documentElement: null };
  globalThis.getComputedStyle = () => ({ getPropertyValue: () => '', fontSize: `${rem}px` });
  globalThis.devicePixelRatio = 1;
  const steps = [];
  let size = 0;
  const context = new Proxy({}, {
    get: (_, name) => ({
      moveTo: (x, y) => steps.push(['move', x, y]),
      lineTo: (x, y) => steps.push(['line', x, y]),
      fillText: (text, x, y) => steps.push(['text', x, text, y, size]),
      measureText: () => ({ width: 0 }),
    }[name] ?? (() => {})),
    set: (_, name, value) => {
      if (name === 'font') size = parseFloat(value);
      return true;
    },
  });
  const channel = { name: 'y0', unit: 'mm', min, max, breaks };
  const window = new TraceWindow({ origin_utc: '2026-11-23T07:00:00.000000Z', step_s: 1, from_s: 0, bins: BINS, less_dwell: null, channels: [channel] });
  new TracePlot({ getContext: () => context, clientWidth: width, clientHeight: height }).draw(window, view, cursors, [null]);
  return steps;
}

const binAt = (x) => Math.floor((x - 8) / 10);

// The instants, in bins, from and to which a line goes across: [[from, to], …].
function linesAcross(values, breaks) {
  const lines = [];
  let at = null;
  for (const [does, x] of penOf({ min: values, breaks })) {
    if (does === 'line' && x !== at) lines.push([at, x]);
    if (does !== 'text') at = x;
  }
  const border = ([from, to]) => from === 0 && to === WIDTH; // below the trace
  return lines.filter((line) => !border(line)).map((line) => line.map(binAt));
}

const readings = (...at) => Array.from({ length: BINS }, (_, i) => (at.includes(i) ? i : null));

test('a line joins readings that follow each other, over bins without a reading as well', () => {
  assert.deepEqual(linesAcross(readings(10, 11, 20), []), [[10, 11], [11, 20]]);
});

test('no line goes to a bin in which readings are missing, and none leaves it', () => {
  assert.deepEqual(linesAcross(readings(10, 11, 12, 13), [11]), [[12, 13]]);
  // The channel failed in a bin that had a reading, and delivers again ten bins later: nothing is known in between.
  assert.deepEqual(linesAcross(readings(10, 11, 21, 22), [11]), [[21, 22]]);
  assert.deepEqual(linesAcross(readings(10, 20), [15]), []);
});

test('a line reaches the least and the greatest reading of every bin, and has no corner on the way from one to the other', () => {
  let state = 1;
  const random = () => ((state = (state * 48271) % 2147483647) / 2147483647);
  const min = Array.from({ length: BINS }, () => random() - 0.9);
  const max = min.map((low) => low + 0.5 * random());
  const scale = Math.max(...max, ...min.map((low) => -low)) > 0.5 ? 1 : 0.5;
  const y = (value) => (100 - 22) / 2 * (1 - value / scale) + 3 * value / scale;
  const trace = penOf({ min, max }).filter(([does, x]) => does !== 'text' && x % 10 === 3); // in the middle of a bin
  let before = null;
  for (let bin = 0, at = 0; bin < BINS; ++bin) {
    const here = [];
    for (; at < trace.length && binAt(trace[at][1]) === bin; ++at) here.push(trace[at][2]);
    const passed = [...(before === null ? [] : [before]), ...here];
    assert.ok(Math.max(...passed) > y(min[bin]) - 1e-6 && Math.min(...passed) < y(max[bin]) + 1e-6, `bin ${bin}: ${passed}`);
    assert.ok(passed.length < 3 || (passed[1] - passed[0]) * (passed[2] - passed[1]) < 0, `a needless corner in bin ${bin}: ${passed}`);
    before = here.at(-1);
  }
});

// Once a mark at 12 s read 10 s, and one at 1.5 s read 2 s.
test('a mark of time tells its own instant, in every view and at every width', () => {
  const unit = { s: 1, ms: 1e-3, '\u00b5s': 1e-6, ks: 1e3 };
  for (const width of [200, 360, 700, 1408, 2528, 3840])
    for (const span of [0.02, 0.3, 0.687, 1.25, 2.5, 5, 10, 20, 40, 60, 150, 160, 600, 7200]) {
      const view = { from_s: 100, to_s: 100 + span, end: 'now' };
      const marks = penOf({ min: readings() }, { width, view }).filter(([does, , text]) => does === 'text' && /^\u2212/.test(text));
      assert.ok(marks.length > 0 || width < 360, `no marks in ${span} s on ${width} px`);
      for (const [, x, text] of marks) {
        const [, value, prefix] = text.match(/^\u2212([\d.\u202f ]+) (\S+)$/) ?? assert.fail(text);
        const told = Number(value.replace(/[\u202f ]/g, '')) * (unit[prefix] ?? assert.fail(text));
        const at = span * (1 - (x - 8) / (width - 16));
        assert.ok(Math.abs(told - at) <= 1.01 * span / (width - 16), `"${text}" stands at ${at} s, of ${span} s on ${width} px`);
      }
    }
});

test('letters are as large as the display has them, where a lane has room, and none stands on another', () => {
  const written = (options) => penOf({ min: readings(1, 2) }, options).filter(([does]) => does === 'text');
  for (const [rem, height, size] of [[16, 100, 12], [16, 40, 12], [48, 100, 36], [48, 50, 18], [48, 30, 12]])
    for (const [, , text, , px] of written({ rem, height })) assert.equal(px, size, `"${text}" at a rem of ${rem} px, ${height} px high`);
  for (const [rem, height] of [[16, 100], [48, 100], [48, 50], [32, 60]]) {
    const texts = written({ rem, height, cursors: [['A', 25], ['B', 100]] });
    const line = (wanted) => texts.find(([, , text]) => wanted.test(text))[3];
    const size = texts[0][4];
    const [scale, now] = [line(/^y0/), line(/^now$/)];
    assert.ok(scale < now - size && now < height, `the scale at ${scale}, the times at ${now}, ${size} px of ${height}`);
    assert.ok(line(/^A$/) === line(/^B$/) && line(/^A$/) < now - size, `a cursor's name at ${line(/^A$/)}, the times at ${now}`);
  }
});
