// The alarms on the page, and their acknowledgement by whoever has the right.
import { alarmRows, waitingText } from './alarms.mjs';
import { h, keyed, setAttributes, setText, show } from './dom.mjs';

const $ = (id) => document.getElementById(id);

const ANSWER_MS = 5000;

// Answers why it was not done; empty: it was.
async function acknowledge(name) {
  try {
    const answer = await fetch('/api/v1/alarms/acknowledge', { method: 'POST', headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ alarm: name }), signal: AbortSignal.timeout(ANSWER_MS) });
    if (answer.ok) return '';
    return (await answer.json()).error;
  } catch {
    return 'no answer of the service';
  }
}

function makeRow({ name }, changed) {
  const button = h('button', { type: 'button', 'aria-label': `Acknowledge ${name}` }, 'Acknowledge');
  button.addEventListener('click', async () => {
    button.disabled = true;
    const why = await acknowledge(name);
    button.disabled = false;
    setText($('alarms-note'), why ? `${name} was not acknowledged: ${why}` : `${name} is acknowledged.`);
    changed();
  });
  return h('li', {}, h('div', {}, h('strong', { class: 'word' }), ' ', h('span', { class: 'text' }), h('span', { class: 'small when' })), button);
}

// changed: called when something was acknowledged: the list has news.
export function showAlarms({ alarms, mayChange, fresh, now, nowMs }, changed) {
  const rows = alarmRows(alarms, nowMs);
  const old = fresh.gone(now);
  const waiting = waitingText(alarms);
  show($('alarm-line'), waiting !== null);
  setText($('alarm-link'), waiting === null ? '' : `${old ? 'when last heard: ' : ''}${waiting}`);
  show($('alarms'), rows.length > 0 || $('alarms-note').textContent !== '');
  setAttributes($('alarms'), { class: old ? 'full old' : 'full' });
  setText($('alarms-none'), rows.length > 0 ? '' : 'No alarms.');
  setText($('alarms-more'), alarms?.left_out ? `${alarms.left_out} more found no room in the list.` : '');
  keyed($('alarm-rows'), rows, (row) => row.name, (row) => makeRow(row, changed), (node, row) => {
    setAttributes(node, { 'data-tone': row.tone });
    const [words, button] = node.children;
    setText(words.children[0], row.word);
    setText(words.children[1], row.text);
    setText(words.children[2], row.when);
    show(button, row.waits && mayChange && !old);
  });
}
