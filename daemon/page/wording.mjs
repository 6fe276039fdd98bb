// What the first line says: the state in one word, what belongs to it, and what is wrong. Pure.
import { ageText, isNumber, joined, NORMAL_95, numberText, percentText, plainText, secondsText } from './number.mjs';

// Grey unless abnormal (ISA-101): `calm` is grey, `care` amber, `alarm` red. Each kind has a shape of its own, so that
// nobody needs the colour.
const TONES = { connecting: 'calm', idle: 'calm', settling: 'calm', measuring: 'calm', complete: 'calm', fault: 'alarm',
  gone: 'alarm', locked: 'alarm' };

// Of whom doubts are: "any element", "element 2", "elements 1, 3".
export function whom(doubts) {
  if (doubts.some((doubt) => doubt.elements.length === 0)) return 'any element';
  const ks = [...new Set(doubts.flatMap((doubt) => doubt.elements))].sort((a, b) => a - b);
  return `${ks.length > 1 ? 'elements' : 'element'} ${ks.join(', ')}`;
}

export const NOT_VERIFIED = 'not verified yet'; // as the service says it

// More elements than these are counted, not named.
const NAMED = 6;
// The state while it is measured. Without any number "measuring" would pass for healthy across the room: the word, the
// shape and the colour are others then. Where some elements have none, the word and the shape are.
function measuringOf({ elements, end_s, settled_s }) {
  const data = `${secondsText(end_s - settled_s)} of data`;
  const ks = elements.filter((e) => !e.identifiable).map((e) => e.k);
  if (ks.length === elements.length)
    return { ...said('measuring', 'no coefficients', `measuring, ${data}; ${ks.length > 0 ? 'withheld: see why at each element' : 'none so far'}`), tone: 'care', shape: 'none' };
  if (ks.length === 0) return said('measuring', 'measuring', data);
  const whose = ks.length > NAMED ? `${ks.length} of ${elements.length} elements` : `${ks.length > 1 ? 'elements' : 'element'} ${ks.join(', ')}`;
  return { ...said('measuring', 'measuring in part', `${data}; no coefficients of ${whose}`), shape: 'part' };
}

// A doubt about one element stands beside it, any other above them all, once.
export const isGeneral = (doubt) => doubt.elements.length !== 1;

// A recording is played in place of a rig, as its driver says: nothing of it is of now.
export const playsRecording = (health) => Boolean(health?.devices?.some((device) => device.recorded));
// … and all that there is to play has been played. Then no drive is seen, which is no fault.
export const hasEnded = (health) => Boolean(health?.devices?.length) && health.devices.every((device) => device.ended);

// { text, tone } of the limits that a dwell does not keep for certain, counted; null: the dwell is not measured, or has
// no limits.
export function limitsText(dwell) {
  const count = (verdict) => (dwell?.limits ?? []).filter((limit) => limit.verdict === verdict).length;
  const [violated, undecided, none] = ['violated', 'undecided', 'none'].map(count);
  if (dwell?.state !== 'measuring' || !dwell.limits?.length) return null;
  const parts = [...(violated ? [`${violated} violated`] : []), ...(undecided ? [`${undecided} undecided`] : []),
    ...(none ? [`${none} without a verdict`] : [])];
  return { text: parts.length > 0 ? parts.join(', ') : 'all kept', tone: violated ? 'alarm' : 'calm' };
}

// The warnings of a dwell beside its doubts: { text, kind, elements, channels } as the service tells them. That it has not
// settled is its state.
export const warningsOf = (dwell) => dwell.warnings.map((text, i) => ({ text, ...dwell.warned[i] }))
  .filter(({ kind }) => kind !== 'doubt' && kind !== 'not settled');

// How many these are. null: none.
export const warningsText = (dwell) => (dwell && warningsOf(dwell).length > 0 ? String(warningsOf(dwell).length) : null);

const said = (kind, word, detail) => ({ kind, word, detail, tone: TONES[kind], shape: kind });

// What is so whatever the dwell; null: then the dwell tells the state.
function stateOfService({ dwell, health, fresh, now, refused, anew }) {
  if (refused) {
    const why = anew ? 'the service was started anew: log in again below to read' : 'log in below to read';
    return dwell ? said('locked', 'logged out', `what is shown is ${ageText(fresh.silence_s(now))} old; ${why}`)
      : { ...said('locked', 'logged out', 'log in below to read'), tone: 'calm' };
  }
  if (!dwell) {
    return fresh.gone(now) && Number.isFinite(fresh.heard_s)
      ? said('gone', 'service gone', 'no answer; trying again every second')
      : said('connecting', 'connecting', 'waiting for the first word of the service');
  }
  if (fresh.gone(now))
    return said('gone', 'service gone', `nothing heard for ${ageText(fresh.silence_s(now))}; trying again every second`);
  if (health?.status === 'fault') return said('fault', 'service fault', health.reason ?? 'no reason stated');
  if (hasEnded(health)) return said('complete', 'recording ended', 'it has been played to its end');
  return null;
}

