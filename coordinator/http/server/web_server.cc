#include "coordinator/http/server/web_server.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <chrono>
#include <thread>
#include <type_traits>

namespace parallax {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Error = boost::system::error_code;
using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

// Threads that read, write and encrypt, and threads of handlers.
constexpr int kIoThreads = 2;
constexpr int kHandlerThreads = 16;
// Replies of up to this size are not counted: health and figures come while large ones are sent.
constexpr int64_t kSmallReplyBytes = 256 << 10;
// A refused caller that goes on sending is heard so long, so that the refusal arrives.
constexpr double kGoodbye_s = 1;
constexpr size_t kGoodbyeBytes = 256 << 10;

std::chrono::nanoseconds Span(double seconds) {
  return std::chrono::nanoseconds(static_cast<int64_t>(seconds * 1e9));
}

int DigitOf(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// Decodes %XX. Returns nothing for a broken code or a control character.
std::optional<std::string> Decode(std::string_view text, bool plus_is_space) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = DigitOf(text[i + 1]), low = DigitOf(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    } else if (c == '+' && plus_is_space) {
      c = ' ';
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return std::nullopt;
    decoded += c;
  }
  return decoded;
}

bool ParseTarget(std::string_view target, ServerRequest& request) {
  if (target.empty() || target[0] != '/') return false;
  const size_t mark = target.find('?');
  const auto path = Decode(target.substr(0, mark), /*plus_is_space=*/false);
  if (!path) return false;
  request.path = *path;
  std::string_view rest = mark == target.npos ? "" : target.substr(mark + 1);
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view pair = rest.substr(0, end);
    const size_t equals = std::min(pair.find('='), pair.size());
    const auto name = Decode(pair.substr(0, equals), true);
    const auto value = Decode(pair.substr(std::min(equals + 1, pair.size())), true);
    if (!name || !value) return false;
    if (!name->empty()) request.query.emplace(*name, *value);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return true;
}

ServerReply Refusal(int status, const char* why) {
  ServerReply refusal;
  refusal.reply = ErrorReply(InvalidArgument("{}", why));
  refusal.reply.status = status;
  return refusal;
}

// The reply for an error of reading; nothing if the connection itself has failed or ended.
std::optional<ServerReply> RefusalOf(const Error& error) {
  if (error == http::error::end_of_stream || error == http::error::partial_message) return {};
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return Refusal(431, "the headers are too long");
  }
  if (error == http::error::body_limit) return Refusal(413, "the body is too long");
  if (error.category() != http::make_error_code(http::error::bad_method).category()) return {};
  return Refusal(400, "this is no HTTP request");
}

class WebServerImpl;

// One connection, from its handshake to its end. All its steps run on one strand.
template <typename Stream>
class Session final : public std::enable_shared_from_this<Session<Stream>> {
 public:
  Session(Stream stream, WebServerImpl& server, std::string peer, std::string from)
      : stream_(std::move(stream)),
        server_(server),
        peer_(std::move(peer)),
        from_(std::move(from)),
        buffer_(kMostHeaderBytes + kMostBodyBytes),
        timer_(stream_.get_executor()) {}
  ~Session() { Release(); }

  void Start() {
    asio::dispatch(stream_.get_executor(), [self = this->shared_from_this()] { self->Open(); });
  }

 private:
  static constexpr bool kIsTls = std::is_same_v<Stream, TlsStream>;
  beast::tcp_stream& Lowest() { return beast::get_lowest_layer(stream_); }
  void Open();
  void Read();
  void OnRead(const Error& error);
  void Answer();
  // Counts the reply's bytes until Release. Errors: kUnavailable.
  absl::Status Reserve(int64_t bytes);
  void Release();
  void Write(ServerReply reply, bool close);
  void OnWritten(bool close);
  void BeginEvents(const ServerReply& reply);
  void NextEvent();
  void WriteEvent(std::optional<std::string> text);
  void Refuse(ServerReply refusal);
  void Close();
  // Reads what still comes and throws it away, for a moment.
  void Drain(size_t left);
  template <typename Body>
  void SetHead(http::response<Body>& response, const WebReply& reply) const;

  Stream stream_;
  WebServerImpl& server_;
  const std::string peer_;  // As Listener::Take has it.
  const std::string from_;
  beast::flat_buffer buffer_;
  asio::steady_timer timer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
  int64_t reserved_ = 0;  // Bytes of the reply that the server has counted.
  http::response<http::empty_body> head_;
  std::optional<http::response_serializer<http::empty_body>> head_serializer_;
  std::function<std::optional<std::string>()> events_;
  double every_s_ = 0;
  std::string event_;
  int served_ = 0;
};

