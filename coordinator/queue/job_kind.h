// Kinds of jobs: all that the queue knows of the work that it hands out. The state machine, its
// tables, readers, auditor and services ask a KindRegistry and never name a kind. A kind is one
// file in kinds/ and one line in kinds/kinds.cc.
//
// A kind decides which work is equal (keys), what a worker is told (spec), which results are right,
// and which jobs a result makes possible. It can't decide who holds a job, when an attempt is
// retried, or what is published: it sees no fence, lease or ledger, and changes the tables only
// through WorkDesk.
//
// Kinds are stateless, thread-safe, and live as long as the program. Errors of hooks: those that
// WorkDesk or ResultReader gave them, and a kind's own only for a broken database (kDataLoss) or a
// mistake in the program (kInternal). An error undoes the whole command.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/hash.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/version.h"
#include "coordinator/queue/job_state.h"
#include "coordinator/study/keys.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

class SqliteConnection;

// Index of a kind in its registry.
struct KindId {
  uint8_t value = 0;
  friend bool operator==(KindId, KindId) = default;
};

// The properties of a kind that the queue acts on.
struct JobTraits {
  // Stages whose results it makes. Its jobs only go to workers with the coordinator's versions of
  // them.
  std::vector<std::string> stages = {};
  std::string doing = {};  // The work of its jobs, for people: "rendering".
  // Its jobs belong to a scene and stand for pairs of it: those of the rigs that a job names, or
  // all pairs of the scene if it names none. Lost pairs are replaced by the variant's next seeds.
  bool of_scene = false;
  // A new scene of a variant begins with a job of this kind. A registry has exactly one such kind.
  bool begins_scenes = false;
  // A result may say that there is no such scene: the job is then REJECTED, which is not a failure.
  bool may_reject = false;
  // An attempt writes files into a folder of the store.
  bool has_output = false;
  // A READY job may pass some of its rigs to new jobs if slots are idle.
  bool can_split = false;
  // Jobs of a group share a part (a layout), which the first of them makes. Until the part exists,
  // only one job of the group is leased at a time.
  bool shares_part = false;
  // A worker that has done one job of a group does the next one faster.
  bool keeps_group_warm = false;
  // An attempt continues from what earlier attempts left in their folders. These folders are kept
  // until the work is done or no study wants it any more; for jobs of scenes, until no job of the
  // scene is open. Jobs without a scene have an input.
  bool resumes = false;
  // Needs of this kind that a worker must meet, beside those of the study and of the job.
  int64_t needs_memory_mb = 0;
  std::vector<std::string> needs_tags = {};
};

// Needs that a worker must meet.
struct WorkNeeds {
  int64_t memory_mb = 0;
  std::vector<std::string> tags;
};

// Stands for the scene's number in messages about jobs without a scene.
inline constexpr uint32_t kNoScene = UINT32_MAX;

// A job as its kind sees it.
struct JobFacts {
  int64_t id = 0;  // 0 while it is not in the table yet.
  int64_t study = 0;
  int64_t variant = 0;
  KindId kind;
  uint32_t ordinal = 0;  // The scene's number; without a scene, the job's number in its variant.
  std::string rigs;      // Its pairs: "0-19"; see study/rigs.h. Empty: see JobTraits::of_scene.
  uint32_t rig_count = 0;
  std::string input;  // Bytes of the kind, which the queue only stores.
  int generation = 1;
  Sha256Digest work_key{};
  Sha256Digest group_key{};
  bool part_given = false;  // The newest lease included the group's part, made by another job.
};

// The keys of a job's work and group.
struct JobKeys {
  Sha256Digest work;   // Equal for equal work. Such jobs share one result.
  Sha256Digest group;  // Equal for jobs that share a part or run faster together; see JobTraits.
};

// A condition that a job waits for before it is READY: another job's success, or a variant's first
// `pairs` published pairs.
struct JobWait {
  static JobWait OnJob(int64_t job) { return {.on_job = job}; }
  static JobWait OnPairs(int64_t variant, int64_t pairs) {
    return {.on_variant = variant, .pairs = pairs};
  }
  int64_t on_job = 0;  // Id of the job; 0: waits for the variant.
  int64_t on_variant = 0;
  int64_t pairs = 0;
};

