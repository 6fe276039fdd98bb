// Acting on the rig from the page: logging in with the token, starting and stopping runs, re-arming the dwell. It is
// there only where the service takes orders over HTTP, or asks for the token before anything may be read.
import { setText, show } from './dom.mjs';

const ASK_MS = 10_000; // a session that has ended is noticed so soon
const ANSWER_MS = 5000; // then an order is given up

const $ = (id) => document.getElementById(id);
const kiosk = new URLSearchParams(location.search).has('kiosk');

// What this browser may; until the service has said it, nothing is offered.
let rights = { read: true, change: false, token: false };
let busy = false;

async function ask() {
  try {
    const answer = await fetch('/api/v1/rights', { signal: AbortSignal.timeout(ANSWER_MS), cache: 'no-store' });
    if (answer.ok) rights = await answer.json();
  } catch {
    // The first line says that the service does not answer.
  }
}

// Nothing can be read before somebody logs in.
export const locked = () => !rights.read;
// This page may change something, for instance acknowledge an alarm.
export const mayChange = () => rights.change;

// Gives the order and says what became of it. True: it is done.
async function order(path, body, said) {
  if (busy) return false;
  busy = true;
  setText($('operate-said'), '');
  try {
    const answer = await fetch(path, { method: 'POST', signal: AbortSignal.timeout(ANSWER_MS),
      headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
    setText($('operate-said'), answer.ok ? said : `Not done: ${(await answer.json()).error}`);
    return answer.ok;
  } catch {
    setText($('operate-said'), 'No answer: whether it was done is not known. See the state above and the events.');
    return false;
  } finally {
    busy = false;
    await ask();
  }
}

function onSubmit(id, act) {
  $(id).addEventListener('submit', (event) => {
    event.preventDefault();
    act();
  });
}

export function beginOperate(changed) {
  const orderThen = async (path, body, said, then) => {
    if (await order(path, body, said)) then?.();
    changed();
  };
  onSubmit('operate-login', () => orderThen('/api/v1/login', { token: $('operate-token').value.trim() }, 'Logged in.',
    () => { $('operate-token').value = ''; }));
  onSubmit('operate-start', () => {
    const label = $('operate-label').value.trim();
    orderThen('/api/v1/start', { label }, `Run "${label}" started.`, () => { $('operate-label').value = ''; });
  });
  $('operate-stop').addEventListener('click', () => {
    if (confirm('Stop the run? Its file is closed.')) orderThen('/api/v1/stop', {}, 'Run stopped.');
  });
  $('operate-rearm').addEventListener('click', () => {
    if (confirm('Re-arm? The dwell ends, and a new one settles.')) orderThen('/api/v1/rearm', {}, 'Dwell re-armed.');
  });
  $('operate-logout').addEventListener('click', () => orderThen('/api/v1/logout', {}, 'Logged out.'));
  const renew = async () => {
    await ask();
    changed();
  };
  renew();
  setInterval(renew, ASK_MS);
}

export function showOperate({ health }) {
  const run = health?.run;
  // A wall display has no hands; it logs in where it could not read otherwise.
  show($('operate'), rights.token && !(kiosk && rights.read));
  show($('operate-why'), !rights.read);
  show($('operate-login'), !rights.change);
  show($('operate-acts'), rights.change);
  show($('operate-start'), Boolean(run?.recorded) && run.begun_by !== 'operator');
  show($('operate-stop'), Boolean(run?.begun_by));
}
