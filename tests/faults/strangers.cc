// Strangers at both ports of a farm with certificates: crowds of connections, requests without end,
// and callers that send a byte now and then. The farm's own callers and /healthz are served
// meanwhile, and what the strangers took is given back.
#include <arpa/inet.h>
#include <grpcpp/grpcpp.h>
#include <openssl/ssl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <thread>

#include "common/rpc/endpoint.h"
#include "common/rpc/free_with.h"
#include "common/rpc/grpc_status.h"
#include "common/store/http_client.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/e2e/process.h"
#include "tests/faults/experiment.h"
#include "tests/faults/farm.h"

namespace parallax::faults {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kServedWithin_s = 2;
constexpr double kAnswerWithin_s = 1;
constexpr double kMostGrowth_mb = 64;
constexpr double kEndless_s = 300;
constexpr int kCrowd = 400;
constexpr int kSlow = 200;
// The coordinator may have few descriptors: less than a crowd.
constexpr char kDescriptors[] = "300";

// A connection to a port of this machine; TLS without a certificate if `context` is given.
class Stranger {
 public:
  Stranger(int port, SSL_CTX* context) {
    fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    name.sin_port = htons(static_cast<uint16_t>(port));
    const timeval patience{5, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    open_ = connect(fd_, reinterpret_cast<sockaddr*>(&name), sizeof name) == 0;
    if (context == nullptr || !open_) return;
    ssl_.reset(SSL_new(context));
    SSL_set_fd(ssl_.get(), fd_);
    open_ = SSL_connect(ssl_.get()) == 1;
  }
  ~Stranger() {
    ssl_.reset();
    if (fd_ >= 0) close(fd_);
  }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  // False when the server has hung up, or the connection was never there.
  bool Send(std::string_view bytes) {
    if (!open_) return false;
    open_ = ssl_ != nullptr
                ? SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size())) > 0
                : send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) > 0;
    return open_;
  }

 private:
  int fd_ = -1;
  bool open_ = false;
  std::unique_ptr<SSL, FreeWith<SSL_free>> ssl_;
};

// A coordinator with certificates, TLS on both ports, and few descriptors.
struct Target {
  TempFolder folder{true};
  std::unique_ptr<Process> coordinator;
  int rpc = 0, http = 0;
  std::unique_ptr<SSL_CTX, FreeWith<SSL_CTX_free>> context{SSL_CTX_new(TLS_client_method())};

  std::string Tls(const std::string& party) const { return folder.path() + "/tls/" + party; }

  bool Start() {
    signal(SIGPIPE, SIG_IGN);
    Process init({PARALLAX_COORDINATOR_PROGRAM, "init", folder.path() + "/tls", "--issue",
                  "read-only", "board"});
    if (init.Wait() != 0) return false;
    coordinator = std::make_unique<Process>(std::vector<std::string>{
        "/bin/sh", "-c", "ulimit -n " + std::string(kDescriptors) + "; exec \"$@\"", "sh",
        PARALLAX_COORDINATOR_PROGRAM, "serve", "--db", folder.path() + "/queue.db", "--store",
        folder.path() + "/store", "--listen", "0.0.0.0:0", "--http", "0.0.0.0:0", "--tls",
        Tls("server"), "--log-level", "error"});
    std::string line;
    if (!coordinator->ReadLine(&line)) return false;
    rpc = std::atoi(line.c_str() + line.rfind(':') + 1);
    if (!coordinator->ReadLine(&line)) return false;
    http = std::atoi(line.c_str() + line.rfind(':') + 1);
    return true;
  }

  // Megabytes of memory that the coordinator has, now or at most so far.
  double Memory(const char* field) const {
    std::ifstream status("/proc/" + std::to_string(coordinator->pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind(field, 0) == 0) return std::atof(line.c_str() + line.find(':') + 1) / 1000;
    }
    return -1;
  }
};

// Asks for a page again and again, as a probe of the engine does, from a connection of its own.
class Watcher {
 public:
  Watcher(const Target& target, std::string path) : target_(target), path_(std::move(path)) {
    thread_ = std::thread([this] { Loop(); });
  }
  void StopInto(Tally& tally, const std::string& during) {
    stop_ = true;
    thread_.join();
    tally.figures[during + path_ + "_asked"] = asked_;
    tally.figures[during + path_ + "_slowest_s"] = slowest_s_;
    if (asked_ == 0 || failed_ > 0) {
      tally.complaints.push_back(path_ + " failed " + std::to_string(failed_) + " of " +
                                 std::to_string(asked_) + " times during " + during + ": " + why_);
    } else if (slowest_s_ > kAnswerWithin_s * kPatience) {
      tally.complaints.push_back(path_ + " took " + std::to_string(slowest_s_) + " s during " +
                                 during);
    }
  }

 private:
  void Loop() {
    const std::string url = "https://127.0.0.1:" + std::to_string(target_.http) + path_;
    while (!stop_) {
      const auto begin = Clock::now();
      const HttpAnswer answer = HttpClient(HttpFarm{.ca_file = target_.Tls("server") + "/ca.crt"})
                                    .Send({.method = "GET", .url = url});
      slowest_s_ = std::max(slowest_s_, SecondsSince(begin));
      ++asked_;
      if (answer.code != 200) {
        ++failed_;
        why_ = std::to_string(answer.code) + " " + answer.error + answer.body;
      }
      Sleep(0.05);
    }
  }

  const Target& target_;
  const std::string path_;
  std::atomic<bool> stop_ = false;
  int asked_ = 0, failed_ = 0;
  double slowest_s_ = 0;
  std::string why_;
  std::thread thread_;
};