// A job that a kind adds.
struct NewJob {
  std::string_view kind;
  int64_t variant = 0;
  // Unique among the variant's jobs of this kind, rigs and generation.
  uint32_t ordinal = 0;
  std::vector<uint32_t> rigs = {};
  std::string input = {};
  std::vector<JobWait> waits = {};
  int generation = 1;  // A manual retry's is its predecessor's plus one.
  // No job can have done this work before, so existing results need not be looked for.
  bool is_fresh = false;
};

// A result as it is stored, by key.
struct StoredResult {
  std::string bytes;  // In the kind's form; empty if rejected.
  bool rejected = false;
  std::string reason;  // Why it was rejected.
  double core_s = 0;   // Time to make it, where its bytes don't say. Kinds don't read it again.
};

// A published pair of a dataset.
struct FrameLink {
  uint32_t rig = 0;
  Sha256Digest key{};   // Key of the frame's result.
  bool reused = false;  // Another job made it.
};

// A variant as kinds see it.
struct VariantFacts {
  int64_t id = 0;
  std::string_view name;
  uint64_t seed = 0;  // Seed of its scenes.
  int64_t pairs_wanted = 0;
  uint32_t rigs_per_scene = 0;
  const v1::SceneConfig* config = nullptr;  // Valid until the hook returns.
  const ConfigDigests* digests = nullptr;
};

// A scene as kinds see it: the number of its rigs, and the hash of its recipe.
struct SceneFacts {
  uint32_t rigs = 0;
  std::optional<Sha256Digest> scene_hash;  // Present once it is solved.
};

// The reads and changes that a kind may make inside the writer's transaction. Errors of all calls:
// those of the database. A hook returns them, and the whole command is undone.
class WorkDesk {
 public:
  virtual ~WorkDesk() = default;
  virtual const StageVersions& versions() const = 0;
  virtual absl::StatusOr<VariantFacts> VariantOf(int64_t variant) = 0;
  virtual absl::StatusOr<SceneFacts> SceneOf(int64_t variant, uint32_t ordinal) = 0;
  // Returns the newest generation of the job with this id.
  virtual absl::StatusOr<JobFacts> NewestOf(int64_t job) = 0;

  // ---- Results by content: the first one committed wins, none ever changes.
  virtual absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key) = 0;
  virtual absl::StatusOr<bool> HasResult(const Sha256Digest& key) = 0;
  // Stores a result. `stage` says what it is: "layout", "frame", or a kind's name. Returns true if
  // it is the first with this key; otherwise the first one stays.
  virtual absl::StatusOr<bool> PutResult(const JobFacts& by, std::string_view stage,
                                         const Sha256Digest& key, const StoredResult& result) = 0;

  // ---- What a result means for the study.
  // Notes that the job's scene is solved, with the hash of its recipe.
  virtual absl::Status SetScene(const JobFacts& job, const Sha256Digest& scene_hash) = 0;
  // Publishes pairs of the job's scene. Requires that their results are stored.
  virtual absl::Status Publish(const JobFacts& job, std::span<const FrameLink> frames) = 0;
  // Makes litter of a folder or file of the current attempt that no result names.
  virtual absl::Status Discard(std::string_view path) = 0;
  // Adds a job and returns its id. Its state is done if its result is known, BLOCKED while it
  // waits, else READY. Errors: kInternal for an unknown kind or a wait that can never end.
  virtual absl::StatusOr<int64_t> AddJob(const NewJob& job) = 0;
};

// A leased job, as a kind sees it to write its spec.
struct LeasedJob {
  JobFacts job;
  uint64_t seed = 0;  // The seed of the job's variant.
  std::shared_ptr<const v1::SceneConfig> config;
  // For kinds that resume: folders in the store of ended attempts with the job's keep key, the
  // newest first.
  std::vector<std::string> kept_folders = {};
};
// Reads committed results for specs. Thread-safe.
class ResultReader {
 public:
  virtual ~ResultReader() = default;
  // Returns the bytes of a result. Errors: kNotFound.
  virtual absl::StatusOr<std::string> ResultBytes(const Sha256Digest& key) = 0;
  // Returns keys of a variant's published frames in the order of scenes and rigs, at most `limit`.
  virtual absl::StatusOr<std::vector<Sha256Digest>> FramesOf(int64_t variant, int64_t limit) = 0;
  // Returns the folders of the same frames in the store. Errors: kDataLoss for a frame that is not
  // in a rig's folder.
  virtual absl::StatusOr<std::vector<v1::FrameFolder>> FoldersOf(int64_t variant,
                                                                 int64_t limit) = 0;
  // Returns the result of the one job that this one waited for, or of its newest generation that
  // has one. Errors: kNotFound.
  virtual absl::StatusOr<std::string> ResultWaitedFor(int64_t job) = 0;
};

