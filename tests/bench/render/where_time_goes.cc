#include "tests/bench/render/where_time_goes.h"

#include <link.h>
#include <signal.h>
#include <sys/time.h>
#include <ucontext.h>

#include <array>
#include <atomic>
#include <cstring>
#include <string>

namespace parallax::bench {
namespace {

enum Owner { kEmbree, kDenoiser, kProgram, kOwners };

struct Range {
  uintptr_t begin = 0, end = 0;
  Owner owner = kProgram;
};

// Written before the timer starts; read by the handler.
std::array<Range, 64> ranges;
size_t range_count = 0;
std::atomic<bool> counting{false};
std::array<std::atomic<int64_t>, kOwners + 1> counts;

int NoteLibrary(dl_phdr_info* info, size_t /*size*/, void* first) {
  const std::string name = info->dlpi_name ? info->dlpi_name : "";
  Owner owner = kOwners;
  if (*static_cast<bool*>(first)) owner = kProgram;  // The program itself comes first.
  *static_cast<bool*>(first) = false;
  if (name.find("libembree") != std::string::npos) owner = kEmbree;
  if (name.find("OpenImageDenoise") != std::string::npos) owner = kDenoiser;
  if (owner == kOwners) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& header = info->dlpi_phdr[i];
    if (header.p_type != PT_LOAD || !(header.p_flags & PF_X) || range_count == ranges.size()) {
      continue;
    }
    const uintptr_t begin = info->dlpi_addr + header.p_vaddr;
    ranges[range_count++] = {begin, begin + header.p_memsz, owner};
  }
  return 0;
}

void OnTimer(int /*signal*/, siginfo_t* /*info*/, void* context) {
  if (!counting.load(std::memory_order_relaxed)) return;
  const auto at =
      static_cast<uintptr_t>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RIP]);
  size_t owner = kOwners;
  for (size_t i = 0; i < range_count; ++i) {
    if (at >= ranges[i].begin && at < ranges[i].end) owner = ranges[i].owner;
  }
  counts[owner].fetch_add(1, std::memory_order_relaxed);
}

void SetTimer(int microseconds) {
  itimerval timer{};
  timer.it_interval.tv_usec = microseconds;
  timer.it_value = timer.it_interval;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

}  // namespace

WhereTimeGoes::WhereTimeGoes() {
  range_count = 0;
  bool first = true;
  dl_iterate_phdr(&NoteLibrary, &first);
  for (auto& count : counts) count = 0;
  struct sigaction action {};
  action.sa_sigaction = &OnTimer;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigaction(SIGPROF, &action, nullptr);
  SetTimer(2000);
}

WhereTimeGoes::~WhereTimeGoes() {
  SetTimer(0);
  counting = false;
}

void WhereTimeGoes::Count(bool on) { counting = on; }

TimeShares WhereTimeGoes::Shares() {
  TimeShares shares;
  for (const auto& count : counts) shares.samples += count;
  if (shares.samples == 0) return shares;
  const auto all = static_cast<double>(shares.samples);
  shares.embree = static_cast<double>(counts[kEmbree]) / all;
  shares.denoiser = static_cast<double>(counts[kDenoiser]) / all;
  shares.program = static_cast<double>(counts[kProgram]) / all;
  return shares;
}

}  // namespace parallax::bench
