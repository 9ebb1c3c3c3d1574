#include "coordinator/rpc/storage/store_use.h"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <set>
#include <unordered_set>

namespace parallax {
namespace {

constexpr int kStudiesAtOnce = 1000;
constexpr int kRowsAtOnce = 1000;
constexpr double kDay_s = 86400;

template <typename Files>
std::pair<uint64_t, int64_t> FolderOf(const std::string& path, const Files& files) {
  int64_t bytes = 0;
  for (const v1::FileEntry& file : files) bytes += static_cast<int64_t>(file.size());
  return {std::hash<std::string>()(path), bytes};
}

// Gives `take` the study's rows behind `cursor`, which `list` reads page by page. Moves `cursor`.
template <typename Request, typename Cursor, typename List, typename Take>
absl::Status ForEachRow(int64_t study, Cursor& cursor, const List& list, const Take& take) {
  Request request;
  request.set_study_id(study);
  request.set_limit(kRowsAtOnce);
  for (size_t read = kRowsAtOnce; read == kRowsAtOnce;) {
    request.set_cursor(cursor);
    ASSIGN_OR_RETURN(const auto page, list(request));
    for (const auto& row : page) {
      take(row);
      cursor = row.cursor();
    }
    read = page.size();
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status StoreUse::FollowStudy(JobQueue& queue, int64_t id, Study& study) {
  RETURN_IF_ERROR(ForEachRow<v1::ListFramesRequest>(
      id, study.frame_cursor, [&](const auto& request) { return queue.ListFrames(request); },
      [&](const v1::PublishedFrame& row) {
        study.folders.push_back(FolderOf(row.frame().path(), row.frame().files()));
      }));
  return ForEachRow<v1::ListResultsRequest>(
      id, study.result_cursor, [&](const auto& request) { return queue.ListResults(request); },
      [&](const v1::JobResult& row) {
        study.folders.push_back(FolderOf(row.path(), row.files()));
      });
}

absl::Status StoreUse::Follow(JobQueue& queue) {
  std::set<int64_t> there;
  int64_t before = 0;
  for (size_t read = kStudiesAtOnce; read == kStudiesAtOnce;) {
    ASSIGN_OR_RETURN(const std::vector<v1::StudyStatus> page,
                     queue.ListStudies(kStudiesAtOnce, before));
    for (const v1::StudyStatus& status : page) {
      const auto [at, is_new] = studies_.try_emplace(status.study_id());
      // A study that had ended before it was read has nothing new.
      if (is_new || at->second.ended_unix_s == 0 || status.finished_unix_s() == 0) {
        const absl::Status followed = FollowStudy(queue, status.study_id(), at->second);
        if (!followed.ok() && !absl::IsNotFound(followed)) return followed;
      }
      at->second.ended_unix_s = status.finished_unix_s();
      there.insert(status.study_id());
      before = status.study_id();
    }
    read = page.size();
  }
  std::erase_if(studies_, [&](const auto& study) { return there.count(study.first) == 0; });
  return absl::OkStatus();
}

int64_t StoreUse::Bytes() const {
  int64_t total = 0;
  std::unordered_set<uint64_t> counted;
  for (const auto& [id, study] : studies_) {
    for (const auto& [folder, bytes] : study.folders) {
      if (counted.insert(folder).second) total += bytes;
    }
  }
  return total;
}

std::vector<ForgetDue> StoreUse::Due(const RetentionRules& rules, double now_unix_s) const {
  std::vector<std::pair<int64_t, const Study*>> order;  // Unfinished ones, then the newest first.
  for (const auto& [id, study] : studies_) order.emplace_back(id, &study);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    const double a_end = a.second->ended_unix_s, b_end = b.second->ended_unix_s;
    if ((a_end == 0) != (b_end == 0)) return a_end == 0;
    return a_end != b_end ? a_end > b_end : a.first > b.first;
  });
  std::vector<ForgetDue> due;
  std::unordered_set<uint64_t> counted;
  int64_t total = 0;
  bool full = false;
  for (const auto& [id, study] : order) {
    for (const auto& [folder, bytes] : study->folders) {
      if (counted.insert(folder).second) total += bytes;
    }
    full = full || (rules.keep_bytes > 0 && total > rules.keep_bytes);
    if (study->ended_unix_s == 0) continue;
    const double age_s = now_unix_s - study->ended_unix_s;
    if (rules.keep_s > 0 && age_s > rules.keep_s) {
      due.push_back({StudyId{id}, fmt::format("ended {:.1f} days ago (--keep-days {:.4g})",
                                              age_s / kDay_s, rules.keep_s / kDay_s)});
    } else if (full) {
      due.push_back({StudyId{id}, fmt::format("with it and newer studies the results take {:.3f} GB"
                                              " (--keep-gb {:.4g})",
                                              static_cast<double>(total) / 1e9,
                                              static_cast<double>(rules.keep_bytes) / 1e9)});
    }
  }
  std::reverse(due.begin(), due.end());
  return due;
}

}  // namespace parallax