// A worker's result, checked and packed by the thread that received it. Kinds derive from it.
struct CheckedResult {
  virtual ~CheckedResult() = default;
  std::string invalid;             // Why no job can have this result; empty if a job can.
  std::vector<std::string> paths;  // Folders of the store that it names, in its attempt's folder.
};

// The outcome of storing a result.
struct Ending {
  bool rejected = false;
  std::string reason;     // Why it was rejected.
  std::string result;     // Bytes for OnSuccess.
  bool is_fresh = false;  // No job had made this before.
};

// The state of a job's work before a worker does it.
struct KnownWork {
  enum class State { kOpen, kDone, kRejected } state = State::kOpen;
  std::string result;         // Set with kDone: bytes for OnSuccess.
  std::string reason;         // Set with kRejected.
  bool part_missing = false;  // Set with kOpen: no worker has made the group's part.
};

class JobKind {
 public:
  // `name` is [a-z][a-z0-9_]*, at most 32 characters; the database, messages and metrics use it.
  JobKind(std::string name, JobTraits traits)
      : name_(std::move(name)), traits_(std::move(traits)) {}
  virtual ~JobKind() = default;
  JobKind(const JobKind&) = delete;
  JobKind& operator=(const JobKind&) = delete;

  const std::string& name() const { return name_; }
  const JobTraits& traits() const { return traits_; }

  // ---- Messages. Called from any thread.
  // Returns the message for the worker's handler. Errors: those of the reader.
  virtual absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const = 0;
  // Describes a job without a scene for people: "narrow, seed 1". By default: nothing.
  virtual std::string LabelOf(std::string_view /*input*/) const { return ""; }
  // Returns the needs of a job with this input, beside those of the traits. By default: none, and
  // of a job of a scene those that WithMemory has put into its input, which has nothing else.
  virtual WorkNeeds NeedsOf(std::string_view input) const;
  // Returns the input of the same job with a need of this memory; empty if jobs of this kind have
  // no needs of their own. By default: empty, unless it is a job of a scene.
  virtual std::string WithMemory(std::string_view input, int64_t memory_mb) const;
  // Returns the needs that jobs of this kind in a study will have, each once; empty if it has no
  // such jobs. By default: jobs of scenes, which need nothing of their own.
  virtual std::vector<WorkNeeds> NeedsOfStudy(const v1::StudySpec& study) const;
  // Returns what a job with this input waits for. By default: nothing.
  virtual std::vector<JobWait> WaitsOf(std::string_view /*input*/) const { return {}; }
  // Parses and checks a handler's answer. All hashing and compressing belongs here, because the
  // writer's thread calls the other hooks. Never returns null.
  virtual std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const = 0;
  // A file in the store that a result names.
  struct OutputFile {
    std::string path;
    int64_t size = 0;
    std::string sha256 = {};  // Lower-case hex.
  };
  virtual std::vector<OutputFile> FilesOf(std::string_view /*result*/) const { return {}; }
  // Returns the files of a stored result, if this kind has stored it; see WorkDesk::PutResult.
  virtual std::vector<OutputFile> StoredFiles(std::string_view /*stage*/,
                                              std::string_view /*bytes*/) const {
    return {};
  }
  // A stored result that is one folder of files, for clients that copy results. The same condition
  // holds.
  struct StoredFolder {
    std::string path;
    google::protobuf::RepeatedPtrField<v1::FileEntry> files;
  };
  virtual std::optional<StoredFolder> FolderOf(std::string_view /*bytes*/) const { return {}; }
  // A figure that a job with this input has measured: of a network or a baseline on a benchmark.
  // The same condition holds.
  struct Score {
    std::string set;        // The training set; empty for a baseline.
    std::string predictor;  // The trainer or the baseline.
    std::optional<uint64_t> seed;
    std::string benchmark;
    int checkpoint = 1, checkpoints = 1;  // Which of how many, from 1; the last is the network.
    std::string metric;
    double value = 0;
    int64_t pairs = 0;  // Number of scored pairs.
  };
  virtual std::optional<Score> ScoreOf(std::string_view /*input*/,
                                       std::string_view /*bytes*/) const {
    return {};
  }
  // Returns the core-seconds that a job with this input took to make its stored result; 0 where it
  // keeps none. The same condition holds.
  virtual double CoreSecondsOf(std::string_view /*input*/, std::string_view /*bytes*/) const {
    return 0;
  }
  // Seconds that a result reports for a stage, for the metrics.
  struct StageSeconds {
    std::string stage;
    double seconds = 0;
  };
  virtual std::vector<StageSeconds> StagesOf(std::string_view /*result*/) const { return {}; }

