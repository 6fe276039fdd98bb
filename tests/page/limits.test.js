// Verdicts on limits, and alarms in words.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { alarmRows, howToAcknowledge, unseenText, waitingText } from '../../daemon/page/alarms.mjs';
import { coefficientsOf, LastNumbers } from '../../daemon/page/coefficients.mjs';
import { limitOf } from '../../daemon/page/limits.mjs';
import { give, noteText } from '../../daemon/page/order.mjs';
import { dwellOf, toldFreshness } from './sample.js';

const limited = (verdict, reason = null, doubted = false) =>
  dwellOf({ limits: [{ element: 2, coefficient: 'stiffness', low: 7500, high: 8500, unit: 'N/m', verdict, doubted, reason }] });

test('each verdict has its word, its shape and the limit', () => {
  assert.deepEqual(limitOf(limited('kept'), 'stiffness', 2), { verdict: 'kept', text: '✓ limit kept: 7.500 to 8.500 kN/m' });
  assert.equal(limitOf(limited('violated'), 'stiffness', 2).text, '▲ limit violated: outside 7.500 to 8.500 kN/m');
  assert.equal(limitOf(limited('undecided'), 'stiffness', 2).text, '◇ limit undecided, 7.500 to 8.500 kN/m: ± reaches over an end');
  assert.equal(limitOf(limited('none', 'not settled'), 'stiffness', 2).text, '– no verdict on the limit 7.500 to 8.500 kN/m: not settled');
});

test('a doubt that takes a limit its verdict is not told once more there', () => {
  assert.equal(limitOf(limited('none', 'do not rely on it: mode at 4.77 Hz, decaying at 1.97 /s', true), 'stiffness', 2).text,
    '– no verdict on the limit 7.500 to 8.500 kN/m: the number must not be relied on');
});

test('a bound has as many digits as it takes to be it: none is rounded to the number beside it', () => {
  const of = (low, high) => limitOf(dwellOf({ limits: [{ element: 2, coefficient: 'stiffness', low, high, unit: 'N/m', verdict: 'kept', reason: null }] }), 'stiffness', 2).text;
  assert.equal(of(8000.4, 8499.9), '✓ limit kept: 8.0004 to 8.4999 kN/m');
  assert.equal(of(1 / 3, 123456.78901), '✓ limit kept: 333.333333333333 mN/m to 123.45678901 kN/m');
  assert.equal(of(-50, 0), '✓ limit kept: −50.00 to 0 N/m');
});

test('a limit with one end says on which side it is', () => {
  const of = (low, high, verdict, reason = null) => limitOf(dwellOf({ limits: [{ element: 2, coefficient: 'stiffness', low, high, unit: 'N/m', verdict, reason }] }), 'stiffness', 2).text;
  assert.equal(of(7500, null, 'kept'), '✓ limit kept: at least 7.500 kN/m');
  assert.equal(of(null, 8500, 'violated'), '▲ limit violated: not at most 8.500 kN/m');
  assert.equal(of(7500, null, 'undecided'), '◇ limit undecided: ± reaches over 7.500 kN/m');
  assert.equal(of(null, 8500, 'none', 'not settled'), '– no verdict on the limit of at most 8.500 kN/m: not settled');
});

test('only the coefficient that has a limit is told one, and only of the dwell that is measured', () => {
  const dwell = limited('kept');
  assert.equal(limitOf(dwell, 'damping', 2), null);
  assert.equal(limitOf(dwell, 'stiffness', 1), null);
  assert.equal(limitOf(dwellOf(), 'stiffness', 2), null);
  const view = { dwell, fresh: toldFreshness(), last: new LastNumbers(), now: 100, broken: false };
  view.fresh.tookDwell(dwell, 100);
  const cells = coefficientsOf(view).elements.flatMap((e) => e.cells);
  assert.deepEqual(cells.map((c) => c.limit?.verdict ?? null), [null, null, 'kept', null]);
});

const alarm = (state, changes = {}) => ({ name: 'channel:y1', text: 'channel y1: timeout', state, since: '2026-11-23T07:00:00Z',
  changed: '2026-11-23T07:00:00Z', count: 1, acknowledged_by: null, comment: null, ...changes });
const NOW = Date.parse('2026-11-23T07:00:12Z');

test('an alarm that waits for somebody is told from one that does not by tone and word', () => {
  const list = { unacknowledged: 2, alarms: [alarm('unacknowledged', { count: 7 }), alarm('returned-unacknowledged'),
    alarm('acknowledged', { acknowledged_by: 'anna (uid 1000)', comment: 'cable pulled' })] };
  const rows = alarmRows(list, NOW);
  assert.deepEqual(rows.map((r) => [r.tone, r.word, r.waits]), [['alarm', 'unacknowledged', true],
    ['care', 'returned, unacknowledged', true], ['calm', 'acknowledged', false]]);
  assert.match(rows[0].when, /^since .* \(12 s\), raised 7 times$/);
  assert.match(rows[2].when, /; acknowledged by anna \(uid 1000\): cable pulled$/);
});

