// Acting on the rig from the page: logging in with the token, starting, labelling and stopping runs, re-arming the dwell.
// It is there only where the service takes orders over HTTP, or asks for the token before anything may be read.
import { setText, show } from './dom.mjs';
import { give, noteText, whileDisabled } from './order.mjs';

const ASK_MS = 10_000; // a session that has ended is noticed so soon
const ANSWER_MS = 5000; // then the question for the rights is given up

const $ = (id) => document.getElementById(id);
const kiosk = new URLSearchParams(location.search).has('kiosk');

// What this browser may; until the service has said it, nothing is offered.
let rights = { read: true, change: false, token: false };
let busy = false; // an order is under way: one at a time
let said = null; // on the newest order, as noteText takes it
let now_s = 0;
let lost = false; // who was logged in no longer is, without having logged out: to be said
let leaving = false; // … he is logging out

let newest = 0; // question; the answer to an older one may be of before a login
async function ask() {
  const question = ++newest;
  try {
    const answer = await fetch('/api/v1/rights', { signal: AbortSignal.timeout(ANSWER_MS), cache: 'no-store' });
    const told = answer.ok ? await answer.json() : rights;
    if (question !== newest) return;
    lost = rights.change && told.token && !told.change && !leaving;
    rights = told;
  } catch {
    // The first line says that the service does not answer.
  }
}

// What this page may, as /api/v1/rights tells it.
export const rightsNow = () => rights;

function say(text, failed = false) {
  said = { text, failed, at_s: now_s };
  setText($('operate-said'), text);
}

// Gives the order and says what became of it. True: it is done.
async function order(path, body, done) {
  if (busy) return false;
  busy = true;
  say('');
  const answer = await whileDisabled([...$('operate').querySelectorAll('button')], () => give(path, body));
  busy = false;
  if (answer === null) say('No answer: whether it was done is not known. See the state above and the events.', true);
  else if (!answer.done) say(`Not done: ${answer.error}`, true);
  else if (answer.recording === null) say(`${done} Whether it is recorded is not known yet: see the state above.`, true);
  else say(done);
  await ask();
  return Boolean(answer?.done);
}

function onSubmit(id, act) {
  $(id).addEventListener('submit', (event) => {
    event.preventDefault();
    act(event.submitter?.id);
  });
}

// changed: called when something came of it. loggedIn: when somebody has logged in.
export function beginOperate(changed, loggedIn) {
  const orderThen = async (path, body, done, then) => {
    if (await order(path, body, done)) then?.();
    changed();
  };
  onSubmit('operate-login', () => orderThen('/api/v1/login', { token: $('operate-token').value.trim() }, 'Logged in.',
    () => {
      $('operate-token').value = '';
      loggedIn();
    }));
  // The Enter key presses the first button, also where that is hidden.
  onSubmit('operate-start', (button) => {
    const label = $('operate-label').value.trim();
    if (label === '') {
      say('Not done: a label is needed. Say in a few words what is measured.', true);
      $('operate-label').focus();
      return;
    }
    const relabel = button === 'operate-relabel' || $('operate-begin').hidden;
    const [path, done] = relabel ? ['/api/v1/label', `The run is "${label}" now.`] : ['/api/v1/start', `Run "${label}" started.`];
    orderThen(path, { label }, done, () => { $('operate-label').value = ''; });
  });
  $('operate-stop').addEventListener('click', () => {
    if (confirm('Stop the run? Its file is closed.')) orderThen('/api/v1/stop', {}, 'Run stopped.');
  });
  $('operate-rearm').addEventListener('click', () => {
    if (confirm('Re-arm? The dwell ends, and a new one settles.')) orderThen('/api/v1/rearm', {}, 'Dwell re-armed.');
  });
  $('operate-logout').addEventListener('click', () => {
    leaving = true;
    orderThen('/api/v1/logout', {}, 'Logged out.', () => location.reload()); // what was read with the token is no longer there for whoever comes next
  });
  const renew = async () => {
    await ask();
    changed();
  };
  renew();
  setInterval(renew, ASK_MS);
}

// Whether the page has its button to start a run now.
export const startsHere = ({ health, refused }) => rights.token && rights.change && !refused && !kiosk && Boolean(health?.run?.recorded) &&
  health.run.begun_by !== 'operator';

export function showOperate({ health, refused, now, anew }) {
  now_s = now;
  if (lost && !refused) say(`${anew ? 'The service was started anew' : 'The login has ended'}: log in again.`, true);
  lost = false;
  setText($('operate-said'), noteText(said, now));
  const [read, change] = [rights.read && !refused, rights.change && !refused];
  const run = health?.run;
  // A wall display has no hands; it logs in where it could not read otherwise.
  show($('operate'), rights.token && !(kiosk && read));
  $('operate').classList.toggle('first', !read); // nothing else can be done
  show($('operate-why'), !read);
  show($('operate-login'), !change);
  show($('operate-acts'), change);
  const [begin, relabel] = [startsHere({ health, refused }), Boolean(run?.recorded && run.begun_by)];
  show($('operate-start'), begin || relabel);
  show($('operate-begin'), begin);
  show($('operate-relabel'), relabel);
  show($('operate-stop'), Boolean(run?.begun_by));
}
