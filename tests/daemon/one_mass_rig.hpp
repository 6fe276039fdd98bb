// A small rig for tests of what surrounds the pipeline: one mass of 2 kg, driven at 10 Hz; a channel on the table and
// one on the mass, both of displacement, m.
#pragma once

#include "core/rig/rig.hpp"

namespace dwell::test {

inline Rig one_mass_rig() {
  Rig rig;
  rig.masses = {2.0};
  rig.excitation.frequency_hz = 10.0;
  rig.excitation.search_low_hz = 9.8;
  rig.excitation.search_high_hz = 10.2;
  rig.excitation.minimum = 1e-5;
  for (int at = 0; at < 2; ++at) rig.channels.emplace_back().at = at;
  return rig;
}

}  // namespace dwell::test
