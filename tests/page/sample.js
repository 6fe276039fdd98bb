// A dwell as the service tells it, for tests of what the page makes of it.
import { Freshness } from '../../daemon/page/freshness.mjs';

export function dwellOf(changes = {}) {
  const coefficient = (value, U95, unit) => ({ value, u: U95 / 2, dof: 1000, U95, significant: true, unit });
  const element = (k, c, r) => ({ k, identifiable: true, stiffness: coefficient(c, c / 1000, 'N/m'),
    damping: coefficient(r, r / 100, 'N*s/m'), budget: [] });
  return { index: 3, state: 'measuring', start_s: 10, settled_s: 12, verdict_s: 12.5, end_s: 22,
    start_utc: '2026-11-23T07:00:00.000000Z', settles_in_s: 0, settling_reason: 'it has decayed',
    frequency_hz: { value: 4.0003, u: 2e-5 }, phasors: [{ channel: 'y0' }, { channel: 'y1' }],
    elements: [element(1, 24000, 60), element(2, 8000, 45)], warnings: [], warned: [], doubts: [], unstated: [], motion: null,
    model: null, since: null, ...changes };
}

// The members of a dwell that warns so. warnings: { kind, text, elements, channels }; the last two may be left out. doubts:
// as in a dwell.
export const warningOf = (warnings, doubts = []) => {
  const all = [...doubts.map(({ what, elements }) => ({ kind: 'doubt', text: what, elements })), ...warnings];
  return { doubts, warnings: all.map(({ text }) => text),
    warned: all.map(({ kind, elements = [], channels = [] }) => ({ kind, elements, channels })) };
};

// What the service says of when numbers are old.
export const OLD_AFTER = { old_after_s: 2.5, old_after_updates: 2.5 };
export function toldFreshness() {
  const fresh = new Freshness();
  fresh.told(OLD_AFTER);
  return fresh;
}

// As dwellOf(), before its transient has decayed.
export const settlingOf = (changes = {}) => dwellOf({ state: 'settling', settled_s: null, verdict_s: null, end_s: 11,
  settles_in_s: 3.24, elements: [], settling_reason: 'transient left in y1: up to 22 times the allowed size',
  ...warningOf([{ kind: 'not settled', text: 'not settled: transient left in y1: up to 22 times the allowed size' }]), ...changes });

export const idleOf = (changes = {}) => settlingOf({ index: null, state: 'idle', settles_in_s: null,
  settling_reason: 'the table does not move', ...warningOf([{ kind: 'not settled', text: 'not settled: the table does not move' }]), ...changes });
