// What the page says of alarms: in which order the service tells them is the order here. Pure.
import { ageText, instantText } from './number.mjs';

// Grey once somebody knows of it. Each state has a shape of its own before the word.
const STATES = {
  unacknowledged: { tone: 'alarm', word: 'unacknowledged' },
  'returned-unacknowledged': { tone: 'care', word: 'returned, unacknowledged' },
  acknowledged: { tone: 'calm', word: 'acknowledged' },
};

const times = (n) => (n > 1 ? `, raised ${n} times` : '');

// [{ name, tone, word, text, when, waits }], those that wait for somebody first. list: the service's; null: not known.
export function alarmRows(list, nowMs) {
  return (list?.alarms ?? []).map((a) => {
    const { tone, word } = STATES[a.state] ?? { tone: 'alarm', word: a.state };
    const [since, changed] = [Date.parse(a.since), Date.parse(a.changed)];
    const ago = (ms) => ageText((nowMs - ms) / 1e3);
    const began = `since ${instantText(since, nowMs)}`;
    const lasted = a.state === 'returned-unacknowledged'
      ? `${began}, over at ${instantText(changed, nowMs)} (${ago(changed)} ago)` : `${began} (${ago(since)})`;
    const by = a.acknowledged_by && a.state === 'acknowledged'
      ? `; acknowledged by ${a.acknowledged_by}${a.comment ? `: ${a.comment}` : ''}` : '';
    return { name: a.name, tone, word, text: a.text, waits: a.state !== 'acknowledged',
      when: `${lasted}${times(a.count)}${by}` };
  });
}

// For the head, with the first one that waits; null: nobody has to look at an alarm.
export function waitingText(list) {
  const n = list?.unacknowledged ?? 0;
  if (n === 0) return null;
  return `${n} ${n > 1 ? 'alarms' : 'alarm'} not acknowledged${list.alarms.length > 0 ? `: ${list.alarms[0].text}${n > 1 ? ' …' : ''}` : ''}`;
}

// That something was done is said for so long: what is in the list says it from then on. Why it was not stays until the
// next attempt.
const NOTE_S = 10;
export const noteText = (note, now) => (note && (note.failed || now - note.at_s < NOTE_S) ? note.text : '');
