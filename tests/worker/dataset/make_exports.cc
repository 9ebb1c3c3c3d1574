// make_exports DIR: a synthetic archive in DIR/archive, one of sequences in DIR/archive_sequences,
// and their exports in every layout in DIR/<layout> (crestereo also flat), for readers written in
// other languages to be tried on.
#include <filesystem>
#include <iostream>

#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/dataset/export.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_exports DIR\n";
    return 2;
  }
  const std::string dir = argv[1];
  std::filesystem::create_directories(dir);
  parallax::SyntheticArchive archive;
  archive.scenes = 5;
  archive.last_frame_dark = true;
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
      parallax::ExportOptions options;
      options.layout = layout;
      options.flat = flat;
      options.shard_pairs = 4;
      const auto result =
          parallax::ExportDataset(dir + (sequences ? "/archive_sequences" : "/archive"),
                                  dir + "/" + layout + (flat ? "_flat" : ""), options);
      if (!result.ok()) {
        std::cerr << layout << ": " << result.status() << "\n";
        return 1;
      }
    }
  }
  return 0;
}
