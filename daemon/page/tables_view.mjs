// Channels, devices, events, dwells and runs: tables that are renewed where something changed.
import { openDwell } from './dwell_view.mjs';
import { about, COEFFICIENTS, keyOf, subscript } from './coefficients.mjs';
import { h, keyed, readable, rowHead, setAttributes, setText, show } from './dom.mjs';
import { beginEarlier, earlierDwells, runOfDwell } from './earlier_view.mjs';
import { limitOf, SHAPES } from './limits.mjs';
import { ageText, instantText, isNumber, joined, NORMAL_95, NO_NUMBER, numberText, plainText, secondsText } from './number.mjs';
import { noDwellsText, olderDwellsText, olderRunsText, runOf } from './runs.mjs';
import { eventsText, isWell, modelBrief, utcMs } from './wording.mjs';

const $ = (id) => document.getElementById(id);
const EVENTS_SHOWN = 100;

const dateText = (iso, nowMs) => instantText(iso ? Date.parse(iso) : null, nowMs);
const count = (n) => n.toLocaleString('en-GB').replaceAll(',', '\u202f');

// Rows of { key, struck, untold, tone, cells: [text…] }, the first cell a heading. untold: the service no longer tells of
// it, so that nothing in the row is of now.
function fillRows(body, rows) {
  keyed(body, rows, (row) => `${row.key} ${row.cells.length}`,
    (row) => h('tr', {}, ...row.cells.map((_, i) => (i === 0 ? rowHead() : h('td', {}, h('span', {}))))),
    (node, row) => {
      setAttributes(node, { class: [row.struck && 'struck', row.untold && 'untold'].filter(Boolean).join(' '), 'data-tone': row.tone ?? 'calm' });
      row.cells.forEach((text, i) => setText(node.children[i].firstChild, text));
    });
}

// Until when it holds is told in full: a row has a colour only once that day has passed.
const calibrationText = (c) => (!c ? 'none stated' : `${c.id}${c.due ? `, due ${c.due}` : ''}${c.overdue ? ': overdue' : ''}`);

function showChannels({ channels, health, fresh, now }) {
  show($('channels'), channels !== null);
  const old = fresh.answersOld(now);
  const since = fresh.answersAge_s(now);
  fillRows($('channel-rows'), (channels ?? []).map((c) => {
    const bad = !isWell(c, health);
    const overdue = c.calibration?.overdue === true;
    const age = isNumber(c.age_s) ? c.age_s + (old ? since : 0) : null;
    return { key: c.name, tone: bad ? 'alarm' : overdue ? 'care' : 'calm', struck: old || age === null || age > fresh.old_s, untold: old,
      cells: [bad ? `▲ ${c.name}` : overdue ? `◆ ${c.name}` : c.name, c.text,
        isNumber(c.value) ? `${plainText(c.value, '', 5)} ${c.unit}` : NO_NUMBER, ageText(age),
        isNumber(c.rate_hz) ? `${c.rate_hz.toFixed(0)} Hz` : NO_NUMBER, isNumber(c.jitter_s) ? plainText(c.jitter_s * 1e3, '', 2) + ' ms' : NO_NUMBER,
        count(c.received), count(c.dropped), count(c.lost), count(c.gaps), calibrationText(c.calibration)] };
  }));
  show($('devices'), health !== null);
  fillRows($('device-rows'), (health?.devices ?? []).map((d) => ({ key: d.name, tone: d.up || d.ended ? 'calm' : 'alarm', struck: old,
    cells: [`${d.up || d.ended ? '' : '▲ '}${d.name}${old ? `, ${ageText(since)} old` : ''}`, d.driver, d.up ? 'delivers' : d.ended ? 'recording ended' : 'does not deliver',
      Object.entries(d.faults).map(([what, n]) => `${what}: ${count(n)}`).join(', ') || 'none'] })));
}

// Section by its name. told: its list comes from the service again and again.
function markOld(name, { fresh, now }, told = true) {
  const old = told && fresh.listOld(name, now);
  $(name).classList.toggle('old', old);
  show($(`${name}-old`), old);
  setText($(`${name}-old`), old ? `${ageText(fresh.listAge_s(name, now))} old: the service does not tell of them` : '');
}

function showEvents(view) {
  const { events, eventsTotal, health, nowMs } = view;
  const least = ['info', 'warning', 'error'].indexOf($('event-level').value);
  const words = $('event-words').value.toLowerCase();
  const fit = events.filter((e) => ['info', 'warning', 'error'].indexOf(e.level) >= least && e.text.toLowerCase().includes(words));
  const shown = fit.slice(-EVENTS_SHOWN).reverse();
  show($('events'), health !== null);
  markOld('events', view);
  setText($('events-none'), eventsText({ shown: shown.length, fit: fit.length, known: events.length, total: eventsTotal }));
  keyed($('event-rows'), shown, (e) => `${e.number} ${e.utc}`, (e) => h('li', { 'data-level': e.level },
    h('time', { datetime: e.utc }), h('span', { class: 'level' }, e.level === 'info' ? '' : e.level === 'error' ? '▲ error ' : '◆ warning '),
    h('span', {}, e.text)), (node, e) => setText(node.firstChild, dateText(e.utc, nowMs)));
}

// { text, verdict: on its limit, doubted } of each coefficient, by its symbol. A mark stands before the number.
function coefficientCells(dwell) {
  return COEFFICIENTS.flatMap(({ key, letter }) => dwell.elements.map((e) => {
    const verdict = e.identifiable ? limitOf(dwell, key, e.k)?.verdict ?? '' : '';
    const doubted = about(dwell.doubts, e.k).length > 0;
    const marks = [...(doubted ? ['?'] : []), ...(verdict && verdict !== 'none' ? [SHAPES[verdict]] : [])];
    return [letter + subscript(e.k), { verdict, doubted: doubted && e.identifiable,
      text: e.identifiable ? [...marks, joined(numberText(e[key].value, e[key].U95, e[key].unit))].join(' ') : NO_NUMBER }];
  }));
}

