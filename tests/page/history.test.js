// Trends, deviations, the polar picture and the budget: geometry and words, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { adviceOn, budgetOf } from '../../daemon/page/budget.mjs';
import { deviationOf, History, HOUR_MS, ROOM, trendPaths, trendTexts } from '../../daemon/page/history.mjs';
import { phasorRows, placeLabels, polarOf, scalesText, shortened, shortNames } from '../../daemon/page/polar.mjs';
import { utcMs } from '../../daemon/page/wording.mjs';
import { dwellOf, settlingOf, toldFreshness, warningOf } from './sample.js';

const at = Date.parse('2026-11-23T07:00:00Z');
const withStiffness = (value, more) => {
  const dwell = dwellOf(more);
  dwell.elements[0].stiffness.value = value;
  return dwell;
};

test('a trend has the dwells that ended, the current one every ten seconds, and now', () => {
  const history = new History();
  history.takeEnded(withStiffness(24100, { index: 2 }), at);
  history.takeEnded(withStiffness(24100, { index: 2 }), at);
  for (let s = 0; s <= 25; s += 1) history.take(withStiffness(24000 + s, { end_s: 22 + s }), at + 60_000 + 1e3 * s);
  assert.deepEqual(history.of('stiffness', 1, at + 90_000).map((p) => p.value), [24100, 24000, 24010, 24020, 24025]);
  assert.equal(history.of('stiffness', 1, at + 30_000 + HOUR_MS).length, 4, 'what is older than an hour is left out');
  assert.equal(history.of('stiffness', 9, at).length, 0);
});

test('what is told again adds nothing, and a state stands where it was new', () => {
  const history = new History();
  history.take(withStiffness(24000, { estimate_age_s: 0.5 }), at);
  for (let s = 1; s <= 30; s += 1) history.take(withStiffness(24000, { estimate_age_s: 0.5 + s, stale: s > 5 }), at + 1e3 * s);
  const points = () => history.of('stiffness', 1, at + 60_000).map((p) => [p.ms - at, p.value]);
  assert.deepEqual(points(), [[-500, 24000]]);
  history.take(withStiffness(24001, { end_s: 53, estimate_age_s: 0.5 }), at + 31_000);
  assert.deepEqual(points(), [[-500, 24000], [30_500, 24001]]);
  history.take(withStiffness(24002, { end_s: 54, stale: true }), at + 42_000);
  assert.equal(points().length, 2);
});

test('the end of a dwell takes the place of its last point, so that short dwells cost one each', () => {
  const history = new History();
  for (let i = 1; i <= 5; ++i) {
    history.take(withStiffness(24000, { index: i }), at + 8000 * i);
    history.takeEnded(withStiffness(24000 + i, { index: i }), at + 8000 * i + 7000);
  }
  assert.deepEqual(history.of('stiffness', 1, at + 60_000).map((p) => p.value), [24001, 24002, 24003, 24004, 24005]);
});

test('a dwell that has ended and stays in view is not drawn on, and what was counted beyond its end is left out', () => {
  const history = new History();
  const counted = utcMs(dwellOf(), dwellOf().end_s);
  for (let s = -30; s <= 30; s += 1) history.take(withStiffness(s > 0 ? 25000 : 24000, { end_s: 22 + s }), counted + 1e3 * s);
  for (let s = 31; s <= 90; s += 1) history.take(withStiffness(24001, { state: 'complete', ended_by: 'end' }), counted + 1e3 * s);
  const points = history.of('stiffness', 1, counted + 90_000);
  assert.deepEqual(points.map((p) => [(p.ms - counted) / 1e3, p.value]), [[-30, 24000], [-20, 24000], [-10, 24000], [0, 24001]]);
});

test('there is room for so many points; more dwells than that in an hour push the oldest out', () => {
  const history = new History();
  const more = 40;
  for (let i = 1; i <= ROOM + more; ++i) history.takeEnded(withStiffness(i, { index: i }), at + 4000 * i);
  const values = history.of('stiffness', 1, at + 4000 * (ROOM + more)).map((p) => p.value);
  assert.deepEqual([values.length, values[0], values.at(-1)], [ROOM, more + 1, ROOM + more]);
  history.takeEnded(withStiffness(1, { index: ROOM + more + 1 }), at + 4000);
  assert.equal(history.of('stiffness', 1, at + 4000 * (ROOM + more))[0].value, more + 1, 'an older one finds no room');
});

