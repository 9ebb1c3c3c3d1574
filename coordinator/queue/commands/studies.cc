#include "coordinator/queue/commands/studies.h"

#include "common/config/check/notify_check.h"
#include "common/config/training_plan.h"
#include "coordinator/queue/database/compress.h"
#include "coordinator/study/expansion.h"

namespace parallax {
namespace {

std::string JoinLines(const google::protobuf::RepeatedPtrField<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

// The hash of everything that decides what a study makes.
Sha256Digest LastingHash(v1::StudySpec spec) {
  spec.clear_source_yaml();
  return Sha256Of(DeterministicBytes(spec));
}

}  // namespace

absl::StatusOr<v1::SubmitReply> Studies::Submit(const v1::SubmitRequest& request,
                                                std::string_view actor) {
  v1::StudySpec spec = request.study();
  // As older releases had it: a key that one of them took still names this study.
  const Sha256Digest former_hash = Sha256Of(DeterministicBytes(spec));
  const v1::NotifySpec receiver = TakeNotify(&spec);
  const std::string spec_bytes = DeterministicBytes(spec);
  const Sha256Digest spec_hash = LastingHash(spec);
  v1::SubmitReply reply;
  const std::string user = UserOfActor(actor);
  // A key is its user's own. Older releases kept it without the user.
  const std::string own_key = request.idempotency_key() + "\n" + user;
  if (!request.idempotency_key().empty()) {
    SqliteQuery known(tables_.db,
                      "SELECT id, spec_hash FROM studies"
                      " WHERE idempotency_key = ?1 OR (idempotency_key = ?2 AND user = ?3)",
                      own_key, request.idempotency_key(), user);
    if (known.Next()) {
      if (known.Digest(1) != spec_hash && known.Digest(1) != former_hash) {
        return AlreadyExists("idempotency key '{}' was used for another study ({})",
                             request.idempotency_key(), known.Int(0));
      }
      reply.set_study_id(known.Int(0));
      reply.set_existed(true);
      RETURN_IF_ERROR(tables_.notices.SetReceiver(reply.study_id(), receiver));
      return reply;
    }
    RETURN_IF_ERROR(known.status());
  }
  RETURN_IF_ERROR(limits_.CheckUser(user, 1, TotalPairsOf(spec)));
  const auto key =
      request.idempotency_key().empty() ? std::nullopt : std::optional<std::string>(own_key);
  RETURN_IF_ERROR(
      tables_.db.Run("INSERT INTO studies(name, spec_z, spec_hash, idempotency_key, seed, priority,"
                     " needs_memory_mb, needs_tags, submitted_unix_s, user, max_running)"
                     " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
                     spec.name(), SqlBlob{Compress(spec_bytes)}, spec_hash, key,
                     static_cast<int64_t>(spec.seed()), spec.priority(), spec.memory_mb(),
                     JoinLines(spec.tags()), tables_.Now(), user, request.max_running()));
  const int64_t id = tables_.db.last_insert_id();
  for (const v1::VariantSpec& variant : spec.variants()) {
    RETURN_IF_ERROR(tables_.db.Run(
        "INSERT INTO variants(study_id, name, config_z, pairs_wanted, rigs_per_scene, seed)"
        " VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
        id, variant.name(), SqlBlob{PackMessage(variant.config())}, PairsOf(spec, variant),
        RigsPerSceneOf(spec, variant), static_cast<int64_t>(SeedOf(spec, variant))));
  }
  RETURN_IF_ERROR(tables_.notices.SetReceiver(id, receiver));
  RETURN_IF_ERROR(tables_.Audit(actor, "submit", id, spec.name()));
  tables_.ledger.NoteCreated(id);
  ASSIGN_OR_RETURN(const Study* study, tables_.ledger.FindStudy(id));
  const std::vector<int64_t> variants = study->variants;
  for (size_t i = 0; i < tables_.kinds.size(); ++i) {
    RETURN_IF_ERROR(tables_.kinds.at(i).OnSubmit(jobs_.desk(), spec, variants));
  }
  tables_.hungry.insert(variants.begin(), variants.end());  // Last: it isn't undone.
  reply.set_study_id(id);
  return reply;
}

absl::Status Studies::Cancel(int64_t id, std::string_view reason, std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  if (study->tally.cancelled) return absl::OkStatus();
  if (study->tally.finished) {
    return FailedPrecondition("study {} has ended already: there is nothing to cancel", id);
  }
  RETURN_IF_ERROR(tables_.db.Run("UPDATE studies SET cancelled = 1 WHERE id = ?1", id));
  tables_.ledger.Change(*study).cancelled = true;
  tables_.changed_variants.insert(study->variants.begin(), study->variants.end());
  RETURN_IF_ERROR(tables_.Audit(actor, "cancel", id, reason));
  RETURN_IF_ERROR(
      jobs_.CancelAll(id, 0, reason.empty() ? "cancelled" : "cancelled: " + std::string(reason)));
  return tables_.folders.SweepUnwanted(tables_.Now());
}

absl::Status Studies::SetPaused(int64_t id, bool paused, std::string_view reason,
                                std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  if (study->tally.paused == paused) return absl::OkStatus();
  RETURN_IF_ERROR(tables_.db.Run("UPDATE studies SET paused = ?2 WHERE id = ?1", id, paused));
  tables_.ledger.Change(*study).paused = paused;
  if (!paused) tables_.effects.work_ready = true;
  return tables_.Audit(actor, paused ? "pause" : "resume", id, reason);
}

absl::Status Studies::Comment(int64_t id, std::string_view text, std::string_view actor) {
  if (text.empty()) return InvalidArgument("a comment without text");
  RETURN_IF_ERROR(tables_.ledger.FindStudy(id).status());
  return tables_.Audit(actor, "comment", id, text);
}

}  // namespace parallax
