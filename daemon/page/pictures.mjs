// When what has changed is drawn: all of it together, in some 20 pictures a second. A picture costs the browser more
// than what changes in it, and results, traces and the moving shape would each ask for pictures of their own.

// ms between two pictures. Results and traces come every 50 ms at most often, and a picture waits for the screen, up to
// 17 ms: so every result is drawn, and the traces that come beside it are in the same picture.
const LEAST_MS = 40;

const due = new Set();
let planned = false;
let newest_ms = -Infinity;

function drawAll() {
  planned = false;
  newest_ms = performance.now();
  const parts = [...due];
  due.clear();
  for (const draw of parts) draw();
}

// draw is called once with the next picture, however often it asks before; not while nobody sees the page.
export function inNextPicture(draw) {
  due.add(draw);
  if (planned) return;
  planned = true;
  const wait_ms = newest_ms + LEAST_MS - performance.now();
  if (wait_ms > 0) setTimeout(() => requestAnimationFrame(drawAll), wait_ms);
  else requestAnimationFrame(drawAll);
}