test('what is told late stands where it belongs, and a rig with more elements begins without losing the others', () => {
  const history = new History();
  history.takeEnded(withStiffness(2, { index: 2 }), at + 60_000);
  history.takeEnded(withStiffness(1, { index: 1 }), at);
  const [element] = dwellOf().elements;
  history.takeEnded(dwellOf({ index: 3, elements: [1, 2, 3].map((k) => ({ ...element, k })) }), at + 120_000);
  assert.deepEqual(history.of('stiffness', 1, at + 120_000).map((p) => p.value), [1, 2, 24000]);
  assert.equal(history.of('stiffness', 3, at + 120_000).length, 1);
});

test('a dwell that has not settled adds nothing', () => {
  const history = new History();
  history.take(settlingOf(), at);
  history.takeEnded(settlingOf({ index: 1 }), at);
  assert.equal(history.of('stiffness', 1, at).length, 0);
});

// As the service tells it of element 1, whose stiffness has changed so.
const since = (stiffness, more = {}) => dwellOf({ since: { index: 2, start_utc: dwellOf().start_utc, end_s: 9,
  elements: [{ k: 1, stiffness, damping: null }], ...more } });

test('the change since the dwell before is told as the service tells it', () => {
  const said = (change, moved) => deviationOf(since({ change, U95: 0.00141, moved }), 'stiffness', 1, at);
  assert.deepEqual(said(0.0005, false), { moved: false, text: '+0.05 ± 0.14 % since dwell 2' });
  assert.deepEqual(said(0.0005, true), { moved: true, text: 'moved by +0.05 ± 0.14 % since dwell 2' }, 'the service judges');
  assert.deepEqual(said(-0.0417, true), { moved: true, text: 'moved by \u22124.17 ± 0.14 % since dwell 2' });
  assert.equal(said(-0.00001, false).text, '0.00 ± 0.14 % since dwell 2');
  assert.equal(deviationOf(dwellOf(), 'stiffness', 1, at), null);
  assert.equal(deviationOf(since(null), 'stiffness', 2, at), null);
});

// Of another run: its dwells are numbered from 1 again.
const EARLIER = '2026-11-23T06:00:00.000000Z';

test('the newest dwell before stays in the trend, though the list has not told its end', () => {
  const history = new History();
  history.takeEnded(withStiffness(20000, { index: 1 }), at);
  // Dwell 2 is seen for 18 s. A new run begins at once, and the service's list is empty.
  for (let s = 0; s <= 18; s += 1) history.take(withStiffness(23900 + s, { index: 2, end_s: 22 + s }), at + 60_000 + 1e3 * s);
  history.take(withStiffness(24012), at + 80_000);
  assert.deepEqual(history.of('stiffness', 1, at + 80_000).map((p) => p.value), [20000, 23900, 23910, 23918, 24012]);
  history.takeEnded(withStiffness(23919, { index: 2 }), at + 79_000);
  assert.deepEqual(history.of('stiffness', 1, at + 80_000).map((p) => p.value), [20000, 23900, 23910, 23919, 24012], 'the end replaces what was seen last');
});

test('a dwell of an earlier run is named as such, with when it was', () => {
  const dwell = since({ change: -0.0417, U95: 0.0014, moved: true }, { index: 3, start_utc: EARLIER });
  assert.match(deviationOf(dwell, 'stiffness', 1, Date.parse(EARLIER)).text,
    /^moved by \u22124\.17 ± 0\.14 % since dwell 3 of an earlier run \(\d\d:\d\d:\d\d\)$/);
});

test('a dwell before that has no such number is not passed over in silence', () => {
  assert.deepEqual(deviationOf(since(null), 'stiffness', 1, at), { moved: false, text: 'nothing to compare with: dwell 2 has no number' });
});