function dwellMarksText(dwells) {
  const verdicts = new Set(dwells.flatMap((d) => (d.limits ?? []).map((limit) => limit.verdict)));
  return [...(dwells.some((d) => d.doubts.length > 0) ? ['?: do not rely on it'] : []),
    ...['kept', 'undecided', 'violated'].filter((verdict) => verdicts.has(verdict)).map((verdict) => `${SHAPES[verdict]}: limit ${verdict}`)].join('. ');
}

let heads = '';
function showDwells(view) {
  const { dwell, runs, health, nowMs } = view;
  const earlier = earlierDwells(view);
  const dwells = earlier?.dwells ?? view.dwells;
  const own = dwells.filter((d) => d.start_utc === dwells.at(-1).start_utc).length;
  show($('dwells'), health !== null);
  markOld('dwells', view, !earlier);
  show($('dwells-table'), dwells.length > 0);
  setText($('dwells-none'), earlier?.text ?? (noDwellsText(dwells, runs) || olderDwellsText(own, view.dwellsTotal)));
  const ks = [...new Set(dwells.flatMap((d) => d.elements.map((e) => e.k)))].sort((a, b) => a - b);
  if (ks.join() !== heads) {
    heads = ks.join();
    $('dwell-heads').replaceChildren(...['dwell', 'ended', 'data', 'frequency', 'table', ...COEFFICIENTS.flatMap(({ letter }) =>
      ks.map((k) => letter + subscript(k))), 'model', 'ended by'].map((title) => h('th', { scope: 'col' }, title)));
  }
  setText($('dwells-marks'), dwellMarksText(dwells));
  keyed($('dwell-rows'), [...dwells].reverse(), (d) => keyOf(d) + heads + JSON.stringify(coefficientCells(d)), (d) => {
    const numbers = new Map(coefficientCells(d));
    const open = h('button', { type: 'button' }, String(d.index));
    open.addEventListener('click', () => openDwell(d, runOfDwell(d, newest), newest.nowMs));
    const cell = (text, verdict = '', doubted = false) => h('td', { 'data-verdict': verdict, 'data-doubted': doubted }, text);
    return h('tr', {}, h('th', { scope: 'row' }, open), ...['', d.settled_s === null ? 'never settled' : secondsText(d.end_s - d.settled_s),
      isNumber(d.frequency_hz.value) ? joined(numberText(d.frequency_hz.value, NORMAL_95 * d.frequency_hz.u, 'Hz')) : NO_NUMBER,
      d.table ? plainText(d.table.amplitude, d.table.unit, 4) : NO_NUMBER,
    ].map((text) => cell(text)),
    ...COEFFICIENTS.flatMap(({ letter }) => ks.map((k) => {
      const number = numbers.get(letter + subscript(k));
      return cell(number?.text ?? NO_NUMBER, number?.verdict, number?.doubted);
    })), cell(''), cell(d.ended_by));
  }, (node, d) => {
    const before = !earlier && dwell !== null && d.start_utc !== dwell.start_utc;
    setText(node.firstChild.firstChild, before ? `${d.index}, earlier run` : String(d.index));
    setText(node.children[1], instantText(utcMs(d, d.end_s), nowMs));
    setText(node.children[node.children.length - 2], modelBrief(d.model) ?? NO_NUMBER); // may come after the dwell's end
  });
}

const RUN_FILE = 3; // column of the link, as index.html has them: run, state, audit, file …

function makeRun({ name, href, run }) {
  const file = href ? h('a', { href, download: name, 'aria-label': `Download run ${run}, ${name}` }) : h('span', {});
  return h('tr', {}, h('th', { scope: 'row' }), ...Array.from({ length: 8 }, (_, i) =>
    (i + 1 === RUN_FILE ? h('td', { class: 'words' }, file, h('span', { class: 'file', title: readable(name) }, name))
      : h('td', i + 1 === RUN_FILE - 1 ? { class: 'words' } : {}, h('span', {})))));
}

function showRuns(view) {
  const { runs, runsTotal, nowMs } = view;
  show($('runs'), runs.length > 0);
  markOld('runs', view);
  setText($('runs-older'), olderRunsText(runs.length, runsTotal));
  const rows = [...runs].reverse().map((r) => {
    const words = runOf(r, nowMs);
    return { ...words, run: r.run, cells: [words.tone === 'alarm' ? `▲ ${r.run}` : String(r.run), words.state, words.audit, words.href ? 'download' : words.why || NO_NUMBER,
      r.label || NO_NUMBER, dateText(r.begun, nowMs), dateText(r.ended, nowMs), count(r.dwells), `${(r.bytes / 1e6).toFixed(1)} MB`] };
  });
  keyed($('run-rows'), rows, (row) => `${row.name} ${row.href !== null}`, makeRun, (node, row) => {
    setAttributes(node, { 'data-tone': row.tone });
    row.cells.forEach((text, i) => setText(i === 0 ? node.firstChild : node.children[i].firstChild, text));
  });
}

let newest = null;
export function showTables(view) {
  newest = view;
  showDwells(view);
  showChannels(view);
  showEvents(view);
  showRuns(view);
}
beginEarlier(() => newest && showDwells(newest));
for (const id of ['event-level', 'event-words']) $(id).addEventListener('input', () => newest && showEvents(newest));
