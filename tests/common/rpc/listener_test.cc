// Who gets a place at a port, and that the port is heard again whatever happened to it.
#include "common/rpc/listener.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>

#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {
namespace {

class Fd {
 public:
  explicit Fd(int fd = -1) : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Fd& operator=(Fd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Fd() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

// A connection that has sent a byte; `from` is an address of this machine.
Fd Connect(int port, const char* from = "127.0.0.1") {
  Fd fd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in name{};
  name.sin_family = AF_INET;
  inet_pton(AF_INET, from, &name.sin_addr);
  if (bind(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof name) != 0) return Fd();
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  name.sin_port = htons(static_cast<uint16_t>(port));
  if (connect(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof name) != 0) return Fd();
  (void)!send(fd.get(), "x", 1, MSG_NOSIGNAL);
  return fd;
}

// Whether the other side has ended the connection, waiting `wait_ms` for it.
bool HasEnded(const Fd& fd, int wait_ms = 0) {
  const timeval limit{wait_ms / 1000, wait_ms % 1000 * 1000 + 1000};
  setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  char byte;
  const ssize_t got = recv(fd.get(), &byte, 1, 0);
  return got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
}

// A server that keeps its connections until they end.
class ListenerTest : public testing::Test {
 protected:
  struct Taken {
    Fd fd;
    std::string peer;
  };

  void Listen(const ListenerLimits& limits) {
    auto bound = Listener::Bind({*ParseRpcAddress("127.0.0.1:0")}, limits);
    ASSERT_TRUE(bound.ok()) << bound.status();
    listener_ = *std::move(bound);
    listener_->Start([this](int fd, size_t, const std::string& peer) {
      const std::lock_guard lock(mu_);
      taken_.push_back({Fd(fd), peer});
      changed_.notify_all();
    });
  }
  int port() const { return listener_->addresses()[0].port; }

  // Connects, and waits until the server has the connection.
  Fd Come(const char* from = "127.0.0.1") {
    std::unique_lock lock(mu_);
    const size_t before = taken_.size();
    lock.unlock();
    Fd fd = Connect(port(), from);
    lock.lock();
    EXPECT_TRUE(
        changed_.wait_for(lock, std::chrono::seconds(10), [&] { return taken_.size() > before; }));
    return fd;
  }
  std::string PeerAt(size_t index) {
    const std::lock_guard lock(mu_);
    return taken_.at(index).peer;
  }
  void CloseAt(size_t index) {
    const std::lock_guard lock(mu_);
    taken_.at(index).fd = Fd();
  }

  std::mutex mu_;
  std::condition_variable changed_;
  std::deque<Taken> taken_;  // Guarded by mu_.
  std::unique_ptr<Listener> listener_;
};

TEST_F(ListenerTest, ANewcomerGetsThePlaceOfTheOldestStrangerOfItsAddress) {
  Listen({.strangers = 8, .strangers_an_address = 3});
  const Fd other = Come("127.0.0.9");
  std::vector<Fd> crowd;
  for (int i = 0; i < 5; ++i) crowd.push_back(Come());
  EXPECT_TRUE(HasEnded(crowd[0], 5000));
  EXPECT_TRUE(HasEnded(crowd[1], 5000));
  for (int i = 2; i < 5; ++i) EXPECT_FALSE(HasEnded(crowd[static_cast<size_t>(i)])) << i;
  EXPECT_FALSE(HasEnded(other)) << "another address's crowd does not push it out";
}

TEST_F(ListenerTest, CrowdsFromManyAddressesPushOutTheirOwn) {
  Listen({.strangers = 6, .strangers_an_address = 4});
  std::vector<Fd> crowd;
  for (int i = 0; i < 4; ++i) crowd.push_back(Come("127.0.0.2"));
  Fd one = Come("127.0.0.3"), two = Come("127.0.0.4"), three = Come("127.0.0.5");
  EXPECT_TRUE(HasEnded(crowd[0], 5000));
  for (Fd* fd : {&one, &two, &three, &crowd[3]}) EXPECT_FALSE(HasEnded(*fd));
}

TEST_F(ListenerTest, WhoIsKnownStaysAndIsBoundedToo) {
  Listen({.known = 3, .known_an_address = 2, .strangers = 8, .strangers_an_address = 2});
  const Fd first = Come(), second = Come();
  EXPECT_TRUE(listener_->Know(PeerAt(0)));
  EXPECT_TRUE(listener_->Know(PeerAt(1)));
  std::vector<Fd> crowd;
  for (int i = 0; i < 6; ++i) crowd.push_back(Come());
  EXPECT_FALSE(HasEnded(first));
  EXPECT_FALSE(HasEnded(second));
  EXPECT_FALSE(listener_->Know(PeerAt(7))) << "this address has its two";
  EXPECT_TRUE(HasEnded(crowd[5], 5000));
  CloseAt(0);  // Its place is free as soon as its owner has closed it.
  const Fd again = Come();
  EXPECT_TRUE(listener_->Know(PeerAt(8)));
  // Forgotten, it is a stranger like others.
  listener_->Forget(PeerAt(1));
  crowd.push_back(Come());
  crowd.push_back(Come());
  EXPECT_TRUE(HasEnded(second, 5000));
  EXPECT_FALSE(HasEnded(again));
}

TEST_F(ListenerTest, WhoIsBeingAnsweredDoesNotGo) {
  Listen({.strangers = 4, .strangers_an_address = 2});
  const Fd busy = Come();
  listener_->SetBusy(PeerAt(0), true);
  const Fd idle = Come(), next = Come();
  EXPECT_TRUE(HasEnded(idle, 5000));
  EXPECT_FALSE(HasEnded(busy));
  listener_->SetBusy(PeerAt(2), true);
  EXPECT_TRUE(HasEnded(Connect(port()), 5000)) << "both places are in use";
  listener_->SetBusy(PeerAt(0), false);
  const Fd newest = Come();
  EXPECT_TRUE(HasEnded(busy, 5000));
  EXPECT_FALSE(HasEnded(next));
}

TEST_F(ListenerTest, AConnectionThatIsExpectedHasItsPlace) {
  Listen({.strangers = 1, .strangers_an_address = 1});
  Fd fd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof name;
  ASSERT_EQ(bind(fd.get(), reinterpret_cast<sockaddr*>(&name), size), 0);
  ASSERT_EQ(getsockname(fd.get(), reinterpret_cast<sockaddr*>(&name), &size), 0);
  listener_->Expect("ipv4:127.0.0.1:" + std::to_string(ntohs(name.sin_port)));
  name.sin_port = htons(static_cast<uint16_t>(port()));
  ASSERT_EQ(connect(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof name), 0);
  (void)!send(fd.get(), "x", 1, 0);
  const Fd one = Come(), two = Come();
  EXPECT_FALSE(HasEnded(fd)) << "strangers do not push it out";
  EXPECT_TRUE(HasEnded(one, 5000));
}

class Echo final : public v1::Coordinator::Service {
  grpc::Status GetInfo(grpc::ServerContext*, const v1::GetInfoRequest*,
                       v1::GetInfoReply*) override {
    return grpc::Status::OK;
  }
};

absl::Status Ask(const RpcAddress& address) {
  const auto stub = v1::Coordinator::NewStub(*ConnectRpc(address, {}));
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::seconds(10));
  context.set_wait_for_ready(true);
  v1::GetInfoReply reply;
  return FromGrpc(stub->GetInfo(&context, {}, &reply));
}

TEST(RpcPort, IsHeardAgainAfterDescriptorsRanOut) {
  Echo service;
  const auto server = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, {}, service);
  ASSERT_TRUE(server.ok()) << server.status();
  const RpcAddress address = (*server)->addresses()[0];
  ASSERT_TRUE(Ask(address).ok());
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit few{std::min<rlim_t>(before.rlim_cur, 512), before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  {
    std::vector<Fd> ours;
    ours.emplace_back(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    for (int fd; (fd = open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) ours.emplace_back(fd);
    ASSERT_EQ(errno, EMFILE);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    name.sin_port = htons(static_cast<uint16_t>(address.port));
    ASSERT_EQ(connect(ours[0].get(), reinterpret_cast<sockaddr*>(&name), sizeof name), 0);
    (void)!send(ours[0].get(), "x", 1, MSG_NOSIGNAL);
    EXPECT_TRUE(HasEnded(ours[0], 5000)) << "its caller knows that it was refused";
  }
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  const absl::Status after = Ask(address);
  EXPECT_TRUE(after.ok()) << after;
  EXPECT_TRUE((*server)->CheckAnswers().ok());
}

TEST(RpcPort, CrowdsOfStrangersLetCallersIn) {
  Echo service;
  const auto server = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, {}, {&service}, nullptr,
                                       {.known = 8, .strangers = 16, .strangers_an_address = 8});
  ASSERT_TRUE(server.ok()) << server.status();
  const RpcAddress address = (*server)->addresses()[0];
  std::vector<Fd> crowd;
  for (int i = 0; i < 200; ++i) crowd.push_back(Connect(address.port));
  const absl::Status asked = Ask(address);
  EXPECT_TRUE(asked.ok()) << asked;
  const absl::Status health = (*server)->CheckAnswers();
  EXPECT_TRUE(health.ok()) << health;
}

TEST(RpcPort, ASocketThatNobodyServesIsNoHealth) {
  Echo service;
  const auto server = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, {}, service);
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_TRUE((*server)->CheckAnswers().ok());
  (*server)->Shutdown(std::chrono::seconds(0));
  const absl::Status after = (*server)->CheckAnswers();
  EXPECT_EQ(after.code(), absl::StatusCode::kUnavailable) << after;
  EXPECT_THAT(std::string(after.message()),
              testing::HasSubstr((*server)->addresses()[0].ToString()));
}

}  // namespace
}  // namespace parallax
