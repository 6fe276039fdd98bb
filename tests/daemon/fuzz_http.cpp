// Whatever bytes a client sends, the server answers in HTTP or closes, keeps nothing of the client, takes no body
// without a certain end for the next request, and does what an
// operator may ask for only where the token was among the bytes. The real server on loopback, over a service that
// measures.
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <cctype>
#include <cerrno>
#include <string>
#include <string_view>

#include "daemon/outlets/http.hpp"
#include "daemon/serve/event_loop.hpp"
#include "tests/daemon/measured_service.hpp"
#include "tests/drivers/fuzz_bytes.hpp"

namespace {

using dwell::test::hold;

constexpr std::string_view kToken = "0123456789abcdef0123456789abcdef";

struct Server {
  Server() {
    dwell::LogOptions quiet;
    quiet.console = false;
    log = std::move(*dwell::Log::make(quiet));
    rights.emplace(dwell::Access{false, dwell::Token(kToken)}, *log);
    dwell::HttpOptions options;
    options.port = 0;
    dwell::HttpContent content{[this] { return service.view(); }};
    content.rights = &*rights;
    content.operate = [this](const dwell::OperatorRequest&, const dwell::record::Person&) {
      operated = true;
      return tl::expected<void, std::string>();
    };
    auto made = dwell::Http::make(loop, options, std::move(content));
    hold(made.has_value());
    http = std::move(*made);
  }

  // Until nothing is left to do: on loopback all that was sent is here.
  void turn() {
    while (loop.context().poll() > 0) {
    }
  }

  dwell::EventLoop loop;
  std::unique_ptr<dwell::Log> log;
  dwell::test::MeasuredService service;
  std::optional<dwell::Rights> rights;
  std::unique_ptr<dwell::Http> http;
  bool operated = false;
};

int connected_to(std::uint16_t port) {
  const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  hold(client >= 0);
  // The fuzzer's timer may interrupt connect(), which then goes on by itself.
  if (connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    hold(errno == EINTR);
    pollfd connected{client, POLLOUT, 0};
    while (poll(&connected, 1, -1) < 0) hold(errno == EINTR);
    hold((connected.revents & (POLLERR | POLLHUP)) == 0);
  }
  // Closing resets: no connection lingers and uses up a port.
  const linger none{1, 0};
  setsockopt(client, SOL_SOCKET, SO_LINGER, &none, sizeof none);
  return client;
}

bool same_letters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// Whether the first request has a Transfer-Encoding on one line that is not "chunked": its end is not certain.
bool ends_nowhere(std::string_view sent) {
  constexpr std::string_view kField = "transfer-encoding:";
  for (std::size_t at = sent.find("\r\n"); at != std::string_view::npos;) {
    sent.remove_prefix(at + 2);
    at = sent.find("\r\n");
    std::string_view line = sent.substr(0, at);
    if (line.empty() || at == std::string_view::npos) return false;
    if (!same_letters(line.substr(0, kField.size()), kField)) continue;
    const char after = at + 2 < sent.size() ? sent[at + 2] : ' ';
    line.remove_prefix(kField.size());
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    return after != ' ' && after != '\t' && !same_letters(line, "chunked");
  }
  return false;
}

// No body holds a line break before this field: JSON has none, and no page has the field.
std::size_t answers_in(std::string_view text) {
  constexpr std::string_view kOfEach = "\r\nServer: dwelld\r\n";
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(kOfEach, at)) != std::string_view::npos; at += kOfEach.size()) ++count;
  return count;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Server server;
  const std::string_view sent(reinterpret_cast<const char*>(data), size);
  server.operated = false;
  const int client = connected_to(server.http->server().port());
  server.turn();
  (void)send(client, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  server.turn();
  server.http->show(server.service.view());
  ++server.service.snapshot.sequence;
  server.turn();
  std::string answer(1 << 20, '\0');
  const ssize_t got = recv(client, answer.data(), answer.size(), MSG_DONTWAIT);
  if (got > 0) hold(std::string_view(answer).starts_with("HTTP/1.1 "));
  if (got > 0 && ends_nowhere(sent)) hold(answers_in(answer) <= 1);
  hold(!server.operated || sent.find(kToken) != std::string_view::npos);
  hold(server.http->server().stats().clients <= 1);
  close(client);
  server.turn();
  hold(server.http->server().stats().clients == 0 && server.http->server().stats().streams == 0);
  return 0;
}
