// The shape of the chain from its phasors; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { barOf, displacedAt, fullestPart, modeShapeOf, reachOf } from '../../daemon/page/mode_shape.mjs';

const f = 1 / (2 * Math.PI); // ω = 1
const phasor = (channel, amplitude, phase_rad, unit = 'm') => ({ channel, unit, amplitude, phase_rad, valid: true, harmonics: [] });
const channel = (name, at, measures = 'displacement', relative_to = null) => ({ name, at, measures, relative_to });
const dwellOf = (phasors, elements = 0) => ({ frequency_hz: { value: f }, phasors, elements: Array.from({ length: elements }) });
const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-12, `${a} is not ${b}`);

test('each mass is where its phasor says, in phase with the table or against it', () => {
  const shape = modeShapeOf(dwellOf([phasor('y0', 2, 0.5), phasor('y1', 4, 0.5 + Math.PI)]), [channel('y0', 0), channel('y1', 1)]);
  const [table, mass] = displacedAt(shape, 0.25);
  near(table, 2);
  near(mass, -4);
  assert.equal(reachOf(shape), 4);
});

test('velocity and acceleration tell of the same motion', () => {
  const shape = modeShapeOf(dwellOf([phasor('y0', 1, 0), phasor('v1', 1, Math.PI / 2, 'm/s'), phasor('a2', 1, Math.PI, 'm/s2')]),
    [channel('y0', 0), channel('v1', 1, 'velocity'), channel('a2', 2, 'acceleration')]);
  for (const d of displacedAt(shape, 0.1)) near(d, Math.sin(0.2 * Math.PI));
});

test('a channel across an element adds to the place it is relative to', () => {
  const shape = modeShapeOf(dwellOf([phasor('d2', 1, 0), phasor('d1', 1, 0), phasor('y0', 1, 0)]),
    [channel('d2', 2, 'displacement', 1), channel('d1', 1, 'displacement', 0), channel('y0', 0)]);
  displacedAt(shape, 0.25).forEach((d, at) => near(d, at + 1));
});

test('a mass that no channel tells of is not known, and forces say nothing of motion', () => {
  const shape = modeShapeOf(dwellOf([phasor('y0', 1, 0), phasor('reaction', 9, 0, 'N')], 3),
    [channel('y0', 0), channel('reaction', 'ground', 'force')]);
  assert.equal(shape.clamped, true);
  assert.deepEqual(shape.nodes.map((n) => n.known), [true, false, false]);
  assert.equal(modeShapeOf(dwellOf([phasor('reaction', 9, 0, 'N')]), [channel('reaction', 'ground', 'force')]), null);
});

test('it stands at the greatest deflection of what moves most, whatever its phase to the table', () => {
  for (const phase of [0, Math.PI / 2, 2, -2]) {
    const shape = modeShapeOf(dwellOf([phasor('y0', 1, 0.3), phasor('y1', 9, 0.3 + phase)]), [channel('y0', 0), channel('y1', 1)]);
    near(displacedAt(shape, fullestPart(shape))[1], 9);
  }
});

test('the scale bar is a round length within the largest displacement', () => {
  for (const [reach, bar] of [[0.0123, 0.01], [0.00499, 0.002], [5, 5], [7e-6, 5e-6]]) near(barOf(reach), bar);
});
