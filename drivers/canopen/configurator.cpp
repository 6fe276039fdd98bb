#include "drivers/canopen/configurator.hpp"

#include <algorithm>

#include "drivers/canopen/words.hpp"

namespace dwell::canopen {
namespace {

constexpr Object kDeviceType{0x1000, 0}, kSyncId{0x1005, 0}, kSyncWindow{0x1007, 0}, kDeviceName{0x1008, 0},
    kHeartbeatTime{0x1017, 0};
constexpr std::uint16_t kIdentity = 0x1018, kPdoParameters = 0x1800, kPdoMapping = 0x1A00;
constexpr std::uint8_t kCobId = 1, kTransmission = 2;
constexpr std::uint8_t kAtEverySync = 1;

// Devices number their TPDOs with gaps of a few at most; 512 may exist.
constexpr unsigned kMostPdos = 64, kMostAbsent = 4;
constexpr unsigned kMostEntries = 64;
constexpr unsigned kPredefinedPdos = 4;
constexpr std::size_t kLongestName = 32, kMostNamed = 6;

constexpr std::uint32_t kNotValid = 1U << 31U, kNoRemote = 1U << 30U, kExtended = 1U << 29U;
constexpr std::uint32_t kProducesSync = 1U << 30U;

// An answer need not say how many of its four bytes count: the object's own width does.
std::uint32_t number(const Answer& answer, std::size_t bytes = 4) {
  return static_cast<std::uint32_t>(get_le(answer.data.first(std::min(bytes, answer.data.size()))));
}

Object parameter(unsigned pdo, std::uint8_t sub_index) {
  return {static_cast<std::uint16_t>(kPdoParameters + pdo), sub_index};
}
Object mapping(unsigned pdo, std::uint8_t sub_index) {
  return {static_cast<std::uint16_t>(kPdoMapping + pdo), sub_index};
}

// Of the node's own, so that the socket's filter lets it through and no other node has it.
bool is_own(std::uint32_t cob_id, std::uint8_t node) {
  const std::uint32_t id = cob_id & CAN_SFF_MASK;
  return (cob_id & kExtended) == 0 && (id & kNodeMask) == node && id >= kFirstPdo && id <= kLastPdo;
}

}  // namespace

void Configurator::begin() {
  *this = Configurator(std::move(wish_));
  read(kDeviceType, &Configurator::take_type);
}

void Configurator::answer(const Answer& answer) {
  if (!request_) return;
  request_.reset();
  const Step step = std::exchange(then_, nullptr);
  (this->*step)(answer);
}

void Configurator::read(const Object& object, Step then) {
  request_ = Request{object, std::nullopt, 4};
  then_ = then;
}

void Configurator::write(const Object& object, std::uint32_t value, std::uint8_t size, Step then) {
  request_ = Request{object, value, size};
  then_ = then;
}

void Configurator::fail(const std::string& what) { failure_ = name() + ": " + what; }

std::string Configurator::name() const {
  std::string text = "node " + std::to_string(wish_.node);
  const std::uint32_t profile = device_type_ & 0xFFFFU;
  if (profile != 0)
    text += " (CiA " + std::to_string(profile) + (device_name_.empty() ? "" : ", " + device_name_) + ")";
  return text;
}

// ---- who it is -----------------------------------------------------------------------------------------------------

void Configurator::take_type(const Answer& answer) {
  if (answer.abort_code) return fail("cannot read its device type, 1000h: " + abort_text(*answer.abort_code));
  device_type_ = number(answer);
  read(kDeviceName, &Configurator::take_name);
}

void Configurator::take_name(const Answer& answer) {
  // A name is a courtesy; what it holds that is no text is left out.
  for (const std::uint8_t byte : answer.data)
    if (!answer.abort_code && byte >= 0x20 && byte < 0x7F && device_name_.size() < kLongestName)
      device_name_.push_back(static_cast<char>(byte));
  ask_identity();
}

void Configurator::ask_identity() {
  while (identity_ < wish_.identity.size() && !wish_.identity[identity_]) ++identity_;
  if (identity_ < wish_.identity.size())
    read({kIdentity, static_cast<std::uint8_t>(identity_ + 1)}, &Configurator::take_identity);
  else
    ask_heartbeat();
}

void Configurator::take_identity(const Answer& answer) {
  const std::uint32_t expected = *wish_.identity[identity_];
  const std::string object = to_string(Object{kIdentity, static_cast<std::uint8_t>(identity_ + 1)});
  const std::string what = std::string(kIdentityKeys[identity_]) + " (" + object + ")";
  if (answer.abort_code)
    return fail("the rig file says which " + what + " it has, it does not tell: " + abort_text(*answer.abort_code));
  if (number(answer) != expected)
    return fail("is another device: its " + what + " is " + hex(number(answer)) + ", the rig file says " +
                hex(expected));
  ++identity_;
  ask_identity();
}

// ---- heartbeat and SYNC --------------------------------------------------------------------------------------------

void Configurator::ask_heartbeat() {
  if (wish_.heartbeat_ms != 0)
    write(kHeartbeatTime, wish_.heartbeat_ms, 2, &Configurator::take_heartbeat_set);
  else
    read(kHeartbeatTime, &Configurator::take_heartbeat);
}

void Configurator::take_heartbeat_set(const Answer& answer) {
  // Not writable: what it has must do.
  if (answer.abort_code) return read(kHeartbeatTime, &Configurator::take_heartbeat);
  heartbeat_ms_ = wish_.heartbeat_ms;
  ask_sync();
}

void Configurator::take_heartbeat(const Answer& answer) {
  heartbeat_ms_ = answer.abort_code ? std::uint16_t{0} : static_cast<std::uint16_t>(number(answer, 2));
  ask_sync();
}

void Configurator::ask_sync() { read(kSyncId, &Configurator::take_sync); }

void Configurator::take_sync(const Answer& answer) {
  const bool as_we_send = (number(answer) & (kProducesSync | kExtended | CAN_SFF_MASK)) == kSync;
  if (answer.abort_code || as_we_send) return ask_window();  // without the object it is 80h
  write(kSyncId, kSync, 4, &Configurator::take_sync_set);
}

void Configurator::take_sync_set(const Answer& answer) {
  if (answer.abort_code)
    return fail("listens for another SYNC than 0x80, or sends it itself, and 1005h cannot be set: " +
                abort_text(*answer.abort_code));
  ask_window();
}

void Configurator::ask_window() {
  if (wish_.window_us != 0)
    write(kSyncWindow, wish_.window_us, 4, &Configurator::take_window);
  else
    ask_pdo();
}

// Most devices lack it; then lateness is ours alone to see.
void Configurator::take_window(const Answer&) { ask_pdo(); }

// ---- what is mapped where ------------------------------------------------------------------------------------------

void Configurator::ask_pdo() { read(parameter(pdo_, kCobId), &Configurator::take_cob_id); }

void Configurator::take_cob_id(const Answer& answer) {
  if (answer.abort_code) return end_pdo(false);
  found_.emplace_back();
  found_.back().number = pdo_;
  found_.back().cob_id = number(answer);
  read(parameter(pdo_, kTransmission), &Configurator::take_transmission);
}

void Configurator::take_transmission(const Answer& answer) {
  if (!answer.abort_code) found_.back().transmission = static_cast<std::uint8_t>(number(answer, 1));
  read(mapping(pdo_, 0), &Configurator::take_count);
}

void Configurator::take_count(const Answer& answer) {
  entry_ = 0;
  entries_ = answer.abort_code ? 0 : number(answer, 1);
  if (entries_ > kMostEntries) entries_ = 0;  // a multiplexed PDO; nothing in it has a place of its own
  ask_entry();
}

void Configurator::ask_entry() {
  if (entry_ < entries_)
    read(mapping(pdo_, static_cast<std::uint8_t>(entry_ + 1)), &Configurator::take_entry);
  else
    end_pdo(true);
}

void Configurator::take_entry(const Answer& answer) {
  const Object where = mapping(pdo_, static_cast<std::uint8_t>(entry_ + 1));
  if (answer.abort_code)
    return fail("cannot read the mapping " + to_string(where) + ": " + abort_text(*answer.abort_code));
  const std::uint32_t entry = number(answer);
  Found& pdo = found_.back();
  const unsigned bits = entry & 0xFFU;
  pdo.entries.push_back(
      {{static_cast<std::uint16_t>(entry >> 16U), static_cast<std::uint8_t>(entry >> 8U)}, pdo.bits, bits});
  pdo.bits += bits;
  ++entry_;
  ask_entry();
}

void Configurator::end_pdo(bool there) {
  absent_ = there ? 0 : absent_ + 1;
  ++pdo_;
  if (absent_ < kMostAbsent && pdo_ < kMostPdos)
    ask_pdo();
  else
    choose();
}

// ---- what is to be set ---------------------------------------------------------------------------------------------

// One that is synchronous already, else the first that holds the object.
Configurator::Found* Configurator::choose_for(const Wanted& wanted) {
  Found* best = nullptr;
  for (Found& pdo : found_) {
    const bool holds = std::any_of(pdo.entries.begin(), pdo.entries.end(),
                                   [&](const Entry& entry) { return entry.object == wanted.object; });
    if (holds && (best == nullptr || (!best->synchronous() && pdo.synchronous()))) best = &pdo;
  }
  return best;
}

std::string Configurator::not_mapped(const Wanted& wanted) const {
  std::string text;
  std::size_t count = 0;
  for (const Found& pdo : found_)
    for (const Entry& entry : pdo.entries)
      if (++count <= kMostNamed)
        text += (text.empty() ? "" : ", ") + to_string(entry.object) + " (" + std::to_string(entry.bits) +
                " bits, TPDO " + std::to_string(pdo.number + 1) + ")";
  return "object " + to_string(wanted.object) + " is not mapped into any TPDO; " +
         (count == 0 ? "nothing is" : "mapped are " + text + (count > kMostNamed ? ", …" : ""));
}

void Configurator::choose() {
  for (const Wanted& wanted : wish_.wanted) {
    Found* const pdo = choose_for(wanted);
    if (pdo == nullptr) return fail(not_mapped(wanted));
    const Entry& entry = *std::find_if(pdo->entries.begin(), pdo->entries.end(),
                                       [&](const Entry& each) { return each.object == wanted.object; });
    const std::string where =
        "object " + to_string(wanted.object) + " is mapped into TPDO " + std::to_string(pdo->number + 1);
    if (entry.bits != wanted.type.bits)
      return fail(where + " with " + std::to_string(entry.bits) + " bits, but " + to_string(wanted.type) + " has " +
                  std::to_string(wanted.type.bits));
    if (entry.first_bit + entry.bits > 8 * CAN_MAX_DLEN)
      return fail(where + " at bit " + std::to_string(entry.first_bit) + ", beyond the 64 that a PDO has");
    pdo->used = true;
    auto place =
        std::find_if(pdos_.begin(), pdos_.end(), [&](const Pdo& each) { return each.number == pdo->number + 1; });
    if (place == pdos_.end()) place = pdos_.insert(pdos_.end(), Pdo{0, pdo->number + 1, {}});
    place->fields.push_back({wanted.channel, entry.first_bit, wanted.type});
  }
  set_next();
}

// 180h, 280h, 380h or 480h + node, its own place first.
std::optional<canid_t> Configurator::free_id(unsigned number) const {
  for (unsigned i = 0; i < kPredefinedPdos; ++i) {
    const canid_t id = kFirstPdo + 0x100 * ((number + i) % kPredefinedPdos) + wish_.node;
    const bool taken = std::any_of(found_.begin(), found_.end(), [&](const Found& each) {
      return each.number != number && each.valid() && (each.cob_id & CAN_SFF_MASK) == id;
    });
    if (!taken) return id;
  }
  return std::nullopt;
}

// Goes on with the next TPDO that is used and not as it must be.
void Configurator::set_next() {
  for (; setting_ < found_.size(); ++setting_) {
    Found& pdo = found_[setting_];
    if (!pdo.used) continue;
    const bool shared = std::any_of(found_.begin(), found_.end(), [&](const Found& each) {
      return each.number != pdo.number && each.valid() && (each.cob_id & CAN_SFF_MASK) == (pdo.cob_id & CAN_SFF_MASK);
    });
    const auto id = is_own(pdo.cob_id, wish_.node) && !shared ? std::optional<canid_t>(pdo.cob_id & CAN_SFF_MASK)
                                                              : free_id(pdo.number);
    if (!id) return fail("no identifier is left for TPDO " + std::to_string(pdo.number + 1));
    id_ = *id;
    if (pdo.valid() && (pdo.cob_id & CAN_SFF_MASK) == id_ && (pdo.cob_id & kExtended) == 0 &&
        pdo.transmission == kAtEverySync)
      continue;
    fixed_ = again_ = false;
    // While it is valid, its identifier must not be changed (CiA 301): it is disabled under the one it has.
    if (pdo.valid())
      return write(parameter(pdo.number, kCobId), pdo.cob_id | kNotValid, 4, &Configurator::take_disabled);
    return set_transmission();
  }
  finish();
}

void Configurator::take_disabled(const Answer& answer) {
  const Found& pdo = found_[setting_];
  // One whose identifier is fixed may still let its transmission type be set.
  const bool must = !is_own(pdo.cob_id, wish_.node) || (pdo.cob_id & CAN_SFF_MASK) != id_;
  if (answer.abort_code && must) return fail_identifier(*answer.abort_code);
  fixed_ = answer.abort_code.has_value();
  set_transmission();
}

void Configurator::set_transmission() {
  write(parameter(found_[setting_].number, kTransmission), kAtEverySync, 1, &Configurator::take_transmission_set);
}

void Configurator::take_transmission_set(const Answer& answer) {
  const Found& pdo = found_[setting_];
  if (answer.abort_code && pdo.transmission != kAtEverySync)
    return fail("TPDO " + std::to_string(pdo.number + 1) + " cannot be sent at every SYNC, " +
                to_string(parameter(pdo.number, kTransmission)) + ": " + abort_text(*answer.abort_code));
  read(parameter(pdo.number, kTransmission), &Configurator::take_transmission_check);
}

void Configurator::take_transmission_check(const Answer& answer) {
  Found& pdo = found_[setting_];
  if (answer.abort_code || number(answer, 1) != kAtEverySync)
    return fail("TPDO " + std::to_string(pdo.number + 1) + " was set to be sent at every SYNC, and says type " +
                (answer.abort_code ? std::string("nothing") : std::to_string(number(answer, 1))));
  pdo.transmission = kAtEverySync;
  if (fixed_) {
    ++setting_;
    return set_next();
  }
  pdo.cob_id = (pdo.cob_id & kNoRemote) | id_;
  enable();
}

void Configurator::enable() {
  const Found& pdo = found_[setting_];
  write(parameter(pdo.number, kCobId), pdo.cob_id, 4, &Configurator::take_enabled);
}

void Configurator::take_enabled(const Answer& answer) {
  const Found& pdo = found_[setting_];
  if (answer.abort_code) {
    if (std::exchange(again_, true)) return fail_identifier(*answer.abort_code);
    // Some take a new identifier only while they stay disabled, and are enabled after that.
    return write(parameter(pdo.number, kCobId), pdo.cob_id | kNotValid, 4, &Configurator::take_moved);
  }
  ++setting_;
  set_next();
}

void Configurator::take_moved(const Answer& answer) {
  if (answer.abort_code) return fail_identifier(*answer.abort_code);
  enable();
}

void Configurator::fail_identifier(std::uint32_t code) {
  const unsigned number = found_[setting_].number;
  fail("cannot set the identifier of TPDO " + std::to_string(number + 1) + ", " + to_string(parameter(number, kCobId)) +
       ": " + abort_text(code));
}

void Configurator::finish() {
  for (Pdo& pdo : pdos_) {
    const auto place =
        std::find_if(found_.begin(), found_.end(), [&](const Found& each) { return each.number + 1 == pdo.number; });
    pdo.id = place->cob_id & CAN_SFF_MASK;
  }
}

}  // namespace dwell::canopen
