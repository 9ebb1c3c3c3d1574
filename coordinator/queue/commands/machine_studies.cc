// Orders of clients for studies: to submit, cancel and pause them; and whether a study is finished.
#include "common/config/training_plan.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/queue/database/compress.h"
#include "coordinator/study/expansion.h"

namespace parallax {
namespace {

std::string JoinLines(const google::protobuf::RepeatedPtrField<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

}  // namespace

absl::StatusOr<v1::SubmitReply> Machine::Submit(const v1::SubmitRequest& request,
                                                std::string_view actor) {
  const v1::StudySpec& spec = request.study();
  const std::string spec_bytes = DeterministicBytes(spec);
  const Sha256Digest spec_hash = Sha256Of(spec_bytes);
  v1::SubmitReply reply;
  const std::string user = UserOfActor(actor);
  // A key is its user's own. Older releases kept it without the user.
  const std::string own_key = request.idempotency_key() + "\n" + user;
  if (!request.idempotency_key().empty()) {
    SqliteQuery known(db_,
                      "SELECT id, spec_hash FROM studies"
                      " WHERE idempotency_key = ?1 OR (idempotency_key = ?2 AND user = ?3)",
                      own_key, request.idempotency_key(), user);
    if (known.Next()) {
      if (known.Digest(1) != spec_hash) {
        return AlreadyExists("idempotency key '{}' was used for another study ({})",
                             request.idempotency_key(), known.Int(0));
      }
      reply.set_study_id(known.Int(0));
      reply.set_existed(true);
      return reply;
    }
    RETURN_IF_ERROR(known.status());
  }
  RETURN_IF_ERROR(CheckUser(user, 1, TotalPairsOf(spec)));
  const auto key =
      request.idempotency_key().empty() ? std::nullopt : std::optional<std::string>(own_key);
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO studies(name, spec_z, spec_hash, idempotency_key, seed, priority,"
              " needs_memory_mb, needs_tags, submitted_unix_s, user, max_running)"
              " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
              spec.name(), SqlBlob{Compress(spec_bytes)}, spec_hash, key,
              static_cast<int64_t>(spec.seed()), spec.priority(), spec.memory_mb(),
              JoinLines(spec.tags()), Now(), user, request.max_running()));
  const int64_t id = db_.last_insert_id();
  for (const v1::VariantSpec& variant : spec.variants()) {
    RETURN_IF_ERROR(
        db_.Run("INSERT INTO variants(study_id, name, config_z, pairs_wanted, rigs_per_scene, seed)"
                " VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                id, variant.name(), SqlBlob{PackMessage(variant.config())}, PairsOf(spec, variant),
                RigsPerSceneOf(spec, variant), static_cast<int64_t>(SeedOf(spec, variant))));
  }
  RETURN_IF_ERROR(Audit(actor, "submit", id, spec.name()));
  ledger_.NoteCreated(id);
  ASSIGN_OR_RETURN(const Study* study, ledger_.FindStudy(id));
  const std::vector<int64_t> variants = study->variants;
  for (size_t i = 0; i < kinds_.size(); ++i) {
    RETURN_IF_ERROR(kinds_.at(i).OnSubmit(*this, spec, variants));
  }
  hungry_.insert(variants.begin(), variants.end());  // Last: it isn't undone.
  reply.set_study_id(id);
  return reply;
}

absl::Status Machine::Cancel(int64_t id, std::string_view reason, std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (study->tally.cancelled) return absl::OkStatus();
  if (study->tally.finished) {
    return FailedPrecondition("study {} has ended already: there is nothing to cancel", id);
  }
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET cancelled = 1 WHERE id = ?1", id));
  ledger_.Change(*study).cancelled = true;
  changed_variants_.insert(study->variants.begin(), study->variants.end());
  RETURN_IF_ERROR(Audit(actor, "cancel", id, reason));
  RETURN_IF_ERROR(
      CancelJobs(id, 0, reason.empty() ? "cancelled" : "cancelled: " + std::string(reason)));
  return folders_.SweepUnwanted(Now());
}

absl::Status Machine::SetPaused(int64_t id, bool paused, std::string_view reason,
                                std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (study->tally.paused == paused) return absl::OkStatus();
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET paused = ?2 WHERE id = ?1", id, paused));
  ledger_.Change(*study).paused = paused;
  if (!paused) effects_.work_ready = true;
  return Audit(actor, paused ? "pause" : "resume", id, reason);
}

absl::Status Machine::Settle() {
  for (const int64_t id : ledger_.changed_studies()) {
    Study* const study = &ledger_.loaded_studies().at(id);
    if (study->tally.forgotten) continue;
    bool finished = true;
    for (const int64_t variant_id : study->variants) {
      ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(variant_id));
      const VariantTally& tally = variant->tally;
      const bool complete = study->tally.cancelled || !tally.problem.empty() ||
                            tally.pairs_planned >= variant->pairs_wanted;
      if (!complete || tally.OpenJobs() > 0) {
        finished = false;
        break;
      }
    }
    if (finished == study->tally.finished) continue;
    RETURN_IF_ERROR(db_.Run("UPDATE studies SET finished_unix_s = ?2 WHERE id = ?1", id,
                            finished ? std::optional<double>(Now()) : std::nullopt));
    study->tally.finished = finished;
  }
  return absl::OkStatus();
}

}  // namespace parallax
