// A screen of watch to be looked at: a measured chain, and what is drawn of it.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/watch_page.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::test {

// A chain of n elements that is measured, with n displacements and a load cell.
inline DwellView chain(int n) {
  Rig rig;
  rig.masses.assign(static_cast<std::size_t>(n - 1), 1.0);
  Dwell d = sample_dwell();
  d.phasors.assign(static_cast<std::size_t>(n) + 1, d.phasors.front());
  d.elements.assign(static_cast<std::size_t>(n), d.elements.front());
  d.warnings.clear();
  for (int k = 1; k <= n; ++k) {
    d.elements[static_cast<std::size_t>(k - 1)].k = k;
    d.elements[static_cast<std::size_t>(k - 1)].stiffness.value += k;
    Channel y;
    y.name = "y" + std::to_string(k - 1);
    rig.channels.push_back(y);
  }
  Channel force;
  force.name = "reaction";
  force.measures = Quantity::force;
  rig.channels.push_back(force);
  return make_view(d, rig, sample_run());
}

inline ctl::WatchState watched(DwellView view) {
  ctl::WatchState state;
  state.name = "bench 2";
  state.take(std::move(view), 100.0);
  return state;
}

inline std::string text_of(const ctl::Page& page) {
  std::string text;
  for (const TextLine& line : page.lines) text += line.text + "\n";
  return text;
}

inline ctl::Page at(const ctl::WatchState& state, const ctl::Controls& controls, ctl::Size size, double now_s = 100.1) {
  return ctl::draw(state, controls, nullptr, size, now_s, "14:03:22");
}

inline std::vector<ctl::Page> all_pages(const ctl::WatchState& state, ctl::Size size, double now_s = 100.1) {
  std::vector<ctl::Page> pages;
  ctl::Controls controls;
  do {
    pages.push_back(at(state, controls, size, now_s));
    EXPECT_EQ(pages.back().page, controls.page);
  } while (++controls.page < pages.back().pages);
  return pages;
}

inline constexpr ctl::Size kUsual{24, 80};

}  // namespace dwell::test
