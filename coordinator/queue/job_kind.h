// A kind of job: what the queue must know of the work that it hands out. The state machine, its
// tables, readers, auditor and services ask a KindRegistry and contain no kind's name; a kind is
// one file in kinds/ and one line in kinds/kinds.cc.
//
// A kind decides what work is equal (keys), what a worker is told (spec), which results are right
// and what they make ready. It can't decide who holds a job, when an attempt is tried again or what
// is published: it sees no fence, lease or ledger, and changes the tables only through WorkDesk.
//
// Kinds are stateless and live as long as the program. Thread-safe. Errors of hooks: what WorkDesk
// or ResultReader gave them, which undoes the whole command; a kind's own only for a broken
// database (kDataLoss) or a mistake in the program (kInternal).
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

struct JobTraits {
  // Stages whose results it makes: it only goes to workers that have the coordinator's versions.
  std::vector<std::string> stages = {};
  std::string doing = {};  // For people, what its workers are doing: "rendering".
  // Its jobs belong to a scene and stand for pairs of it: for the rigs that they name, or for all
  // of the scene's if they name none. Lost pairs are replaced by the variant's next seeds.
  bool of_scene = false;
  // A variant's new scene begins with a job of this kind. Exactly one kind of a registry does.
  bool begins_scenes = false;
  // A result may be "there is no such thing": REJECTED, which is no failure.
  bool may_reject = false;
  // An attempt writes files into a folder of the store.
  bool has_output = false;
  // A READY job may give rigs away to new jobs while slots idle.
  bool can_split = false;
  // Jobs of a group share a part (a layout) that the first of them makes: until there is one, only
  // one job of the group is leased at a time.
  bool shares_part = false;
  // A worker that has done one job of a group does the next one faster.
  bool keeps_group_warm = false;
  // An attempt goes on from what earlier attempts have left in their folders. Those stay until the
  // work is done or nobody wants it any more; jobs of scenes: until no job of the scene is open.
  // Jobs without a scene have an input.
  bool resumes = false;
  // What a worker must have for this kind, beside what the study and the job ask for.
  int64_t needs_memory_mb = 0;
  std::vector<std::string> needs_tags = {};
};

// What a job asks of its worker.
struct WorkNeeds {
  int64_t memory_mb = 0;
  std::vector<std::string> tags;
};

// In place of a scene's number in messages on jobs that have none.
inline constexpr uint32_t kNoScene = UINT32_MAX;

// A job as its kind sees it.
struct JobFacts {
  int64_t id = 0;  // 0 while it is not in the table yet.
  int64_t study = 0;
  int64_t variant = 0;
  KindId kind;
  uint32_t ordinal = 0;  // The scene's number; without a scene, the job's number in its variant.
  std::string rigs;      // Pairs that it stands for: "0-19"; see study/rigs.h. Empty: see of_scene.
  uint32_t rig_count = 0;
  std::string input;  // The kind's own bytes; the queue only keeps them.
  int generation = 1;
  Sha256Digest work_key{};
  Sha256Digest group_key{};
  bool part_given = false;  // The newest lease carried the group's part, made by another job.
};

struct JobKeys {
  Sha256Digest work;   // Equal for equal work: such jobs share one result.
  Sha256Digest group;  // Locality, and who shares a part; see JobTraits.
};

// What a job waits for before it is READY: another job's success, or a variant's first `pairs`
// published pairs.
struct JobWait {
  static JobWait OnJob(int64_t job) { return {.on_job = job}; }
  static JobWait OnPairs(int64_t variant, int64_t pairs) {
    return {.on_variant = variant, .pairs = pairs};
  }
  int64_t on_job = 0;  // 0: the variant.
  int64_t on_variant = 0;
  int64_t pairs = 0;
};

// A job that a kind asks for.
struct NewJob {
  std::string_view kind;
  int64_t variant = 0;
  // Unique among the variant's jobs of this kind, rigs and generation.
  uint32_t ordinal = 0;
  std::vector<uint32_t> rigs = {};
  std::string input = {};
  std::vector<JobWait> waits = {};
  int generation = 1;  // A manual retry has its predecessor's plus one.
  // Nobody can have done this work before: results needn't be looked for.
  bool is_fresh = false;
};

// A result as it is stored, by key.
struct StoredResult {
  std::string bytes;  // As the kind stored them; empty if rejected.
  bool rejected = false;
  std::string reason;  // Why it was rejected.
};

// A published pair of a dataset.
struct FrameLink {
  uint32_t rig = 0;
  Sha256Digest key{};   // Key of the frame's result.
  bool reused = false;  // Made by another job.
};

struct VariantFacts {
  int64_t id = 0;
  std::string_view name;
  uint64_t seed = 0;  // That its scenes are drawn from.
  int64_t pairs_wanted = 0;
  uint32_t rigs_per_scene = 0;
  const v1::SceneConfig* config = nullptr;  // Lives until the hook returns.
  const ConfigDigests* digests = nullptr;
};

