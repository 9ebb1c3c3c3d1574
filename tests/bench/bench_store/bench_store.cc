// How many pairs a store takes in a second: threads write pairs as workers do, each file durable
// before the next. Prints one JSON line.
//
//   bench_store URI [--pairs 40] [--files 17] [--mb 11] [--threads 2]
//
// `URI` as `coordinator serve --store` takes it: a folder, or s3://...; what is written is removed.
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "common/base/seconds.h"
#include "common/store/store.h"
#include "tests/bench/program_main.h"

namespace parallax {
namespace {

constexpr char kPrefix[] = "bench";

struct Arguments {
  std::string uri;
  int pairs = 40, files = 17, threads = 2;
  double mb = 11;
};

// Bytes that no store can squeeze.
std::string NoiseOf(size_t size) {
  std::string bytes(size, '\0');
  std::mt19937_64 random(1);
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

// Writes all pairs. Errors: the first one of the store.
absl::Status WritePairs(const Arguments& arguments, Store& store) {
  const std::string file =
      NoiseOf(static_cast<size_t>(1e6 * arguments.mb / std::max(1, arguments.files)));
  std::atomic<int> next{0};
  std::mutex mutex;
  absl::Status first;  // Guarded by `mutex`.
  const auto write = [&] {
    for (int pair = next++; pair < arguments.pairs; pair = next++) {
      for (int k = 0; k < arguments.files; ++k) {
        const absl::Status status = store.Put(
            std::string(kPrefix) + "/" + std::to_string(pair) + "/" + std::to_string(k), file);
        const std::lock_guard lock(mutex);
        if (first.ok()) first = status;
        if (!first.ok()) return;
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < arguments.threads; ++i) threads.emplace_back(write);
  for (std::thread& thread : threads) thread.join();
  return first;
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  Arguments arguments;
  CLI::App app("Pairs that a store takes in a second; one JSON line.", "bench_store");
  app.add_option("URI", arguments.uri, "A folder, or s3://bucket/prefix?...")->required();
  app.add_option("--pairs", arguments.pairs, "Pairs to write (default 40)");
  app.add_option("--files", arguments.files, "Files of a pair (default 17)");
  app.add_option("--mb", arguments.mb, "Megabytes of a pair (default 11)");
  app.add_option("--threads", arguments.threads, "Writers at a time (default 2)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const auto store, OpenStore(arguments.uri));
  const auto begin = std::chrono::steady_clock::now();
  const absl::Status written = WritePairs(arguments, *store);
  const double seconds = SecondsSince(begin);
  RETURN_IF_ERROR(store->RemoveTree(kPrefix));
  RETURN_IF_ERROR(written);
  const nlohmann::ordered_json line = {{"bench", "store"},
                                       {"pairs_per_s", arguments.pairs / seconds},
                                       {"files_per_s", arguments.pairs * arguments.files / seconds},
                                       {"mb_per_s", arguments.pairs * arguments.mb / seconds},
                                       {"seconds", seconds},
                                       {"pairs", arguments.pairs},
                                       {"files", arguments.files},
                                       {"mb", arguments.mb},
                                       {"threads", arguments.threads}};
  std::printf("%s\n", line.dump().c_str());
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_store", &parallax::Run, argc, argv);
}