class WebServerImpl final : public WebServer {
 public:
  explicit WebServerImpl(WebServerOptions options) : options_(std::move(options)) {}
  ~WebServerImpl() override { Stop(); }

  absl::Status Listen() {
    if (options_.tls != nullptr) {
      tls_ = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
      SSL_CTX_set_mode(tls_->native_handle(), SSL_MODE_RELEASE_BUFFERS);
      // Tickets are the callers' to keep; the cache would be ours.
      SSL_CTX_set_session_cache_mode(tls_->native_handle(), SSL_SESS_CACHE_OFF);
      if (!options_.tls(*tls_->native_handle())) return FailedPrecondition("TLS can't be prepared");
    }
    ASSIGN_OR_RETURN(listener_, Listener::Bind({options_.listen}, options_.limits.connections));
    return absl::OkStatus();
  }

  const RpcAddress& address() const override { return listener_->addresses()[0]; }

  void Start(Handler handler, IsUrgent is_urgent) override {
    handler_ = std::move(handler);
    is_urgent_ = std::move(is_urgent);
    io_ = std::make_unique<asio::io_context>(kIoThreads);
    handlers_ = std::make_unique<asio::thread_pool>(kHandlerThreads);
    urgent_ = std::make_unique<asio::thread_pool>(1);
    work_.emplace(io_->get_executor());
    for (int i = 0; i < kIoThreads; ++i) {
      threads_.emplace_back([this] {
        pthread_setname_np(pthread_self(), "http-io");
        io_->run();
      });
    }
    listener_->Start([this](int fd, size_t, const std::string& peer) { Take(fd, peer); });
  }

  void Stop() override {
    if (listener_ != nullptr) listener_->Stop();
    for (auto* pool : {&handlers_, &urgent_}) {
      if (*pool == nullptr) continue;
      (*pool)->stop();
      (*pool)->join();
    }
    work_.reset();
    if (io_ != nullptr) io_->stop();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
    // Requests that wait for a handler hold sessions, and sessions hold sockets of io_.
    handlers_.reset();
    urgent_.reset();
    io_.reset();
  }

  Listener& listener() { return *listener_; }
  const WebServerOptions& options() const { return options_; }
  asio::thread_pool& PoolFor(const ServerRequest& request) {
    return is_urgent_(request.path) ? *urgent_ : *handlers_;
  }
  asio::thread_pool& handlers() { return *handlers_; }
  std::atomic<int64_t>& reply_bytes() { return reply_bytes_; }

  ServerReply Handle(const ServerRequest& request) const {
    try {
      return handler_(request);
    } catch (const std::exception& error) {
      ServerReply reply;
      reply.reply = ErrorReply(Internal("{}", error.what()));
      return reply;
    }
  }

 private:
  void Take(int fd, const std::string& peer) {
    // An error leaves the socket closed, or the descriptor ours.
    Error error;
    const bool is_v6 = SocketFamily(fd) == AF_INET6;
    asio::ip::tcp::socket socket(asio::make_strand(*io_));
    socket.assign(is_v6 ? asio::ip::tcp::v6() : asio::ip::tcp::v4(), fd, error);
    if (error) {
      close(fd);
      return;
    }
    const auto endpoint = socket.remote_endpoint(error);
    if (error) return;
    auto from = endpoint.address();
    if (from.is_v6() && from.to_v6().is_v4_mapped()) {
      from = asio::ip::make_address_v4(asio::ip::v4_mapped, from.to_v6());
    }
    beast::tcp_stream stream(std::move(socket));
    if (tls_ == nullptr) {
      std::make_shared<Session<PlainStream>>(std::move(stream), *this, peer, from.to_string())
          ->Start();
    } else {
      std::make_shared<Session<TlsStream>>(TlsStream(std::move(stream), *tls_), *this, peer,
                                           from.to_string())
          ->Start();
    }
  }

