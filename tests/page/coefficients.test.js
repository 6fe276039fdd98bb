// Numbers, or the reason in place of the number.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { channelWarnings, coefficientsOf, generalWarnings, LastNumbers, legendOf, trendLegendOf } from '../../daemon/page/coefficients.mjs';
import { joined } from '../../daemon/page/number.mjs';
import { utcMs } from '../../daemon/page/wording.mjs';
import { dwellOf, idleOf, settlingOf, toldFreshness, warningOf } from './sample.js';

// s of the page's clock: when the data of dwellOf() are new.
const AT = 101;
const utcAt = (now) => utcMs(dwellOf(), dwellOf().end_s) + 1e3 * (now - AT);
// The page takes a dwell at an instant.
function tell(view, dwell, now) {
  Object.assign(view, { dwell, now });
  view.fresh.tookDwell(dwell, now);
  view.last.take(dwell, now, utcAt(now));
}
const newView = () => ({ fresh: toldFreshness(), last: new LastNumbers(), now: AT, broken: false });

// The page after it was given these dwells a second apart, the last one just now.
function after(...dwells) {
  const view = newView();
  dwells.forEach((dwell, i) => tell(view, dwell, AT + i));
  return view;
}
const text = (cell) => `${cell.symbol} ${cell.number ? joined(cell.number) : 'none'}${cell.struck ? `, ${cell.struck} old` : ''}`;
const texts = (shown) => shown.elements.flatMap((e) => e.cells.map(text));

test('measured: every coefficient with its ± and unit', () => {
  const shown = coefficientsOf(after(dwellOf()));
  assert.equal(shown.source, 'measured');
  assert.deepEqual(texts(shown), ['c₁ 24.000 ± 0.024 kN/m', 'r₁ 60.00 ± 0.60 N·s/m', 'c₂ 8.0000 ± 0.0080 kN/m', 'r₂ 45.00 ± 0.45 N·s/m']);
});

test('the legend names the runs that the trends lack', () => {
  const shown = coefficientsOf(after(dwellOf()));
  assert.doesNotMatch(legendOf(shown), /trends/);
  assert.match(legendOf(shown, [7]), /\. the trends lack run 7: no file of theirs could be read\.$/);
  assert.match(legendOf(shown, [7, 9]), /runs 7, 9:/);
});

test('below the numbers stands how long the trends reach back, and how high they are', () => {
  const shown = coefficientsOf(after(dwellOf()));
  assert.equal(trendLegendOf(shown, 1_200_000), 'A trend shows the last 20 min. Its middle is the newest measured value, its upper and lower edge that value ± the % below it. The grey band is the ± of each value.');
  assert.equal(trendLegendOf(shown, null), '', 'nothing has been measured');
  assert.equal(trendLegendOf(coefficientsOf(after(settlingOf())), 60_000), '', 'no number has a trend beside it');
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
  assert.match(legendOf(shown), /\. Slanted: an estimate from the readings so far, not yet the result; /);
  const later = coefficientsOf({ ...after(settlingOf({ motion })), nowMs: utcMs(settlingOf(), 12.9) });
  assert.match(later.title, /^from the transient, 0\.6 to 3\.9 s, 9\.0 s ago: an estimate before the verdict$/);
  const none = coefficientsOf(after(dwellOf({ index: 2 }), settlingOf()));
  assert.equal(none.source, 'none');
  assert.equal(none.reason, 'settling: transient left in y1: up to 22 times the allowed size');
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
  assert.equal(shown.title, 'last dwell: 3, last seen 1.0 s ago');
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m, 1.0 s old');
});

test('the drive has stopped: the last numbers hold, as those of a dwell that ended', () => {
  const view = after(dwellOf(), dwellOf({ state: 'complete', ended_by: 'drive stopped' }), idleOf());
  const shown = coefficientsOf(view);
  assert.equal(shown.title, 'last dwell: 3, ended 2.0 s ago: drive stopped');
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m');
});