test('a trend is drawn within its box, dwells apart', () => {
  const points = [{ ms: at - HOUR_MS / 4, from: at - HOUR_MS / 2, value: 10, U95: 1, key: 'a' }, { ms: at, from: at - 1, value: 12, U95: 1, key: 'b' }];
  const { line, band } = trendPaths(points, at, HOUR_MS / 2, 100, 32);
  assert.equal(line.match(/M/g).length, 2);
  assert.match(line, /^M0\.0 31\.0L50\.0 31\.0M97\.0 16\.0L100\.0 16\.0$/, 'half an hour fills the width');
  for (const [, y] of band.matchAll(/ (-?[\d.]+)/g)) assert.ok(y >= 0 && y <= 32, y);
  assert.equal(trendPaths([], at, HOUR_MS, 100, 32), null);
  assert.doesNotMatch(trendPaths([{ ms: at, from: at, value: 0, U95: 0, key: 'a' }], at, HOUR_MS, 100, 32).line, /NaN/);
});

test('all trends show the same time: since the first dwell that is known, a minute at least, an hour at most', () => {
  const history = new History();
  assert.equal(history.reachMs(at), null);
  const settled = utcMs(dwellOf(), dwellOf().settled_s);
  history.takeEnded(dwellOf({ index: 2 }), settled + 10_000);
  assert.equal(history.reachMs(settled + 20_000), 60_000);
  assert.equal(history.reachMs(settled + 720_000), 720_000);
  assert.equal(history.reachMs(settled + HOUR_MS + 5000), HOUR_MS);
  assert.equal(history.reachMs(settled + HOUR_MS + 10_000), null, 'it is older than an hour');
});

test('a trend says how high it is, and what its line does for those who do not see it', () => {
  const points = [9.95, 10.02, 10].map((value, i) => ({ ms: at - 1e3 * (2 - i), from: at - 4000, value, U95: 0.01, key: 'a' }));
  const { half } = trendPaths(points, at, 60_000, 100, 32);
  assert.ok(Math.abs(half - 0.05) < 1e-12, 'an older value was further away than twice U95');
  assert.deepEqual(trendTexts(points, 720_000, half), { height: '± 0.5 %',
    spoken: 'Trend of the last 720 s: from the newest value \u22120.5 % to +0.2 %, height ± 0.5 %' });
  const one = points.slice(2);
  assert.equal(trendTexts(one, HOUR_MS, trendPaths(one, at, HOUR_MS, 100, 32).half).height, '± 0.2 %', 'twice U95');
  assert.deepEqual(trendTexts([{ ...points[0], value: 0 }], HOUR_MS, 1), { height: '', spoken: 'Trend of the last 60 min' });
});

// A doubted value at the edge stretched the height to ± 45 %, and the sound ones lay flat.
test('what is doubted sets no scale and no middle: hatching stands over its time, and the words say so', () => {
  const point = (s, value, doubted = false) => ({ ms: at - 1e3 * s, from: at - 1e3 * s - 5000, value, U95: 0.1, doubted, key: String(s) });
  const sound = [point(30, 10.3), point(20, 10)];
  const [alone, all] = [sound, [point(50, 14, true), ...sound, point(0, 6, true)]].map((points) => ({ ...trendPaths(points, at, 60_000, 100, 32), points }));
  assert.deepEqual([all.line, all.band, all.half], [alone.line, alone.band, alone.half]);
  assert.equal(alone.hatch, '');
  const strokes = all.hatch.split('M').slice(1).map((stroke) => Number(stroke.split(' ')[0]));
  assert.ok(strokes.length >= 2 && strokes.every((x) => x < 20 || x > 80), `hatched at ${strokes}`);
  assert.equal(trendTexts(all.points, 60_000, all.half).spoken,
    `${trendTexts(sound, 60_000, alone.half).spoken}; without values that must not be relied on`);
  const none = [point(50, 14, true)];
  assert.equal(trendPaths(none, at, 60_000, 100, 32).line, '');
  assert.deepEqual(trendTexts(none, 60_000, null), { height: '', spoken: 'Trend of the last 60 s: none of its values can be relied on' });
});

