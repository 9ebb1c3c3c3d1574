#include "worker/dataset/export/export_card.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "common/base/system/file.h"
#include "common/base/version.h"
#include "worker/dataset/archive/publication.h"

namespace parallax {
namespace {

std::string Croissant(const std::string& layout, const ExportResult& result,
                      const std::string& export_json, bool other_licence) {
  Publication publication;
  publication.name = "parallax-" + layout;
  publication.description = fmt::format(
      "{} synthetic stereo pairs with exact ground truth, in the layout {}.", result.pairs, layout);
  publication.version = kProgramVersion;
  publication.other_licence = other_licence;
  publication.table_file = "export.json";
  publication.table_bytes = export_json;
  publication.json_path = "$.frames[*]";
  publication.fields = {
      {"variant", "Variant of the study.", "Text"},
      {"scene", "Number of the scene.", "Integer"},
      {"rig", "Number of the rig in its scene.", "Integer"},
      {"split", "TRAIN or TEST.", "Text"},
      {"files", "The pair's files, as train.txt and test.txt list them.", "Text"}};
  return CroissantJson(publication);
}

}  // namespace

ExportCard MakeExportCard(const std::string& layout, const ExportResult& result,
                          const std::string& export_json, const std::string& licence,
                          const std::vector<Shard>& train, const std::vector<Shard>& test) {
  const bool other_licence = licence != DataLicence(/*own_content=*/false);
  const bool shards = !train.empty() || !test.empty();
  ExportCard card;
  card.markdown = fmt::format(
      "{}# Stereo pairs made by Parallax, in the layout {}\n\n{} pairs, {} of them for tests; "
      "`export.json` lists them all.\n\n{}{}",
      CardHead(result.pairs, other_licence, shards ? ShardHead(train, test) : ""), layout,
      result.pairs, result.pairs_test, shards ? ShardCard(train, test) + "\n" : "",
      CitationSection(other_licence));
  card.croissant = Croissant(layout, result, export_json, other_licence);
  return card;
}

absl::StatusOr<std::string> LicenceOf(const std::vector<DatasetVariant>& variants) {
  std::vector<std::string> different;
  for (const DatasetVariant& variant : variants) {
    absl::StatusOr<std::string> text = ReadFile(variant.dir + "/LICENSE");
    if (absl::IsNotFound(text.status())) text = DataLicence(/*own_content=*/false);
    RETURN_IF_ERROR(text.status());
    if (std::find(different.begin(), different.end(), *text) == different.end()) {
      different.push_back(*std::move(text));
    }
  }
  std::string all;
  for (const std::string& text : different) all += (all.empty() ? "" : "\n") + text;
  return all;
}

}  // namespace parallax
