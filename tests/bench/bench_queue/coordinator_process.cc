#include "coordinator_process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <vector>

#include "common/rpc/address.h"
#include "samples.h"

namespace parallax {
namespace {

// Text behind `prefix` on the first line that begins with it.
bool FindLine(const std::string& text, const std::string& prefix, std::string* rest) {
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin);
    if (end == std::string::npos) return false;
    if (text.compare(begin, prefix.size(), prefix) == 0) {
      *rest = text.substr(begin + prefix.size(), end - begin - prefix.size());
      return true;
    }
    begin = end + 1;
  }
  return false;
}

}  // namespace

absl::StatusOr<std::unique_ptr<CoordinatorProcess>> CoordinatorProcess::Start(
    const Options& options) {
  int out[2];
  if (pipe2(out, O_CLOEXEC) != 0) return ErrnoError(errno, "pipe");
  const std::string lease = std::to_string(options.lease_s);
  std::vector<const char*> arguments = {options.program.c_str(),
                                        "serve",
                                        "--db",
                                        options.db.c_str(),
                                        "--store",
                                        options.store.c_str(),
                                        "--listen",
                                        "127.0.0.1:0",
                                        "--trust-workers",  // Their files are not there.
                                        "--http",
                                        "127.0.0.1:0",
                                        "--lease-s",
                                        lease.c_str(),
                                        "--log-level",
                                        "warning"};
  if (!options.limits.empty()) {
    arguments.insert(arguments.end(), {"--limits", options.limits.c_str()});
  }
  arguments.push_back(nullptr);
  const int log = open(options.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  const int pid = fork();
  if (pid == 0) {
    dup2(out[1], STDOUT_FILENO);
    if (log >= 0) dup2(log, STDERR_FILENO);
    execv(options.program.c_str(), const_cast<char* const*>(arguments.data()));
    _exit(127);
  }
  close(out[1]);
  if (log >= 0) close(log);
  if (pid < 0) {
    close(out[0]);
    return ErrnoError(errno, "fork");
  }
  std::unique_ptr<CoordinatorProcess> process(new CoordinatorProcess(pid));
  std::string text, http;
  char buffer[512];
  while (!FindLine(text, "listening on ", &process->address_) ||
         !FindLine(text, "http on http://", &http)) {
    const ssize_t n = read(out[0], buffer, sizeof buffer);
    if (n <= 0) {
      close(out[0]);
      return Unavailable("{} did not come up; see {}", options.program, options.log);
    }
    text.append(buffer, static_cast<size_t>(n));
  }
  close(out[0]);
  process->http_address_ = http.substr(0, http.find('/'));
  return process;
}

CoordinatorProcess::~CoordinatorProcess() { Kill(); }

absl::Status CoordinatorProcess::Terminate() {
  if (pid_ <= 0) return absl::OkStatus();
  kill(pid_, SIGTERM);
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = 0;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return absl::OkStatus();
  return Internal("the coordinator did not end cleanly");
}

void CoordinatorProcess::Kill() {
  if (pid_ <= 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
}

absl::StatusOr<double> TimeGet(const std::string& address, const std::string& path) {
  ASSIGN_OR_RETURN(const RpcAddress where, ParseRpcAddress(address));
  const auto begin = BenchClock::now();
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return ErrnoError(errno, "socket");
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<uint16_t>(where.port));
  inet_pton(AF_INET, where.host.c_str(), &peer.sin_addr);
  const std::string request =
      "GET " + path + " HTTP/1.1\r\nHost: " + address + "\r\nConnection: close\r\n\r\n";
  std::string answer;
  bool sent = connect(fd, reinterpret_cast<sockaddr*>(&peer), sizeof peer) == 0 &&
              write(fd, request.data(), request.size()) == static_cast<ssize_t>(request.size());
  char buffer[4096];
  for (ssize_t n = 1; sent && n > 0;) {
    n = read(fd, buffer, sizeof buffer);
    if (n > 0) answer.append(buffer, static_cast<size_t>(n));
  }
  close(fd);
  if (answer.rfind("HTTP/1.1 200", 0) != 0) {
    return Unavailable("GET {}: {}", path, answer.substr(0, 60));
  }
  return SecondsSince(begin);
}

}  // namespace parallax
