#include "common/rpc/probe.h"

#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string_view>

#include "common/rpc/free_with.h"

namespace parallax {
namespace {

constexpr timeval kPatience{2, 0};  // For each step.

// The client's preface of HTTP/2 and an empty SETTINGS frame.   Source: RFC 9113, 3.4 and 4.1.
constexpr std::string_view kPreface("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
constexpr size_t kFrameHeaderBytes = 9;
constexpr char kSettingsFrame = 4;

struct SocketName {
  sockaddr_storage storage{};
  socklen_t size = 0;
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
};

// The address to connect to.
absl::StatusOr<SocketName> NameOf(const RpcAddress& address) {
  SocketName name;
  if (address.is_unix()) {
    auto* const un = reinterpret_cast<sockaddr_un*>(&name.storage);
    un->sun_family = AF_UNIX;
    std::memcpy(un->sun_path, address.unix_path.c_str(), address.unix_path.size() + 1);
    name.size = sizeof *un;
    return name;
  }
  const std::string host = address.host == "0.0.0.0" ? "127.0.0.1"
                           : address.host == "::"    ? "::1"
                                                     : address.host;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failed =
      getaddrinfo(host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (failed != 0) return Unavailable("{}", gai_strerror(failed));
  std::memcpy(&name.storage, found->ai_addr, found->ai_addrlen);
  name.size = found->ai_addrlen;
  freeaddrinfo(found);
  return name;
}

// Binds the socket to a port of its own on the address that it connects to, and returns the name
// that the other side will see.
absl::StatusOr<std::string> NameOwnEnd(int fd, const RpcAddress& address, SocketName to) {
  auto* const v4 = reinterpret_cast<sockaddr_in*>(&to.storage);
  auto* const v6 = reinterpret_cast<sockaddr_in6*>(&to.storage);
  const bool is_v4 = to.storage.ss_family == AF_INET;
  (is_v4 ? v4->sin_port : v6->sin6_port) = 0;
  if (bind(fd, to.get(), to.size) != 0 || getsockname(fd, to.get(), &to.size) != 0) {
    return ErrnoError(errno, "ask " + address.ToString());
  }
  char host[NI_MAXHOST];
  getnameinfo(to.get(), to.size, host, sizeof host, nullptr, 0, NI_NUMERICHOST);
  return is_v4 ? fmt::format("ipv4:{}:{}", host, ntohs(v4->sin_port))
               : fmt::format("ipv6:%5B{}%5D:{}", host, ntohs(v6->sin6_port));
}

bool AnswersPlain(int fd) {
  if (send(fd, kPreface.data(), kPreface.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(kPreface.size())) {
    return false;
  }
  char header[kFrameHeaderBytes];
  const ssize_t got = recv(fd, header, sizeof header, MSG_WAITALL);
  return got == static_cast<ssize_t>(sizeof header) && header[3] == kSettingsFrame;
}

// Shows no certificate: with TLS 1.3 the server's part is complete before it asks for ours.
bool AnswersTls(int fd) {
  const std::unique_ptr<SSL_CTX, FreeWith<SSL_CTX_free>> context(SSL_CTX_new(TLS_client_method()));
  const std::unique_ptr<SSL, FreeWith<SSL_free>> ssl(context == nullptr ? nullptr
                                                                        : SSL_new(context.get()));
  if (ssl == nullptr) return false;
  SSL_set_fd(ssl.get(), fd);
  const bool done = SSL_connect(ssl.get()) == 1;
  ERR_clear_error();
  return done;
}

}  // namespace

absl::Status CheckRpcAnswers(const RpcAddress& address, bool tls,
                             const std::function<void(const std::string& peer)>& expect) {
  ASSIGN_OR_RETURN(SocketName to, NameOf(address));
  const int fd = socket(to.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return ErrnoError(errno, "ask " + address.ToString());
  const std::unique_ptr<const int, void (*)(const int*)> owner(&fd,
                                                               [](const int* f) { close(*f); });
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  if (!address.is_unix()) {
    ASSIGN_OR_RETURN(const std::string own, NameOwnEnd(fd, address, to));
    expect(own);
  }
  if (connect(fd, to.get(), to.size) != 0) {
    return Unavailable("gRPC at {} does not accept: {}", address.ToString(), std::strerror(errno));
  }
  if (tls ? AnswersTls(fd) : AnswersPlain(fd)) return absl::OkStatus();
  return Unavailable("gRPC at {} accepts and does not answer", address.ToString());
}

}  // namespace parallax
