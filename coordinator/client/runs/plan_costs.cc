// Measured costs of rendering. Core-seconds (user + system) on an AMD EPYC with
// AVX-512, release build.
#include <map>

#include "coordinator/client/runs/plan.h"

namespace parallax::client {

const Costs kMeasuredCosts = {
    // preview render solve:1:dense --rigs 3: build_core_s.
    .build_s = 2.1,
    // bench_render solve:1 --pairs 1 --quality-rigs 0: cache_s_per_scene on two cores, by paths.
    .cache_s_per_mpath = 3.6,
    // bench_render solve:1 --pairs 2 --quality-rigs 0, stage_s on two cores by megapixels of one
    // image: trace 11.6 with 4 samples; denoise 6.1 at `high`, 2.8 at `balanced`, 1.6 at `fast`;
    // ground truth 0.6, encoding and writing 0.5, statistics.
    .trace_s_per_mpx_sample = 3.1,
    .denoise_high_s_per_mpx = 6.6,
    .denoise_balanced_s_per_mpx = 3.0,
    .denoise_fast_s_per_mpx = 1.8,
    .fixed_s_per_mpx = 1.3,
    // Not measured as a whole. Rays as two ground truths take (1.2), and twelve float channels of
    // EXR
    // with four masks (bench_image_io: 0.1 a channel). bench_render --flow measures it.
    .flow_s_per_mpx = 3.0,
    // Batch 2, crops of 192x384, one thread of Zen 4: 0.48 a step, forward, backward and update.
    .train_step_s_per_mpx = 0.48 / (2 * 0.192 * 0.384),
    // trainer predict --threads 2, another pair in its list: 3.0 at 480x270, 4.2 at 741x500, 3.6 at
    // 1280x720, 4.6 at 2880x1920, each by SeenMpx: 4.6, 2.8, 3.9, 4.2.
    .evaluate_s_per_mpx = 3.9,
};

BenchmarkSize SizeOfBenchmark(const std::string& name) {
  // Sizes as published; see worker/evaluate/benchmarks.
  static const auto& sizes =
      *new std::map<std::string, BenchmarkSize>{{"booster-Q", {228, 1028, 752}},
                                                {"drivingstereo", {200, 881, 400}},
                                                {"eth3d", {27, 900, 490}},
                                                {"kitti2012", {194, 1242, 375}},
                                                {"kitti2015", {200, 1242, 375}},
                                                {"middlebury2014-F", {15, 2880, 1980}},
                                                {"middlebury2014-H", {15, 1440, 990}},
                                                {"middlebury2014-Q", {15, 720, 495}},
                                                {"middlebury2014-heldout", {13, 2880, 1980}},
                                                {"middlebury2014-sets", {23, 2880, 1980}},
                                                {"middlebury2021", {24, 1920, 1080}},
                                                {"shipped", {1, 741, 500}}};
  const auto found = sizes.find(name);
  return found == sizes.end() ? BenchmarkSize{} : found->second;
}

}  // namespace parallax::client