test('the legend says what ± does not cover, of whichever dwell the numbers are', () => {
  const unstated = ['mass 1', 'scales of y0 and y1'];
  const covers = /\. ± covers noise, clock and what the rig file states; not stated: mass 1, scales of y0 and y1\.$/;
  assert.doesNotMatch(legendOf(coefficientsOf(after(dwellOf()))), /not stated/);
  assert.match(legendOf(coefficientsOf(after(dwellOf({ unstated })))), covers);
  const motion = { start_s: 0.6, end_s: 3.9, elements: dwellOf().elements };
  assert.match(legendOf(coefficientsOf(after(settlingOf({ motion, unstated })))), covers);
  const last = coefficientsOf(after(dwellOf({ unstated }), dwellOf({ unstated, state: 'complete', ended_by: 'drive stopped' }), idleOf()));
  assert.equal(last.source, 'last');
  assert.match(legendOf(last), covers);
  assert.equal(legendOf(coefficientsOf(after(settlingOf({ unstated })))), '', 'there are no numbers');
});

// As the service shows the last dwell of a run that an operator stopped while the drive is on.
const WHY = 'the run was stopped: the next one begins with "dwellctl start", or with the drive once it has rested';
const stoppedOf = (changes) => dwellOf({ state: 'complete', ended_by: 'end', settling_reason: WHY, estimate_age_s: 0.1, stale: false, ...changes });

test('the run was stopped: its numbers are a result, with the time since their end and the reason', () => {
  const view = after(dwellOf());
  for (let s = 1; s <= 56; ++s) tell(view, stoppedOf(), AT + s);
  const shown = coefficientsOf(view);
  assert.equal(shown.source, 'last');
  assert.equal(shown.title, `last dwell: 3, ended 56 s ago: ${WHY}`);
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m', 'not struck: data are not expected');
  assert.equal(texts(coefficientsOf({ ...view, broken: true }))[0], 'c₁ 24.000 ± 0.024 kN/m, 56 s old', 'as of any last dwell while a channel is dead');
});

test('a page that is opened after the run was stopped counts from the end of the data', () => {
  const view = newView();
  tell(view, stoppedOf(), AT + 40);
  assert.match(coefficientsOf(view).title, /^last dwell: 3, ended 40 s ago: the run was stopped/);
});

test('a dwell that had ended before the run was stopped keeps its own cause', () => {
  const view = after(dwellOf(), stoppedOf({ ended_by: 'data lost' }));
  assert.match(coefficientsOf(view).title, /ago: data lost; the run was stopped: /);
  const none = after(dwellOf({ index: 2 }), stoppedOf({ ended_by: 'end', settled_s: null, elements: [] }));
  assert.equal(coefficientsOf(none).title, 'last dwell: 2, last seen 1.0 s ago', 'the stop ended dwell 3, which never settled');
});

// The service cuts a dwell back to before the drive stopped; the live numbers of the last seconds hold data of after it.
test('the end of a dwell replaces its live numbers: one dwell, one number', () => {
  const [first, second] = dwellOf().elements;
  const doubts = [{ elements: [1], what: 'the phase wanders' }];
  const live = dwellOf({ end_s: 23, doubts, elements: [{ ...first, stiffness: { ...first.stiffness, value: 25678 } }, second] });
  const withheld = { k: 2, identifiable: false, reason: 'y2 is disconnected', stiffness: null, damping: null };
  const final = { ended_by: 'drive stopped', state: 'complete', elements: [first, withheld] };
  for (const how of ['list', 'stream']) {
    const view = after(live);
    if (how === 'list') view.last.takeEnded(dwellOf(final), utcAt(AT - 1), AT + 9, utcAt(AT + 9));
    else tell(view, dwellOf(final), AT + 9);
    tell(view, idleOf(), AT + 9);
    const shown = coefficientsOf(view);
    assert.deepEqual(texts({ elements: shown.elements.slice(0, 1) }), ['c₁ 24.000 ± 0.024 kN/m', 'r₁ 60.00 ± 0.60 N·s/m'], how);
    assert.equal(shown.elements[1].reason, 'y2 is disconnected', how);
    assert.equal(shown.title, 'last dwell: 3, ended 10 s ago: drive stopped', `${how}: the doubts were about the live numbers`);
  }
});

test('a dwell of which nothing is left at its end has no numbers', () => {
  for (const how of ['list', 'stream']) {
    const view = after(dwellOf());
    const final = dwellOf({ ended_by: 'drive stopped', state: 'complete', settled_s: null, elements: [], end_s: 11 });
    if (how === 'list') view.last.takeEnded(final, utcAt(AT - 11), AT + 1, utcAt(AT + 1));
    else tell(view, final, AT + 1);
    tell(view, idleOf(), AT + 1);
    assert.deepEqual(coefficientsOf(view).elements.map((e) => e.reason), Array(2).fill('too few of its data count'), how);
  }
});

