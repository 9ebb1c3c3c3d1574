#include "tests/faults/tcp_proxy.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <list>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "common/base/rng.h"

namespace parallax::faults {
namespace {

constexpr int kPollMs = 5;       // How soon a change of weather is felt.
constexpr size_t kPreface = 24;  // Bytes that open an HTTP/2 connection.   Source: RFC 9113, 3.4
constexpr size_t kHead = 9;      // Bytes of a frame's header.              Source: RFC 9113, 4.1
enum FrameType { kData = 0, kHeaders = 1, kResetStream = 3, kWindowUpdate = 8 };
constexpr uint8_t kEndStream = 1;
constexpr uint32_t kInternalError = 2;

std::string Frame(FrameType type, uint32_t stream, uint32_t value) {
  std::string frame(kHead + 4, '\0');
  frame[2] = 4;
  frame[3] = static_cast<char>(type);
  for (int i = 0; i < 4; ++i) {
    frame[5 + static_cast<size_t>(i)] = static_cast<char>(stream >> (24 - 8 * i));
    frame[9 + static_cast<size_t>(i)] = static_cast<char>(value >> (24 - 8 * i));
  }
  return frame;
}

bool WriteAll(int fd, const std::string& bytes) {
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t n = send(fd, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (n <= 0) return false;
    at += static_cast<size_t>(n);
  }
  return true;
}

struct Shared {
  explicit Shared(const LossRates& rates, uint64_t seed)
      : losses(rates), rng(SceneSeed{seed}, "faults/proxy") {}
  const LossRates losses;
  std::atomic<Weather> weather{Weather::kClear};
  std::atomic<bool> stopping{false};
  std::atomic<int> cuts{0};
  std::mutex mu;
  // Guarded by mu.
  Rng rng;
  TcpProxy::Counts counts;
};

class Connection {
 public:
  Connection(int client, int server, Shared& shared)
      : client_(client), server_(server), shared_(shared), born_(shared.cuts) {
    const int yes = 1;
    setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    setsockopt(server_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    thread_ = std::thread([this] { Loop(); });
  }
  ~Connection() {
    thread_.join();
    // A reset, not an orderly end: that is what a cut looks like.
    const linger hard{1, 0};
    setsockopt(client_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    setsockopt(server_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    close(client_);
    close(server_);
  }
  bool over() const { return over_; }

 private:
  // Both directions in one thread, so that frames can be added to either between two of its own.
  void Loop() {
    while (!shared_.stopping) {
      const Weather weather = shared_.weather;
      if (weather == Weather::kPartition || shared_.cuts != born_) {
        const std::lock_guard lock(shared_.mu);
        ++shared_.counts.cut;
        break;
      }
      if (weather == Weather::kStall) {
        poll(nullptr, 0, kPollMs);
        continue;
      }
      pollfd ready[2] = {{client_, POLLIN, 0}, {server_, POLLIN, 0}};
      if (poll(ready, 2, kPollMs) <= 0) continue;
      if (ready[0].revents != 0 && !Pass(client_, up_, weather == Weather::kDeafUp, true)) break;
      if (ready[1].revents != 0 && !Pass(server_, down_, weather == Weather::kDeafDown, false)) {
        break;
      }
    }
    over_ = true;
  }

  bool Pass(int from, std::string& buffer, bool swallow, bool up) {
    char bytes[1 << 16];
    const ssize_t n = recv(from, bytes, sizeof bytes, 0);
    if (n <= 0) return false;
    if (swallow) {
      swallowed_ = true;
      return true;
    }
    // A stream with a hole in it can't go on: TCP would not have let it through either.
    if (swallowed_) return false;
    if (shared_.losses.unary == 0 && shared_.losses.stream == 0) {
      return WriteAll(up ? server_ : client_, std::string(bytes, static_cast<size_t>(n)));
    }
    buffer.append(bytes, static_cast<size_t>(n));
    return up ? PassUp() : PassDown();
  }

  bool PassUp() {
    std::string whole;
    if (!preface_seen_) {
      if (up_.size() < kPreface) return true;
      preface_seen_ = true;
      whole = up_.substr(0, kPreface);
      up_.erase(0, kPreface);
    }
    std::string frame;
    while (TakeFrame(up_, &frame)) {
      const uint32_t stream = StreamOf(frame);
      // A unary caller ends its stream with its request; a worker's stream stays open.
      if (stream != 0 && (frame[4] & kEndStream) != 0 && frame[3] <= kHeaders) {
        half_closed_[stream] = true;
      }
      whole += frame;
    }
    return WriteAll(server_, whole);
  }

  bool PassDown() {
    std::string frame;
    std::string down;
    std::string up;
    while (TakeFrame(down_, &frame)) {
      const uint32_t stream = StreamOf(frame);
      if (frame[3] != kData || stream == 0) {
        down += frame;  // Headers of a lost stream too: they keep the two ends' tables alike.
        continue;
      }
      const size_t size = frame.size() - kHead;
      if (size > 0 && !lost_.count(stream) && Lose(stream)) {
        lost_[stream] = true;
        down += Frame(kResetStream, stream, kInternalError);
        if (!half_closed_[stream]) up += Frame(kResetStream, stream, kInternalError);
      }
      if (lost_.count(stream) == 0) {
        down += frame;
      } else if (size > 0) {
        // The client would have given the room back.
        up += Frame(kWindowUpdate, 0, static_cast<uint32_t>(size));
      }
    }
    return WriteAll(client_, down) && (up.empty() || WriteAll(server_, up));
  }

  bool Lose(uint32_t stream) {
    const std::lock_guard lock(shared_.mu);
    ++shared_.counts.replies;
    const bool unary = half_closed_[stream];
    if (!shared_.rng.Bernoulli(unary ? shared_.losses.unary : shared_.losses.stream)) return false;
    ++shared_.counts.lost;
    return true;
  }

  static uint32_t StreamOf(const std::string& frame) {
    uint32_t stream = 0;
    for (size_t i = 5; i < kHead; ++i) stream = stream << 8 | static_cast<uint8_t>(frame[i]);
    return stream & 0x7fffffff;
  }
  static bool TakeFrame(std::string& buffer, std::string* frame) {
    if (buffer.size() < kHead) return false;
    const size_t size = static_cast<size_t>(static_cast<uint8_t>(buffer[0])) << 16 |
                        static_cast<size_t>(static_cast<uint8_t>(buffer[1])) << 8 |
                        static_cast<size_t>(static_cast<uint8_t>(buffer[2]));
    if (buffer.size() < kHead + size) return false;
    *frame = buffer.substr(0, kHead + size);
    buffer.erase(0, kHead + size);
    return true;
  }

  const int client_;
  const int server_;
  Shared& shared_;
  const int born_;
  std::string up_;
  std::string down_;
  bool preface_seen_ = false;
  bool swallowed_ = false;
  std::map<uint32_t, bool> half_closed_;
  std::map<uint32_t, bool> lost_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

sockaddr_in Loopback(int port) {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  name.sin_port = htons(static_cast<uint16_t>(port));
  return name;
}

}  // namespace

class TcpProxy::Impl {
 public:
  Impl(const std::string& target, const LossRates& losses, uint64_t seed) : shared_(losses, seed) {
    target_port_ = std::atoi(target.substr(target.rfind(':') + 1).c_str());
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name = Loopback(0);
    socklen_t size = sizeof name;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&name), size) != 0 ||
        listen(listener_, 64) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&name), &size) != 0) {
      std::perror("proxy");
      std::exit(3);
    }
    port_ = ntohs(name.sin_port);
    thread_ = std::thread([this] { Loop(); });
  }
  ~Impl() {
    shared_.stopping = true;
    thread_.join();
    close(listener_);
  }