  static int SocketFamily(int fd) {
    sockaddr_storage name{};
    socklen_t size = sizeof name;
    getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size);
    return name.ss_family;
  }

  const WebServerOptions options_;
  Handler handler_;
  IsUrgent is_urgent_;
  std::unique_ptr<asio::ssl::context> tls_;  // Null: plain HTTP.
  std::atomic<int64_t> reply_bytes_ = 0;     // All replies under way take so many bytes.
  std::unique_ptr<asio::io_context> io_;
  std::unique_ptr<asio::thread_pool> handlers_, urgent_;
  std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_;
  std::vector<std::thread> threads_;
  std::unique_ptr<Listener> listener_;
};

template <typename Stream>
void Session<Stream>::Open() {
  if constexpr (kIsTls) {
    Lowest().expires_after(Span(server_.options().limits.handshake_s));
    stream_.async_handshake(asio::ssl::stream_base::server,
                            [self = this->shared_from_this()](const Error& error) {
                              if (!error) self->Read();
                            });
  } else {
    Read();
  }
}

template <typename Stream>
void Session<Stream>::Read() {
  parser_.emplace();
  parser_->header_limit(kMostHeaderBytes);
  parser_->body_limit(kMostBodyBytes);
  Lowest().expires_after(Span(server_.options().limits.request_s));
  http::async_read(
      stream_, buffer_, *parser_,
      [self = this->shared_from_this()](const Error& error, size_t) { self->OnRead(error); });
}

template <typename Stream>
void Session<Stream>::OnRead(const Error& error) {
  if (error == http::error::end_of_stream) return Close();
  if (error) {
    if (auto refusal = RefusalOf(error)) Refuse(*std::move(refusal));
    return;
  }
  const auto& message = parser_->get();
  if (message.method() != http::verb::get && message.method() != http::verb::head &&
      message.method() != http::verb::post) {
    return Refuse(Refusal(405, "allowed are GET, HEAD and POST"));
  }
  if (message.target().size() > kMostTargetBytes) return Refuse(Refusal(414, "too long a path"));
  if (message.count(http::field::host) != 1) return Refuse(Refusal(400, "wanted is one Host"));
  Answer();
}

