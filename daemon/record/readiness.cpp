#include "daemon/record/readiness.hpp"

#include <algorithm>

namespace dwell::record {

bool Readiness::look(const ClockPair& now) {
  next_look_ns_ = now.raw_ns + kLook_ns;
  if (log_.progress() != nullptr) {
    healed();
    return false;
  }
  const bool was_open = open_;
  const auto ready = folder_.ready();
  open_ = open_ || folder_.is_open();
  if (!open_) next_look_ns_ = now.raw_ns + kRetry_ns;
  if (open_ && !was_open) opened();
  if (!ready && !std::exchange(told_trouble_, true))
    tell_({Notice::Grade::error, "runs cannot be recorded: " + ready.error() + "; measuring goes on", 0, {}});
  trouble_ = ready ? std::string() : std::string(ready.error());
  if (!ready) return false;
  if (log_.stopped().empty()) {
    healed();
    return false;
  }
  // A run that was asked for begins once its record has come through the stream: until then nothing here has changed.
  if (now.raw_ns - std::max(log_.stopped_ns(), asked_ns_.value_or(INT64_MIN)) < kRetry_ns) return false;
  asked_ns_ = now.raw_ns;
  healed();
  log_.goes_on();
  return true;
}

// Told when a run is about to begin, or nothing keeps one from it: not while a stopped run waits to go on.
void Readiness::healed() {
  trouble_.clear();
  if (std::exchange(told_trouble_, false)) tell_({Notice::Grade::info, "runs can be recorded again", 0, {}});
}

void Readiness::opened() {
  if (folder_.key_is_new())
    tell_({Notice::Grade::info, "a key was made, for there was none: " + folder_.key().vkey(), 0, {}});
  const auto cut_off = folder_.take_cut_off();
  if (!cut_off) return;
  std::string text = "run " + std::to_string(cut_off->run) + " was cut off";
  if (!cut_off->until_utc.empty()) text += " at " + cut_off->until_utc;
  text += cut_off->file.empty() ? ", it has no file" : ", " + cut_off->file;
  if (!cut_off->trouble.empty()) text += "; it cannot be read, and the ledger has no head of it: " + cut_off->trouble;
  log_.interrupted(text);
  log_.keep_label(cut_off->label, cut_off->comment);
  log_.goes_on();
  tell_({Notice::Grade::warning, text, cut_off->run, {}});
}

std::string Readiness::why_not() const {
  if (!trouble_.empty()) return trouble_;
  if (told_trouble_ && !log_.stopped().empty())
    return "what kept runs from being recorded is mended; a new run begins within 30 s";
  return log_.stopped();
}

}  // namespace dwell::record
