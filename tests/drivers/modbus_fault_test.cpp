// Every fault a Modbus device can have is counted by its kind and costs only its own samples.
#include <gtest/gtest.h>

#include <functional>
#include <ostream>

#include "tests/drivers/modbus_fixture.hpp"

namespace dwell::test {
namespace {

// What one scripted fault of every other answer is counted as; the answers between must still be delivered.
struct Fault {
  const char* name;
  ModbusDevice::Over over;
  dwell_fault counted;
  std::function<std::vector<Reply>(const Request&)> reply;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

Reply changed(const Request& request, const std::function<void(Reply&)>& change) {
  Reply reply = answer(request, register_number);
  change(reply);
  return reply;
}

class ModbusFault : public ::testing::TestWithParam<Fault> {};

TEST_P(ModbusFault, IsCountedByKindAndCostsOnlyItsOwnSamples) {
  const Fault& fault = GetParam();
  ModbusDevice device(fault.over, [&](const Request& request) -> std::vector<Reply> {
    return request.number % 2 == 0 ? honest(request) : fault.reply(request);
  });
  Given given = fault.over == ModbusDevice::Over::tcp ? over_tcp(device) : over_serial(device);
  given.set("timeout", 0.03);
  add_word(given, "a", 3);
  add_word(given, "b", 4);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.counted(fault.counted) >= 3 && host.sample_count() >= 8; }));
  instance.stop();
  for (const dwell_sample& sample : host.samples(10)) EXPECT_EQ(sample.raw, 3.0);
  for (const dwell_sample& sample : host.samples(11)) EXPECT_EQ(sample.raw, 4.0);
  for (const std::size_t scan : host.scans()) EXPECT_EQ(scan, 2U);
  const auto samples = host.samples(10);
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(samples[i].flags, i == 0 ? 0U : DWELL_SAMPLE_GAP) << i;
}

INSTANTIATE_TEST_SUITE_P(
    Every, ModbusFault,
    ::testing::Values(
        Fault{"TcpTimeout", kTcp, DWELL_FAULT_TIMEOUT, [](const Request&) { return std::vector<Reply>{}; }},
        Fault{"TcpException", kTcp, DWELL_FAULT_EXCEPTION,
              [](const Request& r) { return std::vector<Reply>{exception(r, 6)}; }},
        Fault{"TcpShortFrame", kTcp, DWELL_FAULT_SHORT_FRAME,
              [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.keep = 10; })}; }},
        Fault{"TcpFewerRegisters", kTcp, DWELL_FAULT_SHORT_FRAME,
              [](const Request& r) {
                return std::vector<Reply>{changed(r, [](Reply& reply) {
                  reply.pdu[1] = 2;
                  reply.pdu.resize(4);
                })};
              }},
        Fault{"TcpMoreRegisters", kTcp, DWELL_FAULT_BAD_FRAME,
              [](const Request& r) {
                return std::vector<Reply>{changed(r, [](Reply& reply) {
                  reply.pdu[1] = 6;
                  reply.pdu.resize(8);
                })};
              }},
        Fault{"TcpOtherStation", kTcp, DWELL_FAULT_BAD_FRAME,
              [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.unit = 9; })}; }},
        Fault{"TcpOtherFunction", kTcp, DWELL_FAULT_BAD_FRAME,
              [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.pdu[0] = 3; })}; }},
        Fault{"TcpHeaderOutOfStep", kTcp, DWELL_FAULT_BAD_FRAME,
              [](const Request& r) {
                return std::vector<Reply>{changed(r, [](Reply& reply) { reply.pdu.push_back(0); })};
              }},
        Fault{"TcpForeignTransaction", kTcp, DWELL_FAULT_LATE_ANSWER,
              [](const Request& r) {
                return std::vector<Reply>{changed(
                    r, [&](Reply& reply) { reply.transaction = static_cast<std::uint16_t>(r.transaction ^ 0x8000U); })};
              }},
        Fault{
            "TcpReset", kTcp, DWELL_FAULT_DISCONNECTED,
            [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.reset = true; })}; }},
        Fault{"SerialTimeout", kSerial, DWELL_FAULT_TIMEOUT, [](const Request&) { return std::vector<Reply>{}; }},
        Fault{"SerialException", kSerial, DWELL_FAULT_EXCEPTION,
              [](const Request& r) { return std::vector<Reply>{exception(r, 4)}; }},
        Fault{"SerialBadChecksum", kSerial, DWELL_FAULT_BAD_CHECKSUM,
              [](const Request& r) {
                return std::vector<Reply>{changed(r, [](Reply& reply) { reply.bad_checksum = true; })};
              }},
        Fault{"SerialShortFrame", kSerial, DWELL_FAULT_SHORT_FRAME,
              [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.keep = 5; })}; }},
        Fault{"SerialOtherStation", kSerial, DWELL_FAULT_BAD_FRAME,
              [](const Request& r) { return std::vector<Reply>{changed(r, [](Reply& reply) { reply.unit = 9; })}; }}),
    [](const ::testing::TestParamInfo<Fault>& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace dwell::test
