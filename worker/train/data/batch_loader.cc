#include "worker/train/data/batch_loader.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <new>
#include <opencv2/core.hpp>
#include <thread>

#include "common/base/status.h"

namespace parallax {
namespace {

// Decoding a pair of 640x360 takes 27 ms, a third of a step. About 140 such pairs are kept.
constexpr size_t kMostKeptBytes = size_t{512} << 20;
constexpr size_t kBytesPerPixel = 8;  // Each eye has colours, disparity, trust.

std::vector<int> SizesOf(const std::vector<TrainingSource>& sources) {
  std::vector<int> sizes;
  for (const TrainingSource& source : sources)
    sizes.push_back(static_cast<int>(source.frames.size()));
  return sizes;
}

std::vector<double> WeightsOf(const std::vector<TrainingSource>& sources) {
  std::vector<double> weights;
  for (const TrainingSource& source : sources) weights.push_back(source.weight);
  return weights;
}

}  // namespace

struct BatchLoader::State {
  State(const std::vector<TrainingSource>& s, const TrainSettings& set, int64_t first_step,
        int ahead_batches)
      : sources(s),
        settings(set),
        ahead(ahead_batches),
        order(set.seed, SizesOf(s), WeightsOf(s)),
        next_made(first_step),
        next_taken(first_step) {
    for (int64_t i = 0; i < first_step * settings.batch; ++i) order.Next();
  }

  // The pair of a folder, from memory once it has been read and while there is room.
  absl::StatusOr<std::shared_ptr<const TrainingPair>> Read(const std::string& dir) {
    std::unique_lock lock(mutex);
    const auto found = kept.find(dir);
    if (found != kept.end()) return found->second;
    lock.unlock();
    ASSIGN_OR_RETURN(TrainingPair read, ReadTrainingPair(dir));
    const auto pair = std::make_shared<const TrainingPair>(std::move(read));
    const size_t bytes = 2 * kBytesPerPixel * pair->left.image.pixels();
    lock.lock();
    if (kept_bytes + bytes <= kMostKeptBytes && kept.emplace(dir, pair).second) kept_bytes += bytes;
    return pair;
  }

  absl::StatusOr<TrainingBatch> Make(int64_t step, const std::vector<FrameChoice>& choices) {
    TrainingBatch batch;
    const Rng rng =
        Rng(SceneSeed{settings.seed}, "augment").Child("step", static_cast<uint64_t>(step));
    for (size_t i = 0; i < choices.size(); ++i) {
      const TrainingSource& source = sources[static_cast<size_t>(choices[i].source)];
      const TrainingFrame& frame = source.frames[static_cast<size_t>(choices[i].frame)];
      ASSIGN_OR_RETURN(const std::shared_ptr<const TrainingPair> pair, Read(frame.dir));
      absl::StatusOr<TrainingCrop> crop = Augment(*pair, settings, rng.Child("pair", i));
      if (!crop.ok()) return WithContext(crop.status(), frame.name);
      batch.crops.push_back(*std::move(crop));
      batch.names.push_back(frame.name);
    }
    return batch;
  }

  // As Make; exceptions, which would end the program in a thread of its own, become errors.
  absl::StatusOr<TrainingBatch> TryMake(int64_t step, const std::vector<FrameChoice>& choices) {
    try {
      return Make(step, choices);
    } catch (const std::bad_alloc&) {
      return ResourceExhausted("batch of step {}: no memory", step);
    } catch (const cv::Exception& error) {
      if (error.code == cv::Error::StsNoMem) {
        return ResourceExhausted("batch of step {}: no memory: {}", step, error.err);
      }
      return Internal("batch of step {}: {}", step, error.err);
    } catch (const std::exception& error) {
      return Internal("batch of step {}: {}", step, error.what());
    }
  }

  void Work() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return stop || next_made < next_taken + ahead; });
      if (stop) return;
      const int64_t step = next_made++;
      std::vector<FrameChoice> choices;
      for (int i = 0; i < settings.batch; ++i) choices.push_back(order.Next());
      lock.unlock();
      absl::StatusOr<TrainingBatch> batch = TryMake(step, choices);
      lock.lock();
      ready.emplace(step, std::move(batch));
      changed.notify_all();
    }
  }

  // Constant after construction.
  const std::vector<TrainingSource>& sources;
  const TrainSettings settings;
  const int64_t ahead;
  // Guarded by `mutex`.
  std::mutex mutex;
  std::condition_variable changed;
  FrameOrder order;
  int64_t next_made, next_taken;
  std::map<int64_t, absl::StatusOr<TrainingBatch>> ready;
  std::map<std::string, std::shared_ptr<const TrainingPair>> kept;  // By folder.
  size_t kept_bytes = 0;
  bool stop = false;

  std::vector<std::jthread> workers;  // Last: joined before the rest goes.
};

BatchLoader::BatchLoader(const std::vector<TrainingSource>& sources, const TrainSettings& settings,
                         int64_t first_step, int threads, int ahead)
    : state_(std::make_unique<State>(sources, settings, first_step, ahead)) {
  for (int i = 0; i < threads; ++i)
    state_->workers.emplace_back([state = state_.get()] { state->Work(); });
}

BatchLoader::~BatchLoader() {
  const std::lock_guard lock(state_->mutex);
  state_->stop = true;
  state_->changed.notify_all();
}

absl::StatusOr<TrainingBatch> BatchLoader::Next() {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [&] { return state_->ready.contains(state_->next_taken); });
  auto node = state_->ready.extract(state_->next_taken++);
  state_->changed.notify_all();
  return std::move(node.mapped());
}

}  // namespace parallax