struct SceneFacts {
  uint32_t rigs = 0;
  std::optional<Sha256Digest> scene_hash;  // Once it is solved.
};

// What a kind may read and change inside the writer's transaction. Errors of the calls are the
// database's; a hook passes them on, and the whole command is undone.
class WorkDesk {
 public:
  virtual ~WorkDesk() = default;
  virtual const StageVersions& versions() const = 0;
  virtual absl::StatusOr<VariantFacts> VariantOf(int64_t variant) = 0;
  virtual absl::StatusOr<SceneFacts> SceneOf(int64_t variant, uint32_t ordinal) = 0;
  // The newest generation of the job with this id.
  virtual absl::StatusOr<JobFacts> NewestOf(int64_t job) = 0;

  // ---- Results by content: the first one committed wins, none ever changes.
  virtual absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key) = 0;
  virtual absl::StatusOr<bool> HasResult(const Sha256Digest& key) = 0;
  // `stage` says what it is ("layout", "frame", a kind's name). True if it is the first.
  virtual absl::StatusOr<bool> PutResult(const JobFacts& by, std::string_view stage,
                                         const Sha256Digest& key, const StoredResult& result) = 0;

  // ---- What a result means for the study.
  // The job's scene is solved as this.
  virtual absl::Status SetScene(const JobFacts& job, const Sha256Digest& scene_hash) = 0;
  // These pairs of the job's scene are published. Their results are stored.
  virtual absl::Status Publish(const JobFacts& job, std::span<const FrameLink> frames) = 0;
  // A folder or file of the attempt at hand that no result names.
  virtual absl::Status Discard(std::string_view path) = 0;
  // In the state where it belongs: done if its result is known, BLOCKED while it waits, else READY.
  // Returns its id. Errors: kInternal for an unknown kind or a wait that can never end.
  virtual absl::StatusOr<int64_t> AddJob(const NewJob& job) = 0;
};

// A leased job, as the one who writes its spec sees it.
struct LeasedJob {
  JobFacts job;
  uint64_t seed = 0;  // The seed of the job's variant.
  std::shared_ptr<const v1::SceneConfig> config;
  // Of kinds that resume: folders in the store of ended attempts with its keep key, the newest
  // first.
  std::vector<std::string> kept_folders = {};
};
// Committed results, for specs. Any thread.
class ResultReader {
 public:
  virtual ~ResultReader() = default;
  // kNotFound.
  virtual absl::StatusOr<std::string> ResultBytes(const Sha256Digest& key) = 0;
  // Keys of a variant's published frames in the order of scenes and rigs, at most `limit`.
  virtual absl::StatusOr<std::vector<Sha256Digest>> FramesOf(int64_t variant, int64_t limit) = 0;
  // Where the same frames are in the store. kDataLoss for one that is in no folder of a rig.
  virtual absl::StatusOr<std::vector<v1::FrameFolder>> FoldersOf(int64_t variant,
                                                                 int64_t limit) = 0;
  // The result of the one job that this one waited for. kNotFound.
  virtual absl::StatusOr<std::string> ResultWaitedFor(int64_t job) = 0;
};

// A worker's result, checked and packed in the thread that received it. Kinds derive from it.
struct CheckedResult {
  virtual ~CheckedResult() = default;
  std::string invalid;             // Not empty: why no job can have this result.
  std::vector<std::string> paths;  // Folders in the store that it names; all in its attempt's.
};

// What a kind made of a result.
struct Ending {
  bool rejected = false;
  std::string reason;     // Why it was rejected.
  std::string result;     // Bytes for OnSuccess.
  bool is_fresh = false;  // What it made was made by nobody before.
};

