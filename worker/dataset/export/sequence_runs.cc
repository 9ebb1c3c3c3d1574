#include "worker/dataset/export/sequence_runs.h"

#include <fmt/core.h>

#include <map>
#include <optional>
#include <tuple>

#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

// Scene, right eye of its left one, way.
using Way = std::tuple<uint32_t, uint32_t, uint32_t>;

struct Member {
  const DatasetFrame* frame = nullptr;
  std::optional<uint32_t> next;  // Rig.
};

absl::Status NoSequence(const DatasetFrame& frame, const std::string& what) {
  return FailedPrecondition(
      "{}: {}; this layout is for sequences with flow (rigs.path or walks of nature, and flow in "
      "render.maps)",
      frame.dir, what);
}

// Where a frame stands, as its frame.json says.
struct Place {
  Way way;
  std::optional<uint32_t> next;  // Rig.
};

absl::StatusOr<Place> PlaceOf(const DatasetFrame& frame) {
  ASSIGN_OR_RETURN(const auto json, ReadFrameJson(frame.dir));
  if (!json.contains("sequence")) return NoSequence(frame, "belongs to no sequence");
  if (!frame.files.contains("flow_forward_left.exr")) return NoSequence(frame, "has no flow");
  const auto& sequence = json.at("sequence");
  const uint32_t eye = frame.rig - json.value("left_rig", frame.rig);
  Place place{{frame.scene, eye, sequence.at("path").get<uint32_t>()}, std::nullopt};
  if (!sequence.at("next").is_null()) place.next = sequence.at("next").get<uint32_t>();
  return place;
}

}  // namespace

absl::StatusOr<std::vector<SequenceRun>> FindRuns(const DatasetVariant& variant, bool unfiltered,
                                                  int64_t& single) {
  std::map<Way, std::vector<Member>> ways;
  std::map<uint32_t, uint32_t> most_eyes;  // By scene.
  for (const DatasetFrame& frame : variant.frames) {
    if (!frame.passed && !unfiltered) continue;
    ASSIGN_OR_RETURN(const Place place, CatchJson(frame.dir, [&frame] { return PlaceOf(frame); }));
    ways[place.way].push_back({&frame, place.next});
    const uint32_t eye = std::get<1>(place.way);
    most_eyes[frame.scene] = std::max(most_eyes[frame.scene], eye);
  }
  std::vector<SequenceRun> runs;
  for (const auto& [way, members] : ways) {
    const auto& [scene, eye, path] = way;
    const std::string name =
        fmt::format("-p{}{}", path, most_eyes[scene] > 0 ? fmt::format("-b{}", eye) : "");
    int gaps = 0;
    for (size_t begin = 0; begin < members.size();) {
      size_t end = begin + 1;
      while (end < members.size() && members[end - 1].next == members[end].frame->rig) ++end;
      SequenceRun run{name + (gaps > 0 ? fmt::format("-r{}", gaps) : ""), {}};
      for (size_t i = begin; i < end; ++i) run.frames.push_back(members[i].frame);
      if (run.frames.size() > 1) {
        runs.push_back(std::move(run));
      } else {
        ++single;
      }
      ++gaps;
      begin = end;
    }
  }
  return runs;
}

}  // namespace parallax
