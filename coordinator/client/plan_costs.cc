// The one place where measured costs are kept. Core-seconds (user + system) on an AMD EPYC with
// AVX-512, release build.
#include "coordinator/client/plan.h"

namespace parallax::client {

const Costs kMeasuredCosts = {
    // bench_solve --seeds 20 (and --mode full): "layout" of reduced and full, "dress".
    .layout_reduced_s = 1.0,
    .layout_full_s = 2.0,
    .dress_s = 1.5,
    // dense_preview --keyframes 20: "objects_s", "keyframe_s".
    .dense_scene_s = 8.0,
    .dense_keyframe_s = 0.1,
    // parallax run quickstart --json, then index.jsonl "seconds" and the workers' logs: "build_s".
    .build_s = 10.0,
    .trace_s_per_mpx_sample = 3.0,
    .denoise_high_s_per_mpx = 5.0,
    .denoise_fast_s_per_mpx = 2.7,
    .fixed_s_per_mpx = 2.5,
};

}  // namespace parallax::client
