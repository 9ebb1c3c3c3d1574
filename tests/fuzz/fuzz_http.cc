// Bytes on the HTTP port, as any browser or scanner sends them: an answer or a closed connection,
// and the next one is served.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>

#include "coordinator/http/http_server.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/workers/wait_reasons.h"

namespace {

class NoServer final : public parallax::CoordinatorServer {
 public:
  explicit NoServer(parallax::JobQueue& queue)
      : waits_(queue, parallax::Clock::System(),
               [] { return std::vector<parallax::WorkerGroup>(); }) {}
  std::vector<std::string> addresses() const override { return {}; }
  std::vector<parallax::v1::WorkerStatus> Workers() const override { return {}; }
  parallax::ServerMetrics Metrics() const override {
    parallax::ServerMetrics metrics;
    metrics.lease_latency_bounds_s = {1};
    metrics.lease_latency_counts = {0, 0};
    return metrics;
  }
  absl::Status CheckAnswers() const override { return absl::OkStatus(); }
  const parallax::WaitReasons& waits() const override { return waits_; }
  void SetPage(PageOpener) override {}
  parallax::ContentKeeper* content() override { return nullptr; }
  absl::StatusOr<std::vector<parallax::v1::StreamStatus>> Streams() const override {
    return std::vector<parallax::v1::StreamStatus>();
  }
  absl::StatusOr<std::vector<parallax::v1::SearchStatus>> Searches() const override {
    return std::vector<parallax::v1::SearchStatus>();
  }
  absl::Status StoreStatus() const override { return absl::OkStatus(); }
  void Shutdown() override {}

 private:
  const parallax::WaitReasons waits_;
};

struct World {
  std::string folder;
  std::unique_ptr<parallax::JobQueue> queue;
  std::optional<NoServer> server;
  std::unique_ptr<parallax::HttpServer> http;
  int port = 0;

  World() {
    char name[] = "/tmp/parallax-fuzz-http-XXXXXX";
    folder = mkdtemp(name);
    parallax::JobQueueOptions options;
    options.db_path = folder + "/queue.db";
    queue = *parallax::JobQueue::Open(options);
    server.emplace(*queue);
    parallax::HttpServerOptions http_options;
    http_options.listen = "127.0.0.1:0";
    http_options.store_uri = "file:///nowhere";
    http_options.db_path = options.db_path;
    http = *parallax::HttpServer::Start(http_options, *queue, *server);
    const std::string address = http->address();
    port = std::atoi(address.substr(address.rfind(':') + 1).c_str());
  }
  ~World() {
    http.reset();
    server.reset();
    queue.reset();
    std::filesystem::remove_all(folder);
  }
};

// A connection from a loopback address that changes with each: the one that closes first keeps its
// port for a minute, and a minute sees more connections than one address has ports. Made anew when
// libFuzzer's timer interrupts it.
int Connect(int port) {
  static uint32_t turn = 0;
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1 + turn++ % 250);
  bool done = bind(fd, reinterpret_cast<sockaddr*>(&name), sizeof name) == 0;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  name.sin_port = htons(static_cast<uint16_t>(port));
  done = done && connect(fd, reinterpret_cast<sockaddr*>(&name), sizeof name) == 0;
  if (!done && errno == EINTR) {
    close(fd);
    return Connect(port);
  }
  if (!done) {
    std::perror("the server does not accept");
    std::abort();
  }
  return fd;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static World world;
  const int fd = Connect(world.port);
  const timeval limit{20, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  (void)!send(fd, data, size, MSG_NOSIGNAL);
  shutdown(fd, SHUT_WR);
  char bytes[1 << 14];
  ssize_t n;
  bool endless = false;  // A stream of events: its head is answer enough.
  do {
    n = recv(fd, bytes, sizeof bytes, 0);
    if (n > 0) {
      const std::string_view piece(bytes, static_cast<size_t>(n));
      endless |= piece.find("text/event-stream") != piece.npos;
    }
  } while (!endless && (n > 0 || (n < 0 && errno == EINTR)));
  if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
    std::fprintf(stderr, "the server neither answers nor hangs up\n");
    std::abort();
  }
  close(fd);
  return 0;
}