// Tells what is known about a job's work before a worker does it.
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

  // ---- Messages. Any thread.
  // The message that the worker's handler parses. Errors: as the reader.
  virtual absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const = 0;
  // What a job without a scene is, for people: "narrow, seed 1". By default: nothing.
  virtual std::string LabelOf(std::string_view /*input*/) const { return ""; }
  // What a worker must have for a job with this input, beside the traits. By default: nothing.
  virtual WorkNeeds NeedsOf(std::string_view /*input*/) const { return {}; }
  // Parses a handler's answer. All hashing and compressing belongs here, because the writer's
  // thread calls the rest. Never null.
  virtual std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const = 0;
  // Files that a result says it has written, with their places in the store.
  struct OutputFile {
    std::string path;
    int64_t size = 0;
  };
  virtual std::vector<OutputFile> FilesOf(std::string_view /*result*/) const { return {}; }
  // The same of a stored result, if this kind has stored it; see WorkDesk::PutResult.
  virtual std::vector<OutputFile> StoredFiles(std::string_view /*stage*/,
                                              std::string_view /*bytes*/) const {
    return {};
  }
  // A stored result as one folder of files with their names, for those who copy results; the
  // same conditions.
  struct StoredFolder {
    std::string path;
    google::protobuf::RepeatedPtrField<v1::FileEntry> files;
  };
  virtual std::optional<StoredFolder> FolderOf(std::string_view /*bytes*/) const { return {}; }
  // What a stored result has measured, of a job with this input: a network's figure, or a
  // baseline's, on a benchmark; the same conditions.
  struct Score {
    std::string set;        // The training set; empty for a baseline.
    std::string predictor;  // The trainer or the baseline.
    std::optional<uint64_t> seed;
    std::string benchmark;
    int checkpoint = 1, checkpoints = 1;  // Which of how many, from 1; the last is the network.
    std::string metric;
    double value = 0;
    int64_t pairs = 0;  // Scored.
  };
  virtual std::optional<Score> ScoreOf(std::string_view /*input*/,
                                       std::string_view /*bytes*/) const {
    return {};
  }
  // Seconds by stage that a result tells of, for the metrics.
  struct StageSeconds {
    std::string stage;
    double seconds = 0;
  };
  virtual std::vector<StageSeconds> StagesOf(std::string_view /*result*/) const { return {}; }

  // ---- Hooks. The writer's thread, inside a command's transaction.
  virtual absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const = 0;
  // Of kinds that resume: equal for jobs whose attempts may go on from each other's folders. By
  // default: the work key.
  virtual absl::StatusOr<Sha256Digest> KeepKey(WorkDesk& desk, const JobFacts& job) const;
  // By default: done if a result of its work key is stored.
  virtual absl::StatusOr<KnownWork> Look(WorkDesk& desk, const JobFacts& job) const;
  // Takes out of a new job what is done already. By default: nothing.
  virtual absl::Status Trim(WorkDesk& desk, JobFacts& job) const;
  // Tells, for kinds that share a part, whether there is one to give.
  virtual absl::StatusOr<bool> HasPart(WorkDesk& desk, const JobFacts& job) const;
  // Why this job can't have that result; empty if it can.
  virtual absl::StatusOr<std::string> WhyNot(WorkDesk& desk, const JobFacts& job,
                                             const CheckedResult& result) const;
  // Stores the result. What was committed first by another job with this work key counts.
  virtual absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                                       const CheckedResult& result) const = 0;
  // The job has succeeded: by its own attempt (`stored`) or by another's result. Adds the jobs that
  // this makes possible.
  virtual absl::Status OnSuccess(WorkDesk& desk, const JobFacts& job, const Ending& ending,
                                 bool by_own_attempt) const;
  // A study was submitted. Adds the jobs that it begins with, beside its scenes.
  virtual absl::Status OnSubmit(WorkDesk& desk, const v1::StudySpec& study,
                                std::span<const int64_t> variants) const;
  // Of the kind that begins scenes: a scene is to give pairs `first` to `first + count - 1` as
  // well.
  virtual absl::Status OnMorePairs(WorkDesk& desk, int64_t variant, uint32_t ordinal,
                                   uint32_t first, uint32_t count) const;

  // ---- The auditor's. Inside a read transaction.
  struct Invariant {
    const char* name;
    const char* sql;  // Gives a row for each violation.
  };
  virtual std::span<const Invariant> Invariants() const { return {}; }
  // What SQL can't say: adds a line for each violation.
  virtual absl::Status Audit(SqliteConnection& db, std::vector<std::string>& violations) const;

 private:
  const std::string name_;
  const JobTraits traits_;
};

inline constexpr size_t kMostKinds = 12;

// The kinds of one queue, in the order in which work flows through them: the scheduler serves later
// ones first, so that what was begun is finished. Immutable.
class KindRegistry {
 public:
  // The kinds of this release; see kinds/kinds.cc.
  static const KindRegistry& Builtin();
  // `kinds` live as long as the registry. Ends the program if a name is bad or there twice, if
  // there are more than kMostKinds, or if not exactly one kind begins scenes.
  explicit KindRegistry(std::vector<const JobKind*> kinds);
  // These kinds and more.
  KindRegistry With(const JobKind& more) const;

  size_t size() const { return kinds_.size(); }
  const JobKind& operator[](KindId id) const { return *kinds_[id.value]; }
  const JobKind& at(size_t i) const { return *kinds_[i]; }
  std::optional<KindId> Find(std::string_view name) const;
  // Errors: kNotFound that names the kind and those there are.
  absl::StatusOr<KindId> IdOf(std::string_view name) const;
  KindId begins_scenes() const { return begins_scenes_; }
  std::vector<std::string> Names() const;

 private:
  std::vector<const JobKind*> kinds_;
  KindId begins_scenes_;
};

}  // namespace parallax
