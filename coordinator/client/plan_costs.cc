// The one place where measured costs are kept. Core-seconds (user + system) on an AMD EPYC with
// AVX-512, release build.
#include "coordinator/client/plan.h"

namespace parallax::client {

const Costs kMeasuredCosts = {
    // bench_solve --scenes 50 --kind any --mode reduced, and --mode full: solve_cpu_s 0.82 and
    // 0.91, shared out as layout_s and dress_s are.
    .layout_reduced_s = 0.26,
    .layout_full_s = 0.30,
    .dress_s = 0.58,
    // dense_preview DIR --keyframes 3: objects_s, keyframe_s, build_s.
    .dense_scene_s = 1.65,
    .dense_keyframe_s = 0.035,
    .build_s = 1.2,
    // parallax run quickstart --json: 38.6 core_seconds_per_pair at 1280x720 and 8 samples. Of
    // these
    // denoising takes 4.6 at `high` (2.5 at `fast`) and ground truth, statistics, encoding and
    // writing 2.2.
    .trace_s_per_mpx_sample = 4.2,
    .denoise_high_s_per_mpx = 5.0,
    .denoise_fast_s_per_mpx = 2.7,
    .fixed_s_per_mpx = 2.4,
};

}  // namespace parallax::client
