// The job `render` without the renderer's construction: caching of renderers, choice of rigs,
// writing of frames.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "worker/dataset/frame/render_job.h"

namespace parallax {

// Builds the renderer of a scene, with its geometry and acceleration structure.
using RendererFactory = std::function<absl::StatusOr<std::unique_ptr<Renderer>>(
    const v1::Scene& scene, const v1::RenderConfig& config)>;

// Keeps the last renderer, so that the next job of the same scene needs no build. Thread-safe; a
// renderer in use is out of the cache, so two jobs never share one.
class RendererCache {
 public:
  // Takes the renderer of `key` out; null if none exists. First drops a renderer of another
  // scene, because two scenes in memory might be too much.
  std::unique_ptr<Renderer> Take(const std::string& key);
  void Keep(const std::string& key, std::unique_ptr<Renderer> renderer);

  // Returns a key that is equal when a renderer can be used again: the recipe and all of the config
  // but `maps`, of which only those of passes of their own count.
  static std::string KeyOf(const v1::Scene& scene, const v1::RenderConfig& config);

 private:
  std::mutex mutex_;
  std::string key_;                     // Guarded by mutex_.
  std::unique_ptr<Renderer> renderer_;  // Guarded by mutex_.
};

// Makes the folder of an attempt durably, with its parents up to the store. Errors: the disk's.
absl::Status MakeAttemptFolder(const std::string& dir);

// Does what RunRenderJob does, with the renderer of `factory`. While a rig is rendered, the one
// before it is encoded and written. Errors: kInvalidArgument for a rig that the scene does not
// have; the factory's; the renderer's and WriteFrame's, naming the rig.
absl::StatusOr<v1::RenderResult> RenderFrames(const v1::RenderJob& job,
                                              const RenderJobContext& context,
                                              const RendererFactory& factory, RendererCache& cache);

}  // namespace parallax
