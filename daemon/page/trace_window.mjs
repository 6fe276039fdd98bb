// A stretch of the traces as the page keeps it: the least and the greatest reading of each bin, by channel, in arrays of
// fixed length. Pure.
import { isNumber, joined, NO_NUMBER, numberText, plainText } from './number.mjs';

// The width of the bins that the stream tells of; every other width is this times or divided by a power of 4.
const LIVE_STEP_S = 0.02;
// The narrowest ones: so near to each other two readings of a channel seldom come.
const FINEST_S = LIVE_STEP_S / 64;
// Bins of an answer at most: of one channel, and of all together.
export const MOST_BINS = 4000;
const MOST_IN_ALL = 64_000;
// Answers that a file of single readings is made of, at most: 20 s of up to 16 channels, 5 s of 64. The service computes
// each within 10 ms.
const MOST_ANSWERS = 16;
// A cursor reads what is no farther away: a reading of a channel at 10 Hz.
const NEAR_S = 0.05;

export class TraceWindow {
  names = [];
  units = [];
  step_s = LIVE_STEP_S;
  first = 0; // number of the first bin: it begins first · step_s after the origin
  bins = 0; // how many are filled
  #lows = [];
  #highs = [];
  #breaks = [];

  // answer: of GET /api/v1/traces. keep: bins to have room for, as new ones come.
  constructor(answer, keep = answer.bins) {
    this.step_s = answer.step_s;
    this.first = Math.round(answer.from_s / answer.step_s);
    this.bins = answer.bins;
    this.less_dwell = answer.less_dwell;
    const room = 2 * Math.max(keep, answer.bins, 1); // the older half is given up at once, not bin by bin
    for (const channel of answer.channels) {
      this.names.push(channel.name);
      this.units.push(channel.unit);
      const [lows, highs] = [new Float32Array(room).fill(NaN), new Float32Array(room).fill(NaN)];
      const breaks = new Uint8Array(room);
      lows.set(channel.min.map((v) => v ?? NaN));
      highs.set(channel.max.map((v) => v ?? NaN));
      for (const i of channel.breaks) breaks[i] = 1;
      this.#lows.push(lows);
      this.#highs.push(highs);
      this.#breaks.push(breaks);
    }
  }

  get from_s() {
    return this.first * this.step_s;
  }
  get to_s() {
    return (this.first + this.bins) * this.step_s;
  }
  low(channel, i) {
    return this.#lows[channel][i];
  }
  high(channel, i) {
    return this.#highs[channel][i];
  }
  broken(channel, i) {
    return this.#breaks[channel][i] === 1;
  }

  // The end of the newest bin with a reading of the channel; null: the window has none.
  last_s(channel) {
    for (let i = this.bins - 1; i >= 0; --i)
      if (!Number.isNaN(this.low(channel, i))) return (this.first + i + 1) * this.step_s;
    return null;
  }

