#include "coordinator/queue/database/fail_point.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace parallax {
namespace {

FailPoint::Hook HookFromEnvironment() {
  const char* value = std::getenv("PARALLAX_FAIL_POINT");
  if (value == nullptr || *value == 0) return nullptr;
  const std::string text(value);
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return nullptr;
  const std::string command = text.substr(0, colon);
  const int step = std::atoi(text.c_str() + colon + 1);
  const size_t second = text.find(':', colon + 1);
  const auto left =
      std::make_shared<int>(second == std::string::npos ? 1 : std::atoi(text.c_str() + second + 1));
  return [=](const std::string& seen, int at) {
    if (seen == command && at == step && --*left == 0) raise(SIGKILL);
    return absl::OkStatus();
  };
}

}  // namespace

FailPoint::FailPoint(Hook hook) : hook_(hook ? std::move(hook) : HookFromEnvironment()) {}

void FailPoint::Begin(const char* command) {
  if (!hook_) return;
  command_ = command;
  if (std::find(kFailPointCommands.begin(), kFailPointCommands.end(), command_) ==
      kFailPointCommands.end()) {
    std::fprintf(stderr, "fail point: command '%s' is not in kFailPointCommands\n", command);
    std::abort();
  }
  step_ = 0;
}

absl::Status FailPoint::Step() { return hook_ ? hook_(command_, ++step_) : absl::OkStatus(); }

}  // namespace parallax
