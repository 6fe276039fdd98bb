// What the page says of recorded runs: whether their files were altered, and whether they can be downloaded. Pure.
import { instantText, secondsText } from './number.mjs';

// A question that a run's file must be read for is given up after so long: the service may read for 60 s.
export const FILE_MS = 70_000;

// { tone, text } of an audit. Each state has a word and a shape; only an abnormal one has a colour. The text says when the
// file was read: what was altered since is not known.
export function auditOf({ audit }, nowMs) {
  if (!audit) return { tone: 'calm', text: '– not known' };
  const known = audit.trusted === false ? ', key not trusted' : '';
  const read = audit.utc ? `, read ${instantText(Date.parse(audit.utc), nowMs)}` : '';
  switch (audit.state) {
    case 'intact': return { tone: known ? 'care' : 'calm', text: `${known ? '◆' : '✓'} intact${known}${read}` };
    case 'open': return { tone: 'care', text: `◇ open${audit.until_s === null ? '' : ` until ${secondsText(audit.until_s)}`}${known}${read}` };
    case 'tampered': return { tone: 'alarm', text: `▲ tampered${read}: ${audit.where}` };
    case 'waiting': return { tone: 'calm', text: '… waits to be audited' };
    default: return { tone: 'calm', text: `– not audited: ${audit.reason}` };
  }
}

// States that ask for an eye: tone and shape.
const ABNORMAL = { unreadable: ['alarm', '▲ '], removed: ['alarm', '▲ '], 'cut off': ['care', '◆ '] };

const TONES = ['calm', 'care', 'alarm'];
const graver = (a, b) => (TONES.indexOf(a) > TONES.indexOf(b) ? a : b);

// { state, audit, tone, href, name, why } for the table. href: where the file is downloaded; null: it cannot be, and why
// says the reason. tone: the graver one of state and audit.
export function runOf(run, nowMs) {
  const [own, shape] = ABNORMAL[run.state] ?? ['calm', ''];
  const audit = auditOf(run, nowMs);
  return { state: shape + run.state, audit: audit.text, tone: graver(own, audit.tone),
    href: run.download ?? null, name: run.file, why: run.download ? '' : run.no_download ?? '' };
}

// Under a table of `shown` runs, the newest of `total`; '': it has all of them.
export const olderRunsText = (shown, total) =>
  (shown < total ? `The newest ${shown} of ${total} runs. Older ones: dwellctl runs, or dwellctl runs FOLDER where they are recorded.` : '');

// The same under a table of dwells of the newest run.
export const olderDwellsText = (shown, total) => (shown < total ? `The newest ${shown} of ${total} dwells of this run.` : '');

// Runs whose dwells can be opened, the newest first: those of the run that goes on are told without its file.
export const earlierRuns = (runs) => runs.filter((run) => run.dwells_at).reverse();

// What must be known of dwells that come from a run's file.
export function fromRun(run, nowMs) {
  const audit = auditOf(run, nowMs);
  const altered = run.audit?.state === 'tampered';
  return { tone: audit.tone, text: `From the file of run ${run.run}${run.label ? `, “${run.label}”` : ''}: an earlier run. Audit: ${audit.text}${altered ? '. Do not rely on these numbers' : ''}.` };
}

// Why the table of dwells is empty; '': it is not. With each run the service's list begins anew.
export function noDwellsText(dwells, runs) {
  if (dwells.length > 0) return '';
  return `No dwell of this run has ended yet.${earlierRuns(runs).length > 0 ? ' To see those of an earlier run, choose it above.' : ''}`;
}
