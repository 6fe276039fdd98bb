// Which SYNC an answer belongs to. A PDO does not say it: it only comes after its SYNC, once, and in turn. So a SYNC
// that stays unanswered while the next one goes out makes every answer after it doubtful: it may be the one or the
// other's. Doubt ends when as many answers have come as SYNCs gone out, or when nothing older can come any more, after
// a pause without SYNC. What is doubtful is never delivered.
//
//   begin(); answer() …; close(); late() …;  begin(); …          one SYNC after the other, for one PDO
//
// Pure; real-time safe.
#pragma once

#include <algorithm>

namespace dwell::canopen {

class Attribution {
 public:
  enum class Outcome { answered, missing, doubtful };

  // A SYNC goes out.
  void begin() noexcept {
    answers_ = 0;
    spoiled_ = false;
  }
  // An answer came while its window is open.
  void answer() noexcept { ++answers_; }
  // … or one of which it cannot be told whether it came after the SYNC.
  void spoil() noexcept { spoiled_ = true; }
  // The window closes. answered: the last answer is this SYNC's.
  Outcome close() noexcept {
    const unsigned answers = answers_;
    const bool spoiled = spoiled_;
    begin();
    if (answers == unanswered_ + 1 && !spoiled) {
      late_ += unanswered_;
      unanswered_ = 0;
      wants_pause_ = false;
      return Outcome::answered;
    }
    if (answers == 0 && !spoiled) {
      unanswered_ = std::min(unanswered_ + 1, kMost);
      return Outcome::missing;
    }
    late_ += answers;
    unanswered_ = unanswered_ + 1 > answers ? unanswered_ + 1 - answers : 1;
    wants_pause_ = true;
    return Outcome::doubtful;
  }
  // An answer came after the window, or before the SYNC: an older one's.
  void late() noexcept {
    ++late_;
    if (unanswered_ > 0) --unanswered_;
    if (unanswered_ == 0) wants_pause_ = false;
  }
  // Nothing that was asked for before can come any more.
  void forget() noexcept {
    begin();
    unanswered_ = 0;
    wants_pause_ = false;
  }
  // An answer had to be given up that the next pause would have saved.
  [[nodiscard]] bool wants_pause() const noexcept { return wants_pause_; }
  // Answers that came too late to be delivered, since the last call.
  unsigned take_late() noexcept {
    const unsigned late = late_;
    late_ = 0;
    return late;
  }

 private:
  static constexpr unsigned kMost = 1'000'000;
  unsigned answers_ = 0;     // in this window
  unsigned unanswered_ = 0;  // earlier SYNCs whose answers may still come
  unsigned late_ = 0;
  bool spoiled_ = false, wants_pause_ = false;
};

}  // namespace dwell::canopen
