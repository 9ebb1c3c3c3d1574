#include "worker/dataset/frame/render_frames.h"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <map>
#include <utility>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/base/system/log.h"
#include "common/config/frame_maps.h"
#include "common/store/store.h"
#include "worker/dataset/frame/frame_writer.h"

namespace parallax {
namespace {

std::string ThreeDigits(uint32_t number) { return fmt::format("{:03}", number); }

// The job's rigs in its order. Errors: kInvalidArgument for a rig that the scene does not have.
absl::StatusOr<std::vector<const v1::Rig*>> FindRigs(const v1::RenderJob& job) {
  std::map<uint32_t, const v1::Rig*> by_index;
  for (const v1::Rig& rig : job.scene().rigs()) by_index.emplace(rig.index(), &rig);
  std::vector<const v1::Rig*> rigs;
  for (const uint32_t index : job.rigs()) {
    const auto found = by_index.find(index);
    if (found == by_index.end()) {
      return InvalidArgument("rig {} is not among the scene's {} rigs", index, by_index.size());
    }
    if (found->second->width_px() <= 0 || found->second->height_px() <= 0) {
      return InvalidArgument("rig {} has no pixels", index);
    }
    rigs.push_back(found->second);
  }
  if (rigs.empty()) return InvalidArgument("a render job without rigs");
  return rigs;
}

// CPU time of all threads, user and system.
double ProcessCpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// `cpu_s`: this frame's share, as far as it is known.
absl::StatusOr<v1::FrameResult> WriteOne(const v1::RenderJob& job, const RenderJobContext& context,
                                         const v1::Rig& rig, const StereoFrame& frame,
                                         double cpu_s) {
  const std::string name = ThreeDigits(rig.index());
  ASSIGN_OR_RETURN(v1::FrameResult result,
                   WriteFrame({.scene = job.scene(),
                               .rig = rig,
                               .frame = frame,
                               .render = job.render(),
                               .dir = context.attempt_dir + "/" + name,
                               .store_path = context.attempt_path + "/" + name,
                               .cancel = context.finished ? CancelToken() : context.cancel}));
  (*result.mutable_stage_s())["cpu"] = cpu_s;
  if (context.finished) context.finished(result);
  return result;
}

// Renders and writes the rigs; the renderer stays with the caller. Each frame gets an equal share
// of what the process has computed since `cpu_begin_s` ("cpu" of its seconds).
absl::Status RenderAll(const v1::RenderJob& job, const RenderJobContext& context,
                       const std::vector<const v1::Rig*>& rigs, Renderer& renderer,
                       double cpu_begin_s, v1::RenderResult& result) {
  // At most one frame is being written, so that memory holds two.
  std::future<absl::StatusOr<v1::FrameResult>> writing;
  const auto collect = [&]() -> absl::Status {
    if (!writing.valid()) return absl::OkStatus();
    ASSIGN_OR_RETURN(*result.add_frames(), writing.get());
    return absl::OkStatus();
  };
  const double count = static_cast<double>(rigs.size());
  for (size_t i = 0; i < rigs.size(); ++i) {
    const v1::Rig& rig = *rigs[i];
    const ProgressFn progress = [&, i](double fraction) {
      if (context.progress) context.progress((static_cast<double>(i) + fraction) / count);
    };
    if (context.cancel.cancelled()) return Cancelled("render job");
    absl::StatusOr<StereoFrame> frame = renderer.RenderRig(rig, context.cancel, progress);
    if (!frame.ok()) return WithContext(frame.status(), fmt::format("rig {}", rig.index()));
    RETURN_IF_ERROR(collect());
    const double cpu_s = (ProcessCpuSeconds() - cpu_begin_s) / static_cast<double>(i + 1);
    writing =
        std::async(std::launch::async, [&job, &context, &rig, cpu_s, log = CurrentLogContext(),
                                        frame = std::make_shared<StereoFrame>(*std::move(frame))] {
          ScopedLogContext scope(log);
          return WriteOne(job, context, rig, *frame, cpu_s);
        });
  }
  RETURN_IF_ERROR(collect());
  const double cpu_s = (ProcessCpuSeconds() - cpu_begin_s) / count;
  for (v1::FrameResult& frame : *result.mutable_frames()) (*frame.mutable_stage_s())["cpu"] = cpu_s;
  if (context.progress) context.progress(1);
  return absl::OkStatus();
}

}  // namespace

absl::Status MakeAttemptFolder(const std::string& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return ErrnoError(error.value(), "make folder " + dir);
  std::filesystem::path above = dir;
  // In a store "<2 hex>/<64 hex>" and, for the first of these, its root.
  for (int i = 0; i < 3 && above.has_parent_path(); ++i) {
    above = above.parent_path();
    RETURN_IF_ERROR(SyncPath(above));
  }
  return absl::OkStatus();
}

std::unique_ptr<Renderer> RendererCache::Take(const std::string& key) {
  std::unique_ptr<Renderer> taken;
  std::unique_ptr<Renderer> dropped;  // Destroyed after the lock is given back.
  {
    std::lock_guard<std::mutex> lock(mutex_);
    (key == key_ ? taken : dropped) = std::move(renderer_);
    key_.clear();
  }
  return taken;
}

void RendererCache::Keep(const std::string& key, std::unique_ptr<Renderer> renderer) {
  std::unique_ptr<Renderer> dropped = std::move(renderer);
  std::lock_guard<std::mutex> lock(mutex_);
  std::swap(renderer_, dropped);
  key_ = key;
}

std::string RendererCache::KeyOf(const v1::Scene& scene, const v1::RenderConfig& config) {
  v1::RenderConfig without_maps = config;
  without_maps.clear_maps();
  for (const FrameMap& row : FrameMaps()) {
    if (row.pass == "truth" || row.pass == "film" || !HasMap(config, row.map)) continue;
    without_maps.add_maps(std::string(row.map));
  }
  return Sha256Hex(Sha256Hex(scene.SerializeAsString()) + without_maps.SerializeAsString());
}

absl::StatusOr<v1::RenderResult> RenderFrames(const v1::RenderJob& job,
                                              const RenderJobContext& context,
                                              const RendererFactory& factory,
                                              RendererCache& cache) {
  ASSIGN_OR_RETURN(const std::vector<const v1::Rig*> rigs, FindRigs(job));
  RETURN_IF_ERROR(MakeAttemptFolder(context.attempt_dir));

  v1::RenderResult result;
  const double cpu_begin_s = ProcessCpuSeconds();  // Before the build: its time counts too.
  const std::string key = RendererCache::KeyOf(job.scene(), job.render());
  std::unique_ptr<Renderer> renderer = cache.Take(key);
  if (renderer == nullptr) {
    const SteadyTime begin = Clock::System().Steady();
    ASSIGN_OR_RETURN(renderer, factory(job.scene(), job.render()));
    result.set_build_s(SecondsSince(begin));
  }
  const absl::Status status = RenderAll(job, context, rigs, *renderer, cpu_begin_s, result);
  // A cancelled job's scene is likely to come again; after any other error start afresh.
  if (status.ok() || absl::IsCancelled(status)) cache.Keep(key, std::move(renderer));
  RETURN_IF_ERROR(status);
  RETURN_IF_ERROR(SyncPath(context.attempt_dir));
  return result;
}

}  // namespace parallax
