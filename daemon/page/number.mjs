// Numbers for people, as daemon/report/number_text.cpp writes them: value ± U, U with two significant digits and the
// value to match (JCGM 100, 7.2.6), an SI prefix where the unit takes one. What does not exist is "—", never zero.

export const NO_NUMBER = '—';
export const NORMAL_95 = 1.959964; // half width of the 95 % interval of a normal distribution, in u

export const MAX_DIGITS = 15; // what a double carries
const PREFIXED = new Set(['m', 'm/s', 'm/s2', 'rad', 'rad/s', 'rad/s2', 'N', 'N*m', 'N/m', 'N*s/m', 'N*m/rad',
  'N*m*s/rad']);
const PREFIXES = ['p', 'n', 'µ', 'm', '', 'k', 'M', 'G', 'T'];

export const isNumber = (x) => typeof x === 'number' && Number.isFinite(x);

// "N*m*s/rad" as people write it.
export const prettyUnit = (unit) => unit.replaceAll('*', '·').replace(/s2/g, 's²').replace(/^um/, 'µm');

// A number rounded to digits · 10^quantum.
function significant(v, count) {
  const [mantissa, exponent] = Math.abs(v).toExponential(count - 1).split('e');
  return { digits: mantissa.replace('.', ''), quantum: Number(exponent) - (count - 1) };
}
const order = (d) => d.quantum + d.digits.length - 1;
const isZero = (d) => d.digits === '0';

function roundTo(v, quantum) {
  if (v === 0) return { digits: '0', quantum };
  const whole = significant(v, 1 + MAX_DIGITS);
  const count = order(whole) - quantum + 1;
  if (count < 0) return { digits: '0', quantum };
  if (count === 0) return { digits: whole.digits[0] >= '5' ? '1' : '0', quantum };
  const d = significant(v, Math.min(count, MAX_DIGITS + 2));
  // Rounding up may have carried into one more digit.
  while (d.quantum > quantum) {
    d.digits += '0';
    d.quantum -= 1;
  }
  return d;
}

// The digits with the decimal point where 10^power is the unit.
function place(d, power) {
  const decimals = power - d.quantum;
  if (decimals <= 0) return isZero(d) ? '0' : d.digits + '0'.repeat(-decimals);
  const text = d.digits.padStart(decimals + 1, '0');
  return `${text.slice(0, -decimals)}.${text.slice(-decimals)}`;
}

const superscript = (n) => String(n).replace(/[-\d]/g, (c) => (c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[c]));

function choosePower(itsOrder, unit) {
  const thousands = Math.floor(itsOrder / 3);
  const base = prettyUnit(unit);
  if (PREFIXED.has(unit) && Math.abs(thousands) <= 4) return [3 * thousands, PREFIXES[thousands + 4] + base];
  if (itsOrder >= -4 && itsOrder <= 6) return [0, base];
  return [3 * thousands, `×10${superscript(3 * thousands)}${base ? ` ${base}` : ''}`];
}

// { value, u, unit }: what stands before and behind the ±. U: the half width to show; not finite: "—" and six digits of
// the value; 0: ten.
export function numberText(value, U, unit) {
  if (!isNumber(value)) return { value: NO_NUMBER, u: '', unit: '' };
  const byU = isNumber(U) && U > 0;
  const ownOrder = value === 0 ? -400 : order(significant(value, 1 + MAX_DIGITS));
  let quantum = value === 0 ? 0 : ownOrder - (U === 0 ? 9 : 5);
  let u = null;
  let beyond = false;
  if (byU) {
    u = significant(U, 2);
    beyond = ownOrder - u.quantum >= MAX_DIGITS;
    quantum = beyond ? ownOrder - MAX_DIGITS + 1 : u.quantum;
  }
  const v = roundTo(value, quantum);
  let shown = isZero(v) ? 0 : order(v);
  if (u && (isZero(v) || order(u) > shown)) shown = order(u);
  const [power, unitText] = choosePower(shown, unit);
  const text = { value: place(v, power), u: '', unit: unitText };
  if (value < 0 && !isZero(v)) text.value = `-${text.value}`;
  if (!u) text.u = U === 0 ? '0' : NO_NUMBER;
  else if (beyond) text.u = `${u.digits[0]}.${u.digits.slice(1)}e${order(u) - power}`;
  else text.u = place(u, power);
  text.value = text.value.replace('-', '\u2212');
  return text;
}

// { value, unit } of a value without an uncertainty, with so many significant digits.
export function plainParts(value, unit, digits) {
  if (!isNumber(value)) return { value: NO_NUMBER, unit: '' };
  const v = value === 0 ? { digits: '0', quantum: 0 } : significant(value, digits);
  const [power, unitText] = choosePower(isZero(v) ? 0 : order(v), unit);
  return { value: `${value < 0 ? '\u2212' : ''}${place(v, power)}`, unit: unitText };
}

export const plainText = (value, unit, digits) => joined(plainParts(value, unit, digits));

export function joined({ value, u, unit }) {
  return `${value}${u ? ` ± ${u}` : ''}${unit ? ` ${unit}` : ''}`;
}

export const percentText = (part) => (isNumber(part) ? `${Number((100 * part).toPrecision(2))} %` : NO_NUMBER);

export const secondsText = (s, decimals = 1) => (isNumber(s) ? `${s.toFixed(decimals)} s` : NO_NUMBER);

// An instant of this computer's time zone; with the date where that is not today's: a page is open for days.
export function instantText(ms, nowMs) {
  if (!isNumber(ms)) return NO_NUMBER;
  const at = new Date(ms);
  const today = at.toDateString() === new Date(nowMs).toDateString();
  return today ? at.toLocaleTimeString('en-GB') : at.toLocaleString('en-GB', { dateStyle: 'short', timeStyle: 'medium' });
}

// "0.3 s", "778 s", "21 min", "5 h", "3 d": how old something is, as people say it; as dwellctl watch does.
export function ageText(s) {
  if (!isNumber(s)) return NO_NUMBER;
  const age = Math.max(0, s);
  if (age < 9.95) return secondsText(age, 1);
  if (age < 1000) return `${Math.floor(age)} s`;
  if (age < 7200) return `${Math.floor(age / 60)} min`;
  if (age < 172800) return `${Math.floor(age / 3600)} h`;
  return `${Math.floor(age / 86400)} d`;
}
