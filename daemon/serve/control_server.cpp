// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/control_server.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <unordered_set>

#include "daemon/serve/listener.hpp"

namespace dwell {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;
using boost::system::error_code;

namespace {
class Caller;
constexpr mode_t kMode = 0660;
}  // namespace

struct ControlServer::Impl : std::enable_shared_from_this<ControlServer::Impl> {
  Impl(EventLoop& loop, ControlOptions asked, Handler answers)
      : options(std::move(asked)), handler(std::move(answers)), listener(loop) {}

  void welcome(Local::socket socket);
  bool make_room();

  const ControlOptions options;
  const Handler handler;
  Listener<Local> listener;
  std::unordered_set<Caller*> callers;
  std::unordered_set<std::shared_ptr<Caller>> awaiting;  // an answer that takes time
  std::uint64_t came = 0;
};

namespace {

class Caller : public std::enable_shared_from_this<Caller> {
 public:
  Caller(std::shared_ptr<ControlServer::Impl> server, Local::socket socket)
      : server_(std::move(server)),
        socket_(std::move(socket)),
        deadline_(socket_.get_executor()),
        number_(server_->came++) {
    server_->callers.insert(this);
    ucred who{};
    socklen_t size = sizeof who;
    if (getsockopt(socket_.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &size) == 0) peer_ = {who.uid, who.pid};
  }
  ~Caller() { server_->callers.erase(this); }
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;

  void read() {
    limit_time();
    asio::async_read_until(
        socket_, asio::dynamic_buffer(line_, server_->options.line_bytes), '\n',
        [self = shared_from_this()](const error_code& error, std::size_t size) { self->received(error, size); });
  }

  void close() {
    server_->callers.erase(this);
    const auto self = shared_from_this();
    server_->awaiting.erase(self);
    error_code ignored;
    socket_.close(ignored);
    limit_no_more();
  }

  // Has sent a whole line.
  [[nodiscard]] bool asked() const noexcept { return asked_; }
  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }

 private:
  // Asio cannot take back a handler that is queued already, so the handler compares its number with the newest wait's.
  void limit_time() {
    deadline_.expires_after(server_->options.idle_time);
    deadline_.async_wait([weak = weak_from_this(), number = ++waits_](const error_code& error) {
      if (error) return;
      if (const auto self = weak.lock(); self && self->waits_ == number) self->close();
    });
  }
  void limit_no_more() {
    ++waits_;
    deadline_.cancel();
  }

  void received(const error_code& error, std::size_t size) {
    if (error == asio::error::not_found)
      return answer(R"({"error":"the request has more bytes than a line may have, which is )" +
                        std::to_string(server_->options.line_bytes) + "\"}",
                    false);
    if (error) return close();
    asked_ = true;
    std::string_view line(line_.data(), size - 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    constexpr const char* kNone = R"({"error":"the answer could not be made"})";
    ControlReply reply(kNone);
    try {
      reply = server_->handler(line, peer_);
    } catch (const std::exception&) {  // the reply stays as it is
    }
    line_.erase(0, size);
    if (!reply.later) return answer(std::move(reply.now), true);
    try {
      await(reply.later);
    } catch (const std::exception&) {
      answer(kNone, true);
    }
  }

  // The server keeps this connection until the answer has come.
  void await(const std::function<void(ControlReply::Answer)>& work) {
    limit_no_more();  // the answer may take its time
    server_->awaiting.insert(shared_from_this());
    work([weak = weak_from_this()](std::string line) {
      if (const auto self = weak.lock()) self->answer(std::move(line), true);
    });
  }

  void answer(std::string reply, bool go_on) {
    server_->awaiting.erase(shared_from_this());
    auto text = std::make_shared<std::string>(std::move(reply));
    text->push_back('\n');
    limit_time();
    asio::async_write(socket_, asio::buffer(*text),
                      [self = shared_from_this(), text, go_on](const error_code& error, std::size_t) {
                        if (error || !go_on) return self->close();
                        self->read();
                      });
  }

  const std::shared_ptr<ControlServer::Impl> server_;
  Local::socket socket_;
  asio::steady_timer deadline_;
  std::uint64_t waits_ = 0;  // number of the deadline's newest wait
  std::string line_;
  Peer peer_;
  const std::uint64_t number_;  // in the order of their coming
  bool asked_ = false;
};

// Removes what a dead process left behind; the reason why not, or nothing.
std::string clear(asio::io_context& context, const std::string& path) {
  struct stat is {};
  if (lstat(path.c_str(), &is) != 0) return {};
  if (!S_ISSOCK(is.st_mode)) return "is there already and is no socket";
  Local::socket probe(context);
  error_code error;
  probe.connect(Local::endpoint(path), error);
  if (!error) return "is in use: another dwelld is running";
  if (error != asio::error::connection_refused) return error.message();
  unlink(path.c_str());
  return {};
}

}  // namespace

void ControlServer::Impl::welcome(Local::socket socket) {
  if (callers.size() < options.clients || make_room())
    std::make_shared<Caller>(shared_from_this(), std::move(socket))->read();
}

// Closes the oldest connection that has not asked anything; false: all have.
bool ControlServer::Impl::make_room() {
  Caller* oldest = nullptr;
  for (Caller* caller : callers)
    if (!caller->asked() && (oldest == nullptr || caller->number() < oldest->number())) oldest = caller;
  if (oldest == nullptr) return false;
  oldest->close();
  return true;
}

tl::expected<std::unique_ptr<ControlServer>, std::string> ControlServer::make(EventLoop& loop,
                                                                              const ControlOptions& options,
                                                                              Handler handler) {
  const auto failed = [&options](const std::string& why) {
    return tl::unexpected("control socket " + options.path + ": " + why);
  };
  // The kernel's limit, and Asio throws beyond it.
  if (options.path.empty() || options.path.size() >= sizeof(sockaddr_un{}.sun_path))
    return failed("the path is empty or too long");
  const std::string obstacle = clear(loop.context(), options.path);
  if (!obstacle.empty()) return failed(obstacle);
  auto impl = std::make_shared<Impl>(loop, options, std::move(handler));
  Local::acceptor& acceptor = impl->listener.acceptor();
  error_code error;
  acceptor.open(Local(), error);
  if (!error) acceptor.bind(Local::endpoint(options.path), error);
  if (error) return failed(error.message());
  // Before listen(): until then nobody can connect, whatever the umask.
  if (chmod(options.path.c_str(), kMode) != 0) return failed("its mode cannot be set");
  impl->listener.begin([server = impl.get()](Local::socket socket) { server->welcome(std::move(socket)); }, error);
  if (error) return failed(error.message());
  return std::unique_ptr<ControlServer>(new ControlServer(std::move(impl)));
}

ControlServer::ControlServer(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

ControlServer::~ControlServer() {
  impl_->listener.close();
  const auto callers = impl_->callers;
  for (Caller* caller : callers) caller->close();
  unlink(impl_->options.path.c_str());
}

}  // namespace dwell