  int port() const { return port_; }
  Shared& shared() { return shared_; }

 private:
  void Loop() {
    std::list<Connection> connections;
    while (!shared_.stopping) {
      connections.remove_if([](const Connection& connection) { return connection.over(); });
      pollfd ready{listener_, POLLIN, 0};
      if (poll(&ready, 1, kPollMs) <= 0) continue;
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) continue;
      const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      sockaddr_in name = Loopback(target_port_);
      if (shared_.weather == Weather::kPartition ||
          connect(server, reinterpret_cast<sockaddr*>(&name), sizeof name) != 0) {
        close(server);
        close(client);
        continue;
      }
      {
        const std::lock_guard lock(shared_.mu);
        ++shared_.counts.connections;
      }
      connections.emplace_back(client, server, shared_);
    }
  }

  Shared shared_;
  int target_port_ = 0;
  int port_ = 0;
  int listener_ = -1;
  std::thread thread_;
};

TcpProxy::TcpProxy(const std::string& target, const LossRates& losses, uint64_t seed)
    : impl_(std::make_unique<Impl>(target, losses, seed)) {}
TcpProxy::~TcpProxy() = default;
std::string TcpProxy::address() const { return "127.0.0.1:" + std::to_string(impl_->port()); }
void TcpProxy::Set(Weather weather) { impl_->shared().weather = weather; }
void TcpProxy::CutAll() { ++impl_->shared().cuts; }
TcpProxy::Counts TcpProxy::counts() const {
  const std::lock_guard lock(impl_->shared().mu);
  return impl_->shared().counts;
}

}  // namespace parallax::faults
