// Files that describe an export: README.md, LICENSE and croissant.json.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/export/export.h"
#include "worker/dataset/export/shards.h"

namespace parallax {

struct ExportCard {
  std::string markdown, croissant;
};

// Makes the card of an export of `result.pairs` pairs. `export_json` is the content of export.json,
// which croissant.json names by its hash; `licence` that of LICENSE. The shards are empty in
// layouts without them.
ExportCard MakeExportCard(const std::string& layout, const ExportResult& result,
                          const std::string& export_json, const std::string& licence,
                          const std::vector<Shard>& train, const std::vector<Shard>& test);

// Returns the variants' different LICENSE files, concatenated; the usual licence for an archive of
// an earlier release, which has no file. Errors: those of ReadFile except kNotFound.
absl::StatusOr<std::string> LicenceOf(const std::vector<DatasetVariant>& variants);

}  // namespace parallax
