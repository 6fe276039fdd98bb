// A wall display has no hands to scroll. Where the elements find no room they are set closer; what finds none then is
// named at the foot.
import { unseenText } from './alarms.mjs';
import { setText, show } from './dom.mjs';

const $ = (id) => document.getElementById(id);
const kiosk = new URLSearchParams(location.search).has('kiosk');

// Of the traces the strip itself counts, not what is free below it.
const PARTS = [['warnings', 'warnings of the dwell'], ['now-warnings', 'warnings of now'], ['legend', 'notes on the coefficients'], ['trace-plot', 'traces'],
  ['phasor-notes', 'warnings of channels'], ['chain', 'the shape of the motion']];

const bottomOf = (node) => node.getBoundingClientRect().bottom; // 0 where it is hidden

// The first alarm that waits stands in the head, whole unless that is cut.
function headTells() {
  const line = $('alarm-line');
  return !line.hidden && line.scrollHeight <= line.clientHeight + 1;
}

// Names of the alarms that nobody reads there.
function unseenAlarms(foot_px) {
  const whole = headTells();
  return [...$('alarm-rows').children].filter((row, i) => bottomOf(row) > foot_px && !(whole && i === 0)).map((row) => row.dataset.name);
}

function beyond(foot_px) {
  const elements = [...$('elements').children];
  const first = elements.findIndex((item) => bottomOf(item) > foot_px);
  const parts = PARTS.filter(([id]) => bottomOf($(id)) > foot_px).map(([, name]) => name);
  const alarms = unseenAlarms(foot_px);
  if (alarms.length > 0) parts.push(unseenText(alarms));
  if (first < 0) return parts;
  const [from, to] = [first + 1, elements.length];
  return [from === to ? `element ${to}` : `elements ${from} … ${to}`, ...parts];
}

// So many elements are always set closer.
const MANY = 6;

// Shows the note at the foot if something finds no room; where the room ends [px from the top].
function footOf() {
  show($('beyond'), beyond(window.innerHeight).length > 0);
  return window.innerHeight - $('beyond').offsetHeight; // 0 high where it is hidden
}

// As wide as they can be: looked at anew each time, for what needed the room may be gone. What lies under the note at the
// foot has no room either.
function layOut() {
  const root = document.documentElement.classList;
  root.toggle('compact', $('elements').children.length >= MANY);
  root.toggle('told', headTells() && $('alarm-rows').children.length === 1);
  const foot_px = footOf();
  if (root.contains('compact') || ['elements', 'warnings', 'now-warnings'].every((id) => bottomOf($(id)) <= foot_px)) return foot_px;
  root.add('compact');
  return footOf();
}

export function showBeyond() {
  if (!kiosk) return;
  const foot_px = layOut();
  // A strip or a picture that is cut off would look whole: what is named as without room is not seen.
  $('traces').classList.toggle('beyond', bottomOf($('trace-plot')) > foot_px);
  $('chain').classList.toggle('beyond', bottomOf($('chain')) > foot_px);
  setText($('beyond'), `▼ no room here for: ${beyond(foot_px).join(', ')}`);
}
