// Whose dwells the table shows: those of now, or of an earlier run that is chosen, which the service reads from its file.
import { h, keyed, setAttributes, setText, show } from './dom.mjs';
import { instantText } from './number.mjs';
import { earlierRuns, FILE_MS, fromRun } from './runs.mjs';

const $ = (id) => document.getElementById(id);
const NOW = '';

let chosen = null; // { file, dwells: null while they are read, total, why: why there are none }

let runs = []; // as shown last

async function choose(file, changed) {
  const run = runs.find((one) => one.file === file);
  if (!run) {
    chosen = null;
    return changed();
  }
  const asked = { file, dwells: null, total: 0, why: '' };
  chosen = asked;
  changed();
  try {
    const answer = await fetch(`${run.dwells_at}?count=100`, { signal: AbortSignal.timeout(FILE_MS) });
    const told = await answer.json();
    if (!answer.ok) throw new Error(told.error);
    Object.assign(asked, { dwells: told.dwells, total: told.total });
  } catch (failure) {
    asked.why = failure.message;
  }
  changed();
}

// changed: called when another run is chosen or its dwells have come.
export function beginEarlier(changed) {
  $('dwells-run').addEventListener('change', (event) => choose(event.target.value, changed));
}

// The run that a dwell of the table comes from; null: the service tells it without a file. dwell: the current one.
export function runOfDwell(finished, { dwell, runs: told }) {
  if (!chosen && (!dwell || finished.start_utc === dwell.start_utc)) return null;
  const file = chosen ? chosen.file : finished.file;
  return earlierRuns(told).find((run) => run.file === file) ?? null;
}

// { dwells, text } of the chosen run, text where there is something to say of them; null: those of now are shown.
export function earlierDwells({ runs: told, nowMs }) {
  const all = earlierRuns(told);
  runs = all;
  if (chosen && !all.some((run) => run.file === chosen.file)) chosen = null; // its file has gone
  show($('dwells-choice'), all.length > 0);
  keyed($('dwells-run'), [{ file: NOW }, ...all], (run) => run.file, (run) => h('option', { value: run.file }), (option, run) =>
    setText(option, run.file === NOW ? 'the newest run' : `run ${run.run}${run.label ? `, ${run.label}` : ''}: ${run.dwells} ${run.dwells > 1 ? 'dwells' : 'dwell'}, begun ${instantText(Date.parse(run.begun), nowMs)}`));
  $('dwells-run').value = chosen?.file ?? NOW;
  const run = all.find(({ file }) => file === chosen?.file);
  const from = run ? fromRun(run, nowMs) : { tone: 'calm', text: '' };
  show($('dwells-of'), Boolean(run));
  setText($('dwells-of'), from.text);
  setAttributes($('dwells-of'), { 'data-tone': from.tone });
  if (!run) return null;
  if (chosen.why) return { dwells: [], text: `They cannot be shown: ${chosen.why}` };
  if (!chosen.dwells) return { dwells: [], text: 'loading …' };
  const left = chosen.total - chosen.dwells.length;
  return { dwells: chosen.dwells, text: left > 0 ? `The newest ${chosen.dwells.length} of ${chosen.total}. All of them: dwellctl show FILE.` : '' };
}
