#include "coordinator/client/views/scene_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"

namespace parallax::client {
namespace {

std::string RoleName(v1::ObjectRole role) {
  return LowerName(v1::ObjectRole_Name(role), "OBJECT_ROLE_");
}

bool IsDrawn(const v1::SceneObject& object) {
  return object.role() == v1::OBJECT_ROLE_FURNITURE || object.role() == v1::OBJECT_ROLE_FLOATING;
}

void Heading(const Terminal& terminal, const std::string& title) {
  *terminal.stream << "\n" << terminal.Paint(Tone::kBold, title) << "\n";
}

void PrintSummary(const Terminal& terminal, const v1::Scene& scene,
                  const SceneDescription& description) {
  std::ostream& out = *terminal.stream;
  out << terminal.Paint(Tone::kBold, fmt::format("scene {:016x}", scene.scene_seed())) << "  "
      << LowerName(v1::SceneType_Name(scene.type()), "SCENE_TYPE_") << "  generator version "
      << scene.generator_version() << "\n";
  for (const std::string& line : description.lines) out << line << "\n";
}

void PrintPlan(const Terminal& terminal, const v1::Scene& scene, const GroundPlan& plan,
               const std::map<uint32_t, Extent>& extents, const std::map<uint32_t, char>& symbols) {
  std::vector<Footprint> footprints;
  for (const v1::SceneObject& object : scene.objects()) {
    const auto extent = extents.find(object.index());
    if (!IsDrawn(object) || extent == extents.end()) continue;
    const Extent& e = extent->second;
    const Vec3d middle((e.x0 + e.x1) / 2, (e.y0 + e.y1) / 2, (e.z0 + e.z1) / 2);
    if (!plan.extent.contains(middle)) continue;
    footprints.push_back({e.x0, e.y0, e.x1, e.y1, e.z1, symbols.at(object.index())});
  }
  GroundPlanOptions options;
  options.columns = std::clamp(terminal.size().columns - 8, 24, 72);
  options.unicode = terminal.unicode;
  Heading(
      terminal,
      "Plan (north up; capitals furniture, small letters floating, D door, = window, arrows rigs)");
  for (const std::string& line : DrawGroundPlan(plan, scene, footprints, options)) {
    *terminal.stream << "  " << line << "\n";
  }
}

std::string MaterialNames(const v1::Scene& scene, const v1::SceneObject& object) {
  std::vector<std::string> names;
  for (const v1::MaterialBinding& binding : object.materials()) {
    for (const v1::SceneMaterial& material : scene.materials()) {
      if (material.index() != binding.material_index()) continue;
      if (std::find(names.begin(), names.end(), material.name()) == names.end()) {
        names.push_back(material.name());
      }
    }
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void PrintObjects(const Terminal& terminal, const v1::Scene& scene,
                  const std::map<uint32_t, Extent>& extents,
                  const std::map<uint32_t, char>& symbols) {
  Heading(terminal, fmt::format("Objects ({})", scene.objects_size()));
  Table table({Right("#"), "PLAN", "NAME", "ROLE", "RELATION", Right("CENTRE m"), Right("SIZE m"),
               "MATERIALS"});
  for (const v1::SceneObject& object : scene.objects()) {
    const auto symbol = symbols.find(object.index());
    std::string centre, size;
    if (const auto found = extents.find(object.index()); found != extents.end()) {
      const Extent& e = found->second;
      centre = fmt::format("{:.2f} {:.2f} {:.2f}", (e.x0 + e.x1) / 2, (e.y0 + e.y1) / 2,
                           (e.z0 + e.z1) / 2);
      size = fmt::format("{:.2f} {:.2f} {:.2f}", e.x1 - e.x0, e.y1 - e.y0, e.z1 - e.z0);
    }
    table.AddRow({std::to_string(object.index()),
                  symbol == symbols.end() ? "" : std::string(1, symbol->second), object.name(),
                  RoleName(object.role()), object.relation(), centre, size,
                  MaterialNames(scene, object)});
  }
  table.Print(terminal, 2);
}

void PrintLights(const Terminal& terminal, const v1::Scene& scene) {
  Heading(terminal, "Light");
  std::ostream& out = *terminal.stream;
  out << "  sky x " << FormatNumber(scene.sky().strength());
  if (scene.sky().sun_strength() > 0) {
    out << ", sun x " << FormatNumber(scene.sky().sun_strength()) << " at "
        << fmt::format("{:.0f} degrees", scene.sky().sun_elevation_rad() * 180 / M_PI);
  }
  out << "\n";
  for (const v1::Light& light : scene.lights()) {
    // The power as configs give it: each channel of a white lamp has the lamp's power.
    const double power = (light.power_w().x() + light.power_w().y() + light.power_w().z()) / 3;
    out << "  " << light.name() << ": " << LowerName(v1::Light::Kind_Name(light.kind()), "KIND_")
        << ", " << FormatNumber(power) << " W";
    if (light.kind() == v1::Light::KIND_POINT || light.kind() == v1::Light::KIND_SPOT) {
      out << fmt::format(" at {:.2f} {:.2f} {:.2f}", light.position_m().x(), light.position_m().y(),
                         light.position_m().z());
    }
    out << "\n";
  }
}

void PrintRigs(const Terminal& terminal, const v1::Scene& scene) {
  if (scene.rigs_size() == 0) return;
  Heading(terminal, fmt::format("Rigs ({})", scene.rigs_size()));
  Table table({Right("RIG"), Right("LEFT EYE m"), Right("BASELINE m"), Right("FOCAL px"),
               Right("IMAGE px"), Right("DEPTH STD m")});
  for (const v1::Rig& rig : scene.rigs()) {
    const v1::Transform& pose = rig.world_from_left();
    table.AddRow({std::to_string(rig.index()),
                  fmt::format("{:.2f} {:.2f} {:.2f}", pose.tx(), pose.ty(), pose.tz()),
                  fmt::format("{:.3f}", rig.baseline_m()), fmt::format("{:.1f}", rig.fx_px()),
                  fmt::format("{}x{}", rig.width_px(), rig.height_px()),
                  fmt::format("{:.2f}", rig.depth_std_m())});
  }
  table.Print(terminal, 2);
}

void PrintSolver(const Terminal& terminal, const v1::SolveReport& report) {
  if (report.steps() == 0) return;
  Heading(terminal, report.room().empty() ? "Solver" : "Solver: " + report.room());
  std::ostream& out = *terminal.stream;
  out << "  " << FormatCount(report.steps()) << " steps, " << FormatCount(report.accepted())
      << " accepted, loss " << FormatNumber(report.initial_loss()) << " -> "
      << FormatNumber(report.final_loss());
  if (report.terms_total() > 0) {
    out << ", " << 100 * report.terms_evaluated() / report.terms_total()
        << " % of its terms worked out anew";
  }
  out << "\n";
  const std::vector<double> curve(report.loss_curve().begin(), report.loss_curve().end());
  if (!curve.empty()) {
    out << "  "
        << terminal.Paint(
               Tone::kAccent,
               Sparkline(curve, std::clamp(terminal.size().columns - 4, 20, 100), terminal.unicode))
        << "\n";
  }
  if (report.constraints_size() == 0) return;
  Table table({"CONSTRAINT", "KIND", Right("VIOLATION")});
  for (const v1::SolveReport::Constraint& constraint : report.constraints()) {
    const bool broken = constraint.violation() > 1e-9;
    table.AddRow({constraint.name(), constraint.hard() ? "hard" : "soft",
                  terminal.Paint(!broken             ? Tone::kGood
                                 : constraint.hard() ? Tone::kBad
                                                     : Tone::kWarning,
                                 broken ? FormatNumber(constraint.violation()) : "ok")});
  }
  table.Print(terminal, 2);
}

}  // namespace

void PrintScene(const Terminal& terminal, const v1::Scene& scene,
                const SceneDescription& description, const std::map<uint32_t, Extent>& extents) {
  std::map<uint32_t, char> symbols;
  size_t drawn[2] = {0, 0};  // Furniture, floating.
  for (const v1::SceneObject& object : scene.objects()) {
    if (!IsDrawn(object)) continue;
    const bool floating = object.role() == v1::OBJECT_ROLE_FLOATING;
    symbols.emplace(object.index(), PlanSymbol(floating, drawn[floating]++));
  }
  PrintSummary(terminal, scene, description);
  if (description.plan) PrintPlan(terminal, scene, *description.plan, extents, symbols);
  PrintObjects(terminal, scene, extents, symbols);
  PrintLights(terminal, scene);
  PrintRigs(terminal, scene);
  PrintSolver(terminal, scene.report());
  for (const v1::SolveReport& report : scene.room_reports()) PrintSolver(terminal, report);
}

}  // namespace parallax::client
