// The coefficients on the page: coefficients.mjs decides what stands there, this puts it there.
import { budgetOf } from './budget.mjs';
import { COEFFICIENTS, coefficientsOf, legendOf, subscript, trendLegendOf } from './coefficients.mjs';
import { h, keyed, s, setAttributes, setText, show } from './dom.mjs';
import { deviationOf, trendPaths, trendTexts } from './history.mjs';
import { percentText } from './number.mjs';

const $ = (id) => document.getElementById(id);

const TREND = { width: 160, height: 32 };
const SHORT = 36; // letters: a longer text of a deviation takes several lines

// Parts of a number apart, so that they can be aligned and the unit stand smaller.
export function makeNumber() {
  return h('span', { class: 'number' }, h('span', { class: 'value' }), h('span', { class: 'pm' }), h('span', { class: 'unit' }),
    h('span', { class: 'marks' }), ' ', h('span', { class: 'age' }));
}

export function renewNumber(node, { number, struck, marks = [] }) {
  const [value, pm, unit, mark, age] = node.children;
  setAttributes(node, { class: `number${struck ? ' struck' : ''}${marks.includes('?') ? ' doubted' : ''}` });
  setText(value, number.value);
  setText(pm, number.u ? ` ± ${number.u}` : '');
  setText(unit, number.unit ? ` ${number.unit}` : '');
  setText(mark, marks.map((m) => ` ${m}`).join(''));
  setText(age, struck ? `${struck} old` : '');
}

function makeCell(cell) {
  return h('div', { class: 'coefficient' },
    h('dt', {}, h('span', { class: 'symbol' }, cell.symbol), h('span', { class: 'name' }, ` ${cell.name}`)),
    h('dd', {}, makeNumber(), s('svg', { class: 'trend', viewBox: `0 0 ${TREND.width} ${TREND.height}`, preserveAspectRatio: 'none',
      role: 'img' }, s('path', { class: 'band' }), s('path', { class: 'middle' }), s('path', { class: 'hatch' })), h('span', { class: 'deviation' }), h('span', { class: 'height', 'aria-hidden': 'true' }),
    h('span', { class: 'limit' })));
}

// The trend changes little: it is drawn anew once a second at most.
const drawn = new WeakMap();
function renewTrend(node, cell, view, source) {
  const [, trend, deviation, height] = node.lastChild.children;
  const second = Math.floor(view.now);
  if (drawn.get(node) === second) return;
  drawn.set(node, second);
  const [, k] = cell.of;
  const points = view.history.of(cell.of[0], k, view.nowMs);
  const reach_ms = view.history.reachMs(view.nowMs);
  const paths = trendPaths(points, view.nowMs, reach_ms, TREND.width, TREND.height);
  const texts = paths && trendTexts(points, reach_ms, paths.half);
  trend.classList.toggle('none', !paths);
  setAttributes(trend, { 'aria-label': texts?.spoken ?? '' });
  setText(height, texts?.height ?? '');
  setAttributes(trend.children[0], { d: paths?.band ?? '' });
  setAttributes(trend.children[1], { d: paths?.line ?? '' });
  setAttributes(trend.children[2], { d: paths?.hatch ?? '' });
  const moved = source === 'measured' ? deviationOf(view.dwell, cell.of[0], k, view.nowMs) : null;
  setText(deviation, moved?.text ?? '');
  const long = (moved?.text.length ?? 0) > SHORT;
  setAttributes(deviation, { class: `deviation${moved?.moved ? ' beyond' : ''}${long ? ' long' : ''}` });
}

function renewLimit(node, { limit, struck }) {
  show(node, Boolean(limit));
  setText(node, limit?.text ?? '');
  setAttributes(node, { 'data-verdict': limit && !struck ? limit.verdict : '', class: struck ? 'limit old' : 'limit' });
}

function makeElement(element) {
  return h('li', { class: 'element' }, h('h3', {}, `Element ${element.k}`), h('p', { class: 'reason' }), h('dl', {}),
    h('ul', { class: 'notes' }), makeBudget(element));
}

// What makes up the ± of an element's coefficients: a list that is opened.
export const makeBudget = ({ k }) => h('details', { class: 'budget' }, h('summary', {}, `What makes up ± of element ${k}`),
  ...COEFFICIENTS.map(({ letter }) => h('div', {}, h('p', {}, letter + subscript(k)), h('ul', { class: 'bars' }))));

const EMPTY = { value: '—', u: '', unit: '' };

export function renewBudget(details, element) {
  COEFFICIENTS.forEach(({ key, letter }, i) => {
    const { bars, advice } = budgetOf(element, key);
    const [head, list] = details.children[i + 1].children;
    setText(head, `± of ${letter}${subscript(element.k)}: ${advice ? `first ${advice}` : 'not known'}`);
    keyed(list, bars, (bar) => bar.source, (bar) => h('li', {}, h('span', { class: 'bar' }), h('span', {})), (item, bar) => {
      item.firstChild.style.width = `${(100 * bar.share).toFixed(0)}%`;
      setText(item.lastChild, `${bar.source} ${percentText(bar.share)}`);
    });
  });
}

function renewElement(node, element, view, source) {
  const [, reason, list, notes, budget] = node.children;
  show(budget, element.budget.length > 0);
  if (budget.open) renewBudget(budget, element);
  node.classList.toggle('withheld', element.reason !== null);
  show(reason, element.reason !== null);
  setText(reason, element.reason === null ? '' : `no coefficients: ${element.reason}`);
  const cells = element.last ?? (element.reason === null ? element.cells : []);
  keyed(list, cells, (cell) => cell.symbol, makeCell,
    (made, cell) => {
      renewNumber(made.lastChild.firstChild, { ...cell, number: cell.number ?? EMPTY });
      renewTrend(made, cell, view, source);
      renewLimit(made.lastChild.lastChild, cell);
    });
  show(notes, element.notes.length > 0);
  keyed(notes, element.notes, (note) => note.text, (note) => h('li', { 'data-tone': note.tone }, note.text));
}

// Said above numbers that are not simply those of now.
const FROM = { transient: 'provisional', last: 'not of now' };

function showWarnings(list, warnings) {
  show(list, warnings.length > 0);
  keyed(list, warnings, (text) => text, (text) => h('li', { 'data-tone': 'care' }, text));
}

export function showCoefficients(view) {
  const shown = coefficientsOf(view);
  setAttributes($('coefficients'), { 'data-source': shown.source });
  show($('coefficients-from'), Boolean(FROM[shown.source]));
  setText($('coefficients-from'), `${FROM[shown.source]} · ${shown.title}`);
  show($('last-notes'), shown.notes.length > 0);
  keyed($('last-notes'), shown.notes, (note) => note.tone + note.text, (note) => h('li', { 'data-tone': note.tone }, note.text));
  setText($('coefficients-none'), shown.reason ? `No coefficients: ${shown.reason}` : '');
  show($('coefficients-none'), shown.reason !== null);
  keyed($('elements'), shown.elements, (element) => element.k, makeElement,
    (node, element) => renewElement(node, element, view, shown.source));
  showWarnings($('warnings'), shown.warnings);
  showWarnings($('now-warnings'), shown.nowWarnings);
  show($('now-warnings-title'), shown.nowWarnings.length > 0);
  setText($('legend'), legendOf(shown, view.trendLacks));
  setText($('trend-legend'), trendLegendOf(shown, view.history.reachMs(view.nowMs), view.history.someDoubted(view.nowMs)));
}
