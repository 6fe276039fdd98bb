// What stands in the table of coefficients: numbers, or the reason in place of the number, and beside each element what
// concerns it. Pure.
import { limitOf } from './limits.mjs';
import { hasEnded, isGeneral, modelOf, utcMs, warningsOf, whom } from './wording.mjs';
import { ageText, isNumber, numberText, secondsText } from './number.mjs';

// c_1, r_1 … of an element, as people write them.
const SUBSCRIPT = '₀₁₂₃₄₅₆₇₈₉';
export const subscript = (k) => String(k).replace(/\d/g, (c) => SUBSCRIPT[c]);

export const COEFFICIENTS = [
  { key: 'stiffness', letter: 'c', name: 'stiffness' },
  { key: 'damping', letter: 'r', name: 'damping' },
];

// Each warning stands once: beside the elements that it names, else with the channels that it names, else with the dwell.
const unsaid = (dwell) => warningsOf(dwell).filter((warning) => !dwell.elements.some((e) => warning.elements.includes(e.k)));
// While the table rests the page has no phasors, so the channels' warnings stand with the dwell's.
const namesChannels = (dwell, warning) => dwell.state !== 'idle' && warning.channels.length > 0;
const textOf = ({ text }) => text;
const warningNotes = (warned, k) => warned.filter(({ elements }) => elements.includes(k)).map(({ text }) => ({ tone: 'care', text }));
export const channelWarnings = (dwell) => unsaid(dwell).filter((warning) => namesChannels(dwell, warning)).map(textOf);
export const generalWarnings = (dwell) => unsaid(dwell).filter((warning) => !namesChannels(dwell, warning)).map(textOf);

// Names a dwell among all of a service's runs: its index begins anew with each.
export const keyOf = (dwell) => `${dwell.start_utc} ${dwell.index}`;

// The doubts that concern an element.
export const about = (doubts, k) => doubts.filter((d) => d.elements.length === 0 || d.elements.includes(k));

const limitsAbout = (limits, k) => (limits ?? []).filter((limit) => limit.element === k);

// Of an element of LastNumbers the newest state in which it had numbers; null: it never had.
const numberedOf = (element) => (element?.identifiable ? element : element?.before ?? null);

// Coefficients that a dwell or its transient gives, remembered for when they are withdrawn: an operator must see that the
// number before his eyes a second ago is gone, and from when it was.
export class LastNumbers {
  key = null; // of their dwell
  index = null;
  // As in a dwell. Where there is a number, also when it was new (seen), its doubts and its limits then. Where the number
  // is withheld while the dwell goes on, also `before`: the element when it had its number.
  elements = [];
  model = null; // the verdict on their dwell's model, as in a dwell
  t = null; // when the newest of them were new, s of the page's clock
  ended_by = null; // null: the end of their dwell is not known
  unstated = []; // uncertainties that their ± does not cover
  warned = []; // the warnings of their dwell, as warningsOf() gives them
  whole = false; // these are those at its end
  #end_s = null; // end of the data that they come from, s on the run's axis

  take(dwell, now, nowMs) {
    const ended_ms = dwell.state === 'complete' ? utcMs(dwell, dwell.end_s) : null;
    // The current dwell's limits have a verdict only while it is measured: the list of dwells brings those of its result.
    if (ended_ms !== null) return this.takeEnded({ ...dwell, limits: null }, ended_ms, now, nowMs);
    if (dwell.settled_s === null || dwell.elements.length === 0) return;
    const same = this.key === keyOf(dwell);
    const t = this.#newAt(dwell, now, nowMs, same);
    const before = same ? new Map(this.elements.map((e) => [e.k, e])) : new Map();
    this.elements = dwell.elements.map((e) => {
      if (e.identifiable) return { ...e, seen: t, doubts: about(dwell.doubts, e.k), limits: limitsAbout(dwell.limits, e.k) };
      const numbered = numberedOf(before.get(e.k));
      return { ...e, before: numbered, doubts: numbered?.doubts ?? about(dwell.doubts, e.k), limits: [] };
    });
    Object.assign(this, { key: keyOf(dwell), index: dwell.index, t, ended_by: null, model: dwell.model ?? (same ? this.model : null),
      unstated: dwell.unstated ?? [], warned: warningsOf(dwell), whole: false });
    this.#end_s = dwell.end_s;
  }