// After SIGSTOP and SIGCONT the service tells what it knew, then the little that its drivers had read before.
const afterStandingStill = [
  ['tells the same', [[{ stale: true, estimate_age_s: 10 }, 111]]],
  ['tells the same as if it were of now', [[{}, 111]]],
  ['tells a little more, and the end', [[{ end_s: 22.05 }, 111], [{ end_s: 22.1, state: 'complete', ended_by: 'data lost' }, 111.05]]],
  ['tells of the end alone', [[{ end_s: 22.1, state: 'complete', ended_by: 'data lost' }, 111.05]]],
];
for (const [what, told] of afterStandingStill) {
  test(`a service that stood still and ${what}: the numbers stay as old as they are`, () => {
    const view = newView();
    for (let s = 5; s >= 0; --s) tell(view, dwellOf({ end_s: 22 - s }), AT - s);
    for (const [changes, now] of told) tell(view, dwellOf(changes), now);
    tell(view, idleOf({ state: 'fault', settling_reason: 'the drive is not seen: y0 is silent' }), 111.5);
    const shown = coefficientsOf(view);
    assert.match(shown.title, /^last dwell: 3, (ended|last seen) 10 s ago/);
    assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m, 10 s old');
  });
}

test('a clock that is set makes no number old', () => {
  for (const clock of ['of the service', 'of the page']) {
    const view = newView();
    for (let s = 0; s < 5; ++s) {
      const jump = s < 2 ? 0 : 3600;
      const [now, nowMs] = [AT + s + (clock === 'of the page' ? jump : 0), utcAt(AT + s) + (clock === 'of the service' ? 1e3 * jump : 0)];
      view.last.take(dwellOf({ end_s: 22 + s }), now, nowMs);
      assert.ok(now - view.last.t < 1e-9, `${clock}: ${now - view.last.t} s`);
    }
  }
});

test('data that come late for a while are of now again when they have caught up', () => {
  const view = newView();
  view.last.take(dwellOf(), AT, utcAt(AT));
  view.last.take(dwellOf({ end_s: 22.1 }), AT + 2, utcAt(AT + 2));
  assert.ok(Math.abs(AT + 2 - view.last.t - 1.9) < 1e-6);
  view.last.take(dwellOf({ end_s: 24.5 }), AT + 2.5, utcAt(AT + 2.5));
  assert.ok(Math.abs(AT + 2.5 - view.last.t) < 1e-6);
});

test('a page that is opened later knows the last dwell from the list', () => {
  const view = after(idleOf());
  view.last.takeEnded(dwellOf({ state: 'complete', ended_by: 'drive stopped' }), 1_000_000, view.now, 1_060_000);
  assert.equal(coefficientsOf(view).title, 'last dwell: 3, ended 60 s ago: drive stopped');
});

// The words alone name element 2 and y1 everywhere: only what the service tells of them counts.
test('a doubt and a warning stand beside the element they name, all others with the dwell', () => {
  const dwell = dwellOf(warningOf([{ kind: 'nonlinear', text: 'it moves little, as element 2', elements: [1] },
    { kind: 'readings', text: 'y1 is gated', channels: ['y1'] }, { kind: 'growing chain', text: 'y1 and element 2 are not to blame' }],
  [{ elements: [2], what: 'r_2 is negative' }, { elements: [], what: 'elements 1 … 2 look swapped' }]));
  const [one, two] = coefficientsOf(after(dwell)).elements;
  assert.deepEqual(one.notes, [{ tone: 'care', text: 'it moves little, as element 2' }]);
  assert.deepEqual(two.notes, [{ tone: 'alarm', text: 'do not rely on this: r_2 is negative' }]);
  assert.deepEqual(two.cells.map((c) => c.marks), [['?'], ['?']]);
  assert.deepEqual(generalWarnings(dwell), ['y1 and element 2 are not to blame']);
  assert.deepEqual(channelWarnings(dwell), ['y1 is gated']);
  // While the table rests, the page has no phasors: their warnings would be counted and told nowhere.
  const idle = { ...dwell, state: 'idle' };
  assert.deepEqual([generalWarnings(idle), channelWarnings(idle)], [['y1 is gated', 'y1 and element 2 are not to blame'], []]);
});

