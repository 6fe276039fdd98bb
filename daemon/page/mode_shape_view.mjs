// Draws the chain as it moves at the drive frequency, slowed down. It can be halted. It stands from the beginning where the
// browser asks for less motion (WCAG 2.2.2), and on a wall, where nobody could halt it: at its greatest deflection, which
// shows the shape.
import { h, keyed, rowHead, s, setAttributes, setText, show } from './dom.mjs';
import { barOf, displacedAt, fullestPart, modeShapeOf, reachOf } from './mode_shape.mjs';
import { isNumber, NO_NUMBER, percentText, plainText } from './number.mjs';
import { inNextPicture } from './pictures.mjs';

const $ = (id) => document.getElementById(id);
const PERIOD_S = 4; // one period of the drive as it is shown
const STEP_MS = 80; // between two places of the masses: smooth enough at this pace
const PITCH = 70; // between two masses at rest; all lengths in units of the picture
const REACH = 20; // of the largest displacement
const HALF = 13; // half a mass' width
const MIDDLE = 46; // height of the chain in the picture

let shape = null;
let moves = !matchMedia('(prefers-reduced-motion: reduce)').matches && !new URLSearchParams(location.search).has('kiosk');
let part = null; // of the period; null: it has not moved yet, and stands at the greatest deflection

const x = (at) => 34 + PITCH * at;

// A spring from one place to another.
function springPath(from, to) {
  const step = (to - from) / 8;
  const zigzag = Array.from({ length: 7 }, (_, i) => `L${(from + (i + 1) * step).toFixed(1)} ${i % 2 ? MIDDLE + 7 : MIDDLE - 7}`);
  return `M${from.toFixed(1)} ${MIDDLE}${zigzag.join('')}L${to.toFixed(1)} ${MIDDLE}`;
}

function place() {
  if (!shape) return;
  const reach = reachOf(shape);
  const moved = displacedAt(shape, part ?? fullestPart(shape)).map((d, at) => x(at) + (reach > 0 ? REACH * d / reach : 0));
  [...$('shape-masses').children].forEach((node, at) => setAttributes(node, { transform: `translate(${moved[at].toFixed(1)} ${MIDDLE})` }));
  const ends = shape.clamped ? [...moved, x(shape.nodes.length)] : moved;
  [...$('shape-springs').children].forEach((node, k) => setAttributes(node, { d: springPath(ends[k] + HALF, ends[k + 1] - HALF) }));
}

function makeMass(node) {
  const name = node.at === 0 ? 'table' : `m${node.at}`;
  return s('g', { class: node.known ? '' : 'unknown' }, s('rect', { x: -HALF, y: -16, width: 2 * HALF, height: 32, class: node.at === 0 ? 'table' : 'mass' }),
    s('text', { y: 32, 'text-anchor': 'middle' }, name));
}

function showHarmonics(dwell) {
  const count = Math.max(0, ...dwell.phasors.map((p) => p.harmonics?.length ?? 0));
  show($('harmonics'), count > 0);
  keyed($('harmonic-heads'), ['channel', ...Array.from({ length: count }, (_, i) => `${i + 2} f`)], (t) => t, (t) => h('th', { scope: 'col' }, t));
  keyed($('harmonic-rows'), dwell.phasors.filter((p) => p.valid), (p) => `${p.channel} ${count}`,
    (p) => h('tr', {}, rowHead(p.channel), ...Array.from({ length: count }, () => h('td'))),
    (row, p) => Array.from({ length: count }, (_, i) => setText(row.children[i + 1], isNumber(p.harmonics[i]) ? percentText(p.harmonics[i]) : NO_NUMBER)));
}

export function showModeShape(view) {
  const dwell = view.dwell;
  const on = dwell !== null && dwell.state === 'measuring' && view.channels !== null && !view.fresh.dwellOld(view.now);
  shape = on ? modeShapeOf(dwell, view.channels) : null;
  show($('chain'), shape !== null);
  if (!shape) return;
  const count = shape.nodes.length;
  const width = x(count - (shape.clamped ? 0 : 1)) + 40;
  setAttributes($('shape-picture'), { viewBox: `0 0 ${width} 96` });
  keyed($('shape-masses'), shape.nodes, (n) => `${n.at} ${n.known}`, makeMass);
  keyed($('shape-springs'), Array.from({ length: count - (shape.clamped ? 0 : 1) }, (_, k) => k), String, () => s('path', { class: 'spring' }));
  show($('shape-ground'), shape.clamped);
  setAttributes($('shape-ground'), { transform: `translate(${x(count)} ${MIDDLE})` });
  const reach = reachOf(shape);
  const bar = reach > 0 ? barOf(reach) : 0;
  setAttributes($('shape-bar'), { d: `M8 88v4h${(REACH * bar / (reach || 1)).toFixed(1)}v-4` });
  setText($('shape-bar-text'), plainText(bar, shape.unit, 1));
  setAttributes($('shape-bar-text'), { x: 14 + REACH * bar / (reach || 1) });
  const hidden = shape.nodes.filter((n) => !n.known).map((n) => (n.at === 0 ? 'table' : `m${n.at}`));
  setText($('shape-note'), `At ${plainText(shape.frequency_hz, 'Hz', 4)}, slowed ${plainText(PERIOD_S * shape.frequency_hz, '', 2)} times. The bar is the scale of displacements; ${
    shape.unit === 'm' ? 'distances between masses are not to scale' : 'angles are drawn as if they were lengths'}.${hidden.length ? ` Dashed: no channel tells of ${hidden.join(', ')}.` : ''}`);
  showHarmonics(dwell);
  place();
}

function turn() {
  setText($('shape-pause'), moves ? 'Halt' : 'Move');
}
$('shape-pause').addEventListener('click', () => {
  moves = !moves;
  turn();
  place(); // now: a picture that is planned already would move it after the halt
});
turn();
setInterval(() => {
  if (!moves || !shape || document.hidden) return;
  part = ((part ?? fullestPart(shape)) + STEP_MS / 1e3 / PERIOD_S) % 1;
  inNextPicture(place);
}, STEP_MS);
