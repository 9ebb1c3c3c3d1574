// make_exports DIR: a synthetic archive in DIR/archive and its export in every layout in
// DIR/<layout> (crestereo also flat); and an archive with infrared and raw pairs in
// DIR/archive_extras with its exports archive_extras_infrared and archive_extras_webdataset; and
// one of sequences in DIR/archive_sequences with archive_sequences_webdataset; for readers written
// in other languages to be tried on.
#include <filesystem>
#include <iostream>

#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/dataset/export/export.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_exports DIR\n";
    return 2;
  }
  const std::string dir = argv[1];
  std::filesystem::create_directories(dir);
  parallax::SyntheticArchive archive{.scenes = 5, .last_frame_dark = true};
  parallax::MakeSyntheticArchive(dir + "/archive", archive);
  archive.scenes = 2;
  archive.rigs = 4;
  archive.last_frame_dark = false;
  archive.sequence = true;
  parallax::MakeSyntheticArchive(dir + "/archive_sequences", archive);
  for (const std::string& layout : parallax::ExportLayouts()) {
    const bool sequences =
        layout == "flyingthings-flow" || layout == "sintel" || layout == "dynamic-replica";
    for (const bool flat : {false, true}) {
      if (flat && layout != "crestereo") continue;
      const auto result =
          parallax::ExportDataset(dir + (sequences ? "/archive_sequences" : "/archive"),
                                  dir + "/" + layout + (flat ? "_flat" : ""),
                                  {.layout = layout, .flat = flat, .shard_pairs = 4});
      if (!result.ok()) {
        std::cerr << layout << ": " << result.status() << "\n";
        return 1;
      }
    }
  }
  const auto moving = parallax::ExportDataset(
      dir + "/archive_sequences", dir + "/archive_sequences_webdataset", {.layout = "webdataset"});
  if (!moving.ok()) {
    std::cerr << "sequences: " << moving.status() << "\n";
    return 1;
  }
  const parallax::SyntheticArchive extras{.extras = true};
  parallax::MakeSyntheticArchive(dir + "/archive_extras", extras);
  for (const bool infrared : {false, true}) {
    const auto result = parallax::ExportDataset(
        dir + "/archive_extras", dir + "/archive_extras_" + (infrared ? "infrared" : "webdataset"),
        {.layout = infrared ? "flyingthings" : "webdataset", .infrared = infrared});
    if (!result.ok()) {
      std::cerr << "extras: " << result.status() << "\n";
      return 1;
    }
  }
  return 0;
}
