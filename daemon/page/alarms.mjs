// What the page says of alarms: in which order the service tells them is the order here. Pure.
import { ageText } from './number.mjs';

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
    const since = Date.parse(a.since);
    const by = a.acknowledged_by && a.state === 'acknowledged'
      ? `; acknowledged by ${a.acknowledged_by}${a.comment ? `: ${a.comment}` : ''}` : '';
    return { name: a.name, tone, word, text: a.text, waits: a.state !== 'acknowledged',
      when: `since ${new Date(since).toLocaleTimeString('en-GB')} (${ageText((nowMs - since) / 1e3)})${times(a.count)}${by}` };
  });
}

// For the head; null: nobody has to look at an alarm.
export function waitingText(list) {
  const n = list?.unacknowledged ?? 0;
  return n > 0 ? `${n} ${n > 1 ? 'alarms' : 'alarm'} not acknowledged` : null;
}
