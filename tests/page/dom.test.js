// Text from outside on the page; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { atMost, readable, setText } from '../../daemon/page/dom.mjs';

test('a name from outside cannot turn the writing direction of the text beside it', () => {
  for (const code of [0x061c, 0x200e, 0x200f, 0x202a, 0x202e, 0x2066, 0x2069, 0x1b, 0x9b])
    assert.equal(readable(`a${String.fromCodePoint(code)}b`), 'a\ufffdb', code.toString(16));
  const node = { childNodes: [], textContent: '' };
  setText(node, 'channel y1: \u202etimeout');
  assert.equal(node.textContent, 'channel y1: \ufffdtimeout');
});

test('text in any language stays as it is', () => {
  const text = 'µm ± 0.1 · 1\u202f234 \u2212 שלום 日本 👍\u200d';
  assert.equal(readable(text), text);
  assert.equal(readable(null), '');
});

test('a table is drawn at most so many times a second, but at once when the first answers come', () => {
  const drawn = [];
  const show = atMost(1, (view) => drawn.push(view.now));
  for (const now of [5.1, 5.2]) show({ now, channels: null });
  for (const now of [5.3, 5.4, 5.9, 6, 6.5]) show({ now, channels: [] });
  assert.deepEqual(drawn, [5.1, 5.2, 5.3, 6]);
});
