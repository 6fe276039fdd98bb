// Sends run files over HTTP, a piece at a time: the next one is read when the client has taken the one before. So a
// download holds two pieces of memory, whatever the size of its file. For http_connection.hpp alone, as that is for the
// one translation unit that includes Beast. Bound to the event loop's thread.
#pragma once

#include <boost/asio/write.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "daemon/serve/file_reader.hpp"

namespace dwell {

class Downloads {
 public:
  // The connection, as its download sees it. What the functions hold keeps it and its server alive until the download
  // has ended; one of refuse, sent and failed is the last that is called.
  struct Client {
    boost::beast::tcp_stream& stream;
    std::chrono::milliseconds time;                        // for the client to take a piece
    std::function<std::string(std::uint64_t bytes)> head;  // of the answer whose body has so many bytes
    std::function<void(HttpReply)> refuse;                 // this is to be answered in place of the file
    std::function<void()> sent;                            // all of it
    std::function<void()> failed;                          // amid the file: only closing tells the client
  };

  // most: files that are sent at once.
  Downloads(EventLoop& loop, std::size_t most) : files_(loop), most_(most) {}

  // Sends the file at `path`; head_alone: only how it would be sent.
  void begin(const std::string& path, bool head_alone, Client client) {
    if (*under_way_ >= most_)
      return client.refuse(http_error(
          503,
          std::to_string(*under_way_) + " files are being downloaded, no more are allowed at once; try again later"));
    const auto sending = std::make_shared<Sending>(files_, under_way_, head_alone, std::move(client));
    files_.open(path, [sending](tl::expected<FileReader::Opened, HttpReply> opened) {
      sending->guarded([&] { sending->opened(std::move(opened)); });
    });
  }

  // Ends all of them, without a word.
  void close() { files_.close(); }

 private:
  class Sending : public std::enable_shared_from_this<Sending> {
   public:
    Sending(FileReader& files, std::shared_ptr<std::size_t> under_way, bool head_alone, Client client)
        : files_(files), under_way_(std::move(under_way)), head_alone_(head_alone), client_(std::move(client)) {
      ++*under_way_;
      client_.stream.expires_never();  // the disk has no deadline: a download whose disk hangs keeps its place
    }
    ~Sending() {
      if (file_) files_.forget(std::move(file_));
      --*under_way_;
    }
    Sending(const Sending&) = delete;
    Sending& operator=(const Sending&) = delete;

    // Does a step. Where memory runs out in it, nothing would be under way any more.
    template <class Step>
    void guarded(Step step) {
      try {
        step();
      } catch (const std::exception&) {
        client_.failed();
      }
    }

    void opened(tl::expected<FileReader::Opened, HttpReply> opened) {
      if (!opened) return client_.refuse(std::move(opened.error()));
      file_ = std::move(opened->file);
      left_ = head_alone_ ? 0 : opened->bytes;
      send(client_.head(opened->bytes));
    }

   private:
    void send(std::string piece) {
      client_.stream.expires_after(client_.time);
      piece_ = std::move(piece);
      boost::asio::async_write(client_.stream, boost::asio::buffer(piece_),
                               [self = shared_from_this()](const boost::system::error_code& error, std::size_t) {
                                 if (!error) self->guarded([&] { self->go_on(); });
                               });
    }

    void go_on() {
      if (left_ == 0) return client_.sent();
      client_.stream.expires_never();
      files_.read(file_, [self = shared_from_this()](std::string piece) {
        self->guarded([&] {
          // Fewer bytes than were announced tell the client that the file is not complete.
          if (piece.empty() || piece.size() > self->left_) return self->client_.failed();
          self->left_ -= piece.size();
          self->send(std::move(piece));
        });
      });
    }

    FileReader& files_;
    const std::shared_ptr<std::size_t> under_way_;
    const bool head_alone_;
    const Client client_;
    std::shared_ptr<FileReader::OpenedFile> file_;
    std::uint64_t left_ = 0;  // bytes of the file behind the piece that is being sent
    std::string piece_;
  };

  FileReader files_;
  const std::size_t most_;
  const std::shared_ptr<std::size_t> under_way_ = std::make_shared<std::size_t>(0);
};

}  // namespace dwell
