// The little that the page needs to build and renew its elements. Text enters as text, never as markup. What has not
// changed is not touched: ten renewals a second must cost next to nothing.

const SVG = 'http://www.w3.org/2000/svg';

// The controls of core/base/printable.hpp without tab and newline. Each becomes U+FFFD. With those of the writing
// direction (UAX #9) a name from outside could show its letters, and the text beside it, in another order.
const CONTROLS = /[\u0000-\u0008\u000b-\u001f\u007f-\u009f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;
export const readable = (text) => String(text ?? '').replace(CONTROLS, '\ufffd');

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) node.setAttribute(name, value);
  node.append(...children.filter((child) => child !== null).map((child) => (typeof child === 'string' ? readable(child) : child)));
  return node;
}

export const h = (tag, attributes, ...children) => fill(document.createElement(tag), attributes, children);
export const s = (tag, attributes, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);

// The head of a table's row: a name, which may be long.
export const rowHead = (text = '') => h('th', { scope: 'row' }, h('span', { class: 'label' }, text));

export function setText(node, given) {
  const text = readable(given);
  const only = node.childNodes.length === 1 && node.firstChild.nodeType === Node.TEXT_NODE ? node.firstChild : null;
  if (only) {
    if (only.data !== text) only.data = text;
  } else if (node.childNodes.length > 0 || text !== '') {
    node.textContent = text;
  }
}

export function setAttributes(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    const text = String(value);
    if (node.getAttribute(name) !== text) node.setAttribute(name, text);
  }
}

export function show(node, on) {
  if (node.hasAttribute('hidden') === on) node.toggleAttribute('hidden', !on); // SVG has no property of that name
}

// One child of `parent` for each item, in their order: made anew for a key that has come, renewed where the key stays.
const kept = new WeakMap();
export function keyed(parent, items, keyOf, make, renew) {
  const before = kept.get(parent) ?? new Map();
  const now = new Map();
  let at = parent.firstChild;
  const focused = parent.contains(document.activeElement) ? document.activeElement : null;
  for (const item of items) {
    let key = keyOf(item);
    while (now.has(key)) key += '\'';
    const node = before.get(key) ?? make(item);
    before.delete(key);
    now.set(key, node);
    if (node === at) at = at.nextSibling;
    else parent.insertBefore(node, at);
    renew?.(node, item);
  }
  for (const node of before.values()) node.remove();
  kept.set(parent, now);
  // A node that is moved loses the focus, although it stays.
  if (focused?.isConnected && document.activeElement !== focused) focused.focus({ preventScroll: true });
}

// Draws at most `times` a second: nobody reads a table faster, and ten times a second it would be most of the load. The
// first answers are drawn at once.
export function atMost(times, draw) {
  let last = null; // none before the first answers
  return (view) => {
    const turn = view.channels === null ? null : Math.floor(times * view.now);
    if (turn !== null && turn === last) return;
    last = turn;
    draw(view);
  };
}
