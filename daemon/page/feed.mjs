// What the page knows, and how it comes: the live stream, and answers asked for once a second. It never gives up: a
// connection that broke is made again each second.
import { applyChange } from './change.mjs';
import { keyOf, LastNumbers } from './coefficients.mjs';
import { Freshness, SELDOM_MS } from './freshness.mjs';
import { History, HOUR_MS, ROOM } from './history.mjs';
import { earlierRuns, FILE_MS } from './runs.mjs';
import { NOT_VERIFIED, utcMs } from './wording.mjs';

const ASK_MS = 1000;
const ANSWER_MS = 2000; // then a question is given up; FILE_MS where a file is read
const SILENT_S = 5; // a stream that says nothing for so long, while answers come, is opened anew
const TRIES = 3; // to read the file of an earlier run
const BEGAN_MS = 2000; // a beginning that is told so much later, or earlier, is another one
const ASKED_AGAIN = 2; // dwells before the newest of the list
const KEPT_EVENTS = 500;
const KEPT_DWELLS = 300;
const PER_ANSWER = 100; // dwells: the most that the service tells at once
const STEPS_BACK = Math.ceil(ROOM / PER_ANSWER) - 1; // from the newest answer: the trend has no room for more dwells

// The service answers, but this browser may not read: nobody is logged in, or no longer.
class Refused extends Error {}

export class Feed {
  dwell = null;
  health = null;
  channels = null;
  alarms = null;
  events = [];
  eventsTotal = 0; // lines since the service began
  dwells = []; // summaries of finished ones, oldest first, each with the file of its run; null: it is not recorded
  dwellsTotal = 0; // how many have ended in the newest run
  runs = []; // the newest
  runsTotal = 0; // how many the service has
  verification = null; // the newest of the run; asked for while the dwell's model has no verdict, for the reason
  last = new LastNumbers();
  history = new History();
  fresh = new Freshness();
  anew = false; // the service was started anew since somebody logged in here: it knows nobody any more
  refused = false; // the newest answer was that somebody must log in
  #clock;
  #changed;
  #source = null;
  #spoke_s = -Infinity; // the stream
  #seldom_s = -Infinity; // when what changes seldom was asked for
  #asking = false;
  #askingSeldom = false;
  #askingEarlier = false;
  #earlier = null; // runs whose dwells the trend still lacks, { run, failed: how often }; null: not known yet
  #back = null; // how far back the dwells of the newest run have been asked for, as #askBack() takes it
  #nextEvent = 0; // 0: all are asked for
  #began_ms = NaN; // UTC when the service began, as health told last
  #uptime_s = 0; // of the service, as health told last
  #missed = false; // it was not reached when it was asked last
  #ahead_ms = 0; // the service's clock before this computer's
  #told = '';
  #model = ''; // the verdict on it, as told last

  #traces;

  // changed: called whenever something came. traces: told of what the stream says of them.
  constructor(clock, changed, traces) {
    this.#traces = traces;
    this.#clock = clock;
    this.#changed = changed;
  }

  begin() {
    this.#listen();
    this.#ask();
    setInterval(() => this.#ask(), ASK_MS);
  }

  // Something was changed: the news are not waited for.
  askNow() {
    this.#ask();
  }

  #now() {
    return this.#clock.now();
  }

  loggedIn() {
    this.anew = false;
    this.#ask();
  }

  // UTC as the service has it: the clock of a phone may be anything.
  nowMs() {
    return Date.now() + this.#ahead_ms;
  }