  // ---- Hooks. Called from the writer's thread, inside a command's transaction.
  // Returns the keys of a new job. Errors, here and below: see the head of this file.
  virtual absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const = 0;
  // For kinds that resume: returns a key that is equal for jobs whose attempts may continue from
  // each other's folders. By default: the work key.
  virtual absl::StatusOr<Sha256Digest> KeepKey(WorkDesk& desk, const JobFacts& job) const;
  // Returns what is known of the job's work. By default: done if a result of its work key is
  // stored.
  virtual absl::StatusOr<KnownWork> Look(WorkDesk& desk, const JobFacts& job) const;
  // Removes from a new job the work that is done already. By default: nothing.
  virtual absl::Status Trim(WorkDesk& desk, JobFacts& job) const;
  // For kinds that share a part: returns whether the part exists.
  virtual absl::StatusOr<bool> HasPart(WorkDesk& desk, const JobFacts& job) const;
  // Returns why this job can't have that result; empty if it can.
  virtual absl::StatusOr<std::string> WhyNot(WorkDesk& desk, const JobFacts& job,
                                             const CheckedResult& result) const;
  // Stores the result. If another job with this work key has committed one before, that one counts.
  virtual absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                                       const CheckedResult& result) const = 0;
  // Called when the job has succeeded, by its own attempt or by another job's result. Adds the jobs
  // that this makes possible.
  virtual absl::Status OnSuccess(WorkDesk& desk, const JobFacts& job, const Ending& ending,
                                 bool by_own_attempt) const;
  // Called when a study was submitted. Adds the jobs that it begins with, beside its scenes.
  virtual absl::Status OnSubmit(WorkDesk& desk, const v1::StudySpec& study,
                                std::span<const int64_t> variants) const;
  // For the kind that begins scenes: called when a scene must also give the pairs `first` to `first
  // + count - 1`.
  virtual absl::Status OnMorePairs(WorkDesk& desk, int64_t variant, uint32_t ordinal,
                                   uint32_t first, uint32_t count) const;

  // ---- Audit. Called inside a read transaction.
  struct Invariant {
    const char* name;
    const char* sql;  // Gives a row for each violation.
  };
  virtual std::span<const Invariant> Invariants() const { return {}; }
  // Checks invariants that SQL can't state: adds a line for each violation. Errors: the database's.
  virtual absl::Status Audit(SqliteConnection& db, std::vector<std::string>& violations) const;

 private:
  const std::string name_;
  const JobTraits traits_;
};

// Returns the folder of one attempt that all of these files are in: "ab/ab12.../.attempt-7/003".
// Empty if none exists.
std::string CommonFolder(const std::vector<JobKind::OutputFile>& files);

inline constexpr size_t kMostKinds = 12;

// The kinds of one queue, in the order in which work flows through them. The scheduler serves later
// kinds first, so that work that was begun is finished. Immutable.
class KindRegistry {
 public:
  // Returns the kinds of this release; see kinds/kinds.cc.
  static const KindRegistry& Builtin();
  // `kinds` live as long as the registry. Ends the program if a name is bad or there twice, if
  // there are more than kMostKinds, or if not exactly one kind begins scenes.
  explicit KindRegistry(std::vector<const JobKind*> kinds);
  // Returns a registry of these kinds and `more`.
  KindRegistry With(const JobKind& more) const;

  size_t size() const { return kinds_.size(); }
  const JobKind& operator[](KindId id) const { return *kinds_[id.value]; }
  const JobKind& at(size_t i) const { return *kinds_[i]; }
  std::optional<KindId> Find(std::string_view name) const;
  // Returns the id of the kind. Errors: kNotFound that names the kind and the existing ones.
  absl::StatusOr<KindId> IdOf(std::string_view name) const;
  KindId begins_scenes() const { return begins_scenes_; }
  std::vector<std::string> Names() const;
  // Returns the files of a stored result, whichever kind has stored it; see WorkDesk::PutResult.
  std::vector<JobKind::OutputFile> StoredFiles(std::string_view stage,
                                               std::string_view bytes) const;

 private:
  std::vector<const JobKind*> kinds_;
  KindId begins_scenes_;
};

}  // namespace parallax
