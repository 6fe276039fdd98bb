// One finished dwell, opened from the list: everything that the service or the run's file keeps of it.
import { about, COEFFICIENTS, marksOf, subscript } from './coefficients.mjs';
import { makeBudget, renewBudget } from './coefficients_view.mjs';
import { h, rowHead, setText } from './dom.mjs';
import { limitOf } from './limits.mjs';
import { joined, NORMAL_95, NO_NUMBER, numberText, secondsText } from './number.mjs';
import { phasorCells, whyNoPhasor } from './polar.mjs';
import { FILE_MS, fromRun } from './runs.mjs';
import { modelOf, whom } from './wording.mjs';

const $ = (id) => document.getElementById(id);

const line = (name, text, tone = 'calm') => h('div', { 'data-tone': tone }, h('dt', {}, name), h('dd', {}, text));

// A coefficient and, below it, the verdict on its limit.
function coefficientParts(d, e, { key, letter }) {
  const marks = marksOf(e[key], about(d.doubts, e.k).length > 0).map((mark) => ` ${mark}`).join('');
  const limit = limitOf(d, key, e.k);
  return [h('span', { class: marks.includes('?') ? 'part doubted' : 'part' },
    `${letter}${subscript(e.k)} = ${joined(numberText(e[key].value, e[key].U95, e[key].unit))}${marks}`),
  limit ? h('span', { class: 'limit', 'data-verdict': limit.verdict }, limit.text) : null];
}

function elementItem(d, e) {
  if (!e.identifiable) return h('li', {}, `Element ${e.k}: no coefficients: ${e.reason}`);
  return h('li', {}, ...COEFFICIENTS.flatMap((coefficient) => coefficientParts(d, e, coefficient)));
}

function budgetItem(element) {
  const details = makeBudget(element);
  renewBudget(details, element);
  return h('li', {}, details);
}

function phasorTable(d) {
  const cells = (p) => (p.valid ? phasorCells(d, p).slice(0, 2).map((text) => h('td', {}, text)) : [h('td', { colspan: 2, class: 'words' }, whyNoPhasor(p))]);
  return h('div', { class: 'wide', role: 'region', 'aria-label': 'Table of phasors of the dwell', tabindex: 0 },
    h('table', {}, h('thead', {}, h('tr', {}, ...['channel', 'amplitude', 'phase'].map((title) => h('th', { scope: 'col' }, title)))),
      h('tbody', {}, ...d.phasors.map((p) => h('tr', {}, rowHead(p.channel), ...cells(p))))));
}

// from: { tone, text } of the run's file; null: it comes from none.
function contentOf(d, from) {
  const settled = d.settled_s !== null;
  const model = modelOf({ ...d, state: 'complete' }, null);
  return [
    h('ul', { class: 'notes' }, ...(from ? [h('li', { 'data-tone': from.tone }, from.text)] : []), ...d.doubts.map((doubt) => h('li', { 'data-tone': 'alarm' }, `do not rely on ${whom([doubt])}: ${doubt.what}`)),
    ...d.warnings.filter((_, i) => d.warned[i].kind !== 'doubt').map((text) => h('li', { 'data-tone': 'care' }, text))),
    h('ul', { class: 'plain' }, ...d.elements.map((e) => elementItem(d, e))),
    h('dl', { class: 'facts' },
      line('data', settled ? `${secondsText(d.settled_s, 2)} to ${secondsText(d.end_s, 2)} of the run` : 'never settled'),
      line('settling', d.settling_reason || NO_NUMBER),
      ...(model ? [line('model', model.text, model.tone)] : []),
      line('frequency', joined(numberText(d.frequency_hz.value, NORMAL_95 * d.frequency_hz.u, 'Hz'))),
      line('ended by', d.ended_by)),
    phasorTable(d),
    h('ul', { class: 'plain' }, ...d.elements.filter((e) => e.budget?.length).map(budgetItem)),
  ];
}

let asked = 0; // questions for a dwell so far: the answer to an older one comes too late

// run: as in /api/v1/runs, the recorded run that it comes from; null: the service knows it without a file.
export async function openDwell(brief, run, nowMs) {
  const path = run ? `${run.dwells_at}/${brief.index}` : `/api/v1/dwells/${brief.index}`;
  setText($('dwell-title'), `Dwell ${brief.index}${run ? ` of run ${run.run}` : ''}`);
  $('dwell-json').href = path;
  $('dwell-content').replaceChildren(h('p', {}, 'loading …'));
  $('dwell').showModal();
  const own = ++asked;
  const fill = (content) => own === asked && $('dwell-content').replaceChildren(...content);
  try {
    const answer = await fetch(path, { signal: AbortSignal.timeout(FILE_MS) });
    const dwell = await answer.json();
    if (!answer.ok) throw new Error(dwell.error);
    // Indices begin anew with each run: the service has only those of the newest.
    if (!run && dwell.start_utc !== brief.start_utc) throw new Error('it belongs to an earlier run: choose that run above the table');
    fill(contentOf(dwell, run ? fromRun(run, nowMs) : null));
  } catch (failure) {
    fill([h('p', {}, `It cannot be shown: ${failure.message}`)]);
  }
}
$('dwell-close').addEventListener('click', () => $('dwell').close());
