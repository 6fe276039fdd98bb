#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/rigsim/client.hpp"

namespace rigsim {
namespace {

using test::read_pdu;

TEST(Crc, MatchesPublishedVectors) {
  const std::string check = "123456789";
  EXPECT_EQ(crc16({reinterpret_cast<const std::uint8_t*>(check.data()), check.size()}), 0x4B37);
  // The Modbus guide's example: slave 2, function 7, CRC 41 12 on the wire.
  EXPECT_EQ(rtu_frame(2, Bytes{7}), (Bytes{2, 7, 0x41, 0x12}));
  EXPECT_EQ(rtu_frame(1, read_pdu(0, 10, 3)), (Bytes{1, 3, 0, 0, 0, 10, 0xC5, 0xCD}));
}

TEST(TcpRequest, IsReadFieldByField) {
  const Bytes frame = tcp_frame(0x1234, 7, read_pdu(0x0102, 5, 3));
  EXPECT_EQ(frame, (Bytes{0x12, 0x34, 0, 0, 0, 6, 7, 3, 1, 2, 0, 5}));
  const Parsed parsed = parse_tcp(frame);
  ASSERT_EQ(parsed.kind, Parsed::Kind::request);
  EXPECT_EQ(parsed.request.transaction, 0x1234);
  EXPECT_EQ(parsed.request.unit, 7);
  EXPECT_EQ(parsed.request.address, 0x0102);
  EXPECT_EQ(parsed.request.count, 5);
  EXPECT_EQ(parsed.request.size, 12U);
  EXPECT_EQ(parsed.request.exception, 0);
}

TEST(TcpRequest, IsIncompleteUntilItsLastByte) {
  const Bytes frame = tcp_frame(1, 1, read_pdu(0, 2));
  for (std::size_t size = 0; size < frame.size(); ++size)
    EXPECT_EQ(parse_tcp(std::span(frame).first(size)).kind, Parsed::Kind::incomplete);
}

TEST(TcpRequest, OfAnotherProtocolOrAnImpossibleLengthIsBroken) {
  for (const Bytes& header : {Bytes{0, 1, 0, 9, 0, 6, 1}, Bytes{0, 1, 0, 0, 0, 1, 1}, Bytes{0, 1, 0, 0, 1, 0, 1}})
    EXPECT_EQ(parse_tcp(header).kind, Parsed::Kind::broken);
}

TEST(Request, ThatCannotBeServedCarriesItsException) {
  EXPECT_EQ(parse_tcp(tcp_frame(1, 1, Bytes{6, 0, 0, 0, 1})).request.exception, kIllegalFunction);
  EXPECT_EQ(parse_tcp(tcp_frame(1, 1, read_pdu(0, 0))).request.exception, kIllegalValue);
  EXPECT_EQ(parse_tcp(tcp_frame(1, 1, read_pdu(0, 126))).request.exception, kIllegalValue);
  EXPECT_EQ(parse_tcp(tcp_frame(1, 1, Bytes{4, 0})).request.exception, kIllegalValue);
}

TEST(RtuRequest, WithAWrongCrcIsBroken) {
  Bytes frame = rtu_frame(3, read_pdu(4, 2));
  ASSERT_EQ(parse_rtu(frame).kind, Parsed::Kind::request);
  for (std::size_t i = 2; i < frame.size(); ++i) {
    Bytes wrong = frame;
    wrong[i] ^= 0x10;
    EXPECT_EQ(parse_rtu(wrong).kind, Parsed::Kind::broken) << i;
  }
}

TEST(RtuRequest, OfVariableLengthIsAwaitedWhole) {
  const Bytes frame = rtu_frame(3, Bytes{16, 0, 0, 0, 1, 2, 0xAB, 0xCD});
  for (std::size_t size = 0; size < frame.size(); ++size)
    EXPECT_EQ(parse_rtu(std::span(frame).first(size)).kind, Parsed::Kind::incomplete);
  EXPECT_EQ(parse_rtu(frame).request.exception, kIllegalFunction);
}

TEST(Parsers, TakeAnyBytesWithoutReachingBeyondThem) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200000; ++i) {
    Bytes bytes(random() % 40);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    // Half of them begin like a frame, to get beyond the first checks.
    if (bytes.size() > 6 && (random() & 1U) != 0) bytes[2] = bytes[3] = bytes[4] = 0;
    if (bytes.size() > 1 && (random() & 1U) != 0) bytes[1] = static_cast<std::uint8_t>(random() % 24);
    for (const Parsed& parsed : {parse_tcp(bytes), parse_rtu(bytes)}) {
      if (parsed.kind != Parsed::Kind::request) continue;
      EXPECT_GT(parsed.request.size, 0U);
      EXPECT_LE(parsed.request.size, bytes.size());
    }
  }
}

