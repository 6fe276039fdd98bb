// What the first line says in each situation.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { eventsText, frequencyText, isWell, limitsText, modelBrief, modelOf, playsRecording, warningsText, runFact, sinceMs, stateOf, troubles, withButton } from '../../daemon/page/wording.mjs';
import { dwellOf, idleOf, settlingOf, toldFreshness, warningOf } from './sample.js';

function viewOf(dwell, more = {}) {
  const fresh = toldFreshness();
  if (dwell) fresh.tookDwell(dwell, 100);
  fresh.answered(100);
  return { dwell, health: null, channels: null, fresh, now: 100.2, ...more };
}
const said = (view) => {
  const { kind, word, detail, tone } = stateOf(view);
  return `${kind} ${tone}: ${word}, ${detail}`;
};

test('the state is one word, what belongs to it, and a colour only where it is abnormal', () => {
  assert.equal(said(viewOf(null)), 'connecting calm: connecting, waiting for the first word of the service');
  assert.equal(said({ ...viewOf(null), refused: true }), 'locked calm: logged out, log in below to read');
  assert.equal(said(viewOf(settlingOf())), 'settling calm: settling, about 3.2 s left');
  assert.equal(said(viewOf(settlingOf({ settles_in_s: null }))), 'settling calm: settling, time left not known: transient left in y1: up to 22 times the allowed size');
  assert.equal(said(viewOf(settlingOf({ settles_in_s: 165.3 }))), 'settling calm: settling, about 165 s left');
  assert.equal(said(viewOf(dwellOf())), 'measuring calm: measuring, 10.0 s of data');
  assert.equal(said(viewOf(idleOf())), 'idle calm: idle, the table does not move');
  assert.equal(said(viewOf(dwellOf({ state: 'complete', ended_by: 'end', settling_reason: 'the run was stopped' }))), 'complete calm: complete, the run was stopped');
  assert.equal(said(viewOf(idleOf({ state: 'fault', settling_reason: 'y0 is timeout' }))), 'fault alarm: fault, y0 is timeout');
  assert.equal(said(viewOf(dwellOf(), { health: { status: 'fault', reason: 'thread estimate stands still' } })),
    'fault alarm: service fault, thread estimate stands still');
});

// "33.7 s of data" stood unmarked while the stream told nothing more.
test('a state that the stream no longer renews has its age', () => {
  for (const dwell of [dwellOf(), settlingOf(), idleOf()]) {
    const view = viewOf(dwell);
    view.fresh.answered(106); // what is asked for still comes
    assert.equal(stateOf(view).age, null);
    assert.equal(stateOf({ ...view, now: 106 }).age, '6.0 s', dwell.state);
    assert.equal(stateOf({ ...view, now: 106 }).kind, dwell.state);
  }
  assert.equal(stateOf(viewOf(dwellOf(), { now: 112 })).age, null, 'the service is gone: the words say for how long');
});

test('numbers that are doubted are an alarm in the first line', () => {
  const doubt = { elements: [2], what: 'r_2 is negative' };
  assert.equal(said(viewOf(dwellOf({ doubts: [doubt] }))), 'measuring alarm: measuring, 10.0 s of data; do not rely on element 2');
  assert.match(said(viewOf(dwellOf({ doubts: [doubt, { elements: [], what: 'x' }] }))), /do not rely on any element$/);
});

test('elements without coefficients are named in the first line', () => {
  const [one, two] = dwellOf().elements;
  const without = (...ks) => ks.map((k) => ({ k, identifiable: false, reason: 'y2: stuck' }));
  assert.equal(said(viewOf(dwellOf({ elements: [one, ...without(2)] }))), 'measuring calm: measuring in part, 10.0 s of data; no coefficients of element 2');
  assert.match(said(viewOf(dwellOf({ elements: [one, two, ...without(3, 4, 5, 6, 7, 8, 9)] }))), /; no coefficients of 7 of 9 elements$/);
});