test('a doubt holds for the element and the dwell that it is of, also for what was told before it came, and after the end', () => {
  const history = new History();
  const doubt = warningOf([], [{ elements: [2], what: 'r_2 is negative' }]);
  const doubted = (k) => history.of('stiffness', k, at + 90_000).map((p) => p.doubted);
  history.take(dwellOf({ index: 1 }), at);
  history.take(dwellOf({ index: 1, end_s: 42, ...doubt }), at + 20_000);
  assert.deepEqual([doubted(1), doubted(2)], [[false, false], [true, true]]);
  history.takeEnded(dwellOf({ index: 1, ...doubt }), at + 21_000);
  history.takeEnded(dwellOf({ index: 2 }), at + 60_000);
  assert.deepEqual(doubted(2), [true, true, false]);
  assert.equal(history.someDoubted(at + 90_000), true);
  assert.equal(history.someDoubted(at + 21_000 + HOUR_MS), false);
  history.takeEnded(dwellOf({ index: 2, ...warningOf([], [{ elements: [], what: 'the model is contradicted' }]) }), at + 60_000);
  assert.deepEqual([doubted(1), doubted(2)], [[false, false, true], [true, true, true]]);
});

test('the points of a dwell around an outage are not joined', () => {
  const point = (s, value) => ({ ms: at - 1e3 * s, from: at - 240_000, value, U95: 1, key: 'a' });
  const { line } = trendPaths([point(220, 10), point(210, 10), point(20, 12), point(10, 12), point(0, 12)], at, 240_000, 100, 32);
  const pieces = line.split('M').slice(1).map((piece) => piece.split('L').map((xy) => Number(xy.split(' ')[0])));
  assert.equal(pieces.length, 2);
  assert.equal(pieces[0][0], 0, 'the first point of the dwell holds from the beginning of its data');
  assert.ok(pieces[1][0] > 85, `the second piece begins at ${pieces[1][0]}: after the outage`);
});

test('the wide band at a dwell\'s beginning does not flatten the hour', () => {
  const points = [{ ms: at - 3000, from: at - 4000, value: 10.1, U95: 5, key: 'a' }, { ms: at, from: at - 4000, value: 10, U95: 0.1, key: 'a' }];
  const { line, band } = trendPaths(points, at, 60_000, 100, 32);
  assert.match(line, / 8\.5L100\.0 16\.0$/, 'one U of the newest is a quarter of the height');
  for (const [, y] of band.matchAll(/ (-?[\d.]+)/g)) assert.ok(y >= 1 && y <= 31, y);
});

const phasor = (channel, amplitude, phase_rad, more) => ({ channel, unit: 'm', amplitude, phase_rad, u_amplitude: amplitude / 100,
  u_relative_phase_rad: 0.02, valid: true, ...more });

test('phases are relative to the first channel, each unit has its own scale, ellipses are 2.45 u', () => {
  const polar = polarOf([phasor('y0', 0.004, 1), phasor('y1', 0.002, 1 + Math.PI / 2), phasor('f', 50, 1, { unit: 'N' }),
    { channel: 'y2', valid: false, reason: 'stale', unit: 'm', amplitude: null }], 100);
  const [y0, y1, f] = polar.arrows;
  assert.deepEqual([y0.x, Math.abs(y0.y), f.x], [100, 0, 100]);
  assert.ok(Math.abs(y1.x) < 1e-9 && Math.abs(y1.y + 50) < 1e-9, 'ahead by 90°: up');
  assert.ok(Math.abs(y0.radial - 2.45) < 1e-9);
  assert.ok(Math.abs(y1.tangential - 2.45 * 0.02 * 50) < 1e-9);
  assert.deepEqual(polar.silent, [{ channel: 'y2', reason: 'stale' }]);
  assert.deepEqual(polarOf([], 100).arrows, []);
});

test('before the dwell has settled no ellipse is drawn, and none is spoken of', () => {
  const phasors = [phasor('y0', 0.004, 1), phasor('y1', 0.002, 1)];
  const polar = polarOf(phasors, 100, false);
  for (const arrow of polar.arrows) assert.deepEqual([arrow.radial, arrow.tangential], [0, 0]);
  assert.equal(scalesText(polar, false), 'Circle: 4.00 mm (solid); phases to y0.');
  assert.equal(scalesText(polarOf(phasors, 100), true), 'Circle: 4.00 mm (solid); phases to y0. Ellipses hold 95 % (k = 2.45).');
  assert.equal(scalesText(polarOf([], 100), true), '');
});