template <typename Stream>
void Session<Stream>::Answer() {
  auto& message = parser_->get();
  ServerRequest request;
  if (!ParseTarget({message.target().data(), message.target().size()}, request)) {
    return Refuse(Refusal(400, "the path can't be read"));
  }
  request.method = message.method() == http::verb::post ? "POST" : "GET";
  for (const auto& field : message) {
    std::string name(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    request.headers.emplace(std::move(name), std::string(field.value()));
  }
  request.body = std::move(message.body());
  request.from = from_;
  if constexpr (kIsTls) request.tls = stream_.native_handle();
  request.know = [this] { return server_.listener().Know(peer_); };
  request.reserve = [this](int64_t bytes) { return Reserve(bytes); };
  Lowest().expires_never();
  server_.listener().SetBusy(peer_, true);
  asio::thread_pool& pool = server_.PoolFor(request);
  asio::post(pool, [self = this->shared_from_this(), request = std::move(request)]() mutable {
    ServerReply reply = self->server_.Handle(request);
    if (const absl::Status status = self->Reserve(static_cast<int64_t>(reply.reply.body.size()));
        !status.ok()) {
      reply.reply = ErrorReply(status);
    }
    Session& session = *self;
    asio::post(session.stream_.get_executor(),
               [self = std::move(self), reply = std::move(reply)]() mutable {
                 self->Write(std::move(reply), /*close=*/false);
               });
  });
}

template <typename Stream>
absl::Status Session<Stream>::Reserve(int64_t bytes) {
  if (bytes <= std::max(reserved_, kSmallReplyBytes)) return absl::OkStatus();
  const int64_t more = bytes - reserved_, most = server_.options().limits.reply_bytes;
  if (server_.reply_bytes().fetch_add(more) + more > most) {
    server_.reply_bytes().fetch_sub(more);
    return Unavailable("too many large replies are being sent (at most {} MB); try again later",
                       most >> 20);
  }
  reserved_ = bytes;
  return absl::OkStatus();
}

template <typename Stream>
void Session<Stream>::Release() {
  server_.reply_bytes().fetch_sub(reserved_);
  reserved_ = 0;
}

template <typename Stream>
template <typename Body>
void Session<Stream>::SetHead(http::response<Body>& response, const WebReply& reply) const {
  response.result(static_cast<unsigned>(reply.status));
  for (const auto& [name, value] : server_.options().headers) response.set(name, value);
  for (const auto& [name, value] : reply.headers) response.insert(name, value);
  if (reply.headers.end() ==
      std::find_if(reply.headers.begin(), reply.headers.end(),
                   [](const auto& h) { return h.first == "Cache-Control"; })) {
    response.set(http::field::cache_control, "no-store");
  }
  if (!reply.type.empty()) response.set(http::field::content_type, reply.type);
}

template <typename Stream>
void Session<Stream>::Write(ServerReply reply, bool close) {
  server_.listener().SetBusy(peer_, false);
  const auto& message = parser_->get();
  const bool is_head = message.method() == http::verb::head;
  if (reply.events != nullptr && !is_head) return BeginEvents(reply);
  const WebServerLimits& limits = server_.options().limits;
  close = close || !message.keep_alive() || ++served_ >= limits.requests;
  response_ = {};
  SetHead(response_, reply.reply);
  response_.keep_alive(!close);
  const size_t size = reply.reply.body.size();
  if (reply.reply.status != 304) response_.content_length(size);
  if (!is_head) response_.body() = std::move(reply.reply.body);
  Lowest().expires_after(Span(limits.reply_s + static_cast<double>(size) / limits.bytes_per_s));
  http::async_write(stream_, response_,
                    [self = this->shared_from_this(), close](const Error& error, size_t) {
                      if (!error) self->OnWritten(close);
                    });
}

template <typename Stream>
void Session<Stream>::OnWritten(bool close) {
  response_ = {};
  Release();
  if (close) return Close();
  server_.listener().Forget(peer_);
  Read();
}

template <typename Stream>
void Session<Stream>::Refuse(ServerReply refusal) {
  Write(std::move(refusal), /*close=*/true);
}

// ---- Streams of events
template <typename Stream>
void Session<Stream>::BeginEvents(const ServerReply& reply) {
  events_ = reply.events;
  every_s_ = reply.every_s;
  SetHead(head_, reply.reply);
  head_.set(http::field::content_type, "text/event-stream");
  head_.chunked(true);
  head_serializer_.emplace(head_);
  Lowest().expires_after(Span(server_.options().limits.reply_s));
  http::async_write_header(stream_, *head_serializer_,
                           [self = this->shared_from_this()](const Error& error, size_t) {
                             if (!error) self->NextEvent();
                           });
}

template <typename Stream>
void Session<Stream>::NextEvent() {
  asio::post(server_.handlers(), [self = this->shared_from_this()]() mutable {
    std::optional<std::string> text = self->events_();
    Session& session = *self;
    asio::post(session.stream_.get_executor(),
               [self = std::move(self), text = std::move(text)]() mutable {
                 self->WriteEvent(std::move(text));
               });
  });
}

template <typename Stream>
void Session<Stream>::WriteEvent(std::optional<std::string> text) {
  const bool is_end = !text.has_value();
  const auto wait = [self = this->shared_from_this(), is_end](const Error& error, size_t) {
    if (error) return;
    if (is_end) return self->Close();
    self->timer_.expires_after(Span(self->every_s_));
    self->timer_.async_wait([self](const Error& stopped) {
      if (!stopped) self->NextEvent();
    });
  };
  Lowest().expires_after(Span(server_.options().limits.reply_s));
  if (is_end) {
    asio::async_write(stream_, http::make_chunk_last(), wait);
  } else if (text->empty()) {
    Lowest().expires_never();
    wait({}, 0);
  } else {
    event_ = *std::move(text);
    asio::async_write(stream_, http::make_chunk(asio::buffer(event_)), wait);
  }
}

// ---- Ends
template <typename Stream>
void Session<Stream>::Close() {
  Lowest().expires_after(Span(kGoodbye_s));
  if constexpr (kIsTls) {
    stream_.async_shutdown([self = this->shared_from_this()](const Error& error) {
      if (error) self->Drain(kGoodbyeBytes);
    });
  } else {
    Error ignored;
    Lowest().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    Drain(kGoodbyeBytes);
  }
}

template <typename Stream>
void Session<Stream>::Drain(size_t left) {
  event_.resize(4096);
  Lowest().async_read_some(asio::buffer(event_),
                           [self = this->shared_from_this(), left](const Error& error, size_t n) {
                             if (!error && n < left) self->Drain(left - n);
                           });
}

}  // namespace

std::string ServerRequest::Header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Bind(WebServerOptions options) {
  auto server = std::make_unique<WebServerImpl>(std::move(options));
  RETURN_IF_ERROR(server->Listen());
  return std::unique_ptr<WebServer>(std::move(server));
}

}  // namespace parallax
