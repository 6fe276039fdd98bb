// How each coefficient has moved over the last hour, and, as the service tells it, since the dwell before. Pure.
import { about, keyOf } from './coefficients.mjs';
import { utcMs } from './wording.mjs';
import { ageText, instantText, isNumber, numberText, percentText } from './number.mjs';

export const HOUR_MS = 3600_000;
const MINUTE_MS = 60_000;
// Of the current dwell a point is kept so often: 360 in an hour.
const LIVE_MS = 10_000;
// Between two of them more than one is missing.
const JOINED_MS = 2.5 * LIVE_MS;
// Points that are kept, in memory of fixed size: a page on a wall is open for months. A dwell measured for t adds
// 1 + floor(t / LIVE_MS) points, one if t is below 10 s. So there is room for an hour of dwells of 5 s. Of shorter ones the
// trend reaches less far back.
export const ROOM = 720;
// Between two strokes of the hatching, in the width of a trend.
const HATCH = 6;

// Numbers of an element in a point: value and U95 of each coefficient, NaN where there is none; and 1 where the service
// doubts the element.
const COLUMNS = { stiffness: 0, damping: 2 };
const DOUBTED = 4;
const WIDTH = 5;

// A state of a dwell. row: where its numbers stand; ms: when it was so, UTC; from: since when its data count, UTC in ms;
// dwell: { key, ended: the service's list has told the end }.
const makePoint = (row) => ({ row, ms: NaN, from: NaN, dwell: null });

export class History {
  #spare = Array.from({ length: ROOM }, (_, row) => makePoint(row)).reverse();
  #points = []; // oldest first
  #live = makePoint(ROOM); // the newest state of the current dwell
  #end_s = null; // of its data
  #elements = 0; // that there is room for
  #numbers = new Float64Array(0); // by row, element, coefficient

