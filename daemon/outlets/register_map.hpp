// The registers that PLCs read: what each holds, stated once. The image and the tables of the manual page
// dwell-modbus(7) are made from this description.
//
//   page p begins at register 200 p and holds elements 10 p + 1 … 10 p + 10:
//     0 … 23   the header, the same on every page but for the page's first element
//    24 … 123  ten elements of ten registers each
//   124        the generation again, as in register 0
//   125 … 128  bit by bit, an element each: c violates its limit; r does; c's limit is undecided; r's is
//
// One Modbus answer holds 125 registers at most. So one read takes registers 0 … 124 of a page from one image, and a
// second one, from 124 on, the rest with its generation. A client that reads in pieces compares the generations of the
// pieces. There are no registers between pages, and no read spans two pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "daemon/service_view.hpp"

namespace dwell {

inline constexpr std::size_t kPageStride = 200, kPageRegisters = 129, kHeaderRegisters = 24;
inline constexpr std::size_t kElementsPerPage = 10, kElementRegisters = 10;
// Raised when a register gets another meaning. Also when one that was always 0 gets a meaning in which 0 says
// something: a reader must know which 0 it is. 2: register 23. 3: registers 125 to 128.
inline constexpr std::uint16_t kMapVersion = 3;

enum class RegisterType : std::uint8_t {
  word,   // uint16, one register
  count,  // uint32, two registers, the high one first
  real,   // float32 (IEEE 754), two registers, the high one first: "abcd"
};
[[nodiscard]] const char* to_string(RegisterType type) noexcept;  // "uint16", "uint32", "float32"
[[nodiscard]] std::size_t size_of(RegisterType type) noexcept;    // in registers

// From this the value of a register is made.
struct RegisterSource {
  const ServiceView& now;
  std::uint16_t generation;
  int k;  // the element, from 1; in the header: the page's first. May be beyond the rig's last element
};

struct Register {
  std::size_t offset;  // from the page's begin, or from the element's
  RegisterType type;
  const char* name;
  const char* unit;  // empty: none
  const char* meaning;
  // NaN of a real register: there is no number.
  double (*value)(const RegisterSource& source);
};

// In order of offset. page_end: the one behind the elements.
[[nodiscard]] std::span<const Register> header_registers() noexcept;
[[nodiscard]] std::span<const Register> element_registers() noexcept;
[[nodiscard]] std::span<const Register> page_end_registers() noexcept;

class RegisterImage {
 public:
  RegisterImage() = default;
  // Of the service as it stands now. Pure; allocates.
  RegisterImage(const ServiceView& now, std::uint16_t generation);

  [[nodiscard]] std::size_t pages() const noexcept { return registers_.size() / kPageRegisters; }
  // Registers first … first + count - 1; empty: one of them does not exist, or they span two pages.
  [[nodiscard]] std::span<const std::uint16_t> read(std::uint16_t first, std::uint16_t count) const noexcept;

 private:
  std::vector<std::uint16_t> registers_;  // kPageRegisters of each page, page after page
};

}  // namespace dwell
