// What is known of how old everything on the page is, by the page's own clock: a service that says nothing cannot say
// that it says nothing. Pure: instants are seconds of one clock, given by the caller.

export const SELDOM_MS = 10_000; // between questions for what changes seldom: events, dwells, runs
const LISTS_OLD_S = 2 * SELDOM_MS / 1e3; // one answer may fail

// Whether the dwell's data must go on. Those of a dwell that has ended do not: its numbers are a result (coefficients.mjs).
const hasData = (dwell) => dwell.state === 'settling' || dwell.state === 'measuring';

const moved = (before, after) => before.index !== after.index || before.state !== after.state ||
  before.end_s !== after.end_s;

export class Freshness {
  // Seconds without renewal after which numbers are old, and without any word after which the service is gone. The service
  // says how many. Before it has, a question that it does not answer tells that it is gone.
  old_s = Infinity;
  #updates = 0; // numbers may be this many usual intervals old, if that is longer than old_s
  heard_s = -Infinity; // anything from the service
  #answered_s = -Infinity; // what the page asks for once a second, all of it
  connected_s = null; // since when the service answers without a break; null: it does not
  gone_s = null; // since when it does not
  #moved_s = -Infinity; // the dwell's data went on
  #turns = [0, 0, 0]; // times between the last renewals
  #dwell = null;
  #lists = new Map(); // when each was told last

  // health: of /api/v1/health.
  told(health) {
    this.old_s = health.old_after_s;
    this.#updates = health.old_after_updates;
  }

  heard(now) {
    this.heard_s = now;
    if (this.connected_s === null) this.connected_s = now;
    this.gone_s = null;
  }

  // The connection broke, which the browser may know before the time is up.
  broke(now) {
    if (this.gone_s === null) this.gone_s = now;
    this.connected_s = null;
  }

  // All that is asked for once a second came: health, channels, alarms.
  answered(now) {
    this.heard(now);
    this.#answered_s = now;
  }

  tookDwell(dwell, now) {
    this.heard(now);
    if (!this.#dwell || !hasData(dwell) || moved(this.#dwell, dwell)) {
      // The service says how old it is: it may have told the same for minutes before this page was opened.
      const at = now - (dwell.estimate_age_s ?? 0);
      this.#turns = [Number.isFinite(this.#moved_s) ? at - this.#moved_s : 0, ...this.#turns.slice(0, 2)];
      this.#moved_s = at;
    }
    this.#dwell = dwell;
  }

  gone(now) {
    return this.gone_s !== null || now - this.heard_s > this.old_s;
  }

  silence_s(now) {
    return now - this.heard_s;
  }

  // How old channels, devices and alarms are, and whether that is too old: the stream does not renew them.
  answersAge_s(now) {
    return now - this.#answered_s;
  }

  answersOld(now) {
    return this.gone(now) || this.answersAge_s(now) > this.old_s;
  }

  // An answer for a list that changes seldom.
  tookList(name, now) {
    this.#lists.set(name, now);
  }

  // How old it is, and whether that is too old. A list that never came is neither.
  listAge_s(name, now) {
    return now - (this.#lists.get(name) ?? now);
  }

  listOld(name, now) {
    return this.#lists.has(name) && (this.gone(now) || this.listAge_s(name, now) > LISTS_OLD_S);
  }

  // How old the dwell's numbers are, and whether that is too old.
  dwellAge_s(now) {
    return now - this.#moved_s;
  }

  dwellOld(now) {
    // One outage among three renewals must not pass as usual: the shortest counts.
    const limit = Math.max(this.old_s, this.#updates * Math.min(...this.#turns));
    return this.gone(now) || this.#dwell?.stale === true || this.dwellAge_s(now) > limit;
  }
}

// A clock that goes on while the computer sleeps: a browser's monotonic one may not, and numbers from before the lid was
// closed would pass as fresh. A wall clock that is set forward makes them look old until the next message.
export class Clock {
  #monotonic;
  #wall;
  #slept_s = 0;
  #last = null;

  constructor(monotonic_s, wall_s) {
    this.#monotonic = monotonic_s;
    this.#wall = wall_s;
  }

  now() {
    const m = this.#monotonic();
    const w = this.#wall();
    if (this.#last && w - this.#last.w > m - this.#last.m + 1) this.#slept_s += w - this.#last.w - (m - this.#last.m);
    this.#last = { m, w };
    return m + this.#slept_s;
  }
}
