// Reads files for the HTTP server aside, at most kBytesPerSecond for all downloads together. Bound to the event loop's
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "daemon/serve/aside.hpp"
#include "daemon/serve/http_server.hpp"

namespace dwell {

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
  // Forgets what was asked for: no `done` is called any more.
  void close() { aside_.close(); }

  // Opens a run file that is complete in itself; refuses links, and a file beside which a -wal lies. `done` is called
  // on the loop, with the answer to be given in place of the file where there is none.
  void open(std::string path, std::function<void(tl::expected<Opened, HttpReply>)> done);
  // Gives `done` the next piece. Empty: it could not be read, or the file has changed since it was opened. Not to be
  // called after the last piece.
  void read(const std::shared_ptr<OpenedFile>& file, std::function<void(std::string)> done);
  // Closes the file, aside: it may have been deleted, and then its room on the disk is freed, which takes long.
  void forget(std::shared_ptr<OpenedFile> file);

 private:
  Aside aside_;
};

}  // namespace dwell
