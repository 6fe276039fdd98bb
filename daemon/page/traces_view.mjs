// The traces: live, or a stretch of the past; zoom, two cursors, CSV. The service keeps bins of 20 ms for 10 min, wider
// ones for longer. A page that is paused asks for what it shows, and gets it coarser as time passes.
import { h, rowHead, setAttributes, setText, show } from './dom.mjs';
import { ageText, isNumber, plainText } from './number.mjs';
import { whileDisabled } from './order.mjs';
import { inNextPicture } from './pictures.mjs';
import { lastText, TracePlot } from './trace_plot.mjs';
import { agesOf, csvName, csvOf, cursorTexts, durationText, finestOf, MOST_BINS, savedText, TraceWindow } from './trace_window.mjs';

const $ = (id) => document.getElementById(id);
const SPANS = { least: 0.02, most: 2 * 3600, usual: 10 }; // s, what may be in view
const LIVE_MOST = 600; // s in view while live: what the service keeps to 20 ms
const LESS_MOST = 60; // s that the service computes less the steady part
const LESS_MS = 500; // between two answers less the steady part while live
const RATIO = 4; // between the widths of bins
const FINEST_LIVE_S = 0.02;
// While live, more bins than the view holds: the newest reading has moved on when the question arrives. Too few to get
// bins a quarter as wide, which the stream could not go on with; so no less than LIVE_LEAST is in view.
const SPARE_BINS = 25;
const LIVE_LEAST = 0.5; // s
const DRAG_PX = 4; // less is a click
const ANSWER_MS = 5000; // then a question is given up …
const AGAIN_MS = 1000; // … and asked again so much later
// The origin moves with the corrections of the service's clock, by far less than this between two answers. More: the
// service began anew, or its clock was set.
const ORIGIN_MOVED_MS = 1000;

const whyText = (error) => (error.name === 'TimeoutError' || error instanceof TypeError
  ? 'The traces in view are not complete: no answer of the service; asking again.' : error.message);

async function ask(query) {
  const answer = await fetch(`/api/v1/traces?${query}`, { cache: 'no-store', signal: AbortSignal.timeout(ANSWER_MS) });
  return { answer, value: await answer.json() };
}

export class TracesView {
  #plot = new TracePlot($('trace-plot'));
  #window = null;
  #played = false;
  #view = { from_s: 0, to_s: SPANS.usual, end: 'now' };
  #span_s = SPANS.usual;
  #live = true;
  #newest_s = 0;
  #origin_ms = NaN; // UTC at 0 s of the axis
  #asking = false; // a question is under way
  #askedWidth = 0; // of the plot, px
  #again = false; // the view has changed meanwhile
  #retry = null; // the timer for the question that failed
  #lessAt = 0;
  #cursors = { A: 0.25, B: 0.75 }; // parts of the view
  #drag = null;
  #seen = true; // the plot is on the screen
  #drawn_s = -Infinity; // when the plot was drawn; -Infinity: not yet with the newest answer
  #clock;
  #came_s = -Infinity; // when the stream last went on, by the page's clock
  #last = []; // of each channel its newest reading seen, s; null: none was
  #ages = []; // of each channel, s, where it is old; else null
  #over_s = null; // less the steady part: since when the dwell is over, so that nothing is shown; null: it is not
  #joins = false; // the stream goes on with the axis of the window
  #news = ''; // what the operator must know of the view, until he acts on it

