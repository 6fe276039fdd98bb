// Orders to the service over HTTP, and what is said of them.

const ANSWER_MS = 8000; // then an order is given up; the service answers a start after 5 s at the latest

// Gives an order. Resolves to the service's answer, { done: true } and more; { error }: why it was not done; null: no
// answer came, so it is not known.
export async function give(path, body) {
  try {
    const answer = await fetch(path, { method: 'POST', signal: AbortSignal.timeout(ANSWER_MS),
      headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
    const told = await answer.json();
    return answer.ok ? told : { error: told.error ?? `status ${answer.status}` };
  } catch {
    return null;
  }
}

// Disables the buttons until `work` has ended. One that had the focus loses it by that, and gets it back.
export async function whileDisabled(buttons, work) {
  const focused = document.activeElement;
  for (const button of buttons) button.disabled = true;
  try {
    return await work();
  } finally {
    for (const button of buttons) button.disabled = false;
    if (document.activeElement === document.body && buttons.includes(focused)) focused.focus({ preventScroll: true });
  }
}

// note: { text, failed, at_s }, what became of an order; null: nothing to say. That it was done is said for NOTE_S, long
// enough to be read: the page shows the change from then on. Why it was not stays until the next order.
const NOTE_S = 10;
export const noteText = (note, now) => (note && (note.failed || now - note.at_s < NOTE_S) ? note.text : '');