// Seconds until a call by a caller of the farm succeeds, over a new connection; -1: it does not.
double TimeOfACall(const Target& target) {
  const auto begin = Clock::now();
  const auto security =
      MakeRpcSecurity(false, target.Tls("read-only-board"), parallax::Clock::System());
  const auto channel =
      ConnectRpc(*ParseRpcAddress("127.0.0.1:" + std::to_string(target.rpc)), *security);
  const auto stub = v1::Coordinator::NewStub(*channel);
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  SetRpcTimeout(context, std::chrono::duration<double>(10 * kPatience));
  v1::GetInfoReply reply;
  return stub->GetInfo(&context, {}, &reply).ok() ? SecondsSince(begin) : -1;
}

// Connections by the hundred: bare ones, ones that begin TLS and stop, and ones that finish it
// without a certificate; held together, then closed.
void Crowds(const Target& target, int64_t connections, Tally& tally) {
  Watcher watcher(target, "/healthz");
  constexpr std::string_view kHello("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11);
  for (int64_t made = 0; made < connections;) {
    std::vector<std::unique_ptr<Stranger>> crowd;
    for (int i = 0; i < kCrowd && made < connections; ++i, ++made) {
      const bool finishes = i % 40 == 0;
      crowd.push_back(
          std::make_unique<Stranger>(target.rpc, finishes ? target.context.get() : nullptr));
      if (!finishes && i % 2 == 1) crowd.back()->Send(kHello);
    }
    ++tally.faults;
  }
  const double served_s = TimeOfACall(target);
  tally.figures["crowd_call_s"] = served_s;
  if (served_s < 0 || served_s > kServedWithin_s * kPatience) {
    tally.complaints.push_back("after the crowd, a call took " + std::to_string(served_s) + " s");
  }
  watcher.StopInto(tally, "crowd");
}

// Headers and chunked bodies without end, each on a new connection when the server has had enough.
void Endless(const Target& target, double megabytes, Tally& tally) {
  const double before = target.Memory("VmRSS");
  const std::string host = "Host: 127.0.0.1\r\n";
  const struct {
    std::string begin, piece;
  } kinds[] = {
      {"GET / HTTP/1.1\r\n" + host, "X-Header: " + std::string(1000, 'x') + "\r\n"},
      {"GET / HTTP/1.1\r\n" + host + "X-Long: ", std::string(4000, 'x')},
      {"GET /" + std::string(100, 'x'), std::string(4000, 'x')},
      {"POST /api/v1/session HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\n",
       "3e8\r\n" + std::string(1000, 'x') + "\r\n"},
      {"POST /api/v1/session HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\n",
       "1;" + std::string(1000, 'x') + "\r\nx\r\n"},
      {"POST /api/v1/session HTTP/1.1\r\n" + host + "Content-Length: 99999999999\r\n\r\n",
       std::string(4000, 'x')},
  };
  double most = before;
  const auto begin = Clock::now();
  double sent = 0;
  while (sent < megabytes * 1e6 && SecondsSince(begin) < kEndless_s * kPatience) {
    for (const auto& kind : kinds) {
      Stranger stranger(target.http, target.context.get());
      if (!stranger.Send(kind.begin)) continue;
      ++tally.faults;
      for (int i = 0; i < 2000 && stranger.Send(kind.piece); ++i) sent += kind.piece.size();
      sent += kind.begin.size();
    }
    most = std::max(most, target.Memory("VmRSS"));
  }
  tally.figures["endless_sent_mb"] = sent / 1e6;
  tally.figures["endless_growth_mb"] = most - before;
  tally.figures["endless_kept_mb"] = target.Memory("VmRSS") - before;
  if (most - before > kMostGrowth_mb) {
    tally.complaints.push_back("endless requests took " + std::to_string(most - before) + " MB");
  }
}

// A byte each half second on many connections.
void Slow(const Target& target, double seconds, Tally& tally) {
  std::vector<std::unique_ptr<Stranger>> slow;
  const std::string request = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + std::string(200, 'x');
  for (int i = 0; i < kSlow; ++i) {
    slow.push_back(std::make_unique<Stranger>(target.http, i % 2 ? target.context.get() : nullptr));
    ++tally.faults;
  }
  // They are there when all have sent a byte. While a hundred come from one address at once, they
  // may take the place of another newcomer from it.
  for (auto& one : slow) one->Send(request.substr(0, 1));
  Sleep(0.5);
  Watcher health(target, "/healthz"), page(target, "/");
  const auto begin = Clock::now();
  for (size_t at = 1; SecondsSince(begin) < seconds; ++at) {
    for (auto& one : slow) one->Send(request.substr(at % request.size(), 1));
    Sleep(0.5);
  }
  health.StopInto(tally, "slow");
  page.StopInto(tally, "slow");
}

}  // namespace

void Strangers(const ExperimentOptions& options, Tally& tally) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  for (int round = 0; round < options.rounds; ++round) {
    Target target;
    if (!target.Start()) {
      tally.complaints.push_back("no coordinator: " +
                                 (target.coordinator ? target.coordinator->Err() : ""));
      return;
    }
    ++tally.rounds;
    tally.figures["descriptors"] = std::atof(kDescriptors);
    Crowds(target, options.full ? 20'000 : 1'600, tally);
    Endless(target, options.full ? 1000 : 30, tally);
    Slow(target, options.full ? 30 : 3, tally);
    if (const double call_s = TimeOfACall(target); call_s < 0) {
      tally.complaints.push_back("at the end no call succeeds");
    }
    target.coordinator->Signal(SIGTERM);
    if (target.coordinator->Wait() != 0) {
      tally.complaints.push_back("the coordinator ended badly: " + target.coordinator->Err());
    }
  }
}

}  // namespace parallax::faults
