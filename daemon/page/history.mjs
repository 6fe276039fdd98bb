// How each coefficient has moved over the last hour, and against the dwell before. Pure.
import { keyOf } from './coefficients.mjs';
import { utcMs } from './wording.mjs';
import { isNumber, numberText } from './number.mjs';

export const HOUR_MS = 3600_000;
const MINUTE_MS = 60_000;
// Of the current dwell a point is kept so often: 360 in an hour.
const LIVE_MS = 10_000;

const pointOf = (coefficient) => ({ value: coefficient.value, U95: coefficient.U95 });

function valuesOf(dwell) {
  const values = new Map();
  for (const element of dwell.elements) {
    if (!element.identifiable) continue;
    for (const key of ['stiffness', 'damping'])
      if (isNumber(element[key]?.value) && isNumber(element[key].U95)) values.set(`${key} ${element.k}`, pointOf(element[key]));
  }
  return values;
}

export class History {
  #points = []; // { ms, from: since when its data count, key of the dwell, index, ended, values }, oldest first
  #live = null; // the newest state of the current dwell

  #keep(point) {
    this.#points.push(point);
    this.#points.sort((a, b) => a.ms - b.ms);
    this.#points = this.#points.filter((p) => p.ms > this.#points.at(-1).ms - HOUR_MS);
  }

  take(dwell, ms) {
    if (dwell.settled_s === null || dwell.elements.length === 0) return;
    const point = { ms, from: utcMs(dwell, dwell.settled_s) ?? ms, key: keyOf(dwell), index: dwell.index, ended: false,
      values: valuesOf(dwell) };
    this.#live = point;
    const before = this.#points.findLast((p) => p.key === point.key);
    if (!before || ms - before.ms >= LIVE_MS) this.#keep(point);
  }

  // A dwell of the service's list, with UTC of its end.
  takeEnded(dwell, ms) {
    const key = keyOf(dwell);
    if (this.#points.some((p) => p.key === key && p.ended)) return;
    if (dwell.settled_s !== null)
      this.#keep({ ms, from: utcMs(dwell, dwell.settled_s) ?? ms, key, index: dwell.index, ended: true, values: valuesOf(dwell) });
  }

  // Points { ms, from, value, U95, key } of a coefficient, oldest first, the newest of now.
  of(coefficient, k, nowMs) {
    const name = `${coefficient} ${k}`;
    const points = this.#live && this.#points.at(-1) !== this.#live && !this.#points.some((p) => p.key === this.#live.key && p.ended)
      ? [...this.#points, this.#live] : this.#points;
    return points.filter((p) => p.ms > nowMs - HOUR_MS && p.values.has(name))
      .map((p) => ({ ms: p.ms, from: p.from, key: p.key, ...p.values.get(name) }));
  }

  // Against the dwell that ended before: { text, beyond }, beyond: by more than both U95 together; null: there is none.
  deviation(coefficient, k, dwell) {
    const element = dwell.elements.find((e) => e.k === k);
    const now = element?.identifiable ? element[coefficient] : null;
    const key = keyOf(dwell);
    const before = this.#points.findLast((p) => p.ended && p.key !== key && p.values.has(`${coefficient} ${k}`));
    if (!before || !now || !isNumber(now.value)) return null;
    const was = before.values.get(`${coefficient} ${k}`);
    if (was.value === 0) return null;
    const change = (now.value - was.value) / Math.abs(was.value);
    const U = Math.hypot(now.U95, was.U95) / Math.abs(was.value);
    const beyond = Math.abs(change) > U;
    const sign = change < 0 ? '\u2212' : '+';
    const { value, u } = numberText(100 * Math.abs(change), 100 * U, '%');
    return { beyond, text: `${beyond ? 'moved by ' : ''}${Number(value) === 0 ? '' : sign}${value} ± ${u} % since dwell ${before.index}` };
  }
}

// Where a trend is drawn, in a box of this size: the band value ± U95 and the line in its middle, as paths; dwells are
// not joined. What is known fills the width: a minute at least, an hour at most. null: nothing to draw.
export function trendPaths(points, nowMs, width, height) {
  if (points.length === 0) return null;
  const low = Math.min(...points.map((p) => p.value - p.U95));
  const high = Math.max(...points.map((p) => p.value + p.U95));
  const span = high - low || Math.abs(high) || 1;
  const reach = Math.min(HOUR_MS, Math.max(MINUTE_MS, nowMs - points[0].from));
  const x = (p) => Math.max(0, width * (1 - (nowMs - p.ms) / reach)).toFixed(1);
  const y = (value) => (height - 1 - (height - 2) * (value - low) / span).toFixed(1);
  let line = '';
  let band = '';
  const pieces = [];
  for (const point of points) {
    if (pieces.at(-1)?.at(-1).key === point.key) pieces.at(-1).push(point);
    else pieces.push([point]);
  }
  for (const piece of pieces) {
    // Before its first point is known, that holds from the beginning of its data; each is at least as wide as a stroke.
    const [first] = piece;
    const ends = [{ ...first, ms: Math.min(first.from, first.ms - 3 * reach / width) }, ...piece];
    line += `M${ends.map((p) => `${x(p)} ${y(p.value)}`).join('L')}`;
    band += `M${ends.map((p) => `${x(p)} ${y(p.value + p.U95)}`).join('L')}L${[...ends].reverse().map((p) => `${x(p)} ${y(p.value - p.U95)}`).join('L')}Z`;
  }
  return { line, band };
}
