// The alarms on the page, and their acknowledgement by whoever has the right.
import { alarmRows, howToAcknowledge, waitingText } from './alarms.mjs';
import { h, keyed, readable, setAttributes, setText, show } from './dom.mjs';
import { ageText } from './number.mjs';
import { give, noteText, whileDisabled } from './order.mjs';

const $ = (id) => document.getElementById(id);
const kiosk = new URLSearchParams(location.search).has('kiosk');

const underWay = new Set(); // names of the alarms that are being acknowledged
let note = null; // on the newest acknowledgement, as noteText takes it
let now_s = 0;

function noteOf(name, answer) {
  const text = answer?.done ? `${name} is acknowledged.` : answer === null
    ? `${name}: no answer, so whether it is acknowledged is not known; the list above will tell.` : `${name} was not acknowledged: ${answer.error}`;
  return { text, failed: !answer?.done, at_s: now_s };
}

function makeRow({ name }, changed) {
  const button = h('button', { type: 'button', 'aria-label': `Acknowledge ${name}` }, 'Acknowledge');
  button.addEventListener('click', async () => {
    underWay.add(name);
    const answer = await whileDisabled([button], () => give('/api/v1/alarms/acknowledge', { alarm: name }));
    underWay.delete(name);
    note = noteOf(name, answer);
    changed();
  });
  return h('li', {}, h('div', {}, h('strong', { class: 'word' }), ' ', h('span', { class: 'text' }), ' ', h('code', {}), h('span', { class: 'small when' })), button);
}

// The place in the list that has the focus; −1: none has.
const focusedRow = () => [...$('alarm-rows').children].findIndex((row) => row.contains(document.activeElement));

// To the alarm that waits at this place, or before it; where none waits to the heading.
function focusNear(place) {
  const buttons = [...$('alarm-rows').children].map((row) => row.lastChild);
  const next = [...buttons.slice(place), ...buttons.slice(0, place).reverse()].find((button) => !button.hidden && !button.disabled);
  (next ?? $('alarms')).focus({ preventScroll: true });
}

// changed: called when something was acknowledged: the list has news.
export function showAlarms({ alarms, rights, fresh, now, nowMs }, changed) {
  now_s = now;
  const rows = alarmRows(alarms, nowMs);
  const old = fresh.answersOld(now);
  const waiting = waitingText(alarms);
  show($('alarm-line'), waiting !== null);
  setAttributes($('alarm-line'), { 'data-tone': waiting?.tone ?? 'calm' });
  setText($('alarm-link'), waiting === null ? '' : `${old ? `when last heard, ${ageText(fresh.answersAge_s(now))} ago: ` : ''}${waiting.text}`);
  const how = howToAcknowledge(alarms, rights, location.hostname, kiosk);
  setText($('alarms-how'), how);
  const said = noteText(note, now);
  setText($('alarms-note'), said);
  show($('alarms'), rows.length > 0 || said !== '');
  setAttributes($('alarms'), { class: old ? 'full old' : 'full' });
  setText($('alarms-none'), rows.length > 0 ? '' : 'No alarms.');
  setText($('alarms-more'), alarms?.left_out ? `${alarms.left_out} more found no room in the list.` : '');
  const place = focusedRow();
  keyed($('alarm-rows'), rows, (row) => row.name, (row) => makeRow(row, changed), (node, row) => {
    setAttributes(node, { 'data-tone': row.tone, 'data-name': readable(row.name) });
    const [words, button] = node.children;
    setText(words.children[0], row.word);
    setText(words.children[1], row.text);
    setText(words.children[2], how && row.waits ? row.name : '');
    setText(words.children[3], row.when);
    show(button, row.waits && rights.change && !old);
    button.disabled = underWay.has(row.name);
  });
  // The alarm that had the focus is acknowledged or gone.
  const focused = document.activeElement;
  if (place >= 0 && !underWay.size && (focusedRow() < 0 || focused.hidden)) focusNear(place);
}