  #listen() {
    this.#source?.close();
    const source = new EventSource('/api/v1/stream?traces');
    this.#source = source;
    this.#spoke_s = this.#now();
    const on = (name, take) => source.addEventListener(name, (event) => {
      this.#spoke_s = this.#now();
      take(JSON.parse(event.data));
    });
    on('dwell', (dwell) => this.#take(dwell));
    on('change', (change) => {
      const whole = applyChange(this.dwell, change);
      if (whole) this.#take(whole);
    });
    on('traces', (traces) => this.#traces.take(traces));
    source.addEventListener('open', () => this.#traces.begun());
    source.onerror = () => this.#ask();
  }

  #take(dwell) {
    const now = this.#now();
    this.dwell = dwell;
    this.fresh.tookDwell(dwell, now);
    this.last.take(dwell, now, this.nowMs());
    this.history.take(dwell, this.nowMs());
    const model = JSON.stringify(dwell.model);
    if (model !== this.#model) this.verification = null; // its reason is of the figures before
    this.#model = model;
    const told = `${dwell.start_utc} ${dwell.index} ${dwell.state} ${model}`;
    if (told !== this.#told) {
      this.#seldom_s = -Infinity; // something has ended or begun: the lists have news
      this.#ask(); // a trouble of before must not stand for a second beside the state of now
    }
    this.#told = told;
    this.#changed();
  }

  async #get(path, most_ms = ANSWER_MS) {
    const answer = await fetch(path, { signal: AbortSignal.timeout(most_ms), cache: 'no-store' });
    const value = await answer.json();
    if (answer.status === 401) throw new Refused(value.error);
    this.fresh.heard(this.#now());
    // Health is told with 503 where the service itself does not work.
    if (!answer.ok && path !== '/api/v1/health') throw new Error(value.error);
    return value;
  }

  async #ask() {
    if (this.#asking) return;
    this.#asking = true;
    try {
      const [health, channels, alarms] = await Promise.all(['health', 'channels', 'alarms'].map((what) => this.#get(`/api/v1/${what}`)));
      // A newer page belongs to it, or all that is known is of another rig.
      if (this.health && ['version', 'rig_sha256'].some((what) => this.health[what] !== health[what])) location.reload();
      this.health = health;
      this.fresh.told(health);
      this.#lookForRestart(health);
      this.#ahead_ms = Date.parse(health.utc) - Date.now();
      this.channels = channels.channels;
      this.alarms = alarms;
      this.refused = this.#missed = false;
      this.fresh.answered(this.#now());
      if (this.#source.readyState === EventSource.CLOSED || this.#now() - this.#spoke_s > SILENT_S) this.#listen();
      if (1e3 * (this.#now() - this.#seldom_s) >= SELDOM_MS) this.#askSeldom(); // not waited for: lists may be long
    } catch (error) {
      this.refused = error instanceof Refused;
      // Logins last while the service goes on. One that was gone and knows nobody was started again.
      this.anew ||= this.refused && this.#missed;
      this.#missed = !this.refused && error instanceof TypeError;
      // A stream that was opened before would go on: what is shown must be of one time.
      if (this.refused) this.#source.close();
      // Another error status is an answer as well: then the service is there.
      if (this.refused || this.#now() - this.fresh.heard_s > ASK_MS / 1e3) this.fresh.broke(this.#now());
    } finally {
      this.#asking = false;
      this.#changed();
    }
  }

  // A clock of the service that is set looks the same, and only has the events asked for once more.
  #lookForRestart({ utc, uptime_s }) {
    const began_ms = Date.parse(utc) - 1e3 * (uptime_s ?? NaN);
    if (Math.abs(began_ms - this.#began_ms) > BEGAN_MS) {
      this.#nextEvent = 0;
      this.#seldom_s = -Infinity;
    }
    this.#began_ms = began_ms;
    this.anew ||= uptime_s < this.#uptime_s;
    this.#uptime_s = uptime_s ?? 0;
  }

  async #askWhyUnverified() {
    if (this.dwell?.model?.verdict !== NOT_VERIFIED) return;
    const model = this.#model;
    const verification = await this.#get('/api/v1/verification');
    if (model === this.#model) this.verification = verification;
  }

  // One question after the other. One that fails keeps none of the others from being asked.
  async #askSeldom() {
    if (this.#askingSeldom) return;
    this.#askingSeldom = true;
    this.#seldom_s = this.#now();
    for (const ask of [this.#askEvents, this.#askDwells, this.#askWhyUnverified, this.#askRuns, this.#askLast]) {
      try {
        await ask.call(this);
      } catch {
        // It is asked again with the others.
      }
    }
    this.#askingSeldom = false;
    this.#changed();
  }

  // Only what is new is asked for. After a restart of the service its numbers begin anew.
  async #askEvents() {
    const from = this.#nextEvent;
    const told = await this.#get(`/api/v1/events${from ? `?from=${from}` : ''}`);
    if (told.next < from || from !== this.#nextEvent) { // it was started again, as told now or meanwhile by health
      this.#nextEvent = 0;
      return this.#askEvents();
    }
    this.#nextEvent = told.next;
    this.eventsTotal = told.total;
    this.fresh.tookList('events', this.#now());
    this.events = [...(from ? this.events : []), ...told.events].slice(-KEPT_EVENTS);
  }

  async #askDwells() {
    const run = this.dwell?.start_utc;
    // The model of a dwell may be verified, or contradicted, after its end: the newest are asked for again.
    const newest = this.dwells.findLast((d) => d.start_utc === run);
    const from = newest ? Math.max(1, newest.index - ASKED_AGAIN) : null;
    const path = `/api/v1/dwells?brief=1&count=${PER_ANSWER}`;
    const list = await this.#get(`${path}${from ? `&from=${from}` : ''}`);
    this.fresh.tookList('dwells', this.#now());
    this.dwellsTotal = list.total;
    this.#addDwells(list);
    for (const dwell of list.dwells) {
      const ended = utcMs(dwell, dwell.end_s);
      if (ended === null) continue;
      this.last.takeEnded(dwell, ended, this.#now(), this.nowMs());
    }
    if (!from) this.#back = { oldest: list.dwells[0], steps: 0 };
    await this.#askBack(path, this.#back, (older) => this.#addDwells(older));
  }

  // list: of dwells of one run, with its file. With each run the service's list begins anew.
  #addDwells({ dwells, file }) {
    const known = new Set(dwells.map(keyOf));
    const run = dwells[0]?.start_utc;
    const own = [...this.dwells.filter((d) => d.start_utc === run && !known.has(keyOf(d))), ...dwells.map((d) => ({ ...d, file }))];
    own.sort((a, b) => a.index - b.index);
    this.dwells = [...this.dwells.filter((d) => d.start_utc !== run), ...own].slice(-KEPT_DWELLS);
    this.#addToTrend(dwells);
  }

  // Asks for the dwells before those that were told, until they reach back an hour: without an index the service tells the
  // newest, with one it goes on to newer ones. path: of the list. back: { oldest: the oldest dwell told, steps: how many
  // were made }, so that a question that fails is asked again where it was. Each answer goes to take().
  async #askBack(path, back, take, most_ms) {
    const isYoung = (dwell) => utcMs(dwell, dwell.end_s) > this.nowMs() - HOUR_MS;
    while (back.oldest?.index > 1 && isYoung(back.oldest) && back.steps < STEPS_BACK) {
      const { index: end, start_utc } = back.oldest;
      const older = [];
      // Of many elements an answer holds fewer dwells than asked for, and says where it goes on.
      for (let from = Math.max(1, end - PER_ANSWER); from < end;) {
        const list = await this.#get(`${path}&from=${from}`, most_ms);
        const told = list.dwells.filter((d) => d.start_utc === start_utc && d.index < end);
        take({ ...list, dwells: told });
        older.push(...told);
        from = told.length > 0 ? list.next ?? end : end;
      }
      back.oldest = older[0];
      back.steps += 1;
    }
  }

  async #askRuns() {
    ({ runs: this.runs, total: this.runsTotal } = await this.#get('/api/v1/runs?count=20'));
    this.fresh.tookList('runs', this.#now());
    this.#askEarlier(); // it is not waited for: files are read
  }

  // For the trend: the dwells of runs that ended within the last hour. Those of another rig file do not belong to it.
  async #askEarlier() {
    if (this.#askingEarlier) return;
    this.#askingEarlier = true;
    const since_ms = this.nowMs() - HOUR_MS;
    this.#earlier ??= earlierRuns(this.runs).filter(({ ended }) => ended && Date.parse(ended) > since_ms).map((run) => ({ run, failed: 0 }));
    for (const one of this.#earlier.filter(({ failed }) => failed < TRIES)) {
      try {
        const path = `${one.run.dwells_at}?count=${PER_ANSWER}`;
        const told = await this.#get(path, FILE_MS);
        if (told.rig_sha256 === this.health.rig_sha256) {
          this.#addToTrend(told.dwells);
          await this.#askBack(path, { oldest: told.dwells[0], steps: 0 }, ({ dwells }) => this.#addToTrend(dwells), FILE_MS);
        }
        this.#earlier = this.#earlier.filter((other) => other !== one);
      } catch {
        one.failed += 1; // it is asked again at the next turn
      }
    }
    this.#askingEarlier = false;
    this.#changed();
  }

  // Numbers of the last hour's runs that the trend lacks, for their files could not be read.
  trendLacks() {
    const since_ms = this.nowMs() - HOUR_MS;
    return (this.#earlier ?? []).filter(({ run, failed }) => failed > 0 && Date.parse(run.ended) > since_ms).map(({ run }) => run.run);
  }

  #addToTrend(dwells) {
    for (const dwell of dwells) {
      const ended = utcMs(dwell, dwell.end_s);
      if (ended !== null && dwell.elements.length > 0) this.history.takeEnded(dwell, ended);
    }
  }

  // What the list leaves out of the last dwell: its warnings.
  async #askLast() {
    const { key, index, ended_by, whole } = this.last;
    if (whole || ended_by === null) return;
    const dwell = await this.#get(`/api/v1/dwells/${index}`);
    const ended = utcMs(dwell, dwell.end_s);
    // Indices begin anew with each run: the service has only the dwells of the newest.
    if (keyOf(dwell) === key && this.last.key === key && ended !== null) this.last.takeEnded(dwell, ended, this.#now(), this.nowMs());
  }
}
