#include "worker/dataset/export/stream_sample.h"

#include <fmt/core.h>

#include "worker/dataset/export/export_layouts.h"
#include "worker/dataset/frame/plain_formats.h"

namespace parallax {

absl::StatusOr<std::string> StreamSample(const v1::StreamedPair& pair, const std::string& folder) {
  DatasetFrame source{.variant = pair.variant(),
                      .scene = pair.scene(),
                      .rig = pair.frame().rig(),
                      .dir = folder,
                      .files = {},
                      .line = {}};
  for (const v1::FileEntry& file : pair.frame().files()) source.files[file.name()] = file.sha256();
  const ExportFrame frame{
      .source = &source,
      .scene = fmt::format("{}_{}_{:06}", pair.chunk(), pair.variant(), pair.scene()),
      .type = ""};
  ASSIGN_OR_RETURN(const FrameFiles made,
                   MakeExportLayout({.layout = "webdataset"})->Convert(frame));
  std::string members;
  for (const ExportFile& file : made.files) {
    ASSIGN_OR_RETURN(const std::string member, TarMember(file.path, file.bytes));
    members += member;
  }
  return members;
}

std::string StreamEnd() { return TarEnd(); }

}  // namespace parallax
