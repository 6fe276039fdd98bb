// When the page is drawn: what has changed is drawn together, in some 20 pictures a second. A picture costs the browser
// more than what changes in it, and results, traces and the moving shape would each ask for pictures of their own.

// ms. The screen shows a picture up to 17 ms later, so one comes each 40 to 57 ms. Results and traces come every 50 ms at
// most often: one that comes in between replaces the one before.
const BETWEEN_PICTURES_MS = 40;

const due = new Set();
let planned = false;
let drawn_ms = -Infinity;

function drawAll() {
  planned = false;
  drawn_ms = performance.now();
  const parts = [...due];
  due.clear();
  for (const draw of parts) {
    try {
      draw();
    } catch (error) {
      reportError(error); // the others are drawn all the same
    }
  }
}

// Calls `draw` once in the next picture, however often it was asked for. Nothing is drawn while the page is hidden.
export function inNextPicture(draw) {
  due.add(draw);
  if (planned) return;
  planned = true;
  const wait_ms = drawn_ms + BETWEEN_PICTURES_MS - performance.now();
  if (wait_ms > 0) setTimeout(() => requestAnimationFrame(drawAll), wait_ms);
  else requestAnimationFrame(drawAll);
}