  // When the numbers that the service tells now were new, s of the page's clock. A service that stood still first tells
  // its old numbers once more: these must not look new.
  #newAt(dwell, now, nowMs, same) {
    const told = now - (dwell.estimate_age_s ?? 0);
    if (!same) return told;
    if (dwell.end_s === this.#end_s) return this.t; // nothing new
    // How far the data lag behind: by the page's clock, and by UTC. A clock that was set makes one of the two large, a
    // service that stood still makes both large. So the smaller one counts.
    const behindBefore = now - (this.t + dwell.end_s - this.#end_s);
    const behindUtc = (nowMs - (utcMs(dwell, dwell.end_s) ?? nowMs)) / 1e3;
    return Math.min(told, now - Math.max(0, Math.min(behindBefore, behindUtc)));
  }

  // A dwell that has ended: before the page was opened, or as it was seen. The service cuts its data back to before the
  // drive changed, so its last numbers and doubts replace those that were told live. limits: null: not known; then those
  // of the same numbers stay. The service's list has no warnings: then those that were told live stay.
  takeEnded(dwell, ended_ms, now, nowMs) {
    const same = this.key === keyOf(dwell);
    const none = dwell.settled_s === null || dwell.elements.length === 0;
    const t = same ? Math.min(now, this.t + dwell.end_s - this.#end_s) : now - (nowMs - ended_ms) / 1e3;
    if (!same && (none || (this.t !== null && this.t > t))) return;
    const elements = !none ? dwell.elements
      : this.elements.map(({ k }) => ({ k, identifiable: false, reason: 'too few of its data count' }));
    const before = same ? this.elements : [];
    const limitsOf = (e) => (dwell.limits === null
      ? before.map(numberedOf).find((b) => b?.k === e.k && COEFFICIENTS.every(({ key }) => b[key]?.value === e[key]?.value))?.limits ?? []
      : limitsAbout(dwell.limits, e.k));
    Object.assign(this, { key: keyOf(dwell), index: dwell.index, t, ended_by: dwell.ended_by, model: dwell.model ?? (same ? this.model : null),
      unstated: dwell.unstated ?? [], warned: dwell.warnings ? warningsOf(dwell) : same ? this.warned : [],
      whole: Boolean(dwell.warnings) || (same && this.whole),
      elements: elements.map((e) => ({ ...e, seen: t, doubts: about(dwell.doubts, e.k), limits: limitsOf(e) })) });
    this.#end_s = dwell.end_s;
  }

  // They hold after the end of the dwell, and after a moment in which there were no numbers to be doubted.
  doubts() {
    return [...new Set(this.elements.flatMap((e) => e.doubts ?? []))];
  }
}

export const marksOf = (coefficient, doubted) =>
  [...(coefficient.significant === false ? ['n.s.'] : []), ...(doubted ? ['?'] : [])];

// limits: as in a dwell; they stand beside the numbers.
function cellsOf(element, doubted, struckAge, limits = []) {
  return COEFFICIENTS.map(({ key, letter, name }) => {
    const coefficient = element[key];
    const cell = { of: [key, element.k], symbol: letter + subscript(element.k), name, number: null, struck: struckAge, marks: [],
      limit: element.identifiable ? limitOf({ limits }, key, element.k) : null };
    if (element.identifiable && coefficient && isNumber(coefficient.value)) {
      cell.number = numberText(coefficient.value, coefficient.U95, coefficient.unit);
      cell.marks = marksOf(coefficient, doubted);
    }
    return cell;
  });
}

// An element as it was when it had its numbers, for where they are withheld now. null: it never had any.
const struckCells = (before, now) => (before ? cellsOf(before, before.doubts.length > 0, ageText(now - before.seen), before.limits) : null);

const MARKS = { 'n.s.': 'not significant: smaller than its standard uncertainty', '?': 'do not rely on it' };

// What stands below the numbers. shown: as coefficientsOf() gives it; trendLacks: numbers of runs.
export function legendOf(shown, trendLacks = []) {
  if (shown.elements.length === 0) return '';
  const parts = ['± is the half width of the 95 % interval, if the rig is as its file says'];
  const marks = new Set(shown.elements.flatMap((e) => e.cells.flatMap((cell) => cell.marks)));
  if (shown.source === 'transient')
    parts.push('Slanted: an estimate from the readings so far, not yet the result; the numbers of the steady motion replace it once the rig has settled');
  for (const mark of marks) parts.push(`${mark}: ${MARKS[mark]}`);
  if (shown.elements.some((e) => e.last || e.cells.some((cell) => cell.struck)))
    parts.push('struck through: no longer renewed; its age stands beside it');
  if (shown.unstated.length > 0)
    parts.push(`± covers noise, clock and what the rig file states; not stated: ${shown.unstated.join(', ')}`);
  if (trendLacks.length > 0)
    parts.push(`the trends lack ${trendLacks.length > 1 ? 'runs' : 'run'} ${trendLacks.join(', ')}: no file of theirs could be read`);
  return `${parts.join('. ')}.`;
}

// What a trend beside a number is, and shows; '': there is none. reach_ms: before now; null: nothing is known yet.
// someDoubted: it leaves out numbers.
export function trendLegendOf(shown, reach_ms, someDoubted = false) {
  if (reach_ms === null || !shown.elements.some((e) => !e.last && e.cells.some((cell) => !cell.struck))) return '';
  return `A trend shows the last ${ageText(reach_ms / 1e3)}. Its middle is the newest measured value, its upper and lower edge that value ± the % below it. The grey band is the ± of each value.${someDoubted ? ' Hatched: left out, do not rely on it.' : ''}`;
}

// { source, title, notes, reason, unstated, warnings, nowWarnings, elements: [{ k, reason, cells, last, notes }] }
//   source  'measured', 'transient', 'last' or 'none'
//   notes   { tone, text }: of 'last': the doubts, and the verdict on the model; the head tells those of a dwell of now
//   unstated  uncertainties that no ± of these numbers covers
//   warnings  of the dwell that these numbers are of, where no element or channel has them beside it
//   nowWarnings  those of now, where the numbers are of a dwell before
//   cells   symbol, name, number (as numberText gives it; null: withheld), struck (null, or the age as text), marks,
//           limit (as limitOf gives it)
//   last    the cells as they were, struck, where the number is withheld now
// view: { dwell, health, fresh, now, nowMs: UTC of now, ms, last: LastNumbers, verification: the newest, broken: a channel that counts is gone,
// refused: nobody is logged in }
export function coefficientsOf({ dwell, health, fresh, now, nowMs, last, verification, broken, refused }) {
  const none = (reason) => ({ source: 'none', title: '', notes: [], reason, unstated: [], warnings: dwell ? generalWarnings(dwell) : [],
    nowWarnings: [], elements: [] });
  if (!dwell) return none(refused ? 'nobody is logged in' : 'the service has not told of a dwell yet');
  const old = fresh.dwellOld(now);
  const age = old ? ageText(fresh.dwellAge_s(now)) : null;

  const shown = (elements, source, title) => ({ source, title, notes: [], reason: null, unstated: dwell.unstated,
    warnings: generalWarnings(dwell), nowWarnings: [], elements: elements.map((e) => {
    const doubts = dwell.doubts.filter((d) => d.elements.includes(e.k));
    const doubted = about(dwell.doubts, e.k).length > 0;
    const before = source === 'measured' && !e.identifiable && last.key === keyOf(dwell)
      ? numberedOf(last.elements.find((b) => b.k === e.k)) : null;
    return {
      k: e.k,
      reason: e.identifiable ? null : e.reason ?? 'no reason stated',
      cells: cellsOf(e, doubted, age, source === 'measured' ? dwell.limits ?? [] : []),
      budget: e.budget ?? [],
      last: struckCells(before, now),
      notes: [...doubts.map((d) => ({ tone: 'alarm', text: `do not rely on this: ${isGeneral(d) ? 'see above' : d.what}` })),
        ...warningNotes(warningsOf(dwell), e.k)],
    };
  }) });

  if (dwell.state !== 'complete' && dwell.settled_s !== null && dwell.elements.length > 0)
    return shown(dwell.elements, 'measured', `dwell ${dwell.index}`);

  const m = dwell.motion;
  if (dwell.state === 'settling' && m && m.elements.length > 0) {
    const age_s = (nowMs - utcMs(dwell, m.end_s)) / 1e3;
    const stretch = `${m.start_s.toFixed(1)} to ${secondsText(m.end_s)}${age_s >= 1 ? `, ${ageText(age_s)} ago` : ''}`;
    return shown(m.elements, 'transient', `from the transient, ${stretch}: an estimate before the verdict`);
  }
  if (dwell.state === 'settling')
    return none(`settling: ${dwell.settling_reason || 'the transient is not over'}`);

  if (last.t === null) return none(dwell.settling_reason || 'nothing has been measured yet');
  // After a recording was played to its end nothing more is expected.
  const played = hasEnded(health);
  const gone = old || (!played && (broken || dwell.state === 'fault'));
  const lastAge = ageText(now - last.t);
  // A dwell that has ended is told on only after the run was stopped, with that as its reason. If the stop ended it, its
  // own cause, the end of the data, says nothing more.
  const staysInView = dwell.state === 'complete' && last.key === keyOf(dwell);
  const stopped = staysInView ? dwell.settling_reason : '';
  const cause = played && last.ended_by === 'data lost' ? 'the recording ended' : last.ended_by;
  const causes = [stopped && cause === 'end' ? '' : cause, stopped].filter(Boolean);
  const doubts = last.doubts();
  const model = modelOf({ ...last, doubts, state: 'complete' }, verification ?? null);
  // Its channels' warnings stand with the phasors while the page shows those of that dwell.
  const warned = last.warned.filter(({ elements, channels }) =>
    !last.elements.some((e) => elements.includes(e.k)) && !(staysInView && channels.length > 0));
  return {
    source: 'last',
    // When a dwell ended of which the service tells no more, as after it was started again, nobody knows.
    title: `last dwell: ${last.index}, ${last.ended_by === null ? 'last seen' : 'ended'} ${lastAge} ago${causes.length > 0 ? `: ${causes.join('; ')}` : ''}`,
    notes: [...doubts.map((d) => ({ tone: 'alarm', text: `do not rely on ${whom([d])}: ${d.what}` })),
      ...(model ? [{ tone: model.tone, text: `model: ${model.text}` }] : [])],
    reason: null,
    unstated: last.unstated,
    warnings: warned.map(textOf),
    nowWarnings: staysInView ? [] : generalWarnings(dwell),
    elements: last.elements.map((e) => ({ k: e.k, reason: e.identifiable ? null : e.reason ?? 'no reason stated',
      cells: cellsOf(e, e.doubts?.length > 0, gone ? lastAge : null, e.limits), last: struckCells(e.before ?? null, now),
      notes: warningNotes(last.warned, e.k),
      budget: [] })),
  };
}
