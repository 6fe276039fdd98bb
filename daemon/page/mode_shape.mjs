// The chain as it moves at the drive frequency, from the phasors: where each mass is, relative to the others. Pure.
import { isNumber } from './number.mjs';

const QUANTITIES = ['displacement', 'velocity', 'acceleration'];
const PER_TIME = ['', '/s', '/s2']; // at the end of their units

const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];

// The complex displacement that a phasor tells of, relative to phase 0 of the first one.
function motionOf(phasor, channel, omega, reference_rad) {
  const order = QUANTITIES.indexOf(channel.measures);
  const phase = phasor.phase_rad - reference_rad;
  let motion = [phasor.amplitude * Math.cos(phase), phasor.amplitude * Math.sin(phase)];
  for (let i = 0; i < order; ++i) motion = times(motion, [0, -1 / omega]); // 1 / jω
  return motion;
}

// { unit, clamped, nodes: [{ at, known, motion: [re, im] }] }, from the table (at 0) to the last mass; null: nothing to
// show. A mass that no channel tells of is not known. channels: of /api/v1/channels.
export function modeShapeOf(dwell, channels) {
  const f = dwell.frequency_hz?.value;
  const about = new Map(channels.map((c) => [c.name, c]));
  const told = dwell.phasors.map((p) => ({ p, c: about.get(p.channel) })).filter(({ p, c }) => p.valid && c && QUANTITIES.includes(c.measures));
  if (!isNumber(f) || told.length === 0) return null;
  const omega = 2 * Math.PI * f;
  const reference = told[0].p.phase_rad;
  const motions = new Map();
  for (const { p, c } of told)
    if (c.relative_to === null && !motions.has(c.at)) motions.set(c.at, motionOf(p, c, omega, reference));
  // Channels across an element: as often as one more place becomes known.
  for (let more = true; more;) {
    more = false;
    for (const { p, c } of told) {
      if (c.relative_to === null || motions.has(c.at) || !motions.has(c.relative_to)) continue;
      motions.set(c.at, plus(motions.get(c.relative_to), motionOf(p, c, omega, reference)));
      more = true;
    }
  }
  const clamped = channels.some((c) => c.at === 'ground');
  const last = Math.max(dwell.elements.length - (clamped ? 1 : 0), ...channels.map((c) => (isNumber(c.at) ? c.at : 0)));
  const nodes = Array.from({ length: last + 1 }, (_, at) => ({ at, known: motions.has(at), motion: motions.get(at) ?? [0, 0] }));
  const [{ p, c }] = told;
  const unit = p.unit.slice(0, p.unit.length - PER_TIME[QUANTITIES.indexOf(c.measures)].length);
  return { unit, clamped, frequency_hz: f, nodes };
}

// The largest displacement of a shape.
export const reachOf = (shape) => Math.max(...shape.nodes.map((n) => Math.hypot(...n.motion)));

// The displacement of each node at a part (0 … 1) of the period.
export function displacedAt(shape, part) {
  const [c, s] = [Math.cos(2 * Math.PI * part), Math.sin(2 * Math.PI * part)];
  return shape.nodes.map((n) => n.motion[0] * s + n.motion[1] * c);
}

// The part of the period at which the mass that moves most is at its greatest deflection.
export function fullestPart(shape) {
  const [re, im] = shape.nodes.map((n) => n.motion).reduce((most, m) => (Math.hypot(...m) > Math.hypot(...most) ? m : most));
  const part = Math.atan2(re, im) / (2 * Math.PI);
  return part < 0 ? part + 1 : part;
}

// The length of a scale bar: 1, 2 or 5 · 10^n, at most the reach.
export function barOf(reach) {
  const power = 10 ** Math.floor(Math.log10(reach));
  return power * [5, 2, 1].find((step) => step * power <= reach * 1.000001);
}
