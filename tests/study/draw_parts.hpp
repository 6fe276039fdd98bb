// The parts of draw(): chains, transducers, drives, sampling, disturbances. Internal to the study.
#pragma once

#include "tests/study/case.hpp"

namespace dwell::study {

// n = 1 … most, both boundaries; every mode's damping ratio within 0.3 … 20 %; the drive anywhere against the modes:
// about one, within 1 % of one, far above the slowest, or where a mass is a node. Needs frequency_hz; fills chain and
// what the rig file says of it.
void draw_chain(Draws& draws, Case& about, int most = 6);

// A displacement transducer on the table and a transducer on every mass, some of them across an element or of another
// quantity, and a load cell if clamped: fills rig.channels, sensors, and lines yet
// without anything.
void draw_channels(Draws& draws, Case& about);

// What the rig file says of the drive, the true frequency being off nominal by this part (0: it is given as `fixed`).
void draw_drive_settings(Draws& draws, Case& about, double from_nominal);

// Fundamental and, in half of the rigs, harmonics as a shaker makes them.
[[nodiscard]] TableMotion draw_table(Draws& draws, double frequency_hz, int harmonics);

// The rig file states what is meant; the rig is off by an error of the stated uncertainty.
void draw_type_b(Draws& draws, Case& about);

// fewest … most samples a period, skewed and irregular; needs the motion.
void draw_sampling(Draws& draws, Case& about, double fewest, double most);

// White noise and the disturbances of the case's population; needs motion and sampling.
void draw_noise(Draws& draws, Case& about, double table_amplitude);

// From rest, from any state, or after a change of a drive before; fills the motion.
void draw_motion(Draws& draws, Case& about, const TableMotion& table);

// A healthy rig, and then a kind of disturbance by the dwell's index (every kind is as frequent), sometimes a second.
void draw_disturbed(Draws& draws, Case& about);

// The populations that do not begin with a transient: an element that hardly deforms; steps and stop of the drive;
// hours of it; three periods between ramps.
void draw_stiff(Draws& draws, Case& about);
void draw_step(Draws& draws, Case& about);
void draw_hours(Draws& draws, Case& about);
void draw_ramps(Draws& draws, Case& about);

// One that begins with a transient, driven at a natural frequency.
void draw_resonance(Draws& draws, Case& about);

// One that is knocked again and again before it has settled, and then no more.
void draw_knocks(Draws& draws, Case& about);

}  // namespace dwell::study
