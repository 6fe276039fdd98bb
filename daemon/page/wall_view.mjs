// A wall display has no hands to scroll: what finds no room on it is named at its foot.
import { setText, show } from './dom.mjs';

const $ = (id) => document.getElementById(id);
const kiosk = new URLSearchParams(location.search).has('kiosk');

// Alarms are counted in the head.
const PARTS = [['warnings', 'warnings of the dwell'], ['legend', 'notes on the coefficients'], ['traces', 'traces'],
  ['phasor-notes', 'warnings of channels']];

const bottomOf = (node) => node.getBoundingClientRect().bottom; // 0 where it is hidden

function beyond(foot_px) {
  const elements = [...$('elements').children];
  const first = elements.findIndex((item) => bottomOf(item) > foot_px);
  const parts = PARTS.filter(([id]) => bottomOf($(id)) > foot_px).map(([, name]) => name);
  if (first < 0) return parts;
  const [from, to] = [first + 1, elements.length];
  return [from === to ? `element ${to}` : `elements ${from} … ${to}`, ...parts];
}

export function showBeyond() {
  if (!kiosk) return;
  const on = beyond(window.innerHeight).length > 0;
  show($('beyond'), on);
  if (on) setText($('beyond'), `▼ no room here for: ${beyond(window.innerHeight - $('beyond').offsetHeight).join(', ')}`);
}