// "measuring" in a grey box looked healthy from afar.
test('where no element has a number the first line has another word, shape and colour', () => {
  const without = (...ks) => ks.map((k) => ({ k, identifiable: false, reason: 'y2: stuck' }));
  const none = viewOf(dwellOf({ elements: without(1, 2) }));
  assert.equal(said(none), 'measuring care: no coefficients, measuring, 10.0 s of data; withheld: see why at each element');
  assert.equal(said(viewOf(dwellOf({ elements: [] }))), 'measuring care: no coefficients, measuring, 10.0 s of data; none so far');
  const part = viewOf(dwellOf({ elements: [dwellOf().elements[0], ...without(2)] }));
  const doubted = viewOf(dwellOf({ elements: without(1, 2), doubts: [{ elements: [2], what: 'r_2 is negative' }] }));
  assert.match(said(doubted), /^measuring alarm: no coefficients, .*; do not rely on element 2$/);
  const shapes = [viewOf(dwellOf()), part, none, doubted].map((view) => stateOf(view).shape);
  assert.equal(new Set(shapes).size, 4);
});

test('a service that is gone comes before all it said last', () => {
  assert.equal(said(viewOf(dwellOf(), { now: 112 })), 'gone alarm: service gone, nothing heard for 12 s; trying again every second');
});

test('logged out comes before all that was read: it is as old as the last answer', () => {
  const view = viewOf(dwellOf());
  view.fresh.answered(100);
  view.fresh.broke(112); // the answer was 401
  assert.equal(said({ ...view, now: 112, refused: true }), 'locked alarm: logged out, what is shown is 12 s old; log in below to read');
  assert.equal(said({ ...view, now: 112, refused: true, anew: true }),
    'locked alarm: logged out, what is shown is 12 s old; the service was started anew: log in again below to read');
  assert.equal(view.fresh.answersOld(112), true);
});

test('channels that are no longer told of are a trouble, though the stream goes on', () => {
  const view = viewOf(dwellOf(), { channels: [] });
  view.fresh.answered(100);
  view.fresh.tookDwell(dwellOf({ end_s: 23 }), 104);
  assert.deepEqual(troubles({ ...view, now: 104 }).map((t) => t.text),
    ['channels, devices and alarms are 4.0 s old: the service does not tell of them']);
  assert.deepEqual(troubles({ ...view, now: 102 }), []);
});

// A channel that was stuck and moves again: its own status is no trouble, but the dwell does not use it.
test('what the service holds against a channel that seems well stands in the head, once', () => {
  const channels = [{ name: 'y1', status: 'ok', text: 'ok' }, { name: 'y2', status: 'gated', text: 'gated: left out' }, { name: 'y3', status: 'timeout', text: 'timeout' }];
  const health = { log: { failing: false }, troubles: [{ kind: 'channel', channel: 'y2', text: 'channel y2: not counted in this dwell: left out', why: 'not counted in this dwell: left out' },
    { kind: 'channel', channel: 'y3', text: 'channel y3: timeout', why: 'timeout' }, { kind: 'limit', channel: null, text: 'limit violated' },
    { kind: 'dwell', channel: null, text: 'no coefficients: too few sync pulses' }, { kind: 'clock', channel: null, text: 'not synchronized' }] };
  const texts = (dwell) => troubles(viewOf(dwell, { health, channels })).map((t) => `${t.tone}: ${t.text}`);
  assert.deepEqual(texts(dwellOf()), ['alarm: channel y3: timeout', 'alarm: channel y2: not counted in this dwell: left out',
    'alarm: no coefficients: too few sync pulses']);
  assert.ok(!texts(idleOf({ state: 'fault' })).some((text) => /sync/.test(text)), 'the state says it');
});

