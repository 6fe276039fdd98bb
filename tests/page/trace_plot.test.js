// What is drawn of a trace: on a canvas that notes each line; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { TracePlot } from '../../daemon/page/trace_plot.mjs';
import { TraceWindow } from '../../daemon/page/trace_window.mjs';

const WIDTH = 1016; // px: 10 px a bin, 8 px of margin on both sides
const BINS = 100;

// The instants, in bins, from and to which a line goes across: [[from, to], …].
function linesAcross(values, breaks) {
  globalThis.document = { documentElement: null };
  globalThis.getComputedStyle = () => ({ getPropertyValue: () => '' });
  globalThis.devicePixelRatio = 1;
  const lines = [];
  let at = null;
  const context = new Proxy({}, {
    get: (_, name) => ({
      moveTo: (x) => { at = x; },
      lineTo: (x) => { if (x !== at) lines.push([at, x]); at = x; },
      measureText: () => ({ width: 0 }),
    }[name] ?? (() => {})),
    set: () => true,
  });
  const channel = { name: 'y0', unit: 'mm', min: values, max: values, breaks };
  const window = new TraceWindow({ origin_utc: '2026-11-23T07:00:00.000000Z', step_s: 1, from_s: 0, bins: BINS, less_dwell: null, channels: [channel] });
  new TracePlot({ getContext: () => context, clientWidth: WIDTH, clientHeight: 100 }).draw(window, { from_s: 0, to_s: BINS, end: 'now' }, [], [null]);
  const border = ([from, to]) => from === 0 && to === WIDTH; // below the trace
  return lines.filter((line) => !border(line)).map((line) => line.map((x) => Math.floor((x - 8) / 10)));
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
