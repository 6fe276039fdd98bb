// Phasors of all channels in one circle, and how sure each is. Pure: lengths are in units of the picture.
import { ageText, isNumber, joined, NORMAL_95, NO_NUMBER, numberText, percentText, plainText } from './number.mjs';

// Radius that holds 95 % of a normal distribution in the plane, in standard uncertainties: sqrt(-2 ln 0.05).
export const ELLIPSE_K = 2.45;

// Every unit has a scale of its own: its largest amplitude is on the circle. Phases are relative to the first valid
// channel, so that the picture stands still. Phase 0 points right, positive phases turn counter-clockwise.
// settled: before that part of the transient is in the numbers, which their u does not cover: the ellipses are points.
// { scales: [{ unit, full }], arrows: [{ channel, unit, x, y, phase, radial, tangential, degrees }], silent: [...] }
export function polarOf(phasors, radius, settled = true) {
  const valid = phasors.filter((p) => p.valid && isNumber(p.amplitude));
  const full = new Map();
  for (const p of valid) full.set(p.unit, Math.max(full.get(p.unit) ?? 0, p.amplitude));
  const reference = valid[0]?.phase_rad ?? 0;
  const arrows = valid.map((p) => {
    const phase = p.phase_rad - reference;
    const scale = full.get(p.unit) > 0 ? radius / full.get(p.unit) : 0;
    const length = scale * p.amplitude;
    return { channel: p.channel, unit: p.unit, phase, x: length * Math.cos(phase), y: -length * Math.sin(phase),
      radial: settled ? ELLIPSE_K * p.u_amplitude * scale : 0, tangential: settled ? ELLIPSE_K * p.u_relative_phase_rad * length : 0,
      degrees: -phase * 180 / Math.PI };
  });
  return { scales: [...full].map(([unit, value]) => ({ unit, full: value })), arrows,
    silent: phasors.filter((p) => !valid.includes(p)).map((p) => ({ channel: p.channel, reason: p.reason ?? 'no reason stated' })) };
}

const STROKES = ['solid', 'dashed', 'dotted', 'dash-dotted'];
// What the picture's scales are, and what its ellipses mean. Empty: there is no arrow.
export function scalesText({ scales, arrows }, settled) {
  if (arrows.length === 0) return '';
  const circle = scales.map((scale, i) => `${plainText(scale.full, scale.unit, 3)} (${STROKES[i % 4]})`).join(', ');
  const small = arrows.every((a) => a.radial < 2.5 && a.tangential < 2.5);
  const ellipses = settled ? ` Ellipses hold 95 % (k = 2.45)${small ? '; all are smaller than the dots' : ''}.` : '';
  return `Circle: ${circle}; phases to ${arrows[0].channel}.${ellipses}`;
}

// Where the labels stand: in a column left or right of the circle, beside their arrow's end, at least `gap` apart and
// within ±reach, which many of one side make closer. Adds { side: -1 or 1, at, gap: that of its column } to each arrow.
export function placeLabels(arrows, gap, reach) {
  const placed = arrows.map((arrow) => ({ ...arrow, side: arrow.x < 0 ? -1 : 1, at: arrow.y }));
  for (const side of [-1, 1]) {
    const column = placed.filter((arrow) => arrow.side === side).sort((a, b) => a.y - b.y);
    const apart = Math.min(gap, 2 * reach / Math.max(column.length - 1, 1));
    let free = -reach;
    for (const arrow of column) {
      arrow.at = Math.max(arrow.y, free);
      arrow.gap = apart;
      free = arrow.at + apart;
    }
    // What was pushed out below pushes the others up again.
    let limit = reach;
    for (const arrow of column.reverse()) {
      arrow.at = Math.min(arrow.at, limit);
      limit = arrow.at - apart;
    }
  }
  return placed;
}

// The text with "…" in its middle, as long as fits; beginning and end are what tells names apart.
export function shortened(text, fits) {
  if (fits(text)) return text;
  const letters = [...text];
  for (let kept = letters.length - 1; kept > 0; --kept) {
    const head = Math.ceil(kept / 2);
    const short = `${letters.slice(0, head).join('')}…${letters.slice(letters.length - kept + head).join('')}`;
    if (fits(short)) return short;
  }
  return '…';
}

// From the first letter in which it differs from the others: their beginnings are the same.
function fromDifference(name, others, fits) {
  const [letters, all] = [[...name], others.map((other) => [...other])];
  const at = letters.findIndex((letter, i) => all.some((other) => other[i] !== letter));
  const rest = letters.slice(Math.max(at, 0));
  for (let kept = rest.length; kept > 0; --kept) {
    const short = `…${rest.slice(0, kept).join('')}${kept < rest.length ? '…' : ''}`;
    if (fits(short)) return short;
  }
  return '…';
}

// A text for each of these different names, each another one. fits(text): it has room. What is left out is marked by "…".
// Names that are alike beyond all this have their place in the list before the "…".
export function shortNames(names, fits) {
  const short = names.map((name) => shortened(name, fits));
  const others = (list, i) => names.filter((_, j) => j !== i && list[j] === list[i]);
  const told = short.map((text, i) => (others(short, i).length > 0 ? fromDifference(names[i], others(short, i), fits) : text));
  return told.map((text, i) => (others(told, i).length > 0 ? `${i + 1}${text.startsWith('…') ? '' : '…'}${text}` : text));
}

const degrees = (rad) => {
  const turn = rad / (2 * Math.PI);
  return 360 * (turn - Math.round(turn));
};

// [amplitude, phase to the first valid channel, mean, largest harmonic] of a valid phasor of a dwell, as text. While the
// transient lasts they have no ±.
export function phasorCells(dwell, p) {
  const provisional = dwell.settled_s === null;
  const reference = dwell.phasors.find((other) => other.valid);
  const phase = degrees(p.phase_rad - reference.phase_rad);
  const largest = p.harmonics.reduce((best, value, i) => (isNumber(value) && value > (best?.value ?? 0) ? { value, i } : best), null);
  return [provisional ? plainText(p.amplitude, p.unit, 3) : joined(numberText(p.amplitude, NORMAL_95 * p.u_amplitude, p.unit)),
    p === reference ? '0°' : provisional ? plainText(phase, '°', 3).replace(' °', '°')
      : joined(numberText(phase, NORMAL_95 * 180 / Math.PI * p.u_relative_phase_rad, '°')).replace(' °', '°'),
    plainText(p.mean, p.unit, 3), largest ? `${percentText(largest.value)} (${largest.i + 2}f)` : NO_NUMBER];
}

export const whyNoPhasor = (p) => p.reason ?? 'no reason stated';

// Rows of the table: { key, struck: null, or its age as text, cells }, or in place of the cells the reason why there are
// none.
export function phasorRows(view) {
  const { dwell, fresh, now } = view;
  const old = fresh.dwellOld(now) ? ageText(fresh.dwellAge_s(now)) : null;
  return dwell.phasors.map((p) => {
    const channel = view.channels?.find((c) => c.name === p.channel);
    // Once the dwell has ended, the age of the channel's newest reading is not that of its phasor.
    const gone = dwell.state !== 'complete' && view.health?.stale.includes(p.channel) ? ageText(channel?.age_s) : null;
    const row = { key: p.channel, struck: old ?? gone };
    return p.valid ? { ...row, cells: phasorCells(dwell, p) } : { ...row, reason: whyNoPhasor(p) };
  });
}
