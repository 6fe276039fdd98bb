// The registers' image, of a service as it may stand; and that the manual page tells of the registers as they are.
#include "daemon/outlets/register_map.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/daemon/measured_service.hpp"

namespace dwell {
namespace {

struct RegisterMap : testing::Test, test::MeasuredService {
  [[nodiscard]] RegisterImage image(const std::string& trouble = {}) const { return {view(trouble), 41}; }
  static std::uint16_t word(const RegisterImage& image, std::size_t at) {
    return image.read(static_cast<std::uint16_t>(at), 1)[0];
  }
  static std::uint32_t two(const RegisterImage& image, std::size_t at) {
    const auto registers = image.read(static_cast<std::uint16_t>(at), 2);
    return static_cast<std::uint32_t>(registers[0]) << 16U | registers[1];
  }
  static float real(const RegisterImage& image, std::size_t at) { return std::bit_cast<float>(two(image, at)); }
  // The first register of element k.
  static std::size_t of(int k) {
    const auto i = static_cast<std::size_t>(k - 1);
    return kPageStride * (i / kElementsPerPage) + kHeaderRegisters + kElementRegisters * (i % kElementsPerPage);
  }
};

TEST_F(RegisterMap, AMeasuredElementHasItsNumbersAndTheStatusValid) {
  const RegisterImage registers = image();
  EXPECT_EQ(word(registers, 3), 2) << "measuring";
  EXPECT_EQ(two(registers, 10), 1U) << "dwell 1";
  EXPECT_FLOAT_EQ(real(registers, 12), 4.0003F);
  EXPECT_FLOAT_EQ(real(registers, 14), 24.58F);
  EXPECT_FLOAT_EQ(real(registers, 18), 0.1F);
  EXPECT_EQ(word(registers, of(1)), 1);
  EXPECT_EQ(word(registers, of(1) + 1), 1);
  EXPECT_FLOAT_EQ(real(registers, of(1) + 2), 24010.0F);
  EXPECT_FLOAT_EQ(real(registers, of(1) + 4), 27.4F);
  EXPECT_FLOAT_EQ(real(registers, of(1) + 6), 60.2F);
  EXPECT_FLOAT_EQ(real(registers, of(1) + 8), 0.79F);
}

TEST_F(RegisterMap, TheHighWordComesFirst) {
  const RegisterImage registers = image();
  const auto c = registers.read(static_cast<std::uint16_t>(of(1) + 2), 2);
  EXPECT_EQ(c[0], 0x46bb) << "24010 is 0x46bb9400";
  EXPECT_EQ(c[1], 0x9400);
}

TEST_F(RegisterMap, AnElementThatIsNotIdentifiableHasNoNumbers) {
  const RegisterImage registers = image();
  EXPECT_EQ(word(registers, of(2)), 4);
  for (const std::size_t i : {2U, 4U, 6U, 8U}) EXPECT_TRUE(std::isnan(real(registers, of(2) + i))) << i;
  EXPECT_EQ(word(registers, of(4)), 0) << "three elements";
  EXPECT_EQ(word(registers, of(4) + 1), 0);
  EXPECT_TRUE(std::isnan(real(registers, of(4) + 2)));
}

TEST_F(RegisterMap, ADoubtfulElementSaysSo) {
  snapshot.dwell.doubts = {{{1}, "its c is negative"}};
  EXPECT_EQ(word(image(), of(1)), 2);
  EXPECT_EQ(word(image(), of(3)), 1);
  EXPECT_EQ(word(image(), 5), 0) << "not ready";
}

TEST_F(RegisterMap, NothingOldIsANumber) {
  now_ns += 3'000'000'000;
  const RegisterImage registers = image();
  EXPECT_EQ(word(registers, 3), 5);
  EXPECT_EQ(word(registers, of(1)), 5);
  EXPECT_TRUE(std::isnan(real(registers, of(1) + 2)));
  EXPECT_TRUE(std::isnan(real(registers, 12)));
  EXPECT_FLOAT_EQ(real(registers, 18), 3.1F) << "its age";
  now_ns -= 3'000'000'000;
  EXPECT_EQ(word(image("thread estimate has not turned"), of(1)), 5);
}

TEST_F(RegisterMap, NothingOldIsReady) {
  chain_of(2);
  EXPECT_EQ(word(image(), 5), 1);
  now_ns += 3'000'000'000;
  EXPECT_EQ(word(image(), 5), 0);
}

TEST_F(RegisterMap, WhatSettlesHasNoCoefficients) {
  snapshot.dwell = test::settling_dwell();
  const RegisterImage registers = image();
  EXPECT_EQ(word(registers, 3), 1);
  EXPECT_FLOAT_EQ(real(registers, 16), 3.25F);
  EXPECT_TRUE(std::isnan(real(registers, 12))) << "no frequency before it is measured";
  EXPECT_EQ(word(registers, of(1)), 3);
  EXPECT_TRUE(std::isnan(real(registers, of(1) + 2)));
}

TEST_F(RegisterMap, TheVerdictIsThatOfTheCurrentDwell) {
  EXPECT_EQ(word(image(), 6), 0);
  verify(Verdict::not_adequate);
  EXPECT_EQ(word(image(), 6), 2);
  snapshot.dwell.index = 2;
  EXPECT_EQ(word(image(), 6), 0);
}

TEST_F(RegisterMap, AlarmsThatWaitForSomebodyAreCounted) {
  EXPECT_EQ(word(image(), 22), 0);
  raise_alarms();
  EXPECT_EQ(word(image(), 22), 2) << "one lasts, one has returned; the third is acknowledged";
}

TEST_F(RegisterMap, ViolatedLimitsHaveABitEach) {
  chain_of(20);
  EXPECT_EQ(word(image(), 23), 0);
  // c = 1000 k, U95 = 10 k
  rig.limits = {
      {3, Bounds{0.0, 10.0}, std::nullopt}, {4, Bounds{0.0, 5e3}, std::nullopt}, {12, std::nullopt, Bounds{0.0, 1.0}}};
  EXPECT_EQ(word(image(), 23), 0x8004) << "element 3, and some limit of the rig";
  EXPECT_EQ(word(image(), kPageStride + 23), 0x8002) << "element 12 is the second one of its page";
  EXPECT_EQ(word(image(), 2 * kPageStride + 23), 0x8000);
  rig.limits = {{4, Bounds{0.0, 4e3}, std::nullopt}};
  EXPECT_EQ(word(image(), 23), 0x4000) << "undecided";
  rig.limits = {{3, Bounds{0.0, 10.0}, std::nullopt}};
  snapshot.dwell.state = State::complete;
  EXPECT_EQ(word(image(), 23), 0) << "none is measured now";
  snapshot.dwell.state = State::measuring;
  now_ns += 3'000'000'000;
  EXPECT_EQ(word(image(), 23), 0) << "stale";
}

// Register 23 says which element; the registers behind the page say which of its coefficients.
TEST_F(RegisterMap, AViolatedLimitNamesItsCoefficient) {
  EXPECT_EQ(word(image(), 1), 3) << "the version that has these registers";
  chain_of(20);
  // c = 1000 k, r = 10 k, U95 a hundredth of it
  rig.limits = {{3, Bounds{0.0, 10.0}, Bounds{0.0, 30.0}},
                {4, Bounds{0.0, 4e3}, Bounds{0.0, 1.0}},
                {12, Bounds{0.0, 1e6}, Bounds{0.0, 1.0}}};
  const RegisterImage registers = image();
  EXPECT_EQ(word(registers, 125), 0x4) << "c of element 3 is violated";
  EXPECT_EQ(word(registers, 126), 0x8) << "r of element 4";
  EXPECT_EQ(word(registers, 127), 0x8) << "c of element 4 is undecided";
  EXPECT_EQ(word(registers, 128), 0x4) << "r of element 3";
  EXPECT_EQ(word(registers, 23), 0xc00c) << "as in version 2";
  EXPECT_EQ(word(registers, kPageStride + 125), 0) << "c of element 12 is kept";
  EXPECT_EQ(word(registers, kPageStride + 126), 0x2);
  EXPECT_EQ(registers.read(124, 5)[0], 41) << "one read holds them and the generation";
  now_ns += 3'000'000'000;
  for (const std::size_t at : {125U, 126U, 127U, 128U}) EXPECT_EQ(word(image(), at), 0) << "stale";
}

TEST_F(RegisterMap, TheHeartbeatStandsStillWithTheEstimation) {
  const RegisterImage before(view(), 1), after(view(), 2);
  EXPECT_EQ(word(before, 2), 77);
  EXPECT_EQ(word(after, 2), 77) << "the same estimate";
  EXPECT_EQ(word(before, 0), 1);
  EXPECT_EQ(word(after, 0), 2);
}

TEST_F(RegisterMap, ALargeChainIsPagedAndEachPageIsCompleteInOneRead) {
  chain_of(64);
  const RegisterImage registers = image();
  ASSERT_EQ(registers.pages(), 7U) << "65 elements";
  for (std::size_t page = 0; page < 7; ++page) {
    ASSERT_EQ(registers.read(static_cast<std::uint16_t>(page * kPageStride), 125).size(), 125U) << page;
    EXPECT_EQ(word(registers, page * kPageStride), 41);
    EXPECT_EQ(word(registers, page * kPageStride + 124), 41);
    EXPECT_EQ(word(registers, page * kPageStride + 3), 2) << "each has the header";
    EXPECT_EQ(word(registers, page * kPageStride + 8), 10 * page + 1);
  }
  for (const int k : {1, 10, 11, 64, 65}) {
    EXPECT_EQ(word(registers, of(k)), 1) << k;
    EXPECT_EQ(word(registers, of(k) + 1), k);
    EXPECT_FLOAT_EQ(real(registers, of(k) + 2), 1000.0F * static_cast<float>(k));
  }
}

TEST_F(RegisterMap, NoReadLeavesItsPage) {
  chain_of(20);
  const RegisterImage registers = image();
  EXPECT_EQ(registers.read(124, 5).size(), 5U);
  EXPECT_TRUE(registers.read(124, 6).empty());
  EXPECT_TRUE(registers.read(129, 1).empty());
  EXPECT_TRUE(registers.read(199, 2).empty()) << "between two pages";
  EXPECT_FALSE(registers.read(200, 125).empty());
  EXPECT_TRUE(registers.read(600, 1).empty()) << "21 elements have three pages";
  EXPECT_TRUE(registers.read(65535, 125).empty());
  EXPECT_TRUE(RegisterImage().read(0, 1).empty()) << "nothing is known yet";
}

TEST_F(RegisterMap, ANumberThatNoFloat32HoldsIsNone) {
  snapshot.dwell.elements[0].stiffness.value = 1e39;
  EXPECT_TRUE(std::isnan(real(image(), of(1) + 2)));
}

// Each page is filled by its description, and no register is described twice.
void expect_room(std::span<const Register> fields, std::size_t begin, std::size_t end) {
  for (const Register& field : fields) {
    EXPECT_GE(field.offset, begin) << field.name;
    begin = field.offset + size_of(field.type);
  }
  EXPECT_LE(begin, end);
}

TEST(RegisterDescription, LeavesEachRegisterToOne) {
  expect_room(header_registers(), 0, kHeaderRegisters);
  expect_room(element_registers(), 0, kElementRegisters);
  expect_room(page_end_registers(), kHeaderRegisters + kElementsPerPage * kElementRegisters, kPageRegisters);
}

// The tables of dwell-modbus(7) as the description has them.
std::string manual_tables() {
  std::ostringstream text;
  const auto table = [&text](const char* title, std::span<const Register> fields, const char* before) {
    text << ".SS " << title << "\n.TS\ntab(|);\nlB lB lB lB lB\nl l l l lx.\nregister|name|type|unit|meaning\n";
    for (const Register& field : fields) {
      text << before << field.offset << "|" << field.name << "|" << to_string(field.type) << "|" << field.unit
           << "|T{\n"
           << field.meaning << "\nT}\n";
    }
    text << ".TE\n";
  };
  table("The header of a page", header_registers(), "");
  table("An element", element_registers(), "+");
  table("The end of a page", page_end_registers(), "");
  return text.str();
}

TEST(RegisterDescription, IsWhatTheManualPageTells) {
  std::ifstream file(DWELL_SOURCE "/docs/man/dwell-modbus.7");
  const std::string page((std::istreambuf_iterator<char>(file)), {});
  const std::string begin = ".\\\" The tables are made from daemon/outlets/register_map.cpp.\n",
                    end = ".\\\" End of the tables.\n";
  const auto first = page.find(begin), last = page.find(end);
  ASSERT_NE(first, std::string::npos);
  ASSERT_NE(last, std::string::npos);
  const std::string told = page.substr(first + begin.size(), last - first - begin.size());
  EXPECT_EQ(told, manual_tables()) << "put this between the two comments of the page:\n" << manual_tables();
}

}  // namespace
}  // namespace dwell
