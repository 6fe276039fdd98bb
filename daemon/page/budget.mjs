// Where the uncertainty of a coefficient comes from, and what to do about the largest part. Pure.
import { isNumber } from './number.mjs';

const SHOWN = 5;

// What an operator can do; the first pattern that fits.
const ADVICE = [
  [/^noise/, 'measure longer'],
  [/^scale of (.+)$/, 'calibrate the scale of $1'],
  [/^(?:delay of|turnaround of) (.+)$/, 'measure the delay of $1'],
  [/^(?:low-?pass|high-?pass|filter).* (?:of|in) (.+)$/, 'state the filter of $1 more exactly'],
  [/^mass (.+)$/, 'weigh mass $1 more exactly'],
  [/^clock rate$/, 'have the clock of this computer synchronized'],
  [/^frequency$/, 'state the frequency of the drive more exactly'],
  [/^transient left/, 'let it settle longer'],
];

export function adviceOn(source) {
  for (const [pattern, text] of ADVICE) {
    const match = source.match(pattern);
    if (match) return text.replace('$1', match[1]);
  }
  return `look at: ${source}`;
}

// { bars: [{ source, share }], advice }: the largest parts of the variance, noise of all channels as one. share: of
// 'stiffness' or 'damping'.
export function budgetOf(element, coefficient) {
  const parts = new Map();
  for (const entry of element.budget ?? []) {
    const share = entry[`${coefficient}_share`];
    const source = entry.source.startsWith('noise of ') ? 'noise of all channels' : entry.source;
    if (isNumber(share)) parts.set(source, (parts.get(source) ?? 0) + share);
  }
  const bars = [...parts].map(([source, share]) => ({ source, share })).filter((bar) => bar.share >= 0.005)
    .sort((a, b) => b.share - a.share).slice(0, SHOWN);
  return { bars, advice: bars.length ? adviceOn(bars[0].source) : null };
}
