// The needs of a READY job: all that it, its study and its kind ask of a worker. Alike jobs have
// equal keys, so that one answer does for all of them. Pure functions; thread-safe.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/queue/job_kind.h"

namespace parallax {

// Jobs that suit the same workers: of one study and kind, with equal needs.
struct ReadyKey {
  int64_t study = 0;
  std::string kind;
  int64_t memory_mb = 0;
  std::vector<std::string> tags;  // Sorted, each once.
  auto operator<=>(const ReadyKey&) const = default;
};

// Returns the group of a job with these own needs: the study's and its kind's are added.
ReadyKey ReadyKeyOf(int64_t study, const WorkNeeds& study_needs, const JobKind& kind,
                    const WorkNeeds& job_needs);

// Returns the tags of the column studies.needs_tags, which has one a line.
std::vector<std::string> TagLines(std::string_view text);

}  // namespace parallax
