// Whatever a node answers and whenever, the SDO client ends, keeps within its bounds and takes for an answer only what
// answers what was asked; and a node's set-up comes to an end, or to a reason. The bytes are first what is asked, then
// answers and the time between them.
#include <cstddef>
#include <cstdint>

#include "drivers/canopen/configurator.hpp"
#include "drivers/canopen/sdo_client.hpp"
#include "tests/drivers/fuzz_bytes.hpp"

namespace {

using namespace dwell::canopen;
using dwell::test::Bytes, dwell::test::hold;

void ask(Bytes& bytes) {
  SdoClient client(1);
  std::int64_t now_ns = 0;
  can_frame answer{};
  while (!bytes.empty()) {
    const Object object{bytes.take<std::uint16_t>(), bytes.take<std::uint8_t>()};
    const bool writes = (bytes.take<std::uint8_t>() & 1U) != 0;
    if (writes)
      client.download(object, bytes.take<std::uint32_t>(), bytes.take<std::uint8_t>(), now_ns);
    else
      client.upload(object, now_ns);
    for (int i = 0; client.state() == SdoClient::State::busy; ++i) {
      hold(i < 100'000);
      while (const auto frame = client.to_send()) hold(frame->can_dlc == 8 && frame->can_id == kSdoRequest + 1);
      const auto what = bytes.take<std::uint8_t>();
      now_ns += what % 16 == 0 ? 100'000'000 : 1'000'000;
      client.tick(now_ns);
      if (client.state() != SdoClient::State::busy || bytes.empty()) continue;
      answer = {};
      answer.can_dlc = what < 16 ? what % 9 : 8;
      for (std::uint8_t& byte : answer.data) byte = bytes.take<std::uint8_t>();
      // Random answers would hardly ever be to the object.
      if (what >= 64) {
        put_le({answer.data + 1, 2}, object.index);
        answer.data[3] = object.sub_index;
      }
      client.take(answer, now_ns);
    }
    hold(client.data().size() <= SdoClient::kMostBytes);
    if (client.state() == SdoClient::State::done && writes) hold(answer.data[0] >> 5U == 3U);
    static_cast<void>(client.take_late());
  }
}

void set_up(Bytes& bytes) {
  Wish wish;
  wish.node = static_cast<std::uint8_t>(1 + bytes.take<std::uint8_t>() % 127);
  for (unsigned count = 1 + bytes.take<std::uint8_t>() % 3U; count > 0; --count)
    wish.wanted.push_back({{0x9130, static_cast<std::uint8_t>(count)}, {Kind::signed_integer, 32}, count});
  if ((bytes.take<std::uint8_t>() & 1U) != 0)
    wish.identity[bytes.take<std::uint8_t>() % 4] = bytes.take<std::uint32_t>();
  Configurator configurator(wish);
  configurator.begin();
  for (int i = 0; configurator.request() != nullptr; ++i) {
    hold(i < 100'000);
    const auto what = bytes.take<std::uint8_t>();
    std::uint8_t mapped[4] = {0x20, static_cast<std::uint8_t>(1 + what % 3), 0x30, 0x91};
    if (what < 64)
      configurator.answer({bytes.take<std::uint32_t>(), {}});
    else if (what < 128)
      configurator.answer({std::nullopt, mapped});
    else
      configurator.answer({std::nullopt, bytes.take_some(what % 16)});
  }
  if (!configurator.failure().empty()) return;
  std::size_t fields = 0;
  for (const Pdo& pdo : configurator.pdos()) {
    hold((pdo.id & kNodeMask) == wish.node && pdo.id >= kFirstPdo && pdo.id <= kLastPdo);
    fields += pdo.fields.size();
    for (const Field& field : pdo.fields) hold(field.first_bit + field.type.bits <= 64);
  }
  hold(fields == wish.wanted.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  if ((bytes.take<std::uint8_t>() & 1U) != 0)
    ask(bytes);
  else
    set_up(bytes);
  return 0;
}