test('a reading that is overrange is no trouble until the service says so', () => {
  const channel = { name: 'y2', status: 'overrange', text: 'overrange: above 20 mm' };
  const health = { log: { failing: false }, troubles: [{ kind: 'calibration', channel: 'y2', text: 'overdue' }] };
  const texts = () => troubles(viewOf(dwellOf(), { health, channels: [channel] })).map((t) => `${t.tone}: ${t.text}`);
  assert.deepEqual(texts(), ['care: overdue']);
  assert.equal(isWell(channel, health), true);
  health.troubles = [{ kind: 'channel', channel: 'y2', text: 'channel y2: not counted in this dwell', why: 'not counted in this dwell' }];
  assert.deepEqual(texts(), ['alarm: channel y2: not counted in this dwell']);
  assert.equal(isWell(channel, health), false);
});

test('channels of which the service says the same stand in one line', () => {
  const channels = ['y0', 'y1', 'y2'].map((name) => ({ name, status: 'ok', text: 'ok' }));
  const why = (channel, n) => ({ kind: 'channel', channel, why: `left out of 836 readings: ${n} readings far from all others` });
  const health = { log: { failing: false }, troubles: [why('y0', 4), why('y1', 4), why('y2', 3)] };
  assert.deepEqual(troubles(viewOf(dwellOf(), { health, channels })).map((t) => t.text), [
    'channels y0, y1: left out of 836 readings: 4 readings far from all others', 'channel y2: left out of 836 readings: 3 readings far from all others']);
});

test('the model is told with figures, and colours only where it is not good', () => {
  const model = { verdict: 'adequate', consistent: true, asked: 0.05, seen: 0.012, U: 0.004 };
  const of = (verdict, verification) => modelOf(dwellOf({ model: verdict }), verification);
  assert.deepEqual(of(model), { text: 'adequate, off by 1.20 ± 0.40 % (accuracy asked for: 5 %)', tone: 'calm' });
  assert.match(of({ ...model, seen: 0.0098, U: 0.0013 }).text, /off by 0\.98 ± 0\.13 %/, 'as many digits as ± has');
  assert.match(of({ ...model, seen: 0, U: 0.015 }).text, /off by 0\.0 ± 1\.5 %/);
  assert.equal(of({ ...model, verdict: 'not adequate' }).tone, 'care');
  assert.equal(of({ ...model, consistent: false }).tone, 'care');
  assert.equal(of({ ...model, objection: 'any motion: the chain does not explain y1' }).tone, 'care');
  assert.equal(modelBrief(model), 'adequate');
  assert.equal(modelBrief({ ...model, consistent: false, objection: 'any motion: …' }), 'adequate, not consistent, objection');
  assert.match(of({ ...model, objection: 'any motion: the chain does not explain y1' }).text, /; any motion: the chain does not explain y1$/);
  assert.equal(modelOf(dwellOf()), null);
  assert.equal(modelOf(null), null);
});

