// Signs closed runs for users of this computer who ask over the control socket: the service's key vouches for their
// words. A file's chain is followed before it is signed, which takes as long as reading the file. So a thread of its
// own does one file after the other.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "daemon/record/run_entries.hpp"

namespace dwell {

struct SignRequest {
  std::string file;                 // its path, or its name in the recording directory
  record::PersonalSignature words;  // name (empty: as the system calls the user), meaning, reason
  std::uint32_t uid = 0;            // who asks
};

// What was signed. run: its number on the ledger; 0: a child file.
struct Countersigned {
  std::int64_t run = 0;
  record::PersonalSignature signature;
};

// Parses a line of the control socket: {"verb":"sign","file":…,"meaning":…,"name":…,"reason":…}; the last two may be
// missing. Fails with what was expected. nullopt: the line asks for something else.
[[nodiscard]] std::optional<record::Result<SignRequest>> parse_sign_request(std::string_view line, std::uint32_t uid);
// {"run":17,"signature":{…}} or {"error":…}
[[nodiscard]] std::string sign_answer(const record::Result<Countersigned>& result);

// The path of a file that may be signed: a regular file *.dwell in `directory` itself, and no link. Fails with what was
// found.
[[nodiscard]] record::Result<std::string> run_file_in(const std::string& directory, const std::string& file);

class Countersigner {
 public:
  // Enters the signature into the ledger. Called on the signing thread; may wait.
  using Enter = std::function<record::Result<void>(const Countersigned&)>;
  using Done = std::function<void(const record::Result<Countersigned>&)>;

  // directory: that of the recordings, which holds the service's key. Starts the thread.
  Countersigner(std::string directory, Enter enter);
  // Waits for the current file. For the waiting ones `done` is called with an error.
  ~Countersigner();
  Countersigner(const Countersigner&) = delete;
  Countersigner& operator=(const Countersigner&) = delete;

  // Thread-safe, never waits for the disk. done: called once, on the signing thread; or at once, if too many wait.
  void ask(SignRequest request, Done done);

 private:
  struct Job {
    SignRequest request;
    Done done;
  };
  void run();
  [[nodiscard]] record::Result<Countersigned> sign_or_why_not(const SignRequest& request) const;
  [[nodiscard]] record::Result<Countersigned> sign(const SignRequest& request) const;

  const std::string directory_;
  const Enter enter_;
  std::mutex mutex_;  // guards jobs_ and stopping_
  std::condition_variable came_;
  std::deque<Job> jobs_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace dwell
