// Numbers on the page are rounded as dwellctl rounds them (tests/ctl/number_text_test.cpp has the same cases).
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ageText, joined, numberText, percentText, plainText, prettyUnit, secondsText } from '../../daemon/page/number.mjs';

const shown = (value, U, unit = '') => joined(numberText(value, U, unit)).replaceAll('\u2212', '-');

test('the uncertainty has two digits and the value matches', () => {
  assert.equal(shown(24010.4, 27.4, 'N/m'), '24.010 ± 0.027 kN/m');
  assert.equal(shown(60.2163, 0.7912, 'N*s/m'), '60.22 ± 0.79 N·s/m');
  assert.equal(shown(0.005, 1.96e-7, 'm'), '5.00000 ± 0.00020 mm');
  assert.equal(shown(4.0003, 3.9e-5, 'Hz'), '4.000300 ± 0.000039 Hz');
});

test('rounding carries over at decade borders', () => {
  assert.equal(shown(123.4, 9.96), '123 ± 10');
  assert.equal(shown(123.4, 9.94), '123.4 ± 9.9');
  assert.equal(shown(12.3456, 0.0996), '12.35 ± 0.10');
  assert.equal(shown(12346, 99.6, 'N'), '12.35 ± 0.10 kN');
  assert.equal(shown(999.97, 1.2, 'N'), '1.0000 ± 0.0012 kN');
  assert.equal(shown(460, 996, 'N'), '0.5 ± 1.0 kN');
});

test('a value smaller than its uncertainty keeps the quantum', () => {
  assert.equal(shown(0.04, 0.79, 'N*s/m'), '40 ± 790 mN·s/m');
  assert.equal(shown(0.0049, 0.79), '0.00 ± 0.79');
  assert.equal(shown(-0.0049, 0.79), '0.00 ± 0.79');
  assert.equal(shown(-0.0051, 0.79), '-0.01 ± 0.79');
  assert.equal(shown(4.96, 996), '0 ± 1000');
});

test('what does not exist is a dash, and zero is a number', () => {
  assert.equal(shown(null, 0.1, 'm'), '—');
  assert.equal(shown(Infinity, 0.1, 'm'), '—');
  assert.equal(shown(1.25, null, 'N'), '1.25000 ± — N');
  assert.equal(shown(0, 0, 'm'), '0 ± 0 m');
  assert.equal(shown(0, 0.012, 'm'), '0 ± 12 mm');
  assert.equal(shown(1.5, 0), '1.500000000 ± 0');
  assert.equal(percentText(null), '—');
  assert.equal(secondsText(null), '—');
  assert.equal(ageText(NaN), '—');
});

test('huge and tiny numbers stay readable', () => {
  assert.equal(shown(1.5e20, 2.5e18, 'N/m'), '150.0 ± 2.5 ×10¹⁸ N/m');
  assert.equal(shown(1.5e-20, 2.5e-22), '15.00 ± 0.25 ×10⁻²¹');
  assert.equal(shown(1, 1e-300), '1.00000000000000 ± 1.0e-300');
});

test('without an uncertainty the digits are those asked for', () => {
  assert.equal(plainText(3.967030597, 'Hz', 4), '3.967 Hz');
  assert.equal(plainText(0.00044444, 'm', 3), '444 µm');
  assert.equal(plainText(0, 'm', 3), '0 m');
});

test('units and ages are as people write them', () => {
  assert.equal(prettyUnit('N*m*s/rad'), 'N·m·s/rad');
  assert.equal(prettyUnit('m/s2'), 'm/s²');
  assert.equal(prettyUnit('um'), 'µm');
  for (const [s, text] of [[-1, '0.0 s'], [9.94, '9.9 s'], [9.95, '9 s'], [778, '778 s'], [1300, '21 min'], [20000, '5 h'],
    [300000, '3 d']]) assert.equal(ageText(s), text);
});
