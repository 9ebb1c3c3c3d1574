#include "common/rpc/listener.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <malloc.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <utility>

#include "common/base/system/log.h"

namespace parallax {
namespace {

constexpr int kBacklog = 4096;
// A connection on which nothing came so long may wait in the kernel; then it is accepted.
constexpr int kFirstByte_s = 3;
constexpr int kPauseWithoutDescriptors_ms = 50;
constexpr int kQuiet_ms = 10'000;  // Without a newcomer.
constexpr int kTriesForOnePort = 10;
constexpr size_t kMostExpected = 16;

absl::Status ListenError(const RpcAddress& address, int error_number) {
  if (error_number == EADDRINUSE) {
    return AlreadyExists("cannot listen on {}: address already in use", address.ToString());
  }
  if (error_number == EADDRNOTAVAIL) {
    return NotFound("cannot listen on {}: no such address on this machine", address.ToString());
  }
  return ErrnoError(error_number, "cannot listen on " + address.ToString());
}

sockaddr_un UnixName(const RpcAddress& address) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, address.unix_path.c_str(), address.unix_path.size() + 1);
  return name;
}

// Inode of a socket; 0 if the descriptor is closed or something else.
ino_t InodeOf(int fd) {
  struct stat entry;
  return fstat(fd, &entry) == 0 && S_ISSOCK(entry.st_mode) ? entry.st_ino : 0;
}

struct Peer {
  std::string name;  // As gRPC writes it.
  std::string host;
};

