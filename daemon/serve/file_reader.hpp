// Reads files for the HTTP server on a thread of its own: a disk that hangs must not hold up the event loop.
//
// The thread has the lowest priority and reads at most kBytesPerSecond, all downloads together, so that no download
// takes processor or disk from the measurement. The thread starts with the first file. The class is bound to the event
// loop's thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "daemon/record/job_thread.hpp"
#include "daemon/serve/http_server.hpp"

namespace dwell {

class EventLoop;

class FileReader {
 public:
  // Larger: more memory for each download. Smaller: more turns of the event loop.
  static constexpr std::size_t kPieceBytes = 128 * 1024;
  // At this rate the event loop uses about 1 % of a processor. A gigabit network carries six times as much.
  static constexpr double kBytesPerSecond = 20e6;

  class OpenedFile;  // keeps the file open
  struct Opened {
    std::shared_ptr<OpenedFile> file;
    std::uint64_t bytes = 0;
  };

  explicit FileReader(EventLoop& loop);
  ~FileReader() { close(); }
  // Forgets what was asked for: no `done` is called any more.
  void close();
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  // Opens a run file that is complete in itself; refuses links, and a file beside which a -wal lies. `done` is called
  // on the loop, with the answer to be given in place of the file where there is none.
  void open(std::string path, std::function<void(tl::expected<Opened, HttpReply>)> done);
  // Gives `done` the next piece. Empty: it could not be read, or the file has changed since it was opened. Not to be
  // called after the last piece.
  void read(const std::shared_ptr<OpenedFile>& file, std::function<void(std::string)> done);

 private:
  struct Shared;
  // Does `work` on the thread, then `then` with its outcome on the loop.
  template <class Work, class Then>
  void ask(Work work, Then then);

  const std::shared_ptr<Shared> shared_;
  std::uint64_t next_ = 0;  // number of the next question
  std::optional<record::JobThread> thread_;
};

}  // namespace dwell
