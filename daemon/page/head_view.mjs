// The first line: state in word, shape and colour, and what an operator asks next.
import { h, keyed, s, setAttributes, setText, show } from './dom.mjs';
import { ageText, instantText } from './number.mjs';
import { frequencyText, limitsText, modelOf, playsRecording, runFact, sinceMs, stateOf, troubles, warningsText } from './wording.mjs';

const $ = (id) => document.getElementById(id);

// By their names, 24 × 24: told apart without any colour.
const SHAPES = {
  connecting: [['circle', { cx: 12, cy: 12, r: 9, class: 'line dashed' }]],
  idle: [['circle', { cx: 12, cy: 12, r: 9, class: 'line' }]],
  settling: [['path', { d: 'M5 3h14M5 21h14M7 3c0 6 10 12 10 18M17 3c0 6 -10 12 -10 18', class: 'line' }]],
  measuring: [['circle', { cx: 12, cy: 12, r: 9, class: 'line' }], ['circle', { cx: 12, cy: 12, r: 5, class: 'area' }]],
  part: [['circle', { cx: 12, cy: 12, r: 9, class: 'line' }], ['path', { d: 'M12 7a5 5 0 0 0 0 10Z', class: 'area' }]],
  none: [['path', { d: 'M12 1L23 12L12 23L1 12Z', class: 'area' }], ['path', { d: 'M7 12h10', class: 'cut' }]],
  complete: [['rect', { x: 4, y: 4, width: 16, height: 16, class: 'area' }]],
  fault: [['path', { d: 'M12 2L23 21H1Z', class: 'area' }], ['path', { d: 'M12 9v6M12 17v2', class: 'cut' }]],
  locked: [['rect', { x: 4, y: 10, width: 16, height: 11, class: 'area' }], ['path', { d: 'M7.5 10V7a4.5 4.5 0 0 1 9 0v3', class: 'line' }]],
  gone: [['path', { d: 'M8 2h8l6 6v8l-6 6h-8l-6 -6v-8z', class: 'area' }], ['path', { d: 'M8 8l8 8M16 8l-8 8', class: 'cut' }]],
};

let drawn = null;
function showShape(shape) {
  if (drawn === shape) return;
  drawn = shape;
  $('shape').replaceChildren(s('svg', { viewBox: '0 0 24 24' }, ...SHAPES[shape].map(([tag, attributes]) => s(tag, attributes))));
}

function sinceText(view) {
  const ms = view.dwell ? sinceMs(view.dwell, view.events) : null;
  return ms === null ? null : `${instantText(ms, view.nowMs)} (${ageText((view.nowMs - ms) / 1e3)})`;
}

// What stands behind the state, in this order; what is not known is left out. struck: it is not of now. The stream tells
// of the dwell, the answers that are asked for tell of the rest: each may stop alone.
function factsOf(view) {
  const { dwell, health } = view;
  const model = modelOf(dwell, view.verification);
  const limits = limitsText(dwell);
  const run = runFact(health, dwell);
  const [streamOld, answersOld] = [view.fresh.dwellOld(view.now), view.fresh.answersOld(view.now)];
  const facts = [
    ['source', playsRecording(health) ? 'recording, not live' : null, answersOld, 'care'],
    ['limits', limits?.text, streamOld, limits?.tone],
    ['warnings', warningsText(dwell), streamOld, 'care'],
    ['model', model?.text, streamOld, model?.tone],
    ['run', run?.text, answersOld, run?.tone],
    ['dwell', dwell?.index ? `${dwell.index}${dwell.state === 'complete' ? ', ended' : ''}` : null, streamOld],
    ['frequency', dwell && frequencyText(dwell), streamOld],
    ['since', sinceText(view), streamOld],
  ];
  return facts.filter(([, text]) => text).map(([name, text, struck, tone]) => ({ name, text, struck, tone: tone ?? 'calm' }));
}

// A head that stays on the screen must not hide what the focus or a link goes to (WCAG 2.2, 2.4.11): the page keeps its
// height free. Where it would take more than this part of the window it scrolls away with the rest.
const MOST_OF_WINDOW = 1 / 3;
function layOut() {
  const height = $('head').getBoundingClientRect().height;
  document.documentElement.classList.toggle('tall-head', height > MOST_OF_WINDOW * window.innerHeight);
  const stays = getComputedStyle($('head')).position === 'sticky';
  document.documentElement.style.setProperty('--head', `${stays ? Math.ceil(height) : 0}px`);
}
new ResizeObserver(layOut).observe($('head'));
window.addEventListener('resize', layOut);

let spoken = '';
// Said aloud when the kind of state changes or a trouble comes or goes, not with each second that passes.
function speak(state, list) {
  const gist = `${state.word}${list.length ? `; ${list.length} ${list.length > 1 ? 'troubles' : 'trouble'}` : ''}`;
  if (gist === spoken) return;
  spoken = gist;
  setText($('spoken'), gist);
}

export function showHead(view) {
  const state = stateOf(view);
  const list = troubles(view);
  const rig = view.health?.rig ?? 'Dwell';
  setText($('rig'), rig);
  setText(document.querySelector('title'), `${state.age ? 'last seen: ' : ''}${state.word} · ${rig}`);
  setAttributes($('state'), { 'data-tone': state.tone, 'data-kind': state.kind });
  showShape(state.shape);
  setText($('word'), state.word);
  setText($('detail'), state.detail);
  setAttributes($('detail'), { class: state.age ? 'old' : '' });
  setText($('detail-age'), state.age ? `last seen ${state.age} ago` : '');
  keyed($('facts'), factsOf(view), (fact) => fact.name,
    (fact) => h('div', { 'data-fact': fact.name }, h('dt', {}, fact.name), h('dd', {})),
    (node, fact) => {
      setText(node.lastChild, fact.text);
      setAttributes(node, { 'data-tone': fact.tone, class: fact.struck ? 'struck' : '' });
    });
  keyed($('troubles'), list, (trouble) => trouble.text.replace(/[\d.]+ (s|min|h|d) ago/, ''),
    (trouble) => h('li', { 'data-tone': trouble.tone }, ''), (node, trouble) => setText(node, trouble.text));
  show($('troubles'), list.length > 0);
  speak(state, list);
}