  // clock: the page's.
  constructor(clock) {
    this.#clock = clock;
    $('trace-pause').addEventListener('click', () => (this.#live ? this.#pause() : this.#resume()));
    $('trace-in').addEventListener('click', () => this.#zoom(0.5));
    $('trace-out').addEventListener('click', () => this.#zoom(2));
    $('trace-back').addEventListener('click', () => this.#pan(-0.5));
    $('trace-on').addEventListener('click', () => this.#pan(0.5));
    $('trace-save').addEventListener('click', () => this.#save());
    $('trace-less').addEventListener('change', () => this.#ask());
    $('traces').addEventListener('click', () => (this.#news = ''));
    $('traces').addEventListener('keydown', () => (this.#news = ''));
    $('trace-cursors').addEventListener('change', () => this.#redraw());
    for (const name of ['A', 'B'])
      $(`trace-${name}`).addEventListener('input', (event) => this.#setCursor(name, event.target.value / 1000));
    const canvas = $('trace-plot');
    canvas.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // the page scrolls
      event.preventDefault();
      this.#zoom(event.deltaY > 0 ? 1.25 : 0.8, this.#partAt(event));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => this.#key(event));
    canvas.addEventListener('pointerdown', (event) => this.#press(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#release(event));
    canvas.addEventListener('pointercancel', () => (this.#drag = null));
    // For as many bins as there are pixels now.
    new ResizeObserver(() => (this.#plot.width === this.#askedWidth ? this.#redraw() : this.#ask())).observe(canvas);
    new IntersectionObserver((entries) => {
      this.#seen = entries.at(-1).isIntersecting;
      this.#redraw();
    }).observe(canvas);
    document.addEventListener('visibilitychange', () => document.hidden || this.#ask());
  }

  // The stream begins, or begins anew: maybe that of a service that has begun anew.
  begun() {
    this.#joins = false;
    this.#ask();
  }

  // To be called some times a second: what stands still grows old, after old_s. played: a recording, not a rig.
  look(now, old_s, played) {
    this.#played = played;
    if ($('traces').hidden) return;
    const quiet = now - this.#came_s;
    const ages = this.#live && this.#window ? this.#agesNow(quiet, old_s) : [];
    const stands = this.#live && quiet > old_s;
    if (this.#live) this.#view.end = stands ? `${ageText(quiet)} ago` : 'now';
    const changed = ages.some((age, c) => (age === null) !== ((this.#ages[c] ?? null) === null)) || ages.length !== this.#ages.length;
    this.#ages = ages;
    if (changed || stands || this.#over_s !== null || ages.some((age) => age !== null)) this.#redraw();
  }
  // Less the steady part every trace ends with the dwell: a channel is old only where others go on.
  #agesNow(quiet, old_s) {
    const last = this.#seenLast();
    const less = isNumber(this.#window.less_dwell) && last.some((t_s) => t_s !== null);
    const newest = less ? Math.max(...last.filter((t_s) => t_s !== null)) : this.#newest_s;
    const over = less ? this.#newest_s - newest : 0;
    this.#over_s = over > old_s ? over : null;
    return agesOf(last, newest, quiet, old_s);
  }
  #seenLast() {
    this.#last = this.#window.names.map((_, c) => this.#window.last_s(c) ?? this.#last[c] ?? null);
    return this.#last;
  }

  // The event `traces`.
  take(event) {
    const newest_s = (event.first + event.bins) * event.step_s;
    if (newest_s > this.#newest_s) this.#came_s = this.#clock.now();
    // The service has begun anew: the view may be of before.
    const back = newest_s < this.#newest_s - ORIGIN_MOVED_MS / 1e3;
    this.#newest_s = newest_s;
    if ($('traces').hidden) {
      show($('traces'), true);
      return this.#ask();
    }
    if (back) this.begun();
    if (!this.#live || document.hidden) return;
    const less = $('trace-less').checked;
    const taken = this.#joins && this.#window.take(event);
    if (taken && !less) this.#say('');
    // An answer that is under way will hold this event too.
    if (less ? performance.now() - this.#lessAt > LESS_MS : !taken && !this.#asking) this.#ask();
    this.#follow();
  }

  #follow() {
    this.#view = { from_s: this.#newest_s - this.#span_s, to_s: this.#newest_s, end: this.#view.end };
    this.#redraw();
  }

  #pause() {
    this.#live = false;
    this.#look(this.#view.from_s, this.#view.to_s);
  }
  #resume() {
    this.#live = true;
    this.#view.end = 'now';
    this.#span_s = Math.min(Math.max(this.#span_s, LIVE_LEAST), LIVE_MOST);
    this.#follow();
    this.#ask();
  }

  // Looks at a stretch of the past.
  #look(from_s, to_s) {
    this.#live = false;
    this.#span_s = Math.min(to_s - from_s, SPANS.most);
    const end = Math.min(to_s, Math.max(this.#newest_s, this.#span_s));
    const from = Math.max(end - this.#span_s, 0);
    this.#view = { from_s: from, to_s: from + this.#span_s, end: this.#timeText(from + this.#span_s) };
    this.#redraw();
    this.#ask();
  }

  // at: the part of the view that stays where it is; while live that is its end.
  #zoom(factor, at = 0.5) {
    const span = Math.min(Math.max(this.#span_s * factor, this.#live ? LIVE_LEAST : SPANS.least), this.#live ? LIVE_MOST : SPANS.most);
    if (this.#live) {
      this.#span_s = span;
      this.#follow();
      return this.#ask();
    }
    const middle = this.#view.from_s + at * this.#span_s;
    this.#look(middle - at * span, middle + (1 - at) * span);
  }
  #pan(part) {
    this.#look(this.#view.from_s + part * this.#span_s, this.#view.to_s + part * this.#span_s);
  }

  #key(event) {
    const does = { ' ': () => (this.#live ? this.#pause() : this.#resume()), '+': () => this.#zoom(0.5), '-': () => this.#zoom(2),
      ArrowLeft: () => this.#pan(-0.1), ArrowRight: () => this.#pan(0.1), End: () => this.#resume() }[event.key];
    if (!does || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    does();
  }

  #partAt(event) {
    const t_s = this.#plot.timeAt(event.offsetX, this.#view);
    return Math.min(1, Math.max(0, (t_s - this.#view.from_s) / this.#span_s));
  }
  #press(event) {
    if (event.button !== 0) return;
    this.#drag = { x: event.clientX, from_s: this.#view.from_s, moved: false };
    event.target.setPointerCapture(event.pointerId);
  }
  #move(event) {
    if (!this.#drag) return;
    const by = event.clientX - this.#drag.x;
    this.#drag.moved ||= Math.abs(by) >= DRAG_PX;
    if (!this.#drag.moved) return;
    const from = this.#drag.from_s - by / this.#plot.width * this.#span_s;
    this.#look(from, from + this.#span_s);
  }
  // A click sets the nearer cursor.
  #release(event) {
    const clicked = this.#drag && !this.#drag.moved;
    this.#drag = null;
    if (!clicked || !$('trace-cursors').checked) return;
    const part = this.#partAt(event);
    const { A, B } = this.#cursors;
    this.#setCursor(Math.abs(part - A) <= Math.abs(part - B) ? 'A' : 'B', part);
  }
  #setCursor(name, part) {
    this.#cursors[name] = part;
    $(`trace-${name}`).value = String(Math.round(1000 * part));
    this.#redraw();
  }

  // What is in view, from the service: one question at a time.
  async #ask() {
    if ($('traces').hidden) return;
    // The width is 0 for a moment while a browser takes a picture of the whole page. It asks when the width is back.
    if (this.#plot.width < 1) {
      this.#askedWidth = 0;
      return;
    }
    if (this.#asking) {
      this.#again = true;
      return;
    }
    this.#asking = true;
    this.#askedWidth = this.#plot.width;
    this.#lessAt = performance.now();
    try {
      const answer = await this.#fetch(this.#bins());
      if (answer) {
        // Soon after the service has begun the answer is short: there must be room for all that will be in view.
        this.#window = new TraceWindow(answer, this.#live ? Math.ceil(this.#span_s / answer.step_s) + SPARE_BINS : 0);
        this.#joins = true;
        this.#drawn_s = -Infinity;
        this.#say('');
      }
    } catch (error) {
      this.#say(whyText(error));
      this.#retry ??= setTimeout(() => {
        this.#retry = null;
        this.#ask();
      }, AGAIN_MS);
    } finally {
      this.#asking = false;
      this.#redraw();
      if (this.#again) {
        this.#again = false;
        this.#ask();
      }
    }
  }
  // As many as the plot has pixels; while live a width that the stream can go on with.
  #bins() {
    const most = Math.max(2, Math.min(MOST_BINS - SPARE_BINS, Math.round(2 * this.#plot.width)));
    if (!this.#live) return most;
    let step = FINEST_LIVE_S;
    while (this.#span_s / step > most) step *= RATIO;
    return Math.ceil(Math.min(this.#span_s, this.#newest_s) / step) + SPARE_BINS;
  }
  #say(trouble) {
    setText($('trace-trouble'), trouble);
  }
  // null: the time axis has another origin than what is in view; then it is live again.
  async #fetch(points, { from_s, to_s } = this.#view) {
    const less = $('trace-less').checked ? '&less=steady' : '';
    const stretch = this.#live ? `from=${-this.#span_s}` : `from=${from_s}&to=${Math.max(to_s, from_s)}`;
    let { answer, value } = await ask(`${stretch}&points=${points}${less}`);
    const refused = answer.ok ? null : value.error;
    // After a restart the service's time axis begins anew, and may not reach this stretch yet. The answer with one bin
    // tells the new origin.
    if (answer.status === 400 && !this.#live) ({ answer, value } = await ask('points=1'));
    if (!answer.ok) throw new Error(value.error);
    const origin_ms = Date.parse(value.origin_utc);
    const moved = Math.abs(origin_ms - this.#origin_ms) > ORIGIN_MOVED_MS;
    this.#origin_ms = origin_ms;
    if (value.newest_s > this.#newest_s || moved) this.#came_s = this.#clock.now();
    this.#newest_s = value.newest_s;
    if (!moved && refused !== null) throw new Error(refused);
    if (!moved) return value;
    this.#last = [];
    this.#again = true;
    if (!this.#live) this.#news = `The traces begin anew at ${this.#timeText(0)}: the service was started again, or its clock was set. What was in view is of before.`;
    this.#resume();
    return null;
  }

  async #save() {
    if (this.#live) this.#pause();
    setText($('trace-saved'), '');
    await whileDisabled([$('trace-save')], () => this.#download());
  }
  async #download() {
    try {
      const bins = await this.#fetch(MOST_BINS);
      if (!bins) return;
      const answer = await finestOf(bins, (from_s, to_s) => this.#fetch(MOST_BINS, { from_s, to_s })) ?? bins;
      const link = h('a', { href: URL.createObjectURL(new Blob([csvOf(answer)], { type: 'text/csv' })), download: csvName(answer) });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
      setText($('trace-saved'), `Saved: ${savedText(answer)}.`);
      this.#say('');
    } catch (error) {
      this.#say(`Not saved. ${whyText(error).replace('; asking again', '')}`);
    }
  }

  #timeText(t_s) {
    return isNumber(this.#origin_ms) ? `${new Date(this.#origin_ms + 1e3 * t_s).toISOString().slice(11, 23)} UTC` : '';
  }

  #drawing = () => this.#draw(); // one function object: inNextPicture() tells drawings apart by identity
  #redraw() {
    inNextPicture(this.#drawing);
  }
  #draw() {
    setText($('trace-pause'), this.#live ? 'Pause' : 'Live');
    const less = isNumber(this.#window?.less_dwell);
    const wide = this.#span_s > LESS_MOST ? ` (of the last ${LESS_MOST} s in view)` : '';
    const over = this.#live && this.#over_s !== null ? `, which ended ${ageText(this.#over_s)} ago: nothing is shown since then` : '';
    const what = less ? `readings less the steady part of dwell ${this.#window.less_dwell}${over}${wide}` : 'readings';
    const bins = this.#window ? `, least and greatest in ${durationText(this.#window.step_s)}` : '';
    const stands = this.#live && this.#view.end !== 'now';
    const state = stands ? `old, from ${this.#view.end}` : this.#live ? (this.#played ? 'a recording as it is played' : 'live') : 'paused';
    setText($('trace-what'), `${durationText(this.#span_s)} in view, ${state}: ${what}${bins}${stands ? '' : this.#oldText()}`);
    setAttributes($('traces'), { 'data-old': stands });
    setText($('trace-news'), this.#news);
    const on = $('trace-cursors').checked;
    show($('trace-readout'), on);
    if (!this.#window) return;
    this.#lanes(this.#window.names.length);
    // Off the screen once a second: who prints the page, or takes a picture of all of it, must not find what was.
    if (!this.#seen && this.#clock.now() - this.#drawn_s < 1) return;
    this.#drawn_s = this.#clock.now();
    const cursors = on ? Object.entries(this.#cursors).map(([name, part]) => [name, this.#view.from_s + part * this.#span_s]) : [];
    this.#plot.draw(this.#window, this.#view, cursors, this.#ages);
    if (on) this.#read(cursors.map(([, t_s]) => t_s));
  }

  // Of channels that have stopped while others go on.
  #oldText() {
    const old = this.#ages.flatMap((age, c) => (age === null ? [] : [`${this.#window.names[c]} (${lastText(age, this.#window)})`]));
    return old.length > 0 ? `; old: ${old.join(', ')}` : '';
  }

  #lanes(count) {
    const style = $('trace-plot').style;
    if (style.getPropertyValue('--lanes') !== String(count)) style.setProperty('--lanes', String(count));
  }

  #read([a, b]) {
    const between = Math.abs(b - a);
    setText($('trace-between'), `B \u2212 A: ${(1e3 * (b - a)).toFixed(2)} ms${between > 0 ? `; 1/|B \u2212 A| = ${plainText(1 / between, 'Hz', 4)}` : ''}`);
    const rows = $('trace-rows');
    while (rows.children.length > this.#window.names.length) rows.lastChild.remove();
    this.#window.names.forEach((name, c) => {
      const row = rows.children[c] ?? rows.appendChild(h('tr', {}, rowHead(), h('td'), h('td'), h('td')));
      const { A, B, difference } = cursorTexts(this.#window.at(c, a), this.#window.at(c, b), this.#window.units[c]);
      [name, A, B, difference].forEach((value, i) => setText(i === 0 ? row.firstChild.firstChild : row.children[i], value));
    });
  }
}
