// Draws traces on a canvas: one lane a channel, each with a scale of its own; time and cursors below.
import { readable } from './dom.mjs';
import { ageText, plainText } from './number.mjs';
import { shortened, shortNames } from './polar.mjs';

const LEFT = 8; // px, room before the first bin
const SHARPEST = 2; // device pixels for one of the page's at most: more costs time and shows nothing
// Size of the letters: 0.75 rem (a wall display has large ones), less where a lane has no room for that, 12 px at least.
const LETTERS = { least: 12, rem: 0.75, around: 4 };
const BELOW = 10; // px, around the times
const MARK = 9.2; // letters, from one time to the next at least
// Room for a channel's name: part of the width, and px at least.
const NAME = { part: 0.2, least: 130 };

// Where a scale ends: the next of 1, 2, 5 · 10^n, so that it does not follow every reading.
function rounded(extent) {
  if (!(extent > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(extent));
  return power * ([1, 2, 5].find((step) => step * power >= extent) ?? 10);
}

// Since when nothing of a channel is shown, s; Infinity: ever since the page was opened. Less the steady part that may be
// the end of the dwell.
export function lastText(age_s, window) {
  if (age_s === Infinity) return 'no reading';
  return `last ${window.less_dwell === null ? 'reading' : 'shown'} ${ageText(age_s)} ago`;
}

// The distance between two marks of time: at most `count` in the range.
const markStep = (range, count) => rounded(range / count);
// So many steps of that distance, with the digits that tell the mark from its neighbours.
function markText(steps, step) {
  const decade = (value) => Math.floor(Math.log10(value * (1 + 1e-9)));
  return `\u2212${plainText(steps * step, 's', decade(steps * step) - decade(step) + 1)}`;
}

export class TracePlot {
  #canvas;
  #context;
  #style;
  #wide = 0; // px, of the picture that is being drawn: each question for clientWidth may cost a layout
  #rem = 16; // px, measured where the canvas has another size
  #size = LETTERS.least; // px, of the letters of the picture that is being drawn
  #short = { of: null, width: 0, size: 0, names: [] }; // measured once for each set of names, width and size

  constructor(canvas) {
    this.#canvas = canvas;
    // desynchronized: the canvas skips the page's own layers. That saves a seventh of the page's time (two pages side by
    // side, one with it and one without, on the scene of tests/page/load.test.js).
    this.#context = canvas.getContext('2d', { alpha: false, desynchronized: true });
    const style = getComputedStyle(document.documentElement);
    this.#style = Object.fromEntries(['sheet', 'line', 'ink', 'faint', 'old'].map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }

  // Pixels of the page.
  get width() {
    return this.#canvas.clientWidth - 2 * LEFT;
  }
  // The instant at a distance from the canvas' left side, and back.
  timeAt(x, view) {
    return view.from_s + (x - LEFT) / this.width * (view.to_s - view.from_s);
  }
  #x(t_s, view) {
    return LEFT + (t_s - view.from_s) / (view.to_s - view.from_s) * (this.#wide - 2 * LEFT);
  }

  // window: a TraceWindow; view: { from_s, to_s, end: what stands at its right end }; cursors: instants with their names;
  // ages: of each channel, s, where its trace is old, else null.
  draw(window, view, cursors, ages) {
    const c = this.#context;
    const sharp = Math.min(devicePixelRatio, SHARPEST);
    const [width, height] = [this.#canvas.clientWidth, this.#canvas.clientHeight];
    this.#wide = width;
    if (this.#canvas.width !== Math.round(width * sharp) || this.#canvas.height !== Math.round(height * sharp)) {
      this.#canvas.width = Math.round(width * sharp);
      this.#canvas.height = Math.round(height * sharp);
      this.#rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    }
    const lanes = Math.max(window.names.length, 1);
    const room = (height - BELOW - lanes * LETTERS.around) / (lanes + 1); // one line a lane, and the times
    this.#size = Math.round(Math.max(LETTERS.least, Math.min(LETTERS.rem * this.#rem, room)));
    const foot = this.#size + BELOW;
    c.setTransform(sharp, 0, 0, sharp, 0, 0);
    c.fillStyle = this.#style.sheet;
    c.fillRect(0, 0, width, height);
    c.font = `${this.#size}px system-ui, "DejaVu Sans", sans-serif`;
    c.lineWidth = this.#size / LETTERS.least;
    this.#marks(view, width, height, height - foot);
    const lane = (height - foot) / lanes;
    const names = this.#namesOf(window.names, width);
    window.names.forEach((_, channel) => this.#lane(window, channel, names[channel], view, channel * lane, lane, ages[channel] ?? null));
    for (const [name, t_s] of cursors) this.#cursor(name, t_s, view, height - foot);
  }

  // Names that are cut stand in full in the canvas' title, in their order.
  #namesOf(of, width) {
    if (this.#short.of === of && this.#short.width === width && this.#short.size === this.#size) return this.#short.names;
    const [whole, room] = [of.map(readable), Math.max(NAME.least, NAME.part * width)];
    const names = shortNames(whole, (text) => this.#context.measureText(text).width <= room);
    this.#short = { of, width, size: this.#size, names };
    this.#canvas.title = names.some((name, i) => name !== whole[i]) ? `From above: ${whole.join(', ')}` : '';
    return names;
  }

  // bottom: of the lanes.
  #marks(view, width, height, bottom) {
    const c = this.#context;
    const range = view.to_s - view.from_s;
    const step = markStep(range, Math.max(2, width / (MARK * this.#size)));
    c.strokeStyle = this.#style.line;
    c.fillStyle = this.#style.faint;
    c.textAlign = 'center';
    c.beginPath();
    // Times are told from the right side on, which is now while the traces are live.
    for (let steps = 0; steps * step <= range * (1 + 1e-9); ++steps) {
      const x = Math.round(this.#x(view.to_s - steps * step, view)) + 0.5;
      c.moveTo(x, 0);
      c.lineTo(x, bottom);
      c.textAlign = steps === 0 ? 'right' : 'center';
      if (x > MARK / 4 * this.#size) c.fillText(steps === 0 ? view.end : markText(steps, step), steps === 0 ? x + LEFT : x, height - BELOW / 2 - 1);
    }
    c.stroke();
  }

  // The part of the window that is in view, one bin more at each side.
  static #visible(window, view) {
    const from = Math.max(0, Math.floor(view.from_s / window.step_s) - window.first - 1);
    const to = Math.min(window.bins, Math.ceil(view.to_s / window.step_s) - window.first + 2);
    return [from, to];
  }

  #scale(window, channel, from, to) {
    let [low, high] = [Infinity, -Infinity];
    for (let i = from; i < to; ++i) {
      if (window.low(channel, i) < low) low = window.low(channel, i);
      if (window.high(channel, i) > high) high = window.high(channel, i);
    }
    if (low > high) return null;
    const middle = low < 0 && high > 0 ? 0 : (low + high) / 2;
    const half = Math.max(high - middle, middle - low);
    return { middle, half: rounded(half || Math.abs(middle) * 1e-3) };
  }

  #lane(window, channel, name, view, top, height, age) {
    const c = this.#context;
    const [from, to] = TracePlot.#visible(window, view);
    const scale = this.#scale(window, channel, from, to);
    c.strokeStyle = this.#style.line;
    c.beginPath();
    c.moveTo(0, Math.round(top + height) + 0.5);
    c.lineTo(this.#wide, Math.round(top + height) + 0.5);
    c.stroke();
    if (scale) {
      const middle = top + height / 2;
      const perUnit = (height / 2 - 3) / scale.half;
      const perBin = window.step_s / (view.to_s - view.from_s) * (this.#wide - 2 * LEFT);
      const start = this.#x((window.first + 0.5) * window.step_s, view);
      c.strokeStyle = age === null ? this.#style.ink : this.#style.old;
      c.beginPath();
      let joined = false;
      let last = 0;
      for (let i = from; i < to; ++i) {
        const broken = window.broken(channel, i); // before its readings, among them or after them
        joined &&= !broken;
        const low = window.low(channel, i);
        if (low !== low) continue; // no reading came: a slow channel's line goes on
        const x = start + i * perBin;
        const [bottom, peak] = [middle - (low - scale.middle) * perUnit, middle - (window.high(channel, i) - scale.middle) * perUnit];
        // Up and down within the bin, beginning at the end that is nearer. No corner there if the line crosses it anyway.
        const down = Math.abs(bottom - last) < Math.abs(peak - last);
        const [one, other] = down ? [bottom, peak] : [peak, bottom];
        if (!joined) c.moveTo(x, one === other ? one - 0.5 : one);
        else if ((one - last) * (other - one) < 0) c.lineTo(x, one);
        c.lineTo(x, other);
        [last, joined] = [other, !broken];
      }
      c.stroke();
    }
    const old = age === null ? '' : `\u25b2 old, ${lastText(age, window)}  `;
    this.#label(`${name}  ${old}`, scale ? `\u00b1${plainText(scale.half, '', 1)}${scale.middle === 0 ? '' : ` about ${plainText(scale.middle, '', 4)}`} ${window.units[channel]}`
      : window.less_dwell === null ? 'no reading here' : 'nothing is shown here', top);
  }

  #label(name, scale, top) {
    const c = this.#context;
    const text = shortened(readable(`${name}${scale}`), (part) => c.measureText(part).width <= this.#wide - 10);
    c.textAlign = 'left';
    c.fillStyle = this.#style.sheet;
    c.fillRect(0, top + 1, c.measureText(text).width + 10, this.#size + 3);
    c.fillStyle = this.#style.ink;
    c.fillText(text, 5, top + this.#size + 2);
  }

  // Its name stands above the times, which it would cover.
  #cursor(name, t_s, view, bottom) {
    const c = this.#context;
    const x = Math.round(this.#x(t_s, view)) + 0.5;
    c.strokeStyle = this.#style.ink;
    c.setLineDash(name === 'A' ? [] : [5, 3]); // told apart without colour
    c.lineWidth *= 2;
    c.beginPath();
    c.moveTo(x, 0);
    c.lineTo(x, bottom);
    c.stroke();
    c.setLineDash([]);
    c.lineWidth /= 2;
    c.fillStyle = this.#style.ink;
    c.fillRect(x - this.#size * 2 / 3, bottom - this.#size - 3, this.#size * 4 / 3, this.#size + 3);
    c.fillStyle = this.#style.sheet;
    c.textAlign = 'center';
    c.fillText(name, x, bottom - 3);
  }
}
