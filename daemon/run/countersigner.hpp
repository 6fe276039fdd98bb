// Signs closed runs with the service's key for users of this computer who ask over the control socket. Enters
// signatures by persons' own keys into the ledger, which only the service may write. A file's chain is followed before
// it is signed, which takes as long as reading the file. So a thread of its own does one file after the other.
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
  std::string file;                     // its path, or its name in the recording directory
  bool enter = false;                   // sign nothing; enter the signatures that the ledger does not know
  record::PersonalSignature statement;  // name (empty: as the system calls the user), meaning, reason
  std::uint32_t uid = 0;                // who asks
};

// What was done. run: its number on the ledger.
struct Signed {
  std::int64_t run = 0;
  std::optional<record::PersonalSignature> signature;  // of the service; none: it was not asked for one
  std::size_t entered = 0;                             // signatures that the ledger now knows and did not before
};

// Parses a line of the control socket: {"verb":"sign","file":…,"meaning":…,"name":…,"reason":…} or
// {"verb":"enter","file":…}. name and reason may be missing; meaning must not be empty. Fails with what was expected.
// nullopt: the line asks for something else, or has more than 64 brackets, in its texts too: so deep the parser might
// recurse.
[[nodiscard]] std::optional<record::Result<SignRequest>> parse_sign_request(std::string_view line, std::uint32_t uid);
// {"run":17,"signature":{…}}, {"run":17,"entered":1} or {"error":…}
[[nodiscard]] std::string sign_answer(const record::Result<Signed>& result);

// The path of a file that may be signed: a regular file *.dwell in `directory` itself, and no link. Fails with what was
// found.
[[nodiscard]] record::Result<std::string> run_file_in(const std::string& directory, const std::string& file);

class Countersigner {
 public:
  // Enters a signature under this run into the ledger. Called on the signing thread; may wait.
  using Enter = std::function<record::Result<void>(std::int64_t run, const record::PersonalSignature& signature)>;
  using Done = std::function<void(const record::Result<Signed>&)>;

  // directory: that of the recordings, which holds the service's key. Starts the thread.
  Countersigner(std::string directory, Enter enter);
  // Waits while a file is being signed; gives up reading one whose signatures are to be entered. For the waiting ones
  // `done` is called with an error.
  ~Countersigner();
  Countersigner(const Countersigner&) = delete;
  Countersigner& operator=(const Countersigner&) = delete;

  // Thread-safe, never waits for the disk. done: called once and must not throw; on the signing thread, by ask() itself
  // if too many wait, or by the destructor.
  void ask(SignRequest request, Done done);

 private:
  struct Job {
    SignRequest request;
    Done done;
  };
  void run();
  [[nodiscard]] record::Result<Signed> answer_to(const SignRequest& request) const;
  [[nodiscard]] record::Result<Signed> sign(const SignRequest& request, const std::string& path) const;
  [[nodiscard]] record::Result<Signed> enter(const std::string& path) const;

  const std::string directory_;
  const Enter enter_;
  mutable std::mutex mutex_;  // guards jobs_ and stopping_
  std::condition_variable job_came_;
  std::deque<Job> jobs_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace dwell