Peer PeerOf(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  char text[INET6_ADDRSTRLEN] = "";
  if (getpeername(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  if (address.ss_family == AF_UNIX) return {"unix:", "unix"};
  const auto* const v4 = reinterpret_cast<const sockaddr_in*>(&address);
  if (address.ss_family == AF_INET) {
    inet_ntop(AF_INET, &v4->sin_addr, text, sizeof text);
    return {fmt::format("ipv4:{}:{}", text, ntohs(v4->sin_port)), text};
  }
  const auto* const v6 = reinterpret_cast<const sockaddr_in6*>(&address);
  if (IN6_IS_ADDR_V4MAPPED(&v6->sin6_addr)) {
    inet_ntop(AF_INET, v6->sin6_addr.s6_addr + 12, text, sizeof text);
    return {fmt::format("ipv4:{}:{}", text, ntohs(v6->sin6_port)), text};
  }
  inet_ntop(AF_INET6, &v6->sin6_addr, text, sizeof text);
  const std::string zone = v6->sin6_scope_id == 0 ? "" : fmt::format("%25{}", v6->sin6_scope_id);
  std::string name = fmt::format("ipv6:%5B{}{}%5D:{}", text, zone, ntohs(v6->sin6_port));
  // Somebody with IPv6 has a whole network of 64 bits, and may come from any address of it.
  in6_addr network = v6->sin6_addr;
  if (!IN6_IS_ADDR_LOOPBACK(&network)) std::memset(network.s6_addr + 8, 0, 8);
  inet_ntop(AF_INET6, &network, text, sizeof text);
  return {std::move(name), text};
}

int SocketFor(int family) { return socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

// Binds and listens. Returns 0 or errno.
int ListenOn(int fd, const sockaddr* name, socklen_t size) {
  const int yes = 1, no = 0;
  if (name->sa_family != AF_UNIX) {
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    setsockopt(fd, IPPROTO_TCP, TCP_DEFER_ACCEPT, &kFirstByte_s, sizeof kFirstByte_s);
  }
  // The address of all interfaces is that of both families.
  if (name->sa_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
  return bind(fd, name, size) == 0 && listen(fd, kBacklog) == 0 ? 0 : errno;
}

int PortOf(int fd) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0) return 0;
  return ntohs(name.ss_family == AF_INET ? reinterpret_cast<sockaddr_in*>(&name)->sin_port
                                         : reinterpret_cast<sockaddr_in6*>(&name)->sin6_port);
}

}  // namespace

// Moved only, and closed when destroyed.
struct Listener::Socket {
  int fd = -1;
  size_t address = 0;
  ino_t file = 0;  // Inode of a Unix socket's file.

  Socket(int descriptor, size_t index) : fd(descriptor), address(index) {}
  Socket(Socket&& other) noexcept
      : fd(std::exchange(other.fd, -1)), address(other.address), file(other.file) {}
  Socket& operator=(Socket&&) = delete;
  ~Socket() {
    if (fd >= 0) close(fd);
  }
};

struct Listener::Connection {
  int fd;
  ino_t inode;
  std::string peer;
  std::string host;
  bool known = false;
  bool busy = false;     // Being answered.
  bool leaving = false;  // Shut down, but not closed yet.

  bool may_go() const { return !busy && !leaving; }

  bool ended() const { return InodeOf(fd) != inode; }
  // Ends the connection for both sides. Its owner may have closed it meanwhile, and the number be
  // another file's: a copy is looked at, which can't change.
  void End() {
    const int copy = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (copy < 0) return;
    if (InodeOf(copy) == inode) shutdown(copy, SHUT_RDWR);
    close(copy);
    leaving = true;
  }
};

Listener::Listener(std::vector<RpcAddress> addresses, const ListenerLimits& limits)
    : addresses_(std::move(addresses)), limits_(limits) {}

Listener::~Listener() {
  Stop();
  for (const int fd : {wake_, spare_}) {
    if (fd >= 0) close(fd);
  }
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Bind(const std::vector<RpcAddress>& addresses,
                                                         const ListenerLimits& limits) {
  std::unique_ptr<Listener> listener(new Listener(addresses, limits));
  for (size_t i = 0; i < addresses.size(); ++i) RETURN_IF_ERROR(listener->BindAddress(i));
  listener->wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (listener->wake_ < 0) return ErrnoError(errno, "listen");
  listener->spare_ = open("/dev/null", O_RDONLY | O_CLOEXEC);
  return listener;
}

absl::Status Listener::BindAddress(size_t index) {
  RpcAddress& address = addresses_[index];
  if (address.is_unix()) {
    const sockaddr_un name = UnixName(address);
    const auto* const generic = reinterpret_cast<const sockaddr*>(&name);
    const Socket probe(SocketFor(AF_UNIX), index);
    if (probe.fd < 0) return ListenError(address, errno);
    if (connect(probe.fd, generic, sizeof name) == 0 || errno == EAGAIN) {
      return ListenError(address, EADDRINUSE);
    }
    struct stat entry;
    // Left by a server that died.
    const bool is_left = lstat(name.sun_path, &entry) == 0 && S_ISSOCK(entry.st_mode);
    if (is_left) unlink(name.sun_path);
    Socket socket(SocketFor(AF_UNIX), index);
    // bind() gives the file the mode of the socket: nobody else gets in, not even for a moment.
    if (socket.fd < 0 || fchmod(socket.fd, 0600) != 0) return ListenError(address, errno);
    if (const int error = ListenOn(socket.fd, generic, sizeof name); error != 0) {
      return ListenError(address, error);
    }
    if (stat(name.sun_path, &entry) == 0) socket.file = entry.st_ino;
    sockets_.push_back(std::move(socket));
    return absl::OkStatus();
  }
  const bool is_any = address.host == "0.0.0.0" || address.host == "::";
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  // A port that is free for one of a name's addresses may be taken for another.
  for (int tries = kTriesForOnePort;; --tries) {
    const int failed = getaddrinfo(is_any ? "::" : address.host.c_str(),
                                   std::to_string(address.port).c_str(), &hints, &found);
    if (failed != 0) {
      return NotFound("cannot listen on {}: {}", address.ToString(), gai_strerror(failed));
    }
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
    std::vector<Socket> bound;
    int port = address.port, error = 0;
    for (const addrinfo* at = found; at != nullptr && error != EADDRINUSE; at = at->ai_next) {
      Socket socket(SocketFor(at->ai_family), index);
      auto* const v4 = reinterpret_cast<sockaddr_in*>(at->ai_addr);
      if (at->ai_family == AF_INET) v4->sin_port = htons(static_cast<uint16_t>(port));
      auto* const v6 = reinterpret_cast<sockaddr_in6*>(at->ai_addr);
      if (at->ai_family == AF_INET6) v6->sin6_port = htons(static_cast<uint16_t>(port));
      error = socket.fd < 0 ? errno : ListenOn(socket.fd, at->ai_addr, at->ai_addrlen);
      if (error != 0) continue;  // The machine may lack one of the families.
      port = PortOf(socket.fd);
      bound.push_back(std::move(socket));
    }
    if (is_any && bound.empty() && error != EADDRINUSE) {  // A machine without IPv6.
      sockaddr_in any{};
      any.sin_family = AF_INET;
      any.sin_port = htons(static_cast<uint16_t>(port));
      Socket socket(SocketFor(AF_INET), index);
      error = socket.fd < 0 ? errno
                            : ListenOn(socket.fd, reinterpret_cast<sockaddr*>(&any), sizeof any);
      if (error == 0) {
        port = PortOf(socket.fd);
        bound.push_back(std::move(socket));
      }
    }
    if (error == EADDRINUSE && address.port == 0 && tries > 1) continue;
    if (bound.empty() || error == EADDRINUSE) return ListenError(address, error);
    address.port = port;
    for (Socket& socket : bound) sockets_.push_back(std::move(socket));
    return absl::OkStatus();
  }
}

void Listener::Start(Take take) {
  take_ = std::move(take);
  thread_ = std::thread([this] { Loop(); });
}

void Listener::Stop() {
  if (thread_.joinable()) {
    const uint64_t one = 1;
    (void)!write(wake_, &one, sizeof one);
    thread_.join();
  }
  for (const Socket& socket : sockets_) {
    const RpcAddress& address = addresses_[socket.address];
    struct stat entry;
    if (address.is_unix() && stat(address.unix_path.c_str(), &entry) == 0 &&
        entry.st_ino == socket.file) {
      unlink(address.unix_path.c_str());
    }
  }
  sockets_.clear();
}

void Listener::Loop() {
  pthread_setname_np(pthread_self(), "listener");
  std::vector<pollfd> polled = {{wake_, POLLIN, 0}};
  for (const Socket& socket : sockets_) polled.push_back({socket.fd, POLLIN, 0});
  bool was_busy = false;
  while (true) {
    const int ready = poll(polled.data(), polled.size(), was_busy ? kQuiet_ms : -1);
    if (ready < 0) continue;
    if (polled[0].revents != 0) return;
    was_busy = ready > 0;
    // The C library keeps what a crowd of connections needed; the machine gets it back.
    if (!was_busy) malloc_trim(0);
    for (size_t i = 0; i < sockets_.size(); ++i) {
      if (polled[i + 1].revents != 0) AcceptAll(sockets_[i]);
    }
  }
}

void Listener::AcceptAll(const Socket& socket) {
  // Some at a time: another address has its turn, and Stop().
  for (int i = 0; i < 64; ++i) {
    const int fd = accept4(socket.fd, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd >= 0) {
      Admit(fd, socket.address);
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      return RunOutOfDescriptors(socket, errno);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return;
    }  // Else the connection was gone before it was accepted.
  }
}

void Listener::RunOutOfDescriptors(const Socket& socket, int error_number) {
  LogWarning("a connection is refused: no descriptor or memory is left for it",
             {{"address", addresses_[socket.address].ToString()},
              {"error", std::string(std::strerror(error_number))}});
  // One is taken off and closed, so that its caller knows.
  if (spare_ >= 0) close(spare_);
  const int fd = accept4(socket.fd, nullptr, nullptr, SOCK_CLOEXEC);
  if (fd >= 0) close(fd);
  {
    const std::lock_guard lock(mu_);
    DropEnded(nullptr);
    if (!strangers_.empty() && !strangers_.front().leaving) strangers_.front().End();
  }
  spare_ = open("/dev/null", O_RDONLY | O_CLOEXEC);
  pollfd stop{wake_, POLLIN, 0};
  poll(&stop, 1, kPauseWithoutDescriptors_ms);
}

void Listener::Admit(int fd, size_t address) {
  Peer peer = PeerOf(fd);
  if (peer.name.empty()) {  // Gone already.
    close(fd);
    return;
  }
  const std::string name = peer.name;
  {
    const std::lock_guard lock(mu_);
    if (strangers_.size() + known_.size() >= drop_at_) {
      DropEnded(nullptr);
      drop_at_ = std::max<size_t>(64, 2 * (strangers_.size() + known_.size()));
    }
    const bool is_unix = addresses_[address].is_unix();
    const bool is_ours = expected_.erase(name) > 0;
    if (!is_unix && !is_ours && !MakeRoom(peer.host)) {
      close(fd);
      return;
    }
    strangers_.push_back({fd, InodeOf(fd), std::move(peer.name), std::move(peer.host)});
    const auto at = std::prev(strangers_.end());
    if (!is_unix) by_peer_[name] = at;
    // A Unix socket's callers have no names by which they could become known later.
    if (is_ours) {
      at->known = true;
      known_.splice(known_.end(), strangers_, at);
    }
    if (is_unix && !AddKnown(at)) {
      close(fd);
      strangers_.erase(at);
      return;
    }
  }
  take_(fd, address, name);
}

bool Listener::MakeRoom(const std::string& host) {
  for (bool looked = false;; looked = true) {
    std::map<std::string_view, size_t> by_host;  // Numbers of those that may go.
    size_t all = 0, of_host = 0;
    for (const Connection& one : strangers_) {
      if (one.leaving) continue;
      ++all;
      if (one.host == host) ++of_host;
      if (one.may_go()) ++by_host[one.host];
    }
    const bool is_host_full = of_host >= limits_.strangers_an_address;
    // Connections that are leaving still have their descriptors.
    const bool is_full = strangers_.size() >= 2 * limits_.strangers;
    if (!is_host_full && all < limits_.strangers && !is_full) return true;
    if (!looked) {
      DropEnded(nullptr);
      continue;
    }
    if (is_full || by_host.empty()) return false;
    const std::string_view from =
        is_host_full
            ? std::string_view(host)
            : std::max_element(by_host.begin(), by_host.end(), [](const auto& a, const auto& b) {
                return a.second < b.second;
              })->first;
    const auto oldest =
        std::find_if(strangers_.begin(), strangers_.end(),
                     [&](const Connection& one) { return one.may_go() && one.host == from; });
    if (oldest == strangers_.end()) return false;
    oldest->End();
    return oldest->leaving;
  }
}

bool Listener::AddKnown(Connections::iterator at) {
  for (bool looked = false;; looked = true) {
    const auto own = static_cast<size_t>(std::count_if(
        known_.begin(), known_.end(), [&](const Connection& one) { return one.host == at->host; }));
    const bool fits = known_.size() < limits_.known && own < limits_.known_an_address;
    if (fits) {
      at->known = true;
      known_.splice(known_.end(), strangers_, at);
      return true;
    }
    if (looked) return false;
    DropEnded(&*at);
  }
}

bool Listener::Know(std::string_view peer) {
  const std::lock_guard lock(mu_);
  const auto found = by_peer_.find(std::string(peer));
  if (found == by_peer_.end() || found->second->known) return true;
  const auto at = found->second;
  if (AddKnown(at)) return true;
  at->End();
  return false;
}

void Listener::Forget(std::string_view peer) {
  const std::lock_guard lock(mu_);
  const auto found = by_peer_.find(std::string(peer));
  if (found == by_peer_.end() || !found->second->known) return;
  found->second->known = false;
  strangers_.splice(strangers_.end(), known_, found->second);
}

void Listener::SetBusy(std::string_view peer, bool busy) {
  const std::lock_guard lock(mu_);
  const auto found = by_peer_.find(std::string(peer));
  if (found != by_peer_.end()) found->second->busy = busy;
}

void Listener::Expect(const std::string& peer) {
  const std::lock_guard lock(mu_);
  if (expected_.size() >= kMostExpected) expected_.clear();  // They never came.
  expected_.insert(peer);
}

void Listener::DropEnded(const Connection* but) {
  for (Connections* all : {&strangers_, &known_}) {
    for (auto at = all->begin(); at != all->end();) {
      if (&*at == but || !at->ended()) {
        ++at;
        continue;
      }
      const auto named = by_peer_.find(at->peer);
      if (named != by_peer_.end() && named->second == at) by_peer_.erase(named);
      at = all->erase(at);
    }
  }
}

}  // namespace parallax
