// Lines of a chip that is not there: tests move the inputs and see the lamps.
#pragma once

#include <deque>
#include <map>
#include <string>

#include "daemon/gpio/line.hpp"

namespace dwell::gpio {

struct FakeLine {
  bool level = false;
  std::deque<LineEdge> edges;
  std::string fault;    // what every call answers; empty: works
  bool held = false;    // by the service
  bool rising = false;  // only rising edges were asked for

  void edge(std::int64_t t_ns, bool to, bool gap = false) {
    level = to;
    edges.push_back({t_ns, to, gap});
  }
};

class FakeLines : public LineSource {
 public:
  FakeLine& operator[](unsigned line) { return lines_[line]; }

  tl::expected<std::unique_ptr<InputLine>, std::string> input(const config::GpioLine& line, Edges edges) override {
    FakeLine& fake = lines_[line.line];
    if (!fake.fault.empty()) return tl::unexpected(fake.fault);
    fake.rising = edges == Edges::rising;
    return std::make_unique<Input>(fake);
  }
  tl::expected<std::unique_ptr<OutputLine>, std::string> output(const config::GpioLine& line, bool level) override {
    FakeLine& fake = lines_[line.line];
    if (!fake.fault.empty()) return tl::unexpected(fake.fault);
    fake.level = level;
    return std::make_unique<Output>(fake);
  }

 private:
  struct Hold {
    explicit Hold(FakeLine& the_line) : line(the_line) { line.held = true; }
    ~Hold() { line.held = false; }
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;
    FakeLine& line;
  };
  struct Input : InputLine, Hold {
    using Hold::Hold;
    [[nodiscard]] int descriptor() const noexcept override { return -1; }
    tl::expected<bool, std::string> level() override {
      if (!line.fault.empty()) return tl::unexpected(line.fault);
      return line.level;
    }
    tl::expected<std::size_t, std::string> take(LineEdge* out, std::size_t room) override {
      if (!line.fault.empty()) return tl::unexpected(line.fault);
      std::size_t taken = 0;
      for (; taken < room && !line.edges.empty(); line.edges.pop_front()) out[taken++] = line.edges.front();
      return taken;
    }
  };
  struct Output : OutputLine, Hold {
    using Hold::Hold;
    tl::expected<void, std::string> set(bool level) override {
      if (!line.fault.empty()) return tl::unexpected(line.fault);
      line.level = level;
      return {};
    }
  };
  std::map<unsigned, FakeLine> lines_;
};

}  // namespace dwell::gpio
