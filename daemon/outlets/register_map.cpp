#include "daemon/outlets/register_map.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "core/rig/limit.hpp"
#include "daemon/alarms/alarm_list.hpp"
#include "daemon/serve/element_standing.hpp"

namespace dwell {
namespace {

using Source = RegisterSource;

// A number of the element; NaN: it may not be given to a machine.
template <Coefficient ElementEstimate::*which, double Coefficient::*part>
double coefficient(const Source& s) {
  const ElementEstimate* const element = element_to_hand_out(s.now, s.k);
  return element == nullptr ? kNaN : element->*which.*part;
}

// `number` if the dwell is in this state and not stale; else NaN.
double while_in(State state, const Source& s, double number) {
  return s.now.snapshot.dwell.state == state && !is_stale(s.now) ? number : kNaN;
}

double state_code(const Source& s) {
  if (is_stale(s.now)) return 5;
  switch (s.now.snapshot.dwell.state) {
    case State::idle:
      return 0;
    case State::settling:
      return 1;
    case State::measuring:
      return 2;
    case State::complete:
      return 3;
    case State::fault:
      return 4;
  }
  return 5;
}

double health_code(const Source& s) {
  switch (s.now.health.status) {
    case Health::Status::ok:
      return 0;
    case Health::Status::degraded:
      return 1;
    case Health::Status::fault:
      return 2;
  }
  return 2;
}

double verdict_code(const Source& s) {
  const VerifiedDwell* const verified = s.now.snapshot.verified.get();
  if (verified == nullptr || is_stale(s.now) || verified->dwell.index != s.now.snapshot.dwell.index) return 0;
  switch (verified->verification.verdict) {
    case Verdict::adequate:
      return 1;
    case Verdict::not_adequate:
      return 2;
    case Verdict::not_verified:
      return 0;
  }
  return 0;
}

double status_code(const Source& s) {
  if (s.k > s.now.rig.element_count()) return 0;
  switch (standing_of(s.now, s.k)) {
    case Standing::valid:
      return 1;
    case Standing::doubtful:
      return 2;
    case Standing::not_settled:
      return 3;
    case Standing::not_identifiable:
      return 4;
    case Standing::stale:
      return 5;
  }
  return 5;
}

// None if the dwell is stale: then no limit has a verdict.
std::vector<JudgedLimit> limits_of(const Source& s) {
  return is_stale(s.now) ? std::vector<JudgedLimit>() : judge_limits_now(s.now.rig, s.now.snapshot.dwell);
}

// Bit 0 to 9 of the limit's element; 0: it stands on another page.
unsigned bit_of(const JudgedLimit& limit, const Source& s) {
  const int place = limit.element - s.k;
  return place >= 0 && place < static_cast<int>(kElementsPerPage) ? 1U << static_cast<unsigned>(place) : 0;
}

// The bits of register 23, as its text has them.
double limits_word(const Source& s) {
  constexpr unsigned kSomeUndecided = 1U << 14U, kSomeViolated = 1U << 15U;
  unsigned bits = 0;
  for (const JudgedLimit& limit : limits_of(s)) {
    if (limit.verdict == LimitVerdict::undecided) bits |= kSomeUndecided;
    if (limit.verdict == LimitVerdict::violated) bits |= kSomeViolated | bit_of(limit, s);
  }
  return bits;
}

// Bit 0 to 9: the limit of this coefficient of element first + 0 to 9 has this verdict.
template <CoefficientKind kind, LimitVerdict verdict>
double limit_bits(const Source& s) {
  unsigned bits = 0;
  for (const JudgedLimit& limit : limits_of(s))
    if (limit.kind == kind && limit.verdict == verdict) bits |= bit_of(limit, s);
  return bits;
}

double generation(const Source& s) { return s.generation; }

constexpr auto kWord = RegisterType::word;
constexpr auto kCount = RegisterType::count;
constexpr auto kReal = RegisterType::real;

constexpr Register kHeader[] = {
    {0, kWord, "generation", "", "counts the images of the registers; every register may change with it", generation},
    {1, kWord, "version", "", "of this table: 3. Registers 125 to 128 came with version 3, register 23 with version 2",
     [](const Source&) { return double{kMapVersion}; }},
    {2, kWord, "heartbeat", "",
     "changes with every estimate, once in the rig file's update. While it stands still, the service measures nothing",
     [](const Source& s) { return static_cast<double>(s.now.snapshot.sequence & 0xffffU); }},
    {3, kWord, "state", "", "0 idle, 1 settling, 2 measuring, 3 complete, 4 fault, 5 stale: not known", state_code},
    {4, kWord, "health", "", "0 ok, 1 degraded, 2 fault", health_code},
    {5, kWord, "ready", "",
     "1: a dwell is measured now whose coefficients may all be relied on, and the interlock is not open",
     [](const Source& s) { return s.now.health.ready ? 1.0 : 0.0; }},
    {6, kWord, "verdict", "", "on the dwell's model: 0 not verified yet, 1 adequate, 2 not adequate", verdict_code},
    {7, kWord, "elements", "", "of the rig", [](const Source& s) { return double(s.now.rig.element_count()); }},
    {8, kWord, "first", "", "the page's first element", [](const Source& s) { return double(s.k); }},
    {9, kWord, "rotation", "", "0: units of translation, 1: of rotation",
     [](const Source& s) { return s.now.rig.motion == Motion::rotation ? 1.0 : 0.0; }},
    {10, kCount, "dwell", "", "index of the current dwell within its run; 0: there is none",
     [](const Source& s) { return double(s.now.snapshot.dwell.index.value_or(0)); }},
    {12, kReal, "frequency", "Hz", "of the drive, while a dwell is measured",
     [](const Source& s) { return while_in(State::measuring, s, s.now.snapshot.dwell.frequency_hz.value); }},
    {14, kReal, "data", "s", "length of the data that count, while a dwell is measured",
     [](const Source& s) {
       return while_in(State::measuring, s, s.now.snapshot.dwell.end_s - s.now.snapshot.dwell.settled_s);
     }},
    {16, kReal, "settles in", "s", "until the dwell has settled, where that is known",
     [](const Source& s) { return while_in(State::settling, s, s.now.snapshot.dwell.settles_in_s); }},
    {18, kReal, "age", "s", "of the estimate, when this image was made; an image is made once a second at least",
     [](const Source& s) { return estimate_age_s(s.now.snapshot, s.now.now_ns); }},
    {20, kCount, "run", "", "runs of the session so far; 0 where runs are not recorded",
     [](const Source& s) { return s.now.snapshot.run.bracketed ? double(s.now.snapshot.run.number) : 0.0; }},
    {22, kWord, "alarms", "", "that wait for somebody to acknowledge them",
     [](const Source& s) { return s.now.alarms == nullptr ? 0.0 : double(s.now.alarms->unacknowledged()); }},
    {23, kWord, "limits", "",
     "bit 0 to 9: a limit of element first + 0 to 9 is violated. bit 14: some limit of the rig is undecided. bit 15: "
     "some limit of the rig is violated. Only while a dwell is measured; a doubted number violates nothing",
     limits_word},
};

constexpr Register kElement[] = {
    {0, kWord, "status", "",
     "0 no such element, 1 valid, 2 doubtful: do not rely on it, 3 not settled, 4 not identifiable: its channels do "
     "not deliver, or do not determine it, 5 stale",
     status_code},
    {1, kWord, "element", "", "its number, 1 from the table on; 0: no such element",
     [](const Source& s) { return s.k > s.now.rig.element_count() ? 0.0 : double(s.k); }},
    {2, kReal, "c", "N/m or N m/rad", "stiffness", coefficient<&ElementEstimate::stiffness, &Coefficient::value>},
    {4, kReal, "U95 of c", "N/m or N m/rad", "half width of its 95 % interval",
     coefficient<&ElementEstimate::stiffness, &Coefficient::U95>},
    {6, kReal, "r", "N s/m or N m s/rad", "damping", coefficient<&ElementEstimate::damping, &Coefficient::value>},
    {8, kReal, "U95 of r", "N s/m or N m s/rad", "half width of its 95 % interval",
     coefficient<&ElementEstimate::damping, &Coefficient::U95>},
};

constexpr Register kPageEnd[] = {
    {124, kWord, "generation", "", "as in register 0 of the same image", generation},
    {125, kWord, "c violated", "", "bit 0 to 9: the limit of c of element first + 0 to 9 is violated",
     limit_bits<CoefficientKind::stiffness, LimitVerdict::violated>},
    {126, kWord, "r violated", "", "the same of r", limit_bits<CoefficientKind::damping, LimitVerdict::violated>},
    {127, kWord, "c undecided", "", "bit 0 to 9: the limit of c of element first + 0 to 9 is undecided",
     limit_bits<CoefficientKind::stiffness, LimitVerdict::undecided>},
    {128, kWord, "r undecided", "", "the same of r", limit_bits<CoefficientKind::damping, LimitVerdict::undecided>},
};

void put(const Register& field, const Source& source, std::uint16_t* begin) {
  const double value = field.value(source);
  std::uint16_t* const at = begin + field.offset;
  if (field.type == RegisterType::word) {
    *at = static_cast<std::uint16_t>(value);
    return;
  }
  std::uint32_t bits = 0;
  if (field.type == RegisterType::count) {
    bits = static_cast<std::uint32_t>(value);
  } else {
    // A number that no float32 holds is no number: a PLC would take a rounded one for good.
    const bool fits = std::isfinite(value) && std::abs(value) <= double{std::numeric_limits<float>::max()};
    bits = std::bit_cast<std::uint32_t>(fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN());
  }
  at[0] = static_cast<std::uint16_t>(bits >> 16U);
  at[1] = static_cast<std::uint16_t>(bits);
}

}  // namespace

const char* to_string(RegisterType type) noexcept {
  return type == RegisterType::word ? "uint16" : type == RegisterType::count ? "uint32" : "float32";
}

std::size_t size_of(RegisterType type) noexcept { return type == RegisterType::word ? 1 : 2; }

std::span<const Register> header_registers() noexcept { return kHeader; }
std::span<const Register> element_registers() noexcept { return kElement; }
std::span<const Register> page_end_registers() noexcept { return kPageEnd; }

RegisterImage::RegisterImage(const ServiceView& now, std::uint16_t generation) {
  const auto elements = static_cast<std::size_t>(now.rig.element_count());
  const std::size_t count = (elements + kElementsPerPage - 1) / kElementsPerPage;
  registers_.resize(count * kPageRegisters);
  for (std::size_t page = 0; page < count; ++page) {
    std::uint16_t* const begin = registers_.data() + page * kPageRegisters;
    const int first = static_cast<int>(page * kElementsPerPage) + 1;
    for (const Register& field : kHeader) put(field, {now, generation, first}, begin);
    for (int i = 0; i < static_cast<int>(kElementsPerPage); ++i)
      for (const Register& field : kElement)
        put(field, {now, generation, first + i},
            begin + kHeaderRegisters + static_cast<std::size_t>(i) * kElementRegisters);
    for (const Register& field : kPageEnd) put(field, {now, generation, first}, begin);
  }
}

std::span<const std::uint16_t> RegisterImage::read(std::uint16_t first, std::uint16_t count) const noexcept {
  const std::size_t page = first / kPageStride, offset = first % kPageStride;
  if (page >= pages() || offset + count > kPageRegisters) return {};
  return {registers_.data() + page * kPageRegisters + offset, count};
}

}  // namespace dwell