test('the last dwell keeps its doubts: its end makes no number reliable', () => {
  const doubts = [{ elements: [2], what: 'r_2 is negative' }];
  // For a moment before the end there may be no numbers, and so no doubts about them.
  const withheld = dwellOf().elements.map((e) => ({ k: e.k, identifiable: false, reason: 'y0: timeout' }));
  for (const view of [after(dwellOf({ doubts }), idleOf()), after(dwellOf({ doubts }), dwellOf({ elements: withheld }), idleOf()), after(idleOf())]) {
    if (view.last.t === null) view.last.takeEnded(dwellOf({ state: 'complete', ended_by: 'drive stopped', doubts }), 1_000_000, view.now, 1_060_000);
    const { source, title, notes, elements } = coefficientsOf(view);
    assert.equal(source, 'last');
    assert.doesNotMatch(title, /rely/);
    assert.deepEqual(notes, [{ tone: 'alarm', text: 'do not rely on element 2: r_2 is negative' }]);
    assert.deepEqual(elements.map((e) => (e.last ?? e.cells).map((c) => c.marks)), [[[], []], [['?'], ['?']]]);
  }
});

// A coefficient that was withheld came back as a good one when the service was started again.
test('of a dwell whose end nobody told, what was withheld stays withheld, with its reason', () => {
  const [first] = dwellOf().elements;
  const withheld = { k: 2, identifiable: false, reason: 'y2 is stuck', stiffness: null, damping: null, budget: [] };
  const view = after(dwellOf({ limits: limitsOf('violated') }), dwellOf({ end_s: 23, elements: [first, withheld] }));
  tell(view, idleOf({ start_utc: '2026-11-23T07:01:00.000000Z' }), AT + 8); // a service that has begun anew
  const shown = coefficientsOf(view);
  assert.equal(shown.title, 'last dwell: 3, last seen 7.0 s ago');
  const [one, two] = shown.elements;
  assert.deepEqual([one.reason, one.last], [null, null]);
  assert.equal(two.reason, 'y2 is stuck');
  assert.deepEqual(two.cells.map((cell) => cell.number), [null, null]);
  assert.deepEqual(two.last.map(text), ['c₂ 8.0000 ± 0.0080 kN/m, 8.0 s old', 'r₂ 45.00 ± 0.45 N·s/m, 8.0 s old']);
  assert.equal(two.last[0].limit.verdict, 'violated', 'beside the struck number that it was made from');
  // The same where it never had a number.
  const never = after(dwellOf({ elements: [first, withheld] }), idleOf());
  assert.deepEqual(coefficientsOf(never).elements.map((e) => [e.reason, e.last]), [[null, null], ['y2 is stuck', null]]);
});

// When the drive stopped, a violated limit stood there in grey without a verdict, and an adequate model was forgotten.
const adequate = { verdict: 'adequate', consistent: true, asked: 0.05, seen: 0.012, U: 0.004 };
const limitsOf = (verdict, reason = null) => [{ element: 2, coefficient: 'stiffness', low: 5000, high: 6000, unit: 'N/m', verdict, reason }];
const verdictsOf = (shown) => shown.elements.flatMap((e) => e.cells.map((c) => c.limit?.verdict ?? null));

test('the last dwell keeps the verdicts on its limits and on its model', () => {
  const live = dwellOf({ limits: limitsOf('violated'), model: adequate });
  const stopped = stoppedOf({ limits: limitsOf('none', 'the dwell has ended') });
  const idle = idleOf({ limits: limitsOf('none', 'not settled') });
  for (const view of [after(live, idle), after(live, stopped), after(live, stopped, idle)]) {
    const shown = coefficientsOf(view);
    assert.equal(shown.source, 'last');
    assert.deepEqual(verdictsOf(shown), [null, null, 'violated', null]);
    assert.deepEqual(shown.notes, [{ tone: 'calm', text: 'model: adequate, off by 1.20 ± 0.40 % (accuracy asked for: 5 %)' }]);
  }
  const later = after(stopped); // the page is opened now; the list brings the verdicts
  assert.deepEqual(verdictsOf(coefficientsOf(later)), [null, null, null, null]);
  later.last.takeEnded(stoppedOf({ limits: limitsOf('violated'), model: adequate }), utcAt(AT), AT + 1, utcAt(AT + 1));
  tell(later, stopped, AT + 2);
  assert.deepEqual(verdictsOf(coefficientsOf(later)), [null, null, 'violated', null]);
  assert.match(coefficientsOf(later).notes[0].text, /^model: adequate/);
});