function stateOfDwell(dwell) {
  if (dwell.state === 'fault') return said('fault', 'fault', dwell.settling_reason || 'the data do not suffice');
  if (dwell.state === 'settling') {
    return said('settling', 'settling', isNumber(dwell.settles_in_s) ? `about ${ageText(dwell.settles_in_s)} left`
      : `time left not known${dwell.settling_reason ? `: ${dwell.settling_reason}` : ''}`);
  }
  if (dwell.state === 'measuring') {
    const state = measuringOf(dwell);
    if (dwell.doubts.length === 0) return state;
    return { ...state, tone: 'alarm', shape: 'fault', detail: `${state.detail}; do not rely on ${whom(dwell.doubts)}` };
  }
  if (dwell.state === 'complete') return said('complete', 'complete', dwell.settling_reason || `ended by: ${dwell.ended_by}`);
  return said('idle', 'idle', dwell.settling_reason || 'the table does not move');
}

// The state as the page must show it: { kind, word, detail, tone, shape, age }. shape: its name, as head_view.mjs draws it. age: how old this is, as text, where that
// is too old while the service answers; else null. view: { dwell, health, fresh, now, refused: nobody is logged in, and
// nothing may be read; anew: for the service has begun anew }; dwell and health may be null.
export function stateOf(view) {
  const state = stateOfService(view);
  if (state) return { ...state, age: null };
  const { dwell, health, fresh, now } = view;
  const told = stateOfDwell(dwell);
  const detail = playsRecording(health) ? `a recording, not live: ${told.detail}` : told.detail;
  return { ...told, detail, age: fresh.dwellOld(now) ? ageText(fresh.dwellAge_s(now)) : null };
}

// Why a dwell's model has no verdict yet. verification: the newest of the run, which may be of a dwell before.
function unverifiedText(dwell, verification) {
  // The doubts themselves stand in full, in their own tone.
  if (dwell.doubts.length > 0) return 'the coefficients are doubted';
  const ended = dwell.state === 'complete';
  if (!verification) return ended ? 'the dwell has ended' : 'no reason known yet';
  if (verification.dwell !== null && verification.dwell !== dwell.index) return ended ? 'the dwell has ended' : 'it is being verified';
  return verification.reasons[0] ?? 'no reason stated';
}

// The verdict on the model, or null where there is none. A verdict that is still to come is no trouble.
export function modelOf(dwell, verification) {
  const model = dwell?.model;
  if (!model) return null;
  let text = model.verdict;
  if (model.verdict === NOT_VERIFIED) text += `: ${unverifiedText(dwell, verification)}`;
  if (isNumber(model.seen)) text += `, off by ${joined(numberText(100 * model.seen, 100 * model.U, '%'))}`;
  text += ` (accuracy asked for: ${percentText(model.asked)})`;
  if (model.consistent === false) text += '; not consistent: more is left than noise and stated uncertainties explain, ± may be too small';
  if (model.objection) text += `; ${model.objection}`;
  const bad = model.verdict === 'not adequate' || model.consistent === false || Boolean(model.objection);
  return { text, tone: bad ? 'care' : 'calm' };
}

// The same as a cell of a table.
export function modelBrief(model) {
  if (!model) return null;
  return model.verdict + (model.consistent === false ? ', not consistent' : '') + (model.objection ? ', objection' : '');
}

export function frequencyText(dwell) {
  const f = dwell.frequency_hz;
  if (!f || !isNumber(f.value)) return null;
  if (dwell.settled_s === null) return `${plainText(f.value, 'Hz', 4)} so far`;
  return joined(numberText(f.value, NORMAL_95 * f.u, 'Hz'));
}

// UTC of an instant on the run's time axis, ms; null: not known.
export function utcMs(dwell, t_s) {
  const start = dwell.start_utc ? Date.parse(dwell.start_utc) : NaN;
  return Number.isFinite(start) && isNumber(t_s) ? start + 1e3 * t_s : null;
}

