// Where the uncertainty of a coefficient comes from, and what to do about the largest part. Pure.
import { isNumber } from './number.mjs';

const SHOWN = 5;

// What an operator can do, by the kind of the source.
const ADVICE = {
  noise: () => 'measure longer',
  scale: ({ channel }) => `calibrate the scale of ${channel}`,
  refresh: ({ channel }) => `have ${channel} refreshed more often`,
  delay: ({ channel, device }) => `measure the delay of ${channel ?? device}`,
  turnaround: ({ device }) => `measure the delay of ${device}`,
  'low-pass': ({ channel }) => `state the filter of ${channel} more exactly`,
  'high-pass': ({ channel }) => `state the filter of ${channel} more exactly`,
  mass: ({ mass }) => `weigh mass ${mass} more exactly`,
  'clock rate': () => 'have the clock of this computer synchronized',
  frequency: () => 'state the frequency of the drive more exactly',
  'transient left': () => 'let it settle longer',
};

// share: an entry of a budget.
export const adviceOn = (share) => ADVICE[share.kind]?.(share) ?? `look at: ${share.source}`;

// { bars: [{ source, share }], advice }: the largest parts of the variance, noise of all channels as one. share: of
// 'stiffness' or 'damping'.
export function budgetOf(element, coefficient) {
  const parts = new Map();
  for (const entry of element.budget ?? []) {
    const share = entry[`${coefficient}_share`];
    if (!isNumber(share)) continue;
    const source = entry.kind === 'noise' ? 'noise of all channels' : entry.source;
    parts.set(source, { ...entry, source, share: (parts.get(source)?.share ?? 0) + share });
  }
  const bars = [...parts.values()].filter((bar) => bar.share >= 0.005).sort((a, b) => b.share - a.share).slice(0, SHOWN);
  return { bars: bars.map(({ source, share }) => ({ source, share })), advice: bars.length ? adviceOn(bars[0]) : null };
}