test('a model without a verdict has the first reason beside it', () => {
  const dwell = dwellOf({ model: { verdict: 'not verified yet', consistent: null, asked: 0.05, seen: null, U: null } });
  const said = (verification) => modelOf(dwell, verification);
  assert.deepEqual(said({ dwell: 3, reasons: ['the transient is too weak', 'y1: U is too large'] }),
    { text: 'not verified yet: the transient is too weak (accuracy asked for: 5 %)', tone: 'calm' });
  assert.match(said({ dwell: null, reasons: ['the dwell has just settled: its model is being verified'] }).text, /: the dwell has just settled/);
  assert.match(said({ dwell: 2, reasons: ['of the dwell before'] }).text, /^not verified yet: it is being verified \(/);
  // The doubt stands below the state in full: once is enough.
  const doubted = { ...dwell, doubts: [{ elements: [], what: 'mode at 4.77 Hz' }] };
  assert.match(modelOf(doubted, { dwell: 3, reasons: ['coefficients are doubted: mode at 4.77 Hz'] }).text, /^not verified yet: the coefficients are doubted \(/);
  assert.match(said({ dwell: 3, reasons: [] }).text, /: no reason stated \(/);
  assert.match(said(null).text, /: no reason known yet \(/);
});

test('the frequency has its ± once the dwell has settled', () => {
  assert.equal(frequencyText(dwellOf()), '4.000300 ± 0.000039 Hz');
  assert.equal(frequencyText(settlingOf()), '4.000 Hz so far');
  assert.equal(frequencyText(idleOf({ frequency_hz: { value: null, u: null } })), null);
});

test('since when: from the dwell, while idle from the events', () => {
  const at = Date.parse('2026-11-23T07:00:00Z');
  assert.equal(sinceMs(dwellOf(), []), at + 12500);
  assert.equal(sinceMs(settlingOf(), []), at + 10000);
  assert.equal(sinceMs(dwellOf({ state: 'complete' }), []), at + 22000);
  assert.equal(sinceMs(idleOf(), []), null);
  const events = [{ state: 'settling', utc: '2026-11-23T06:00:00Z' }, { state: 'idle', utc: '2026-11-23T07:00:07Z' },
    { state: null, utc: '2026-11-23T07:00:09Z', text: 'state of the art' }];
  assert.equal(sinceMs(idleOf(), events), at + 7000);
  assert.equal(sinceMs(idleOf({ state: 'fault' }), events), null);
});

test('channels that fail alike are told together, with the cause in full', () => {
  const silent = { status: 'timeout', text: 'timeout: station 1: no answer within 0.1 s' };
  const channels = [{ name: 'y0', ...silent }, { name: 'y1', ...silent }, { name: 'y2', status: 'ok', text: 'ok' },
    { name: 'y3', status: 'stuck', text: 'stuck at one reading' }];
  assert.deepEqual(troubles(viewOf(dwellOf(), { channels })).map((t) => t.text),
    ['channels y0, y1: timeout: station 1: no answer within 0.1 s', 'channel y3: stuck at one reading']);
});

test('recording, GPIO and doubts about the whole dwell stand beside the state', () => {
  const health = { status: 'degraded', gpio: { interlock: { works: true, level: 0 }, ready: { works: false, reason: 'no such chip' } },
    recorder: { alarms: ['the disk is full'] }, log: { failing: true, dropped: 7 } };
  const dwell = dwellOf({ doubts: [{ elements: [], what: 'y1 and y2 look swapped' }, { elements: [1, 2], what: 'z' },
    { elements: [2], what: 'x' }] });
  assert.deepEqual(troubles(viewOf(dwell, { health })).map((t) => t.text), ['interlock open: the shaker may not run',
    'GPIO ready: no such chip', 'recording: the disk is full', 'the log loses lines, 7 so far',
    'do not rely on any element: y1 and y2 look swapped', 'do not rely on elements 1, 2: z']);
});

test('numbers that stand still are told, with their age', () => {
  const view = viewOf(dwellOf());
  view.fresh.heard(778);
  assert.match(troubles({ ...view, now: 778 })[0].text, /^old numbers, from 678 s ago/);
});

test('what the service says to do next names the button first where the page has it', () => {
  assert.equal(withButton('the run was stopped: the next one begins with "dwellctl start", or with the drive once it has rested'),
    'the run was stopped: the next one begins with the button "Start a run" below, "dwellctl start", or with the drive once it has rested');
  assert.equal(withButton('it has decayed'), 'it has decayed');
});

test('the run', () => {
  const said = (health, dwell = idleOf()) => Object.values(runFact(health, dwell)).join(': ');
  assert.equal(said({ run: { recorded: true }, recorder: { run: { run: 17, label: 'new bush' } } }, dwellOf()), '17, “new bush”: calm');
  assert.equal(said({ run: { recorded: true }, recorder: { run: null } }), 'none goes on: calm');
  assert.equal(said({ run: { recorded: true }, recorder: { run: null } }, dwellOf()), 'not recorded: care', 'the disk is full, for instance');
  assert.equal(said({ run: { recorded: false }, recorder: null }, dwellOf()), 'not recorded: calm', 'nobody asked for it');
});

test('limits and warnings of the dwell are counted for the head, acknowledged or not', () => {
  const of = (...verdicts) => limitsText(dwellOf({ limits: verdicts.map((verdict) => ({ verdict })) }));
  assert.deepEqual(of('violated', 'undecided', 'kept', 'none'), { text: '1 violated, 1 undecided, 1 without a verdict', tone: 'alarm' });
  assert.deepEqual(of('undecided'), { text: '1 undecided', tone: 'calm' });
  assert.deepEqual(of('kept'), { text: 'all kept', tone: 'calm' });
  assert.deepEqual(of('kept', 'none'), { text: '1 without a verdict', tone: 'calm' }, 'its number is withheld: nobody knows whether it is kept');
  assert.equal(of(), null);
  assert.equal(limitsText(dwellOf()), null, 'not told');
  assert.equal(limitsText(idleOf({ limits: [{ verdict: 'none' }] })), null);
  const warnings = ['a', 'b'].map((text) => ({ kind: 'hum', text }));
  assert.equal(warningsText(dwellOf(warningOf(warnings, [{ elements: [1], what: 'a' }]))), '2', 'a doubt is none, whatever its words');
  assert.equal(warningsText(dwellOf(warningOf(warnings.slice(1)))), '1');
  assert.equal(warningsText(idleOf()), null, 'that it has not settled is its state');
});

test('a recording that is played does not pass for a rig, and its end for a fault', () => {
  const device = { name: 'recording', driver: 'any', recorded: true, up: true, ended: false };
  assert.equal(playsRecording({ devices: [device] }), true);
  assert.equal(playsRecording({ devices: [{ ...device, recorded: false }] }), false);
  assert.equal(playsRecording(null), false);
  const fault = idleOf({ state: 'fault', settling_reason: 'the drive is not seen: y0 is end of data' });
  const channels = [{ name: 'y0', status: 'end of data', reason: 'the recording has been played to its end' }];
  const view = viewOf(fault, { channels, health: { status: 'ok', log: {}, devices: [{ ...device, up: false, ended: true }] } });
  assert.equal(said(view), 'complete calm: recording ended, it has been played to its end');
  assert.deepEqual(troubles(view), []);
  assert.match(said(viewOf(fault, { health: { status: 'ok', devices: [{ ...device, up: false }] } })), /^fault alarm/);
});

test('an overdue calibration stands in the head in the tone of care', () => {
  const health = { status: 'ok', log: {}, troubles: [{ kind: 'calibration', channel: 'y1', text: 'channel y1: the calibration K-7 is overdue: it was due on 2025-03-31', degrades: false }] };
  assert.deepEqual(troubles(viewOf(dwellOf(), { health })), [{ tone: 'care', text: 'channel y1: the calibration K-7 is overdue: it was due on 2025-03-31' }]);
});

test('a list of events says what it leaves out, and how far its filter looks', () => {
  const text = (shown, fit, known, total) => eventsText({ shown, fit, known, total });
  assert.equal(text(0, 0, 0, 0), 'No events yet.');
  assert.equal(text(80, 80, 80, 80), '');
  assert.equal(text(100, 200, 200, 1234), 'The newest 100 of 1234 events.');
  assert.equal(text(7, 7, 80, 80), '');
  assert.equal(text(0, 0, 80, 80), 'No event fits the filter.');
  assert.equal(text(100, 130, 200, 200), 'The newest 100 of 130 that fit the filter.');
  assert.equal(text(7, 7, 200, 1234), 'The filter looks at the newest 200 of 1234 events.');
  assert.equal(text(100, 130, 200, 1234), 'The newest 100 of 130 that fit the filter. The filter looks at the newest 200 of 1234 events.');
});
