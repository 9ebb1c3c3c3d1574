#include "common/base/system/memory_end.h"

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

namespace parallax {
namespace {

std::atomic<int> exit_status_at_end{-1};  // -1: go on.
char program_name[64] = "";

void Write(const char* text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, strlen(text));
}

// Says how much a process may have, where `ulimit -v` says it. Allocates nothing.
void WriteLimit() {
  const int64_t limit_bytes = AddressSpaceLimit();
  if (limit_bytes == 0) return;
  char digits[24] = "";
  char* at = digits + sizeof digits - 1;
  for (int64_t megabytes = limit_bytes >> 20;; megabytes /= 10) {
    *--at = static_cast<char>('0' + megabytes % 10);
    if (megabytes < 10) break;
  }
  Write("; the address space of a process is limited to ");
  Write(at);
  Write(" MB (ulimit -v)");
}

void WriteThatMemoryRanOut() {
  Write("error: memory ran out");
  WriteLimit();
  Write("\n");
}

// Libraries in C abort where an allocation fails.
void OnAbort(int) {
  Write("error: ");
  Write(program_name);
  Write(" was aborted");
  WriteLimit();
  Write("\n");
}

[[noreturn]] void OnNoMemory() {
  WriteThatMemoryRanOut();
  _exit(exit_status_at_end);
}

[[noreturn]] void OnUncaught() {
  try {
    if (const std::exception_ptr current = std::current_exception())
      std::rethrow_exception(current);
  } catch (const std::bad_alloc&) {
    WriteThatMemoryRanOut();
  } catch (const std::exception& error) {
    Write("error: ");
    Write(program_name);
    Write(": ");
    Write(error.what());
    WriteLimit();  // Threads are refused for want of address space, too.
    Write("\n");
  } catch (...) {
  }
  const int status = exit_status_at_end;
  if (status >= 0) _exit(status);
  signal(SIGABRT, SIG_DFL);  // All is said.
  std::abort();
}

}  // namespace

void EndWhenMemoryRunsOut(std::string_view program, int exit_status) {
  exit_status_at_end = exit_status;
  NameUncaughtExceptions(program);
  std::set_new_handler(OnNoMemory);
}

void NameUncaughtExceptions(std::string_view program) {
  program.copy(program_name, sizeof program_name - 1);
  std::set_terminate(OnUncaught);
  struct sigaction action {};
  action.sa_handler = OnAbort;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // Then it ends as an abort does.
  sigaction(SIGABRT, &action, nullptr);
}

int64_t AddressSpaceLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return 0;
  return static_cast<int64_t>(limit.rlim_cur);
}

void EndIfMemoryIsNeeded() {
  if (exit_status_at_end >= 0) OnNoMemory();
}

}  // namespace parallax
