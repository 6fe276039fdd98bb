// A rig of two displacement transducers, one on the table and one on the mass behind it, driven at 4 Hz.
#pragma once

#include "core/rig/rig.hpp"

namespace dwell {

inline Rig table_and_mass() {
  Rig rig;
  rig.excitation.frequency_hz = 4.0;
  rig.excitation.search_low_hz = 3.8;
  rig.excitation.search_high_hz = 4.2;
  rig.excitation.harmonics = 2;
  for (const int at : {0, 1}) {
    Channel channel;
    channel.name = at == 0 ? "table" : "y1";
    channel.at = at;
    rig.channels.push_back(channel);
  }
  return rig;
}

}  // namespace dwell