test('an alarm that has returned says when it was over', () => {
  const [row] = alarmRows({ unacknowledged: 1, alarms: [alarm('returned-unacknowledged', { changed: '2026-11-23T07:00:07Z', count: 2 })] }, NOW);
  const local = (iso) => new Date(iso).toLocaleTimeString('en-GB');
  assert.equal(row.when, `since ${local('2026-11-23T07:00:00Z')}, over at ${local('2026-11-23T07:00:07Z')} (5.0 s ago), raised 2 times`);
});

test('an alarm of another day has its date', () => {
  const [row] = alarmRows({ unacknowledged: 1, alarms: [alarm('unacknowledged', { since: '2026-11-20T07:00:00Z' })] }, NOW);
  assert.match(row.when, /^since 20\/11\/2026, \d\d:\d\d:00 \(3 d\)$/);
});

test('why an order was not done is always told: a refusal without words is told by its status', async (t) => {
  const answers = (status, body) => t.mock.method(globalThis, 'fetch', async () => new Response(body, { status }));
  answers(403, '{"error": "no right to change"}');
  assert.deepEqual(await give('/api/v1/stop', {}), { error: 'no right to change' });
  answers(502, '{}');
  assert.deepEqual(await give('/api/v1/stop', {}), { error: 'status 502' });
  answers(502, '<html>');
  assert.equal(await give('/api/v1/stop', {}), null, 'not the service: whether it was done is not known');
  answers(200, '{"done": true, "recording": null}');
  assert.deepEqual(await give('/api/v1/start', {}), { done: true, recording: null });
});

test('that it was done is said for 10 s, why it was not until the next attempt', () => {
  const done = { text: 'x is acknowledged.', failed: false, at_s: 100 };
  assert.equal(noteText(done, 109), 'x is acknowledged.');
  assert.equal(noteText(done, 110), '');
  assert.equal(noteText({ ...done, failed: true }, 500), 'x is acknowledged.');
  assert.equal(noteText(null, 0), '');
});

test('the head counts those that wait and names the first, and is silent where none does', () => {
  assert.deepEqual(waitingText({ unacknowledged: 1, alarms: [alarm('unacknowledged')] }), { tone: 'alarm', text: '1 alarm not acknowledged: channel y1: timeout' });
  assert.equal(waitingText({ unacknowledged: 2, alarms: [alarm('unacknowledged'), alarm('unacknowledged')] }).text, '2 alarms not acknowledged: channel y1: timeout …');
  assert.equal(waitingText({ unacknowledged: 0, alarms: [] }), null);
  assert.equal(waitingText(null), null);
  assert.deepEqual(alarmRows(null, NOW), []);
});

// After a device was back, the head said in red that it does not deliver.
test('an alarm that is over is not told as one that lasts', () => {
  const over = alarm('returned-unacknowledged', { text: 'device amplifier does not deliver' });
  assert.deepEqual(waitingText({ unacknowledged: 1, alarms: [over] }), { tone: 'care', text: '1 alarm not acknowledged, over: device amplifier does not deliver' });
  assert.equal(waitingText({ unacknowledged: 2, alarms: [over, over] }).text, '2 alarms not acknowledged, over: device amplifier does not deliver …');
  assert.deepEqual(waitingText({ unacknowledged: 2, alarms: [alarm('unacknowledged'), over] }),
    { tone: 'alarm', text: '1 alarm not acknowledged: channel y1: timeout; 1 more over' });
});

test('where the page has no button for it, it says how else an alarm is acknowledged', () => {
  const list = { unacknowledged: 1, alarms: [alarm('unacknowledged')] };
  const how = (rights, host = '127.0.0.1') => howToAcknowledge(list, { read: true, change: false, token: false, ...rights }, host);
  assert.equal(how({ change: true }), '');
  assert.match(how({ token: true }), /^To acknowledge: log in below, or dwellctl acknowledge NAME on this computer\. /);
  assert.match(how({}), /^To acknowledge: dwellctl acknowledge NAME on this computer\. /);
  assert.match(how({}, 'rig-2.lab'), /on the computer of the service\. /);
  assert.equal(howToAcknowledge({ unacknowledged: 0, alarms: [] }, {}, ''), '');
  // Nobody logs in at a wall display: it has no form for it.
  const wall = (rights) => howToAcknowledge(list, { read: true, change: false, token: false, ...rights }, 'rig-2.lab', true);
  assert.match(wall({ token: true }), /^To acknowledge: log in to this page on another computer, without \?kiosk, or dwellctl acknowledge NAME on the computer of the service\. /);
  assert.match(wall({}), /^To acknowledge: dwellctl acknowledge NAME on/);
});

test('alarms that find no room on a wall display are named, more than three counted', () => {
  assert.equal(unseenText(['clock']), 'alarm “clock”');
  assert.equal(unseenText(['clock', 'log']), 'alarms “clock”, “log”');
  assert.equal(unseenText(['clock', 'log', 'channel:y1', 'channel:y2', 'channel:y3']), 'alarms “clock”, “log”, “channel:y1” and 2 more');
});
