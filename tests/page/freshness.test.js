// What the page takes for old, and when: by its own clock.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { applyChange } from '../../daemon/page/change.mjs';
import { Clock, Freshness } from '../../daemon/page/freshness.mjs';
import { dwellOf, idleOf, toldFreshness } from './sample.js';

test('a service that says nothing is gone within three seconds', () => {
  const fresh = toldFreshness();
  fresh.tookDwell(dwellOf(), 100);
  assert.equal(fresh.gone(102.4), false);
  assert.equal(fresh.gone(102.6), true);
  assert.equal(fresh.dwellOld(102.6), true);
  assert.equal(fresh.silence_s(778), 678);
  fresh.heard(778);
  assert.equal(fresh.gone(779), false);
});

test('before the service has said when numbers are old, only a question without an answer tells that it is gone', () => {
  const fresh = new Freshness();
  fresh.tookDwell(dwellOf(), 100);
  assert.equal(fresh.gone(1000), false);
  fresh.broke(1000);
  assert.equal(fresh.gone(1000), true);
  fresh.heard(1001);
  fresh.told({ old_after_s: 1, old_after_updates: 3 });
  assert.deepEqual([1001.9, 1002.1].map((t) => fresh.gone(t)), [false, true], 'as the service says');
});

test('a connection that is known to be broken is gone at once, until something is heard', () => {
  const fresh = toldFreshness();
  fresh.heard(10);
  fresh.broke(10.1);
  assert.equal(fresh.gone(10.1), true);
  fresh.heard(11);
  assert.equal(fresh.gone(11), false);
});

test('numbers are old where the service answers but the data stand still', () => {
  const fresh = toldFreshness();
  for (let t = 0; t <= 10; t += 1) fresh.tookDwell(dwellOf({ end_s: 12 + t }), t);
  for (let t = 10.1; t < 14; t += 0.1) fresh.tookDwell(dwellOf({ end_s: 22 }), t);
  assert.equal(fresh.gone(14), false);
  assert.equal(fresh.dwellOld(12.4), false);
  assert.equal(fresh.dwellOld(12.6), true);
  assert.ok(Math.abs(fresh.dwellAge_s(14) - 4) < 1e-9);
});

test('a page that is opened while the service tells a stale dwell shows it as old at once, with its true age', () => {
  const fresh = toldFreshness();
  fresh.tookDwell({ ...dwellOf(), estimate_age_s: 678, stale: true }, 100);
  assert.equal(fresh.gone(100), false);
  assert.equal(fresh.dwellOld(100), true);
  assert.equal(fresh.dwellAge_s(101), 679);
  fresh.tookDwell({ ...dwellOf({ end_s: 700 }), estimate_age_s: 0, stale: false }, 102);
  assert.equal(fresh.dwellOld(102), false);
  assert.equal(fresh.dwellAge_s(102), 0);
});

test('while idle there are no data that could stand still', () => {
  const fresh = toldFreshness();
  for (let t = 0; t < 100; t += 1) fresh.tookDwell(idleOf(), t);
  assert.equal(fresh.dwellOld(100), false);
});

test('the dwell of a run that was stopped has no data that could stand still', () => {
  const fresh = toldFreshness();
  fresh.tookDwell(dwellOf(), 0);
  for (let t = 1; t < 100; t += 1) fresh.tookDwell(dwellOf({ state: 'complete', ended_by: 'end', estimate_age_s: 0.1, stale: false }), t);
  assert.equal(fresh.dwellOld(100), false);
  fresh.tookDwell(dwellOf({ state: 'complete', ended_by: 'end', estimate_age_s: 4, stale: true }), 101);
  assert.equal(fresh.dwellOld(101), true, 'a service that no longer works');
});

test('a rig that is renewed every ten seconds is not old after five', () => {
  const fresh = toldFreshness();
  for (let t = 0; t <= 60; t += 10) fresh.tookDwell(dwellOf({ end_s: t }), t);
  fresh.heard(64.9);
  assert.equal(fresh.dwellOld(65), false);
  fresh.heard(85.1);
  assert.equal(fresh.dwellOld(85.1), true);
});

test('a computer that slept does not take the numbers of before for fresh', () => {
  let monotonic = 1000;
  let wall = 5000;
  const clock = new Clock(() => monotonic, () => wall);
  const before = clock.now();
  monotonic += 0.2;
  wall += 3600; // the lid was closed
  assert.ok(clock.now() - before > 3599);
  wall -= 7200; // the wall clock is set back: no number becomes younger
  monotonic += 0.2;
  assert.ok(clock.now() - before > 3599);
});

test('a change is merged by name, and one that does not fit is passed over', () => {
  const dwell = dwellOf();
  const change = { index: 3, state: 'measuring', end_s: 23, elements: [{ k: 2, stiffness: { value: 8001 } }],
    phasors: [{ channel: 'y1', amplitude: 2 }].map((p) => ({ channel: p.channel })) };
  const merged = applyChange(dwell, change);
  assert.equal(merged.end_s, 23);
  assert.equal(merged.elements[1].stiffness.value, 8001);
  assert.equal(merged.elements[1].stiffness.unit, 'N/m');
  assert.equal(merged.elements[0], dwell.elements[0]);
  assert.equal(dwell.elements[1].stiffness.value, 8000);
  assert.equal(applyChange(dwell, { ...change, index: 4 }), null);
  assert.equal(applyChange(dwell, { ...change, state: 'settling' }), null);
  assert.equal(applyChange(null, change), null);
  assert.equal(applyChange(dwell, { index: 3, state: 'measuring', elements: [{ k: 9, identifiable: true }] }), null);
});

test('a list that changes seldom is old when the service is gone, or when it was not told for two turns', () => {
  const fresh = toldFreshness();
  fresh.heard(100);
  assert.equal(fresh.listOld('runs', 100), false, 'it never came');
  fresh.tookList('runs', 100);
  fresh.heard(120);
  assert.deepEqual([119, 121].map((now) => fresh.listOld('runs', now)), [false, true]);
  assert.equal(fresh.listAge_s('runs', 121), 21);
  fresh.tookList('runs', 121);
  fresh.heard(121);
  assert.deepEqual([122, 124].map((now) => fresh.listOld('runs', now)), [false, true]);
});
