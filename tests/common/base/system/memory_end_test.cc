#include "common/base/system/memory_end.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>

#include "common/base/status.h"

namespace parallax {
namespace {

using ::testing::ExitedWithCode;
using ::testing::KilledBySignal;

constexpr char kLine[] =
    "error: memory ran out; the address space of a process is limited to 70000 MB .ulimit -v.";

template <typename Exception>
void Throw(const Exception& exception) {
  throw exception;
}

void LimitAddresses() {
  const rlimit limit = {rlim_t{70000} << 20, rlim_t{70000} << 20};
  setrlimit(RLIMIT_AS, &limit);
}

TEST(MemoryEndDeathTest, AFailedAllocationEndsTheProcessWithOneLine) {
  EXPECT_EXIT(
      {
        LimitAddresses();
        EndWhenMemoryRunsOut("run", 7);
        ::operator delete(::operator new (size_t{1} << 40));
      },
      ExitedWithCode(7), kLine);
}

TEST(MemoryEndDeathTest, ASystemCallWithoutMemoryEndsItToo) {
  EXPECT_EXIT(
      {
        LimitAddresses();
        EndWhenMemoryRunsOut("run", 7);
        ErrnoError(ENOMEM, "list a folder").IgnoreError();
      },
      ExitedWithCode(7), kLine);
  // Programs that did not ask for it get a status.
  EXPECT_EQ(ErrnoError(ENOMEM, "list a folder").code(), absl::StatusCode::kResourceExhausted);
}

TEST(MemoryEndDeathTest, UncaughtExceptionsAndAbortsAreNamed) {
  EXPECT_EXIT(
      {
        NameUncaughtExceptions("worker");
        []() noexcept { Throw(std::bad_alloc()); }();
      },
      KilledBySignal(SIGABRT), "error: memory ran out");
  EXPECT_EXIT(
      {
        NameUncaughtExceptions("worker");
        []() noexcept { Throw(std::runtime_error("no thread")); }();
      },
      KilledBySignal(SIGABRT), "error: worker: no thread");
  EXPECT_EXIT(
      {
        LimitAddresses();
        NameUncaughtExceptions("worker");
        std::abort();
      },
      KilledBySignal(SIGABRT), "error: worker was aborted; the address space .* 70000 MB");
}

}  // namespace
}  // namespace parallax
