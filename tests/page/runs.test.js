// What the page says of recorded runs.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { auditOf, earlierRuns, fromRun, noDwellsText, olderDwellsText, olderRunsText, runOf } from '../../daemon/page/runs.mjs';

const audit = (state, more = {}) => ({ audit: { state, where: null, until_s: null, trusted: true, utc: null, reason: null, ...more } });
const said = (run) => Object.values(auditOf(run)).join(': ');

test('each verdict has a word and a shape, and a colour only where it is abnormal', () => {
  assert.equal(said(audit('intact')), 'calm: ✓ intact');
  assert.equal(said(audit('intact', { trusted: false })), 'care: ◆ intact, key not trusted');
  assert.equal(said(audit('open', { until_s: 12.34 })), 'care: ◇ open until 12.3 s');
  assert.equal(said(audit('tampered', { where: 'entry 5: its head does not follow' })), 'alarm: ▲ tampered: entry 5: its head does not follow');
  assert.equal(said(audit('waiting', { trusted: null, reason: 'it waits for its turn' })), 'calm: … waits to be audited');
  assert.equal(said(audit('not audited', { trusted: null, reason: 'the run goes on' })), 'calm: – not audited: the run goes on');
  assert.equal(said({}), 'calm: – not known');
});

test('what was read has the instant of it, with the date where that is another day', () => {
  const now = Date.parse('2026-11-23T14:03:30Z');
  const text = (utc, state, more) => auditOf(audit(state, { utc, ...more }), now).text;
  const today = '2026-11-23T14:03:07.000000Z';
  const at = new Date(today).toLocaleTimeString('en-GB');
  assert.equal(text(today, 'intact'), `✓ intact, read ${at}`);
  assert.equal(text(today, 'intact', { trusted: false }), `◆ intact, key not trusted, read ${at}`);
  assert.equal(text(today, 'open', { until_s: 12.34 }), `◇ open until 12.3 s, read ${at}`);
  assert.equal(text(today, 'tampered', { where: 'entry 5' }), `▲ tampered, read ${at}: entry 5`);
  assert.match(text('2026-11-20T12:00:00Z', 'intact'), /^✓ intact, read 20\/11\/2026, \d\d:00:00$/);
  assert.equal(fromRun({ run: 3, label: '', ...audit('intact', { utc: today }) }, now).text, `From the file of run 3: an earlier run. Audit: ✓ intact, read ${at}.`);
  assert.equal(runOf({ state: 'closed', ...audit('intact', { utc: today }) }, now).audit, `✓ intact, read ${at}`);
});

test('a run that is closed can be downloaded, any other has the reason', () => {
  const run = { run: 3, file: 'rig-3-20261123T031217Z.dwell', state: 'closed', download: '/api/v1/runs/rig-3-20261123T031217Z.dwell', no_download: null, ...audit('intact') };
  assert.deepEqual(runOf(run), { state: 'closed', audit: '✓ intact', tone: 'calm', href: run.download, name: run.file, why: '' });
  const going = runOf({ ...run, state: 'recording', download: null, no_download: 'the run goes on', ...audit('not audited', { reason: 'the run goes on' }) });
  assert.deepEqual([going.href, going.why, going.tone], [null, 'the run goes on', 'calm']);
  assert.equal(runOf({ ...run, state: 'unreadable', ...audit('tampered', { where: 'no database' }) }).state, '▲ unreadable');
  const removed = runOf({ ...run, state: 'removed', download: null, no_download: 'its file was removed', ...audit('not audited', { reason: 'its file was removed' }) });
  assert.deepEqual([removed.state, removed.tone, removed.href, removed.why], ['▲ removed', 'alarm', null, 'its file was removed']);
  assert.equal(runOf({ ...run, state: 'cut off', ...audit('waiting') }).tone, 'care');
  assert.equal(runOf({ ...run, ...audit('tampered', { where: 'entry 2' }) }).tone, 'alarm');
});

test('an empty table of dwells says that a new run has begun it anew', () => {
  assert.equal(noDwellsText([{}], []), '');
  assert.equal(noDwellsText([], [{ dwells: 0, dwells_at: null }]), 'No dwell of this run has ended yet.');
  assert.equal(noDwellsText([], [{ dwells: 4, dwells_at: '/a' }, { dwells: 0, dwells_at: null }]), 'No dwell of this run has ended yet. To see those of an earlier run, choose it above.');
  assert.equal(noDwellsText([], [{ dwells: 4, dwells_at: null }]), 'No dwell of this run has ended yet.');
});

test('earlier runs with dwells can be chosen, the newest first', () => {
  const runs = [{ run: 1, dwells_at: '/api/v1/runs/a.dwell/dwells' }, { run: 2, dwells_at: null }, { run: 3, dwells_at: '/api/v1/runs/c.dwell/dwells' }];
  assert.deepEqual(earlierRuns(runs).map((run) => run.run), [3, 1]);
});

test('numbers from a file say so, with its audit', () => {
  assert.deepEqual(fromRun({ run: 3, label: 'oil', ...audit('intact') }),
    { tone: 'calm', text: 'From the file of run 3, “oil”: an earlier run. Audit: ✓ intact.' });
  assert.deepEqual(fromRun({ run: 3, label: '', ...audit('tampered', { where: 'entry 5' }) }),
    { tone: 'alarm', text: 'From the file of run 3: an earlier run. Audit: ▲ tampered: entry 5. Do not rely on these numbers.' });
});

test('runs that are not in the table are told of', () => {
  assert.equal(olderRunsText(20, 20), '');
  assert.equal(olderRunsText(0, 0), '');
  assert.match(olderRunsText(20, 57), /^The newest 20 of 57 runs\. /);
});

test('dwells of the newest run that are not in the table are told of', () => {
  assert.equal(olderDwellsText(12, 12), '');
  assert.equal(olderDwellsText(300, 0), '', 'a new run has begun');
  assert.equal(olderDwellsText(300, 412), 'The newest 300 of 412 dwells of this run.');
});
