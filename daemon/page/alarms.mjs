// What the page says of alarms, in the order in which the service lists them. Pure.
import { ageText, instantText } from './number.mjs';

// Grey once somebody has acknowledged it. The style sheet puts a shape of its own before the word of each tone.
const STATES = {
  unacknowledged: { tone: 'alarm', word: 'unacknowledged' },
  'returned-unacknowledged': { tone: 'care', word: 'returned, unacknowledged' },
  acknowledged: { tone: 'calm', word: 'acknowledged' },
};

const times = (n) => (n > 1 ? `, raised ${n} times` : '');

// [{ name, tone, word, text, when, waits: nobody has acknowledged it }]. list: the service's; null: not known.
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
