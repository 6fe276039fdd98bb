// Text from outside on the page; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readable, setText } from '../../daemon/page/dom.mjs';

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
