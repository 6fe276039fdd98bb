#include "daemon/ctl/http_client.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>
#include <utility>

namespace dwell::ctl {
namespace {

using Got = StreamSocket::Got;

struct Header {
  int status = 0;
  std::optional<std::size_t> content_length;
  bool encoded = false;
};

bool same_word(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [&](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

template <typename Number>
bool whole_number(std::string_view text, Number& number) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  return code == std::errc{} && end == text.data() + text.size() && !text.empty();
}

// The header without its final empty line; none: not HTTP.
std::optional<Header> parse_header(std::string_view text) {
  Header header;
  bool first = true;
  while (!text.empty()) {
    const auto end = std::min(text.find("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 2, text.size()));
    if (std::exchange(first, false)) {
      if (line.size() < 12 || line.substr(0, 7) != "HTTP/1." || line[8] != ' ') return std::nullopt;
      if (!whole_number(line.substr(9, 3), header.status)) return std::nullopt;
      continue;
    }
    const auto colon = line.find(':');
    if (colon == std::string_view::npos) return std::nullopt;
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (same_word(name, "content-length")) {
      std::size_t length = 0;
      if (!whole_number(value, length)) return std::nullopt;
      header.content_length = length;
    } else if (same_word(name, "transfer-encoding")) {
      header.encoded = true;
    }
  }
  return header.status >= 100 ? std::optional(header) : std::nullopt;
}

struct Begun {
  StreamSocket socket;
  Header header;
  std::string received;  // of the body
};

tl::expected<Begun, std::string> request(const Url& url, std::string_view path, const char* accept,
                                         const HttpLimits& limits, Deadline deadline) {
  auto socket = StreamSocket::connect_tcp(url.host, url.port, deadline);
  if (!socket) return tl::unexpected(socket.error());
  std::string text = "GET " + url.prefix;
  text.append(path).append(" HTTP/1.1\r\nHost: ").append(url.authority);
  if (!url.token.empty()) text.append("\r\nAuthorization: Bearer ").append(url.token);
  text.append("\r\nAccept: ").append(accept).append("\r\nConnection: close\r\nUser-Agent: dwellctl\r\n\r\n");
  if (const auto sent = socket->send(text, deadline); !sent) return tl::unexpected(sent.error());
  std::string received;
  while (true) {
    const auto end = received.find("\r\n\r\n");
    if (end != std::string::npos) {
      const auto header = parse_header(std::string_view(received).substr(0, end));
      if (!header) return tl::unexpected(std::string("what answers is not an HTTP server"));
      if (header->encoded) return tl::unexpected(std::string("the answer's transfer encoding is not understood"));
      return Begun{std::move(*socket), *header, received.substr(end + 4)};
    }
    if (received.size() >= limits.header_bytes) return tl::unexpected(std::string("the answer's header is too long"));
    const auto got = socket->receive(received, limits.header_bytes - received.size(), deadline);
    if (!got) return tl::unexpected(got.error());
    if (*got == Got::timeout) return tl::unexpected(std::string("no answer in time"));
    if (*got == Got::end) return tl::unexpected(std::string("the connection was closed before an answer"));
  }
}

tl::expected<HttpAnswer, std::string> get(const Url& url, std::string_view path, const HttpLimits& limits) {
  const Deadline deadline = in(limits.time);
  auto begun = request(url, path, "application/json", limits, deadline);
  if (!begun) return tl::unexpected(begun.error());
  const std::size_t most = limits.body_bytes;
  const auto length = begun->header.content_length;
  if (length && *length > most) return tl::unexpected("the answer is too large, " + std::to_string(*length) + " bytes");
  std::string body = std::move(begun->received);
  while (!length || body.size() < *length) {
    if (body.size() > most) return tl::unexpected(std::string("the answer is too large"));
    const auto got = begun->socket.receive(body, length ? *length - body.size() : most + 1 - body.size(), deadline);
    if (!got) return tl::unexpected(got.error());
    if (*got == Got::timeout) return tl::unexpected(std::string("the answer did not end in time"));
    if (*got == Got::end) {
      if (!length) break;
      return tl::unexpected("the answer ends after " + std::to_string(body.size()) + " of " + std::to_string(*length) +
                            " bytes");
    }
  }
  if (length) body.resize(*length);
  return HttpAnswer{begun->header.status, std::move(body)};
}

}  // namespace

tl::expected<Url, std::string> parse_url(std::string_view text) {
  const auto refused = [&] {
    return tl::unexpected(std::string(text) + " is no address of the service: expected http://HOST[:PORT]");
  };
  constexpr std::string_view scheme = "http://";
  // Nothing that could end the request line early may come from the command line.
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < '\x7F'; });
  if (!plain || text.substr(0, scheme.size()) != scheme) return refused();
  Url url;
  url.text = text;
  std::string_view rest = text.substr(scheme.size());
  const auto slash = std::min(rest.find('/'), rest.size());
  std::string_view prefix = rest.substr(slash);
  while (!prefix.empty() && prefix.back() == '/') prefix.remove_suffix(1);
  url.prefix = prefix;
  std::string_view host = rest.substr(0, slash);
  url.authority = host;
  std::string_view after = host;
  if (!host.empty() && host.front() == '[') {
    const auto close = host.find(']');
    if (close == std::string_view::npos) return refused();
    url.host = host.substr(1, close - 1);
    after = host.substr(close + 1);
  } else {
    url.host = host.substr(0, host.find(':'));
    after = host.substr(url.host.size());
  }
  if (!after.empty()) {
    std::uint16_t port = 0;
    if (after.front() != ':' || !whole_number(after.substr(1), port)) return refused();
    url.port = std::to_string(port);
  }
  if (url.host.empty()) return refused();
  return url;
}

tl::expected<HttpAnswer, std::string> http_get(const Url& url, std::string_view path, const HttpLimits& limits) {
  auto answer = get(url, path, limits);
  if (!answer) return tl::unexpected(url.text + ": " + answer.error());
  return answer;
}

EventStream::EventStream(StreamSocket socket, std::string received, std::size_t event_bytes)
    : socket_(std::move(socket)), buffer_(std::move(received)), event_bytes_(event_bytes) {}

tl::expected<EventStream, std::string> EventStream::open(const Url& url, std::string_view path,
                                                         const HttpLimits& limits) {
  auto begun = request(url, path, "text/event-stream", limits, in(limits.time));
  if (!begun) return tl::unexpected(url.text + ": " + begun.error());
  if (begun->header.status != 200) {
    return tl::unexpected(url.text + ": the stream was refused, status " + std::to_string(begun->header.status));
  }
  return EventStream(std::move(begun->socket), std::move(begun->received), limits.event_bytes);
}

bool EventStream::take_lines(Event& event) {
  std::size_t begin = 0;
  bool complete = false;
  while (!complete) {
    const auto end = buffer_.find('\n', std::max(begin, searched_));
    if (end == std::string::npos) break;
    std::string_view line = std::string_view(buffer_).substr(begin, end - begin);
    begin = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    const auto colon = std::min(line.find(':'), line.size());
    const std::string_view field = line.substr(0, colon);
    std::string_view value = line.substr(std::min(colon + 1, line.size()));
    if (!value.empty() && value.front() == ' ') value.remove_prefix(1);
    if (line.empty()) {
      complete = std::exchange(has_data_, false);
      if (complete) event = std::move(pending_);
      pending_ = {};
    } else if (field == "event") {
      pending_.name = value;
    } else if (field == "data") {
      if (std::exchange(has_data_, true)) pending_.data += '\n';
      pending_.data += value;
    }
  }
  buffer_.erase(0, begin);
  searched_ = complete ? 0 : buffer_.size();
  return complete;
}

tl::expected<EventStream::Next, std::string> EventStream::next(Event& event, Deadline deadline, int stop_fd) {
  while (true) {
    if (take_lines(event)) return Next::event;
    if (buffer_.size() + pending_.data.size() > event_bytes_) {
      return tl::unexpected(std::string("an event of the stream is too large"));
    }
    const auto got = socket_.receive(buffer_, 1U << 16U, deadline, stop_fd);
    if (!got) return tl::unexpected(got.error());
    if (*got == Got::timeout) return Next::timeout;
    if (*got == Got::stopped) return Next::stopped;
    if (*got == Got::end) return Next::ended;
  }
}

}  // namespace dwell::ctl
