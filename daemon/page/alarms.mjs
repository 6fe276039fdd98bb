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

// For the head, { tone, text }, with the first one that waits; null: nobody has to look at an alarm. One that is over is
// told as such: what it says does not hold any longer. The service lists those that last before them.
export function waitingText(list) {
  const waiting = list?.unacknowledged ?? 0;
  if (waiting === 0) return null;
  const over = list.alarms.filter((a) => a.state === 'returned-unacknowledged').length;
  const active = waiting - over;
  const first = list.alarms.length > 0 ? list.alarms[0].text : null;
  const of = (n, words) => `${n} ${n > 1 ? 'alarms' : 'alarm'} not acknowledged${first === null ? '' : `${words}${first}${n > 1 ? ' …' : ''}`}`;
  if (active === 0) return { tone: 'care', text: of(over, ', over: ') };
  return { tone: 'alarm', text: `${of(active, ': ')}${over > 0 ? `; ${over} more over` : ''}` };
}

// How an alarm is acknowledged where the page has no button for it; '': it has, or nothing waits. rights: as
// /api/v1/rights tells them; host: that the page came from; wall: it is a wall display, on which nobody logs in.
export function howToAcknowledge(list, rights, host, wall) {
  if (!list?.unacknowledged || rights.change) return '';
  const here = /^(localhost|127\..*|\[::1\])$/.test(host) ? 'this computer' : 'the computer of the service';
  const page = wall ? 'log in to this page on another computer, without ?kiosk, or ' : 'log in below, or ';
  return `To acknowledge: ${rights.token ? page : ''}dwellctl acknowledge NAME on ${here}. Each alarm has its NAME beside it.`;
}

// At most these are named; more are counted.
const NAMED = 3;

// "alarms “NAME”, “NAME” and 2 more": those that find no room.
export function unseenText(names) {
  const more = names.length - NAMED;
  return `${names.length > 1 ? 'alarms' : 'alarm'} ${names.slice(0, NAMED).map((name) => `“${name}”`).join(', ')}${more > 0 ? ` and ${more} more` : ''}`;
}