  // A dwell of the stream. An estimation that hangs is told again and again: the trend must not go on over the outage.
  take(dwell, nowMs) {
    if (dwell.settled_s === null || dwell.elements.length === 0) return;
    // The last dwell of a run that was stopped stays in view.
    if (dwell.state === 'complete') return this.takeEnded(dwell, utcMs(dwell, dwell.end_s) ?? nowMs);
    const same = this.#live.dwell?.key === keyOf(dwell);
    if (dwell.stale || (same && dwell.end_s === this.#end_s)) return;
    if (this.#live.dwell && !same) this.#keepLive();
    this.#end_s = dwell.end_s;
    const ms = nowMs - 1e3 * (dwell.estimate_age_s ?? 0);
    this.#write(this.#live, dwell, ms);
    const before = this.#points.findLast((p) => p.dwell === this.#live.dwell);
    if (before && ms - before.ms < LIVE_MS) return;
    this.#keep(dwell, ms, false);
  }

  // A dwell of the service's list, with UTC of its end.
  takeEnded(dwell, ms) {
    if (dwell.settled_s === null) return;
    if (this.#dwellOf(dwell)?.ended) return this.#doubt(this.#points.findLast((p) => p.dwell.key === keyOf(dwell)), dwell);
    const newestPoint = () => this.#points.findLastIndex((p) => p.dwell.key === keyOf(dwell));
    // Its data were cut back to before the drive changed: what was told live beyond them counts no longer.
    while (this.#points[newestPoint()]?.ms > ms) this.#forget(newestPoint());
    const before = newestPoint();
    if (before >= 0 && ms - this.#points[before].ms < LIVE_MS) this.#forget(before);
    this.#keep(dwell, ms, true);
  }

  // Keeps the newest state of a dwell when the service tells of another one. A new run empties the service's list, which
  // then never tells how the dwell before ended.
  #keepLive() {
    const { dwell, ms } = this.#live;
    const before = this.#points.findLast((p) => p.dwell === dwell);
    if (dwell.ended || (before && before.ms >= ms)) return;
    const point = this.#roomFor(ms);
    if (!point) return;
    Object.assign(point, this.#live, { row: point.row });
    this.#numbers.copyWithin(this.#at(point, 1), this.#at(this.#live, 1), this.#at(this.#live, this.#elements + 1));
    this.#insert(point);
  }

  #dwellOf(dwell) {
    const key = keyOf(dwell);
    return this.#live.dwell?.key === key ? this.#live.dwell : this.#points.findLast((p) => p.dwell.key === key)?.dwell;
  }

  #forget(i) {
    const [point] = this.#points.splice(i, 1);
    point.dwell = null;
    this.#spare.push(point);
  }

  #keep(dwell, ms, end) {
    const point = this.#roomFor(ms);
    if (!point) return;
    this.#write(point, dwell, ms);
    point.dwell.ended ||= end;
    this.#insert(point);
  }

  // A point that the caller writes and inserts. null: it is older than an hour, or than all points of a full list.
  #roomFor(ms) {
    const newest = Math.max(ms, this.#points.at(-1)?.ms ?? ms);
    while (this.#points[0]?.ms <= newest - HOUR_MS) this.#forget(0);
    if (ms <= newest - HOUR_MS || (this.#spare.length === 0 && ms < this.#points[0].ms)) return null;
    if (this.#spare.length === 0) this.#forget(0);
    return this.#spare.pop();
  }

  #insert(point) {
    this.#points.splice(this.#points.findLastIndex((p) => p.ms <= point.ms) + 1, 0, point);
  }

  #write(point, dwell, ms) {
    point.dwell = this.#dwellOf(dwell) ?? { key: keyOf(dwell), ended: false };
    point.ms = ms;
    point.from = utcMs(dwell, dwell.settled_s) ?? ms;
    this.#widen(Math.max(...dwell.elements.map((e) => e.k)));
    this.#numbers.fill(NaN, this.#at(point, 1), this.#at(point, this.#elements + 1));
    for (const element of dwell.elements) {
      if (!element.identifiable) continue;
      for (const [key, column] of Object.entries(COLUMNS)) {
        const { value, U95 } = element[key] ?? {};
        if (isNumber(value) && isNumber(U95)) this.#numbers.set([value, U95], this.#at(point, element.k) + column);
      }
    }
    this.#doubt(point, dwell);
  }

  // A doubt may come after the end of a dwell. Its elements have their room already.
  #doubt(point, dwell) {
    for (const { k } of dwell.elements)
      if (point && k <= this.#elements) this.#numbers[this.#at(point, k) + DOUBTED] = about(dwell.doubts, k).length > 0 ? 1 : 0;
  }

  #at(point, k) {
    return WIDTH * (point.row * this.#elements + k - 1);
  }

  // Room for so many elements: once, unless the service begins anew with another rig.
  #widen(elements) {
    if (elements <= this.#elements) return;
    const [had, numbers] = [WIDTH * this.#elements, this.#numbers];
    this.#elements = elements;
    this.#numbers = new Float64Array(WIDTH * elements * (ROOM + 1)).fill(NaN);
    for (let row = 0; row <= ROOM; ++row) this.#numbers.set(numbers.subarray(row * had, (row + 1) * had), WIDTH * elements * row);
  }

  // { value, U95, doubted } of a coefficient in a point; null: it has none.
  #numberOf(point, coefficient, k) {
    if (k > this.#elements) return null;
    const at = this.#at(point, k) + COLUMNS[coefficient];
    const value = this.#numbers[at];
    return Number.isNaN(value) ? null : { value, U95: this.#numbers[at + 1], doubted: this.#numbers[this.#at(point, k) + DOUBTED] === 1 };
  }

  // Points { ms, from, value, U95, doubted, key } of a coefficient, oldest first, the newest of now. A doubt that came
  // while the dwell went on concerns its earlier points as well: they are of the same motion.
  of(coefficient, k, nowMs) {
    const list = [];
    const add = (point) => {
      const number = point.ms > nowMs - HOUR_MS ? this.#numberOf(point, coefficient, k) : null;
      if (number) list.push({ ms: point.ms, from: point.from, key: point.dwell.key, ...number });
    };
    this.#points.forEach(add);
    const { dwell, ms } = this.#live;
    if (dwell && !dwell.ended && this.#points.at(-1)?.ms !== ms) add(this.#live);
    const newest = new Map(list.map((point) => [point.key, point.doubted]));
    return list.map((point) => ({ ...point, doubted: point.doubted || newest.get(point.key) }));
  }

  // Whether a trend leaves out numbers that are doubted.
  someDoubted(nowMs) {
    const isDoubted = (point) => {
      for (let k = 1; k <= this.#elements; ++k) if (this.#numbers[this.#at(point, k) + DOUBTED] === 1) return true;
      return false;
    };
    return [...this.#points, this.#live].some((point) => point.dwell && point.ms > nowMs - HOUR_MS && isDoubted(point));
  }

  // What all trends show, ms before now: since the first dwell that is known, a minute at least, an hour at most. null:
  // none is known.
  reachMs(nowMs) {
    const first = this.#points.find((point) => point.ms > nowMs - HOUR_MS);
    return first ? Math.min(HOUR_MS, Math.max(MINUTE_MS, nowMs - first.from)) : null;
  }
}

// How the coefficient of a live dwell differs from that of the settled dwell before: { text, moved }. null: there is
// nothing to say.
export function deviationOf(dwell, coefficient, k, nowMs) {
  const { since } = dwell;
  const element = since?.elements.find((e) => e.k === k);
  if (!element) return null;
  const earlier = since.start_utc === dwell.start_utc ? '' : ` of an earlier run (${instantText(utcMs(since, since.end_s), nowMs)})`;
  const which = `dwell ${since.index}${earlier}`;
  const move = element[coefficient];
  if (!move) return { moved: false, text: `nothing to compare with: ${which} has no number` };
  const { value, u } = numberText(100 * Math.abs(move.change), 100 * move.U95, '%');
  const sign = Number(value) === 0 ? '' : move.change < 0 ? '\u2212' : '+';
  return { moved: move.moved, text: `${move.moved ? 'moved by ' : ''}${sign}${value} ± ${u} % since ${which}` };
}

// Where a trend is drawn, in a box of this size: the band value ± U95 and the line in its middle, as paths. Dwells are not
// joined, nor the points around an outage of one: nobody knows what was in between. The width is the time reach_ms before
// now. Numbers that are doubted are left out: they set no scale, and hatching stands over the time that they are of. The
// newest value that remains is the middle; it ± its U95 takes half the height, or less where an older value was further
// away. Wider bands, as at a dwell's beginning, are cut off at the edge. half: from the middle to an edge, in the unit of
// the values; null: all are doubted. Instead of an object null: nothing to draw.
export function trendPaths(points, nowMs, reach, width, height) {
  if (points.length === 0) return null;
  const sound = points.filter((p) => !p.doubted);
  const newest = sound.at(-1);
  const most = newest ? Math.max(2 * newest.U95, ...sound.map((p) => Math.abs(p.value - newest.value))) || Math.abs(newest.value) || 1 : null;
  const at = (ms) => Math.max(0, width * (1 - (nowMs - ms) / reach));
  const x = (p) => at(p.ms).toFixed(1);
  const part = (value) => Math.min(1, Math.max(-1, (value - newest.value) / most));
  const y = (value) => (height / 2 - (height / 2 - 1) * part(value)).toFixed(1);
  let line = '';
  let band = '';
  let hatch = '';
  const pieces = [];
  for (const point of points) {
    const before = pieces.at(-1)?.at(-1);
    if (before?.key === point.key && before.doubted === point.doubted && point.ms - before.ms <= JOINED_MS) pieces.at(-1).push(point);
    else pieces.push([point]);
  }
  for (const piece of pieces) {
    // What the first point of a dwell tells holds from the beginning of its data. Each piece is at least as wide as a
    // stroke.
    const [first] = piece;
    const begins = points.find((p) => p.key === first.key) === first;
    const ends = [{ ...first, ms: Math.min(begins ? first.from : first.ms, first.ms - 3 * reach / width) }, ...piece];
    if (first.doubted) {
      for (let to = at(ends[0].ms); to < at(ends.at(-1).ms); to += HATCH) hatch += `M${to.toFixed(1)} ${height - 1}L${(to + HATCH).toFixed(1)} 1`;
      continue;
    }
    line += `M${ends.map((p) => `${x(p)} ${y(p.value)}`).join('L')}`;
    band += `M${ends.map((p) => `${x(p)} ${y(p.value + p.U95)}`).join('L')}L${[...ends].reverse().map((p) => `${x(p)} ${y(p.value - p.U95)}`).join('L')}Z`;
  }
  return { line, band, hatch, half: most };
}

// What a trend shows, { height: "± 0.28 %" of the newest value, spoken: for those who do not see it }. half: as above.
export function trendTexts(points, reach_ms, half) {
  const over = `Trend of the last ${ageText(reach_ms / 1e3)}`;
  const sound = points.filter((p) => !p.doubted);
  if (sound.length === 0) return { height: '', spoken: `${over}: none of its values can be relied on` };
  const newest = sound.at(-1).value;
  const values = sound.map((p) => p.value);
  const away = (value) => `${value < newest ? '\u2212' : '+'}${percentText(Math.abs((value - newest) / newest))}`;
  const height = newest === 0 ? '' : `± ${percentText(half / Math.abs(newest))}`;
  const range = newest === 0 ? '' : `: from the newest value ${away(Math.min(...values))} to ${away(Math.max(...values))}, height ${height}`;
  const without = sound.length < points.length ? '; without values that must not be relied on' : '';
  return { height, spoken: `${over}${range}${without}` };
}
