// Numbers, or the reason in place of the number.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { channelWarnings, coefficientsOf, generalWarnings, LastNumbers, namesChannel, namesElement } from '../../daemon/page/coefficients.mjs';
import { joined } from '../../daemon/page/number.mjs';
import { dwellOf, idleOf, settlingOf, toldFreshness } from './sample.js';

// The page after it was given these dwells a second apart, the last one just now.
function after(...dwells) {
  const view = { fresh: toldFreshness(), last: new LastNumbers(), now: 100, broken: false };
  for (const dwell of dwells) {
    view.now += 1;
    view.dwell = dwell;
    view.fresh.tookDwell(dwell, view.now);
    view.last.take(dwell, view.now);
  }
  return view;
}
const text = (cell) => `${cell.symbol} ${cell.number ? joined(cell.number) : 'none'}${cell.struck ? `, ${cell.struck} old` : ''}`;
const texts = (shown) => shown.elements.flatMap((e) => e.cells.map(text));

test('measured: every coefficient with its ± and unit', () => {
  const shown = coefficientsOf(after(dwellOf()));
  assert.equal(shown.source, 'measured');
  assert.deepEqual(texts(shown), ['c₁ 24.000 ± 0.024 kN/m', 'r₁ 60.00 ± 0.60 N·s/m', 'c₂ 8.0000 ± 0.0080 kN/m', 'r₂ 45.00 ± 0.45 N·s/m']);
});

test('withheld: the reason, and what stood there is struck through with its age', () => {
  const [first] = dwellOf().elements;
  const withheld = { k: 2, identifiable: false, reason: 'y2 is disconnected', stiffness: null, damping: null, budget: [] };
  const view = after(dwellOf(), dwellOf({ end_s: 23, elements: [first, withheld] }));
  const element = coefficientsOf(view).elements[1];
  assert.equal(element.reason, 'y2 is disconnected');
  assert.deepEqual(element.last.map(text), ['c₂ 8.0000 ± 0.0080 kN/m, 1.0 s old', 'r₂ 45.00 ± 0.45 N·s/m, 1.0 s old']);
  assert.equal(coefficientsOf(after(dwellOf({ elements: [first, withheld] }))).elements[1].last, null, 'it never stood there');
  assert.equal(coefficientsOf(after(dwellOf({ index: 2 }), dwellOf({ elements: [first, withheld] }))).elements[1].last, null,
    'it stood there of another dwell');
});

test('while it settles: from the transient, marked as such, or the reason', () => {
  const motion = { start_s: 0.6, end_s: 3.9, elements: dwellOf().elements };
  const shown = coefficientsOf(after(settlingOf({ motion })));
  assert.equal(shown.source, 'transient');
  assert.match(shown.title, /^from the transient, 0\.6 to 3\.9 s: an estimate before the verdict$/);
  const none = coefficientsOf(after(dwellOf({ index: 2 }), settlingOf()));
  assert.equal(none.source, 'none');
  assert.equal(none.reason, 'settling: transient left in y1: 22 times the allowed size');
});

test('no data come: every number is struck through with its age', () => {
  const view = after(dwellOf());
  view.fresh.heard(113);
  assert.deepEqual(texts(coefficientsOf({ ...view, now: 113 })).slice(0, 1), ['c₁ 24.000 ± 0.024 kN/m, 12 s old']);
});

test('the device has died: the last numbers, struck through', () => {
  const view = after(dwellOf(), idleOf({ state: 'fault', settling_reason: 'the drive is not seen: y0 is timeout' }));
  const shown = coefficientsOf({ ...view, broken: true });
  assert.equal(shown.source, 'last');
  assert.equal(shown.title, 'last dwell: 3, ended 1.0 s ago');
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m, 1.0 s old');
});

test('the drive has stopped: the last numbers hold, as those of a dwell that ended', () => {
  const view = after(dwellOf(), dwellOf({ state: 'complete', ended_by: 'drive stopped' }), idleOf());
  const shown = coefficientsOf(view);
  assert.equal(shown.title, 'last dwell: 3, ended 1.0 s ago: drive stopped');
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m');
});

test('a page that is opened later knows the last dwell from the list', () => {
  const view = after(idleOf());
  view.last.takeEnded(dwellOf({ state: 'complete', ended_by: 'drive stopped' }), 1_000_000, view.now, 1_060_000);
  assert.equal(coefficientsOf(view).title, 'last dwell: 3, ended 60 s ago: drive stopped');
});

test('a doubt and a warning stand beside the element they name, all others with the dwell', () => {
  const dwell = dwellOf({ doubts: [{ elements: [2], what: 'r_2 is negative' }, { elements: [], what: 'elements 1 … 2 look swapped' }],
    warnings: ['r_2 is negative', 'elements 1 … 2 look swapped', 'element 1 moves little', 'y1 is gated', 'the clock is not synchronized'] });
  const [one, two] = coefficientsOf(after(dwell)).elements;
  assert.deepEqual(one.notes, [{ tone: 'care', text: 'element 1 moves little' }]);
  assert.deepEqual(two.notes, [{ tone: 'alarm', text: 'do not rely on this: r_2 is negative' }]);
  assert.deepEqual(two.cells.map((c) => c.marks), [['?'], ['?']]);
  assert.deepEqual(generalWarnings(dwell), ['the clock is not synchronized']);
  assert.deepEqual(channelWarnings(dwell), ['y1 is gated']);
});

test('the last dwell keeps its doubts: its end makes no number reliable', () => {
  const doubts = [{ elements: [2], what: 'r_2 is negative' }];
  // For a moment before the end there may be no numbers, and so no doubts about them.
  const withheld = dwellOf().elements.map((e) => ({ k: e.k, identifiable: false, reason: 'y0: timeout' }));
  for (const view of [after(dwellOf({ doubts }), idleOf()), after(dwellOf({ doubts }), dwellOf({ elements: withheld }), idleOf()), after(idleOf())]) {
    if (view.last.t === null) view.last.takeEnded(dwellOf({ state: 'complete', ended_by: 'drive stopped', doubts }), 1_000_000, view.now, 1_060_000);
    const { source, title, elements } = coefficientsOf(view);
    assert.equal(source, 'last');
    assert.match(title, /; do not rely on element 2: r_2 is negative$/);
    assert.deepEqual(elements.map((e) => e.cells.map((c) => c.marks)), [[[], []], [['?'], ['?']]]);
  }
});

test('names are found as words', () => {
  assert.equal(namesElement('elements 2, 3 and 12 are alike', 12), true);
  assert.equal(namesElement('element 12', 1), false);
  assert.equal(namesElement('the chain (elements 1 … 4) has none', 3), true);
  assert.equal(namesElement('mass 2', 2), false);
  assert.equal(namesChannel('scale of y1: off', 'y1'), true);
  assert.equal(namesChannel('scale of y11', 'y1'), false);
  assert.equal(namesChannel('load cell (east) is stuck', 'load cell (east)'), true);
});
