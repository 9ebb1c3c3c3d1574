// Tags by which workers tell by themselves what they can do, and by which jobs ask for it. They
// have a colon, which no tag of an operator or a study has.
#pragma once

#include <string>

namespace parallax {

// The worker may run this trainer: it is installed there and allowed.
inline std::string TrainerTag(const std::string& trainer) { return "trainer:" + trainer; }
// The worker has the files of this benchmark.
inline std::string BenchmarkTag(const std::string& benchmark) { return "benchmark:" + benchmark; }
// The trained network beside the worker's programs has this SHA-256, in hex.
inline std::string NetworkTag(const std::string& sha256) { return "network:" + sha256; }

// The worker has a GPU. Its operator says so (worker --tags gpu).
inline constexpr char kGpuTag[] = "gpu";

// The benchmark that is installed with the programs, so that no job asks for it.
inline constexpr char kShippedBenchmark[] = "shipped";

}  // namespace parallax
