#include "config/observability.hpp"

#include <cstddef>

namespace dwell::config {

std::vector<int> undetermined_places(int masses, const std::vector<Transducer>& transducers) {
  const std::size_t places = static_cast<std::size_t>(masses) + 1;
  const auto in_chain = [&](int place) { return place >= 0 && place <= masses; };
  std::vector<std::vector<std::size_t>> neighbours(places);
  std::vector<bool> known(places, false);
  std::vector<std::size_t> reached;
  const auto reach = [&](std::size_t place) {
    if (known[place]) return;
    known[place] = true;
    reached.push_back(place);
  };
  for (const Transducer& transducer : transducers) {
    if (!in_chain(transducer.at)) continue;
    const auto at = static_cast<std::size_t>(transducer.at);
    if (!transducer.relative_to) {
      reach(at);
    } else if (in_chain(*transducer.relative_to)) {
      const auto from = static_cast<std::size_t>(*transducer.relative_to);
      neighbours[at].push_back(from);
      neighbours[from].push_back(at);
    }
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const std::size_t next : neighbours[reached[i]]) reach(next);
  }
  std::vector<int> missing;
  for (std::size_t place = 0; place < places; ++place) {
    if (!known[place]) missing.push_back(static_cast<int>(place));
  }
  return missing;
}

}  // namespace dwell::config
