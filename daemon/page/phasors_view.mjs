// The polar picture and the table beside it.
import { channelWarnings } from './coefficients.mjs';
import { h, keyed, rowHead, s, setAttributes, setText, show } from './dom.mjs';
import { phasorRows, placeLabels, polarOf, scalesText, shortNames } from './polar.mjs';

const $ = (id) => document.getElementById(id);
const RADIUS = 100;
// Of the names: their letters, the distance between two lines, where they begin, and their room beside the circle
// (index.html: the picture reaches to 172).
const LABEL = { size: 12, gap: 15, at: RADIUS + 15, room: 172 - RADIUS - 16 };

// The names as they have room in the picture. Its letters are measured once for each set of names.
const measure = document.createElement('canvas').getContext('2d');
let labels = { of: null, names: [] };
function labelsOf(channels) {
  const of = channels.join('\n');
  if (labels.of !== of) {
    measure.font = `${LABEL.size}px ${getComputedStyle($('polar')).fontFamily}`;
    labels = { of, names: shortNames(channels, (text) => measure.measureText(text).width <= LABEL.room) };
  }
  return labels.names;
}

function makeArrow(arrow) {
  return s('g', { class: 'arrow' }, s('line', { class: 'shaft' }), s('ellipse', { class: 'ellipse' }), s('circle', { r: 2.5, class: 'tip' }),
    s('line', { class: 'leader' }), s('text', {}), s('title', {}, arrow.channel));
}

function renewArrow(node, arrow, units) {
  const [shaft, ellipse, tip, leader, text] = node.children;
  // Quantities differ by their stroke, not by colour.
  setAttributes(shaft, { x1: 0, y1: 0, x2: arrow.x.toFixed(1), y2: arrow.y.toFixed(1), class: `shaft dash${units.indexOf(arrow.unit) % 4}` });
  setAttributes(ellipse, { rx: arrow.radial.toFixed(2), ry: arrow.tangential.toFixed(2),
    transform: `translate(${arrow.x.toFixed(1)} ${arrow.y.toFixed(1)}) rotate(${arrow.degrees.toFixed(1)})` });
  setAttributes(tip, { cx: arrow.x.toFixed(1), cy: arrow.y.toFixed(1) });
  const end = arrow.side * (LABEL.at - 3);
  setAttributes(leader, { x1: arrow.x.toFixed(1), y1: arrow.y.toFixed(1), x2: end, y2: arrow.at.toFixed(1) });
  const size = LABEL.size * arrow.gap / LABEL.gap;
  setAttributes(text, { x: arrow.side * LABEL.at, y: (arrow.at + size / 3).toFixed(1), 'font-size': size.toFixed(1), 'text-anchor': arrow.side < 0 ? 'end' : 'start' });
  setText(text, arrow.label);
}

// What is to be known of all these numbers.
function noteOf(dwell) {
  if (dwell.state === 'complete') return `Of dwell ${dwell.index}, which has ended: not of now.`;
  return dwell.settled_s === null ? 'Not settled: part of the transient is in these numbers, so they have no ±.' : '';
}

function showNotes(dwell) {
  const texts = channelWarnings(dwell);
  show($('phasor-notes'), texts.length > 0);
  keyed($('phasor-notes'), texts, (text) => text.replace(/\b\d+/g, ''), () => h('li', { 'data-tone': 'care' }), setText);
}

export function showPhasors(view) {
  // While the table rests, what is left is noise.
  // A wall display has no table: without arrows nothing would be left there.
  const wall = document.documentElement.classList.contains('kiosk');
  const some = view.dwell !== null && view.dwell.state !== 'idle' && (!wall || view.dwell.phasors.some((p) => p.valid));
  show($('phasors'), some);
  if (!some) return;
  const settled = view.dwell.settled_s !== null;
  const polar = polarOf(view.dwell.phasors, RADIUS, settled);
  const units = polar.scales.map((scale) => scale.unit);
  const names = labelsOf(polar.arrows.map((arrow) => arrow.channel));
  const arrows = placeLabels(polar.arrows.map((arrow, i) => ({ ...arrow, label: names[i] })), LABEL.gap, RADIUS);
  show($('polar'), arrows.length > 0);
  const ended = view.dwell.state === 'complete';
  setAttributes($('polar'), { class: ended || view.fresh.dwellOld(view.now) ? 'old' : '' });
  setAttributes($('phasors'), { 'data-ended': ended });
  keyed($('arrows'), arrows, (arrow) => arrow.channel, makeArrow, (node, arrow) => renewArrow(node, arrow, units));
  setText($('scales'), scalesText(polar, settled));
  showNotes(view.dwell);
  const rows = phasorRows(view);
  setText($('phasors-note'), arrows.length > 0 ? noteOf(view.dwell) : '');
  keyed($('phasor-rows'), rows, (row) => `${row.key} ${row.reason !== undefined}`,
    (row) => (row.reason !== undefined ? h('tr', {}, rowHead(), h('td', { colspan: 4, class: 'words' }))
      : h('tr', {}, rowHead(), ...Array.from({ length: 4 }, () => h('td', {}, h('span', {}))))),
    (node, row) => {
      setAttributes(node, { class: row.struck ? 'struck' : '' });
      setText(node.firstChild.firstChild, row.struck && row.reason === undefined ? `${row.key}, ${row.struck} old` : row.key);
      if (row.reason !== undefined) setText(node.lastChild, row.reason);
      else row.cells.forEach((text, i) => setText(node.children[i + 1].firstChild, text));
    });
}