  // Takes the event `traces` of the stream. false: something is missing between it and this window, or its bins are too
  // wide for it, or they are of another kind: this window's are less the steady part; then it is to be asked for anew.
  take(event) {
    if (this.less_dwell !== null) return false;
    const ratio = Math.round(this.step_s / LIVE_STEP_S);
    const next = Math.floor(event.first / Math.max(ratio, 1));
    if (ratio < 1 || event.channels.length !== this.names.length || next > this.first + this.bins || next < this.first) return false;
    for (let k = 0; k < event.bins; ++k) {
      const number = Math.floor((event.first + k) / ratio);
      while (this.first + this.bins <= number) this.#append();
      const i = number - this.first;
      event.channels.forEach((channel, c) => {
        const [low, high] = [channel.min[k], channel.max[k]];
        if (low !== null && !(this.#lows[c][i] <= low)) this.#lows[c][i] = low;
        if (high !== null && !(this.#highs[c][i] >= high)) this.#highs[c][i] = high;
        if (channel.breaks.includes(k)) this.#breaks[c][i] = 1;
      });
    }
    return true;
  }

  #append() {
    const room = this.#lows[0]?.length ?? 0;
    if (this.bins === room) {
      const kept = room >> 1;
      for (const values of [...this.#lows, ...this.#highs, ...this.#breaks]) values.copyWithin(0, room - kept);
      this.first += room - kept;
      this.bins = kept;
    }
    for (const values of [...this.#lows, ...this.#highs]) values[this.bins] = NaN;
    for (const values of this.#breaks) values[this.bins] = 0;
    this.bins += 1;
  }

  // { low, high } of the bin at an instant, or of the nearest one with a reading within two bins or NEAR_S; null: none.
  at(channel, t_s) {
    const reach = Math.max(2, Math.ceil(NEAR_S / this.step_s));
    const here = Math.floor(t_s / this.step_s + 1e-9) - this.first;
    for (let d = 0; d <= reach; ++d)
      for (const i of [here - d, here + d])
        if (i >= 0 && i < this.bins && !Number.isNaN(this.low(channel, i)))
          return { low: this.low(channel, i), high: this.high(channel, i) };
    return null;
  }
}

export const durationText = (s, digits = 3) => (s < 1 ? `${Number((1e3 * s).toPrecision(digits))} ms` : `${Number(s.toPrecision(digits))} s`);
const widthText = ({ step_s }) => durationText(step_s, 6);

// A number in the unit of its channel, without a prefix that would differ from cursor to cursor.
function inUnit(value, half, unit) {
  if (!isNumber(value)) return NO_NUMBER;
  return `${half > 0 ? joined(numberText(value, half, '')) : plainText(value, '', 5)} ${unit}`;
}

// What two cursors read, { A, B, difference } as text. ± is half the distance between the least and the greatest reading of
// the bin: a bound, in which every reading lies, and no standard uncertainty. So the two are added for the difference. The
// root of the sum of squares would hold for independent errors; of the readings of one motion nothing says that they are
// independent. A bin with one reading has no ±. a, b: as TraceWindow.at() gives them.
export function cursorTexts(a, b, unit) {
  const middle = (bin) => (bin ? (bin.low + bin.high) / 2 : null);
  const half = (bin) => (bin ? (bin.high - bin.low) / 2 : 0);
  return { A: inUnit(middle(a), half(a), unit), B: inUnit(middle(b), half(b), unit),
    difference: inUnit(a && b ? middle(b) - middle(a) : null, half(a) + half(b), unit) };
}

const cell = (value) => (value === null ? '' : String(value));
// "y0" in quotes where CSV needs them; the rig file allows neither quotes nor commas.
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

// The age of each channel's trace, s, where its newest reading is old; else null. Infinity: no reading was ever seen.
// newest_s: the newest instant of the stream, which came quiet_s ago. last: of each channel the newest reading seen, s.
// old_s: from when on it is old.
export function agesOf(last, newest_s, quiet_s, old_s) {
  return last.map((t_s) => {
    const age = t_s === null ? Infinity : quiet_s + Math.max(0, newest_s - t_s);
    return age > old_s ? age : null;
  });
}

// What was taken out of the readings, as the file says it; empty: nothing was.
const lessText = (answer) => (answer.less_dwell === null ? ''
  : ` less steady part of dwell ${answer.less_dwell} fitted from ${Number(answer.less_from_s.toFixed(3))} s`);

// What an answer holds, in the narrowest bins. null: they are too many, or the service no longer keeps them. ask(from_s,
// to_s): an answer of as many bins as one may have.
export async function finestOf(answer, ask) {
  const each = Math.min(MOST_BINS, Math.floor(MOST_IN_ALL / Math.max(answer.channels.length, 1)));
  const first = Math.round(answer.from_s / FINEST_S);
  const last = Math.floor(Math.min(answer.from_s + answer.bins * answer.step_s, answer.newest_s) / FINEST_S);
  const answers = answer.less_dwell === null ? MOST_ANSWERS : 1; // the steady part is fitted anew from answer to answer
  if (last - first >= answers * each) return null;
  const parts = [];
  for (let at = first; at <= last; at += each) {
    const part = await ask(at * FINEST_S, Math.min(at + each - 1, last) * FINEST_S);
    if (part?.step_s !== FINEST_S || part.less_dwell !== answer.less_dwell) return null;
    parts.push(part);
  }
  const all = (c, which) => parts.flatMap((part) => part.channels[c][which]);
  return { ...parts[0], bins: parts.reduce((sum, { bins }) => sum + bins, 0),
    channels: answer.channels.map(({ name, unit }, c) => ({ name, unit, min: all(c, 'min'), max: all(c, 'max') })) };
}

// In each bin there is one reading of the channel at most.
const single = ({ step_s }, { min, max }) => step_s === FINEST_S && min.every((low, i) => low === max[i]);

// What the rows of a file hold, in words.
export function savedText(answer) {
  const width = widthText(answer);
  const pairs = answer.channels.filter((channel) => !single(answer, channel)).map(({ name }) => name);
  if (pairs.length === answer.channels.length) return `the smallest and the largest reading of each ${width}`;
  const readings = `single readings, each within ${width} after its t`;
  return pairs.length === 0 ? readings : `${readings}; of ${pairs.join(', ')} the smallest and the largest reading of each ${width}, for two came within one`;
}

// An answer of GET /api/v1/traces as CSV, its numbers as they came: t in seconds since `origin_utc`, where each bin begins,
// then the smallest and the largest reading of each channel, or its reading where none of its bins has two. An empty cell:
// no reading. All that is to be known stands in the heads: many readers of CSV know no comments.
export function csvOf(answer) {
  const ones = answer.channels.map((channel) => single(answer, channel));
  const one = ones.includes(true);
  const [less, width] = [lessText(answer), widthText(answer)];
  const heads = answer.channels.flatMap(({ name, unit }, c) => (ones[c] ? [`${name}${less} [${unit}]`]
    : ['min', 'max'].map((which) => `${name} ${which} in ${width}${less} [${unit}]`)));
  const lines = [[`t [s since ${answer.origin_utc}${one ? `; readings are up to ${width} later` : ''}]`, ...heads].map(quoted).join(',')];
  for (let i = 0; i < answer.bins; ++i) {
    const values = answer.channels.flatMap(({ min, max }, c) => (ones[c] ? [min[i]] : [min[i], max[i]]));
    if (answer.step_s === FINEST_S && values.every((value) => value === null)) continue; // most of them
    lines.push([String(Number((answer.from_s + i * answer.step_s).toFixed(9))), ...values.map(cell)].join(','));
  }
  return `${lines.join('\n')}\n`;
}

// Of that file: UTC of its first bin, and what was taken out.
export function csvName(answer) {
  const begins = new Date(Date.parse(answer.origin_utc) + 1e3 * answer.from_s).toISOString().replace(/[-:]|\.\d+/g, '');
  return `traces-${answer.less_dwell === null ? '' : `less-steady-part-of-dwell-${answer.less_dwell}-`}${begins}.csv`;
}