test('a channel that has gone strikes its phasor while the dwell is measured, not the result of one that has ended', () => {
  const phasors = [phasor('y0', 0.004, 1), phasor('y1', 0.002, 1)].map((p) => ({ ...p, mean: 0, harmonics: [] }));
  const struck = (dwell) => {
    const fresh = toldFreshness();
    fresh.tookDwell(dwell, 100);
    return phasorRows({ dwell, fresh, now: 100.1, health: { stale: ['y1'] }, channels: [{ name: 'y1', age_s: 5 }] }).map((row) => row.struck);
  };
  assert.deepEqual(struck(dwellOf({ phasors })), [null, '5.0 s']);
  assert.deepEqual(struck(settlingOf({ phasors })), [null, '5.0 s']);
  assert.deepEqual(struck(dwellOf({ phasors, state: 'complete' })), [null, null]);
});

test('labels do not overlap and stay beside the circle', () => {
  const arrows = Array.from({ length: 9 }, (_, i) => ({ x: 90, y: 80 + i }));
  const at9 = placeLabels(arrows, 15, 100).map((a) => a.at).sort((a, b) => a - b);
  for (let i = 1; i < at9.length; ++i) assert.ok(at9[i] - at9[i - 1] >= 15 - 1e-9);
  assert.ok(at9.at(-1) <= 100);
  const many = placeLabels(Array.from({ length: 31 }, () => ({ x: 90, y: 0 })), 15, 100);
  assert.ok(many.every((a) => Math.abs(a.at) <= 100 + 1e-9 && a.gap < 6.7), 'many stand closer, none leaves the picture');
});

test('the budget says what to do about the largest part, noise of all channels as one', () => {
  const element = { budget: [{ source: 'noise of y1', kind: 'noise', channel: 'y1', stiffness_share: 0.2, damping_share: 0.5 },
    { source: 'scale of y1', kind: 'scale', channel: 'y1', stiffness_share: 0.5, damping_share: 0.1 },
    { source: 'noise of y0', kind: 'noise', channel: 'y0', stiffness_share: 0.2, damping_share: 0.4 },
    { source: 'frequency', kind: 'frequency', stiffness_share: 0.001, damping_share: 0 }] };
  assert.deepEqual(budgetOf(element, 'stiffness').bars, [{ source: 'scale of y1', share: 0.5 }, { source: 'noise of all channels', share: 0.4 }]);
  assert.equal(budgetOf(element, 'stiffness').advice, 'calibrate the scale of y1');
  assert.equal(budgetOf(element, 'damping').advice, 'measure longer');
  assert.equal(budgetOf({}, 'damping').advice, null);
  assert.equal(adviceOn({ source: 'm2', kind: 'mass', mass: 2 }), 'weigh mass 2 more exactly');
  assert.equal(adviceOn({ source: 'delay of noise of y', kind: 'delay', channel: 'noise of y' }), 'measure the delay of noise of y', 'a channel may have any name');
  assert.equal(adviceOn({ source: 'delay of line', kind: 'delay', device: 'line' }), 'measure the delay of line');
  assert.equal(adviceOn({ source: 'turnaround of line (y0, y1)', kind: 'turnaround', device: 'line' }), 'measure the delay of line');
  assert.equal(adviceOn({ source: 'errors to second order', kind: 'second order' }), 'look at: errors to second order');
});

// Cut without a mark, long names of one rig looked alike.
test('a name that finds no room has … where it is cut, and no two look alike', () => {
  const fits = (text) => [...text].length <= 9;
  assert.equal(shortened('reaction', fits), 'reaction');
  assert.equal(shortened('acceleration', fits), 'acce…tion');
  assert.equal(shortened('x', () => false), '…');
  assert.deepEqual(shortNames(['y0', 'suspension front left', 'suspension front right'], fits), ['y0', 'susp…left', 'susp…ight']);
  const middle = ['tower of the rig, mass 1, displacement', 'tower of the rig, mass 2, displacement'];
  assert.deepEqual(shortNames(middle, fits), ['…1, disp…', '…2, disp…']);
  const three = ['1234 a long 567 name 1234', '1234 a long 568 name 1234', '1234 b long 567 name 1234'];
  assert.equal(new Set(shortNames(three, fits)).size, 3);
});