test('a verdict is never beside a number that it was not made from', () => {
  const [first, second] = dwellOf().elements;
  const other = { ...second, stiffness: { ...second.stiffness, value: 5500 } };
  const view = after(dwellOf({ limits: limitsOf('violated') }), stoppedOf({ elements: [first, other], limits: limitsOf('none', 'the dwell has ended') }));
  assert.deepEqual(verdictsOf(coefficientsOf(view)), [null, null, null, null]);
});

test('a model that was never verified, of a dwell that has ended, is not said to be verified still', () => {
  const model = { ...adequate, verdict: 'not verified yet', seen: null, U: null };
  const view = after(dwellOf({ model }), idleOf());
  assert.deepEqual(coefficientsOf(view).notes, [{ tone: 'calm', text: 'model: not verified yet: the dwell has ended (accuracy asked for: 5 %)' }]);
});

test('the numbers of a recording that was played to its end are a result', () => {
  const view = after(dwellOf(), dwellOf({ state: 'complete', ended_by: 'data lost' }), idleOf({ state: 'fault', settling_reason: 'y0 is end of data' }));
  const shown = coefficientsOf({ ...view, broken: true, health: { devices: [{ recorded: true, ended: true }] } });
  assert.equal(shown.title, 'last dwell: 3, ended 2.0 s ago: the recording ended');
  assert.equal(texts(shown)[0], 'c₁ 24.000 ± 0.024 kN/m');
});

test('a warning about an element that has no place of its own stands with the dwell', () => {
  const of = (warnings) => warningOf(warnings.map((text) => ({ kind: 'nonlinear', text, elements: [1] })));
  assert.deepEqual(generalWarnings(settlingOf(of(['it is not linear']))), ['it is not linear']);
  assert.deepEqual(generalWarnings(dwellOf(of(['it is not linear']))), []);
});

// Warnings of the idle time stood directly below the last dwell's numbers, and its own stood nowhere.
test('the last dwell keeps its own warnings; those of now are told apart', () => {
  const live = dwellOf(warningOf([{ kind: 'hum', text: 'seen live' }]));
  const final = dwellOf({ state: 'complete', ended_by: 'drive stopped', ...warningOf([{ kind: 'hum', text: 'hum at 50 Hz' },
    { kind: 'nonlinear', text: 'it is not linear', elements: [2] }, { kind: 'readings', text: 'y1 was gated', channels: ['y1'] }]) });
  const { warnings, warned, ...brief } = final; // as the list of dwells has it
  const idle = idleOf(warningOf([{ kind: 'readings', text: 'y1 is gated now', channels: ['y1'] }]));
  const view = after(live, idle);
  view.last.takeEnded(brief, utcAt(AT), AT + 1, utcAt(AT + 1));
  assert.equal(view.last.whole, false);
  assert.deepEqual(coefficientsOf(view).warnings, ['seen live']);
  view.last.takeEnded(final, utcAt(AT), AT + 1, utcAt(AT + 1));
  assert.equal(view.last.whole, true);
  view.last.takeEnded(brief, utcAt(AT), AT + 1, utcAt(AT + 1)); // its model has been verified: the list tells it once more
  assert.equal(view.last.whole, true);
  const shown = coefficientsOf(view);
  assert.deepEqual(shown.warnings, ['hum at 50 Hz', 'y1 was gated']);
  assert.deepEqual(shown.elements.map((e) => e.notes.map((note) => note.text)), [[], ['it is not linear']]);
  assert.deepEqual(shown.nowWarnings, ['y1 is gated now']);
});

test('the dwell of a run that was stopped has its warnings once: those of channels are with the phasors', () => {
  const shown = coefficientsOf(after(stoppedOf(warningOf([{ kind: 'hum', text: 'hum at 50 Hz' },
    { kind: 'nonlinear', text: 'it is not linear', elements: [2] }, { kind: 'readings', text: 'y1 was gated', channels: ['y1'] }]))));
  assert.equal(shown.source, 'last');
  assert.deepEqual([shown.warnings, shown.nowWarnings], [['hum at 50 Hz'], []]);
  assert.deepEqual(shown.elements[1].notes.map((note) => note.text), ['it is not linear']);
});
