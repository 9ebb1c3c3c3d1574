#include "common/base/system/clock.h"

namespace parallax {
namespace {

class SystemClock final : public Clock {
 public:
  double UnixSeconds() override {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  SteadyTime Steady() override { return std::chrono::steady_clock::now(); }
};

}  // namespace

Clock& Clock::System() {
  static SystemClock clock;
  return clock;
}

}  // namespace parallax
