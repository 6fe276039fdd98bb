// The page: draws what the feed knows, when something came or time has made something old.
import { showAlarms } from './alarms_view.mjs';
import { showCoefficients } from './coefficients_view.mjs';
import { atMost } from './dom.mjs';
import { Feed } from './feed.mjs';
import { Clock } from './freshness.mjs';
import { showHead } from './head_view.mjs';
import { showModeShape } from './mode_shape_view.mjs';
import { beginOperate, rightsNow, showOperate, startsHere } from './operate_view.mjs';
import { showPhasors } from './phasors_view.mjs';
import { inNextPicture } from './pictures.mjs';
import { showTables } from './tables_view.mjs';
import { TracesView } from './traces_view.mjs';
import { showBeyond } from './wall_view.mjs';
import { playsRecording, withButton } from './wording.mjs';

// Ages and the connection are looked at so often even when nothing comes.
const TICK_MS = 250;

const clock = new Clock(() => performance.now() / 1e3, () => Date.now() / 1e3);

const slower = [atMost(2, showPhasors), atMost(1, showModeShape), atMost(1, showTables), atMost(4, showOperate), atMost(1, showBeyond),
  atMost(2, (view) => showAlarms(view, () => feed.askNow()))];

function draw() {
  const now = clock.now();
  const silent = new Set((feed.channels ?? []).filter((c) => feed.health?.stale.includes(c.name)).map((c) => c.name));
  const dwell = feed.dwell && startsHere(feed) ? { ...feed.dwell, settling_reason: withButton(feed.dwell.settling_reason) } : feed.dwell;
  const view = { dwell, health: feed.health, channels: feed.channels, events: feed.events, eventsTotal: feed.eventsTotal,
    dwells: feed.dwells, dwellsTotal: feed.dwellsTotal, runs: feed.runs, runsTotal: feed.runsTotal, verification: feed.verification, alarms: feed.alarms, fresh: feed.fresh, last: feed.last, history: feed.history, trendLacks: feed.trendLacks(), now,
    nowMs: feed.nowMs(), broken: silent.size > 0, refused: feed.refused, anew: feed.anew, rights: rightsNow() };
  showHead(view);
  showCoefficients(view);
  for (const part of slower) part(view);
  traces.look(now, feed.fresh.old_s, playsRecording(feed.health));
}

const changed = () => inNextPicture(draw);

const traces = new TracesView(clock);
const feed = new Feed(clock, changed, traces);
if (new URLSearchParams(location.search).has('kiosk')) document.documentElement.classList.add('kiosk');
draw();
feed.begin();
beginOperate(changed, () => feed.loggedIn());
setInterval(changed, TICK_MS);