// When the state that is shown began, ms of UTC; null: not known. events: newest last.
export function sinceMs(dwell, events) {
  if (dwell.state === 'settling') return utcMs(dwell, dwell.start_s);
  if (dwell.state === 'measuring') return utcMs(dwell, dwell.verdict_s);
  if (dwell.state === 'complete') return utcMs(dwell, dwell.end_s);
  const newest = events.findLast((event) => event.state !== null);
  return newest?.state === dwell.state && newest.utc ? Date.parse(newest.utc) : null;
}

// Above the list of events: why it is empty, or what it leaves out; '': it has all. Of `total` events since the service
// began the page knows the newest. Of those known some fit the filter, and of these the newest are shown.
export function eventsText({ shown, fit, known, total }) {
  if (known === 0) return 'No events yet.';
  if (fit === known) return shown < total ? `The newest ${shown} of ${total} events.` : '';
  const left = fit === 0 ? 'No event fits the filter.' : shown < fit ? `The newest ${shown} of ${fit} that fit the filter.` : '';
  const looked = known < total ? `The filter looks at the newest ${known} of ${total} events.` : '';
  return [left, looked].filter(Boolean).join(' ');
}

// What the service says to do next, where the page itself has the button for it.
export const withButton = (text) => text?.replaceAll('"dwellctl start"', 'the button "Start a run" below, "dwellctl start"') ?? text;

// { text, tone } of the run; null: not known. A dwell without a run, where runs are recorded, is lost: why stands below.
export function runFact(health, dwell) {
  if (!health) return null;
  const run = health.recorder?.run;
  if (run) return { text: `${run.run}${run.label ? `, “${run.label}”` : ''}`, tone: 'calm' };
  if (health.recorder && ['settling', 'measuring'].includes(dwell?.state)) return { text: 'not recorded', tone: 'care' };
  return { text: health.run.recorded ? 'none goes on' : 'not recorded', tone: 'calm' };
}

// Whether a channel's status is no trouble. A reading that is overrange now and then is none by itself: health says when
// that is one.
export const isWell = ({ name, status }, health) => ['ok', 'held', 'gated', 'end of data'].includes(status) ||
  (status === 'overrange' && !health?.troubles?.some((trouble) => trouble.kind === 'channel' && trouble.channel === name));

// What is wrong, each { tone, text }: beside the state, so that no trouble hides below. Channels that fail alike are told
// together.
export function troubles({ dwell, health, channels, fresh, now }) {
  const list = [];
  const add = (tone, text) => list.push({ tone, text });
  if (!dwell || fresh.gone(now)) return list;
  if (fresh.dwellOld(now))
    add('alarm', `old numbers, from ${ageText(fresh.dwellAge_s(now))} ago: the service answers, but no new data come`);
  if (channels && fresh.answersOld(now))
    add('alarm', `channels, devices and alarms are ${ageText(fresh.answersAge_s(now))} old: the service does not tell of them`);
  const alike = new Map();
  const fails = (name, why) => alike.set(why, [...(alike.get(why) ?? []), name]);
  const quiet = new Set(); // channels whose own status is no trouble: of these health says why they are one
  for (const channel of channels ?? []) {
    if (isWell(channel)) quiet.add(channel.name);
    else fails(channel.name, channel.text);
  }
  for (const trouble of health?.troubles ?? [])
    if (trouble.kind === 'channel' && quiet.has(trouble.channel)) fails(trouble.channel, trouble.why);
  for (const [why, names] of alike) add('alarm', `${names.length > 1 ? 'channels' : 'channel'} ${names.join(', ')}: ${why}`);
  // Of the service's troubles only those that the page tells nowhere else: of a channel whose own status is fine, and of
  // the dwell while it is measured. Others stand in the state, beside a number, or are added here below.
  for (const trouble of health?.troubles ?? []) {
    if (trouble.kind === 'calibration') add('care', trouble.text);
    if (trouble.kind === 'dwell' && dwell.state === 'measuring') add('alarm', trouble.text);
  }
  for (const [name, line] of Object.entries(health?.gpio ?? {})) {
    if (!line.works) add('alarm', `GPIO ${name}: ${line.reason ?? 'does not work'}`);
    else if (name === 'interlock' && line.level === 0) add('alarm', 'interlock open: the shaker may not run');
  }
  for (const alarm of health?.recorder?.alarms ?? []) add('alarm', `recording: ${alarm}`);
  if (health?.log.failing) add('care', `the log loses lines, ${health.log.dropped} so far`);
  for (const doubt of dwell.doubts) if (isGeneral(doubt)) add('alarm', `do not rely on ${whom([doubt])}: ${doubt.what}`);
  return list;
}
