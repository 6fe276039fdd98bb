// What is asked of a node and set in it before it is started, and what to make of the answers: its identity against
// what the rig file says, in which TPDO each wanted object is mapped and at which bit, that this TPDO is sent at every
// SYNC and with an identifier of the node's own. Pure, without time: one request after the other, each answered.
//
//   Configurator c(wish);
//   for (c.begin(); c.request(); c.answer(…)) …;
//   c.failure().empty(): c.pdos() says where everything is
//
// Bound to one thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/canopen/message.hpp"
#include "drivers/canopen/value.hpp"

namespace dwell::canopen {

// An object that is to be measured; `channel` is the caller's.
struct Wanted {
  Object object;
  Type type;
  std::size_t channel = 0;
};

// One node as the rig file wants it.
struct Wish {
  std::uint8_t node = 0;
  std::vector<Wanted> wanted;
  std::array<std::optional<std::uint32_t>, 4> identity;  // vendor, product code, revision, serial number
  std::uint16_t heartbeat_ms = 0;                        // that it shall send; 0: left as it is
  std::uint32_t window_us = 0;                           // within which it shall answer a SYNC; 0: left as it is
};
inline constexpr const char* kIdentityKeys[4] = {"vendor_id", "product_code", "revision", "serial_number"};

// A TPDO to be listened to.
struct Field {
  std::size_t channel = 0;
  unsigned first_bit = 0;
  Type type;
};
struct Pdo {
  canid_t id = 0;
  unsigned number = 0;  // 1 …
  std::vector<Field> fields;
};

struct Request {
  Object object;
  std::optional<std::uint32_t> value;  // to be written; none: read
  std::uint8_t size = 4;               // bytes of it
};
struct Answer {
  std::optional<std::uint32_t> abort_code;  // none: done
  std::span<const std::uint8_t> data;       // what was read
};

class Configurator {
 public:
  explicit Configurator(Wish wish) : wish_(std::move(wish)) {}

  void begin();
  // What to ask next; null: it is over.
  [[nodiscard]] const Request* request() const noexcept { return request_ ? &*request_ : nullptr; }
  void answer(const Answer& answer);

  // Why it cannot be used, in one line that names the node; empty: nothing is wrong (so far).
  [[nodiscard]] const std::string& failure() const noexcept { return failure_; }
  // When it is over without failure.
  [[nodiscard]] const std::vector<Pdo>& pdos() const noexcept { return pdos_; }
  // The heartbeat that the node sends; 0: none.
  [[nodiscard]] std::uint16_t heartbeat_ms() const noexcept { return heartbeat_ms_; }
  // "node 5 (CiA 404, LVDT-2)", as far as it is known.
  [[nodiscard]] std::string name() const;

 private:
  using Step = void (Configurator::*)(const Answer&);
  struct Entry {
    Object object;
    unsigned first_bit = 0, bits = 0;
  };
  struct Found {
    unsigned number = 0;  // from 0
    std::uint32_t cob_id = 0;
    std::uint8_t transmission = 0;  // 0, too, where it does not tell
    std::vector<Entry> entries;
    unsigned bits = 0;
    bool used = false;
    [[nodiscard]] bool valid() const noexcept { return (cob_id >> 31U) == 0; }
    [[nodiscard]] bool synchronous() const noexcept { return valid() && transmission >= 1 && transmission <= 240; }
  };

  void read(const Object& object, Step then);
  void write(const Object& object, std::uint32_t value, std::uint8_t size, Step then);
  void fail(const std::string& what);

  void take_type(const Answer& answer);
  void take_name(const Answer& answer);
  void ask_identity();
  void take_identity(const Answer& answer);
  void ask_heartbeat();
  void take_heartbeat_set(const Answer& answer);
  void take_heartbeat(const Answer& answer);
  void ask_sync();
  void take_sync(const Answer& answer);
  void take_sync_set(const Answer& answer);
  void ask_window();
  void take_window(const Answer& answer);
  void ask_pdo();
  void take_cob_id(const Answer& answer);
  void take_transmission(const Answer& answer);
  void take_count(const Answer& answer);
  void ask_entry();
  void take_entry(const Answer& answer);
  void end_pdo(bool there);
  void choose();
  [[nodiscard]] Found* choose_for(const Wanted& wanted);
  [[nodiscard]] std::string not_mapped(const Wanted& wanted) const;
  [[nodiscard]] std::optional<canid_t> free_id(unsigned number) const;
  void set_next();
  void take_disabled(const Answer& answer);
  void set_transmission();
  void take_transmission_set(const Answer& answer);
  void take_transmission_check(const Answer& answer);
  void enable();
  void take_enabled(const Answer& answer);
  void take_moved(const Answer& answer);
  void fail_identifier(std::uint32_t code);
  void finish();

  Wish wish_;
  std::optional<Request> request_;
  Step then_ = nullptr;
  std::string failure_;
  std::uint32_t device_type_ = 0;
  std::string device_name_;
  std::size_t identity_ = 0;  // that is being asked for
  std::uint16_t heartbeat_ms_ = 0;
  unsigned pdo_ = 0;     // that is being read
  unsigned absent_ = 0;  // in a row
  std::vector<Found> found_;
  unsigned entry_ = 0, entries_ = 0;
  std::size_t setting_ = 0;  // of found_, that is being set
  canid_t id_ = 0;           // that it shall have
  bool fixed_ = false;       // its identifier cannot be written
  bool again_ = false;       // enabling it has been refused once
  std::vector<Pdo> pdos_;
};

}  // namespace dwell::canopen
