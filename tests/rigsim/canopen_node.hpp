// One simulated CANopen transducer (CiA 301; CiA 404 or 406): an object dictionary, an SDO server, NMT states, a
// heartbeat, emergencies, and TPDOs that a SYNC triggers. It is strict where devices are: the identifier of a TPDO that
// is valid cannot be changed, not even by what disables it, nor a transmission type, and neither while operational.
// Virtual time only.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace rigsim {

// What of a rig's channel is measured how, by its position: motions at even places are CiA 406 encoders (6004h, signed
// 32 bits, 1 nm), at odd ones CiA 404 transducers (9130h:01, likewise, behind 8 bits of status, in a TPDO that is
// disabled), the force is a CiA 404 one (6130h:01, REAL32, N).
enum class Transducer : std::uint8_t { encoder, input, load_cell };

class CanopenNode {
 public:
  static constexpr std::uint32_t kVendor = 0x4477, kRevision = 0x00010002;
  static constexpr std::int64_t kBoot_ns = 20'000'000;  // from a reset to the boot-up message

  // Answers are appended to `out`, which outlives it. Off until reset.
  CanopenNode(std::uint8_t id, Transducer what, std::vector<::can_frame>& out);

  [[nodiscard]] std::uint8_t id() const noexcept { return id_; }
  [[nodiscard]] bool operational() const noexcept { return state_ == State::operational; }

  void take(const ::can_frame& frame, std::int64_t now_ns);
  // A SYNC, at which the quantity is `si`; NaN: none (integers: the lowest code).
  void sync(double si);
  void tick(std::int64_t now_ns);
  // When tick is needed; INT64_MAX: not before another call.
  [[nodiscard]] std::int64_t next_ns() const noexcept;

  // Power comes back: the dictionary is as delivered, but for wrong mapping.
  void reset(std::int64_t now_ns);
  void emergency(std::uint16_t code, std::uint8_t error_register);
  // The measured object is not in any TPDO; as of the next reset.
  void map_wrongly(bool wrong) noexcept { wrong_ = wrong; }
  // Of its clock, for the heartbeat.
  void set_drift(double ppm) noexcept { rate_ = 1.0 + 1e-6 * ppm; }
  // The quantity as SDO reads it.
  void set_value(double si) { encode(si); }

  // An entry of the dictionary as it is, for tests; 0: there is none.
  [[nodiscard]] std::uint32_t entry(std::uint16_t index, std::uint8_t sub_index) const;
  void set_entry(std::uint16_t index, std::uint8_t sub_index, std::uint32_t value, std::size_t bytes, bool writable);
  void remove_entry(std::uint16_t index, std::uint8_t sub_index);

 private:
  enum class State : std::uint8_t { off, booting, pre_operational, operational, stopped };
  struct Entry {
    std::vector<std::uint8_t> bytes;
    bool writable = false;
  };
  static std::uint32_t key(std::uint16_t index, std::uint8_t sub_index) {
    return std::uint32_t{index} << 8U | sub_index;
  }

  void fill();
  void encode(double si);
  void send(canid_t id, const std::vector<std::uint8_t>& bytes);
  void serve_sdo(const ::can_frame& request);
  void abort(const ::can_frame& request, std::uint32_t code);
  void upload(const ::can_frame& request);
  void upload_segment(const ::can_frame& request);
  void download(const ::can_frame& request);
  [[nodiscard]] std::uint32_t refusal(std::uint16_t index, std::uint8_t sub_index, std::uint32_t value) const;
  void send_pdo(unsigned number);

  std::uint8_t id_;
  Transducer what_;
  std::vector<::can_frame>& out_;
  State state_ = State::off;
  std::map<std::uint32_t, Entry> dictionary_;
  bool wrong_ = false;
  double rate_ = 1.0;
  std::int64_t boot_ns_ = 0, heartbeat_ns_ = 0;
  unsigned syncs_ = 0;
  std::vector<std::uint8_t> segments_;  // what is left of an upload
  bool toggle_ = false;
};

}  // namespace rigsim
