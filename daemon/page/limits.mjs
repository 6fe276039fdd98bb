// What is said of a limit of the rig file: by value ± U95, as the service judged it. Pure.
import { isNumber, joined, MAX_DIGITS, plainParts } from './number.mjs';

// Each verdict has a word and a shape; a colour only the one that is abnormal.
export const SHAPES = { kept: '✓', undecided: '◇', violated: '▲', none: '–' };

// At least these digits of a bound; more until the text is the bound: a rounded one would look kept, or violated, where
// it is not.
const LEAST_DIGITS = 4;
function boundParts(bound, unit) {
  let digits = LEAST_DIGITS;
  while (digits < MAX_DIGITS && Number(bound.toPrecision(digits)) !== bound) ++digits;
  return plainParts(bound, unit, digits);
}

// A limit may have one end: the other is null.
const end = ({ low, high, unit }) => joined(boundParts(low ?? high, unit));

function boundsText(limit) {
  const { low, high, unit } = limit;
  if (low === null) return `at most ${end(limit)}`;
  if (high === null) return `at least ${end(limit)}`;
  const [a, b] = [boundParts(low, unit), boundParts(high, unit)];
  return `${a.unit === b.unit ? a.value : joined(a)} to ${joined(b)}`;
}

// A doubt stands in full once, above the numbers or beside the element.
const shortReason = ({ doubted, reason }) => (doubted ? 'the number must not be relied on' : reason);

// Of the coefficient (key: "stiffness", "damping") of element k; null: it has no limit, or it has no number to be held
// against it.
export function limitOf(dwell, key, k) {
  const limit = (dwell.limits ?? []).find((l) => l.element === k && l.coefficient === key);
  if (!limit || !isNumber(limit.low ?? limit.high)) return null;
  const bounds = boundsText(limit);
  const oneEnd = limit.low === null || limit.high === null;
  const words = {
    kept: `limit kept: ${bounds}`,
    // The bounds first: a wall display cuts a long line at its end.
    undecided: oneEnd ? `limit undecided: ± reaches over ${end(limit)}` : `limit undecided, ${bounds}: ± reaches over an end`,
    violated: `limit violated: ${oneEnd ? 'not' : 'outside'} ${bounds}`,
    none: `no verdict on the limit${oneEnd ? ' of' : ''} ${bounds}: ${shortReason(limit)}`,
  };
  return { verdict: limit.verdict, text: `${SHAPES[limit.verdict]} ${words[limit.verdict]}` };
}