TEST(Station, MapCoversEveryTypeAndOrder) {
  EXPECT_FALSE(station(0));
  EXPECT_FALSE(station(kStations + 1));
  EXPECT_EQ(station(1)->type, Type::float32);
  EXPECT_EQ(station(2)->order, Order::cdab);
  EXPECT_EQ(station(5)->type, Type::float64);
  EXPECT_EQ(station(24)->type, Type::uint16);
  EXPECT_EQ(station(24)->order, Order::dcba);
}

TEST(Encoding, OrdersBytesAsNamed) {
  const auto words = [](double value, Type type, Order order) {
    std::array<std::uint16_t, 4> registers{};
    encode(value, false, 1.0, {type, order}, registers);
    return registers;
  };
  // 1.0f is 3F 80 00 00.
  EXPECT_EQ(words(1.0, Type::float32, Order::abcd)[0], 0x3F80);
  EXPECT_EQ(words(1.0, Type::float32, Order::cdab)[1], 0x3F80);
  EXPECT_EQ(words(1.0, Type::float32, Order::badc)[0], 0x803F);
  EXPECT_EQ(words(1.0, Type::float32, Order::dcba)[1], 0x803F);
  EXPECT_EQ(words(1e-9, Type::int32, Order::abcd)[1], 1);
  EXPECT_EQ(words(-1e-6, Type::int16, Order::abcd)[0], 0xFFFF);
  EXPECT_EQ(words(0.0, Type::uint16, Order::abcd)[0], 0x8000);
}

TEST(Encoding, SaturatesAndMarksWhatIsNoNumber) {
  std::array<std::uint16_t, 2> registers{};
  encode(1e9, false, 1.0, {Type::int16, Order::abcd}, registers);
  EXPECT_EQ(registers[0], 0x7FFF);
  encode(-1e9, true, 1.0, {Type::uint32, Order::abcd}, registers);
  EXPECT_EQ(registers[0], 0);
  encode(std::numeric_limits<double>::quiet_NaN(), false, 1.0, {Type::int32, Order::abcd}, registers);
  EXPECT_EQ(registers[0], 0x8000);
}

TEST(Encoding, IsUndoneByTheIndependentDecoder) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> value(-0.02, 0.02);
  for (int unit = 1; unit <= kStations; ++unit) {
    const Station which = *station(unit);
    for (int i = 0; i < 200; ++i) {
      const double si = value(random);
      std::array<std::uint16_t, 4> registers{};
      encode(si, false, 1.0, which, registers);
      Bytes bytes;
      for (const std::uint16_t word : registers) {
        bytes.push_back(static_cast<std::uint8_t>(word >> 8));
        bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
      }
      const double got = test::decode(bytes.data(), which);
      if (which.floating())
        EXPECT_EQ(got, which.type == Type::float64 ? si : static_cast<float>(si)) << unit;
      else
        EXPECT_NEAR((got - which.bias()) * which.step(false), si, 0.5001 * which.step(false)) << unit;
    }
  }
}

}  // namespace
}  // namespace rigsim
