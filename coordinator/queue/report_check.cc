#include "coordinator/queue/report_check.h"

#include <algorithm>

#include "coordinator/queue/compress.h"
#include "coordinator/study/keys.h"

namespace parallax {
namespace {

bool IsSha256Hex(std::string_view text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

std::string WhyBadFrame(const v1::FrameResult& frame) {
  const std::string where = "frame of rig " + std::to_string(frame.rig());
  if (!IsConfinedPath(frame.path()))
    return where + ": path '" + frame.path() + "' leaves the store";
  for (const v1::FileEntry& file : frame.files()) {
    if (!IsConfinedPath(file.name())) {
      return where + ": file name '" + file.name() + "' leaves its folder";
    }
    if (file.size() < 0) return where + ": " + file.name() + " has a negative size";
    if (!IsSha256Hex(file.sha256())) {
      return where + ": " + file.name() + " has no SHA-256 of 64 lower-case hex digits";
    }
  }
  return "";
}

void CheckSolve(const v1::SolveResult& result, CheckedReport& out) {
  out.kind = WorkKind::kSolve;
  if (result.has_layout()) out.layout_z = PackMessage(result.layout());
  switch (result.outcome_case()) {
    case v1::SolveResult::kScene: {
      const std::string bytes = DeterministicBytes(result.scene());
      out.scene_hash = Sha256Of(bytes);
      out.scene_z = Compress(bytes);
      out.scene_seed = result.scene().scene_seed();
      out.scene_rigs = static_cast<uint32_t>(result.scene().rigs_size());
      break;
    }
    case v1::SolveResult::kRejected:
      out.rejected = true;
      out.reject_reason = result.rejected().reason();
      break;
    case v1::SolveResult::OUTCOME_NOT_SET:
      out.invalid = "a solve result with neither a scene nor a rejection";
  }
}

void CheckRender(const v1::RenderResult& result, CheckedReport& out) {
  out.kind = WorkKind::kRender;
  for (const v1::FrameResult& frame : result.frames()) {
    out.invalid = WhyBadFrame(frame);
    if (!out.invalid.empty()) return;
    out.frames.push_back({frame.rig(), frame.path(), PackMessage(frame)});
  }
  std::sort(out.frames.begin(), out.frames.end(),
            [](const CheckedFrame& a, const CheckedFrame& b) { return a.rig < b.rig; });
}

}  // namespace

bool IsConfinedPath(std::string_view path) {
  if (path.empty() || path.size() > 4096) return false;
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return std::none_of(path.begin(), path.end(),
                      [](char c) { return c == '\\' || static_cast<unsigned char>(c) < 0x20; });
}

CheckedReport CheckReport(const v1::CompleteRequest& request) {
  CheckedReport report;
  report.attempt = request.attempt();
  report.worker = request.worker();
  switch (request.result_case()) {
    case v1::CompleteRequest::kSolve:
      CheckSolve(request.solve(), report);
      break;
    case v1::CompleteRequest::kRender:
      CheckRender(request.render(), report);
      break;
    case v1::CompleteRequest::RESULT_NOT_SET:
      report.invalid = "a report without a result";
  }
  return report;
}

}  // namespace parallax
