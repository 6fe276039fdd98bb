// The coefficients on the page: coefficients.js decides what stands there, this puts it there.
import { coefficientsOf, generalWarnings } from './coefficients.mjs';
import { h, keyed, setAttributes, setText, show } from './dom.mjs';

const $ = (id) => document.getElementById(id);

const MARKS = { 'n.s.': 'not significant: smaller than its standard uncertainty', '?': 'do not rely on it' };

// Parts of a number apart, so that they can be aligned and the unit stand smaller.
export function makeNumber() {
  return h('span', { class: 'number' }, h('span', { class: 'value' }), h('span', { class: 'pm' }), h('span', { class: 'unit' }),
    h('span', { class: 'marks' }), h('span', { class: 'age' }));
}

export function renewNumber(node, { number, struck, marks = [] }) {
  const [value, pm, unit, mark, age] = node.children;
  setAttributes(node, { class: struck ? 'number struck' : 'number' });
  setText(value, number.value);
  setText(pm, number.u ? ` ± ${number.u}` : '');
  setText(unit, number.unit ? ` ${number.unit}` : '');
  setText(mark, marks.map((m) => ` ${m}`).join(''));
  setText(age, struck ? ` ${struck} old` : '');
}

function makeCell(cell) {
  return h('div', { class: 'coefficient' },
    h('dt', {}, h('span', { class: 'symbol' }, cell.symbol), h('span', { class: 'name' }, ` ${cell.name}`)),
    h('dd', {}, makeNumber()));
}

function makeElement(element) {
  return h('li', { class: 'element' }, h('h3', {}, `Element ${element.k}`), h('p', { class: 'reason' }), h('dl', {}),
    h('ul', { class: 'notes' }));
}

const EMPTY = { value: '—', u: '', unit: '' };

function renewElement(node, element) {
  const [, reason, list, notes] = node.children;
  show(reason, element.reason !== null);
  setText(reason, element.reason === null ? '' : `no coefficients: ${element.reason}`);
  const cells = element.last ?? (element.reason === null ? element.cells : []);
  keyed(list, cells, (cell) => cell.symbol, makeCell,
    (made, cell) => renewNumber(made.lastChild.firstChild, { ...cell, number: cell.number ?? EMPTY }));
  show(notes, element.notes.length > 0);
  keyed(notes, element.notes, (note) => note.text, (note) => h('li', { 'data-tone': note.tone }, note.text));
}

const FROM = {
  measured: '', none: '',
  transient: 'provisional',
  last: 'not of now',
};

function legendOf(shown, dwell) {
  if (shown.elements.length === 0) return '';
  const parts = ['± is the half width of the 95 % interval'];
  const marks = new Set(shown.elements.flatMap((e) => e.cells.flatMap((cell) => cell.marks)));
  for (const mark of marks) parts.push(`${mark}: ${MARKS[mark]}`);
  if (shown.elements.some((e) => e.last || e.cells.some((cell) => cell.struck)))
    parts.push('struck through: no longer renewed, and from so long ago');
  if (shown.source !== 'last' && dwell.unstated.length > 0)
    parts.push(`± covers noise, clock and what the rig file states; not stated: ${dwell.unstated.join(', ')}`);
  return `${parts.join('. ')}.`;
}

export function showCoefficients(view) {
  const shown = coefficientsOf(view);
  setAttributes($('coefficients'), { 'data-source': shown.source });
  setText($('coefficients-from'), FROM[shown.source] ? `${FROM[shown.source]} · ${shown.title}` : shown.title);
  show($('coefficients-from'), shown.title !== '');
  setText($('coefficients-none'), shown.reason ? `No coefficients: ${shown.reason}` : '');
  show($('coefficients-none'), shown.reason !== null);
  keyed($('elements'), shown.elements, (element) => element.k, makeElement, renewElement);
  const warnings = view.dwell ? generalWarnings(view.dwell) : [];
  show($('warnings'), warnings.length > 0);
  keyed($('warnings'), warnings, (text) => text, (text) => h('li', { 'data-tone': 'care' }, text));
  setText($('legend'), legendOf(shown, view.dwell));
}
