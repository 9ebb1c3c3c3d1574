// catalogue: every class of object and every material, with what they cost, or as pictures.
#include "coordinator/client/commands/catalogue_command.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/edit_distance.h"
#include "common/base/status.h"
#include "coordinator/client/cancellable.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"
#include "worker/catalogue/figures.h"
#include "worker/catalogue/sheet.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

struct CatalogueOptions {
  int seeds = 8;
  bool markdown = false;
  SheetOptions sheet;
};

struct Figures {
  std::vector<AssetFigures> classes;
  std::vector<MaterialFigures> materials;
};

bool Matches(const CatalogueOptions& options, const std::string& name, const std::string& family) {
  const std::vector<std::string>& only = options.sheet.only;
  return only.empty() || std::any_of(only.begin(), only.end(), [&](const std::string& wanted) {
           return wanted == name || wanted == family;
         });
}

// All names and families of classes and materials.
std::set<std::string> KnownNames() {
  std::set<std::string> names;
  for (const AssetClass& c : AssetCatalogue()) names.insert({c.name, c.family});
  for (const MaterialClass& c : MaterialCatalogue()) names.insert({c.name, c.family});
  return names;
}

// Writes the options' names as the catalogue does; studies may write them in any case, too. Errors:
// kNotFound for the first unknown one.
absl::Status ResolveNames(std::vector<std::string>& names) {
  const std::set<std::string> known = KnownNames();
  std::vector<std::string> resolved;
  for (const std::string& name : names) {
    const size_t before = resolved.size();
    if (known.count(name) > 0) {
      resolved.push_back(name);
      continue;
    }
    // A class and a family may differ in case only: both are meant.
    std::copy_if(known.begin(), known.end(), std::back_inserter(resolved),
                 [&](const std::string& other) { return LowerName(other) == LowerName(name); });
    if (resolved.size() > before) continue;
    return NotFound("no class, material or family is called '{}'{}", name,
                    NearestHint(name, {known.begin(), known.end()}));
  }
  names = std::move(resolved);
  return absl::OkStatus();
}

Figures Measure(const CatalogueOptions& options) {
  Figures figures;
  for (const AssetClass& c : AssetCatalogue()) {
    if (Matches(options, c.name, c.family)) {
      figures.classes.push_back(MeasureAssetClass(c, options.seeds));
    }
  }
  for (const MaterialClass& c : MaterialCatalogue()) {
    if (Matches(options, c.name, c.family)) figures.materials.push_back(MeasureMaterialClass(c));
  }
  return figures;
}

Json SizeJson(const Vec3f& size) {
  Json json = Json::array();
  for (int axis = 0; axis < 3; ++axis) {
    json.push_back(std::round(1000 * static_cast<double>(size[axis])) / 1000);
  }
  return json;
}

Json ClassJson(const AssetFigures& f) {
  const AssetClass& c = *f.asset_class;
  return {{"name", c.name},
          {"family", c.family},
          {"on_by_default", c.on_by_default},
          {"placement", PlacementName(c.placement)},
          {"front_clearance_m", std::round(1000 * static_cast<double>(c.front_clearance_m)) / 1000},
          {"holds_things", f.offers_support},
          {"triangles", f.median_triangles},
          {"triangles_max", f.most_triangles},
          {"ms", std::round(1000 * f.median_ms) / 1000},
          {"ms_max", std::round(1000 * f.ms.back()) / 1000},
          {"size_min_m", SizeJson(f.least_m)},
          {"size_max_m", SizeJson(f.most_m)},
          {"slots", f.slots}};
}

Json MaterialJson(const MaterialFigures& f) {
  const MaterialClass& c = *f.material_class;
  Json tags = Json::array();
  std::string rest = TagNames(c.tags);
  for (size_t end; !rest.empty(); rest = end == std::string::npos ? "" : rest.substr(end + 2)) {
    end = rest.find(", ");
    tags.push_back(rest.substr(0, end));
  }
  return {{"name", c.name},
          {"family", c.family},
          {"tags", tags},
          {"evaluate_ns", std::round(f.evaluate_ns)},
          {"height_ns", std::round(f.height_ns)}};
}

// "0.38-0.66 x 0.38-0.70 x 0.72-1.15"
std::string SizeText(const AssetFigures& f) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    const int digits = f.most_m[axis] < 0.1f ? 3 : 2;
    text += fmt::format("{}{:.{}f}-{:.{}f}", axis > 0 ? " x " : "",
                        static_cast<double>(f.least_m[axis]), digits,
                        static_cast<double>(f.most_m[axis]), digits);
  }
  return text;
}

std::vector<std::string> ClassCells(const AssetFigures& f) {
  const AssetClass& c = *f.asset_class;
  return {c.name + (c.on_by_default ? "" : " (off)"),
          c.family,
          SizeText(f),
          FormatCount(static_cast<int64_t>(f.median_triangles)),
          FormatCount(static_cast<int64_t>(f.most_triangles)),
          fmt::format("{:.2f}", f.median_ms),
          PlacementName(c.placement)};
}

std::vector<std::string> MaterialCells(const MaterialFigures& f) {
  return {f.material_class->name, f.material_class->family, fmt::format("{:.0f}", f.evaluate_ns),
          fmt::format("{:.0f}", f.height_ns), TagNames(f.material_class->tags)};
}

const std::vector<Table::Column>& ClassColumns() {
  static const std::vector<Table::Column>& columns = *new std::vector<Table::Column>{
      "class",     "family", "width x depth x height, m", Right("triangles"), Right("most"),
      Right("ms"), "stands"};
  return columns;
}

const std::vector<Table::Column>& MaterialColumns() {
  static const std::vector<Table::Column>& columns = *new std::vector<Table::Column>{
      "material", "family", Right("colour ns"), Right("relief ns"), "serves"};
  return columns;
}

template <typename Figure, typename Cells>
void Print(const std::vector<Table::Column>& columns, const std::vector<Figure>& figures,
           const Cells& cells, bool markdown, const Terminal& out) {
  if (figures.empty()) return;
  if (!markdown) {
    Table table(columns);
    for (const Figure& figure : figures) table.AddRow(cells(figure));
    table.Print(out);
    *out.stream << "\n";
    return;
  }
  std::string title = "|", rule = "|";
  for (const Table::Column& column : columns) {
    title += " " + column.title + " |";
    rule += column.align == Align::kRight ? "---:|" : "---|";
  }
  *out.stream << title << "\n" << rule << "\n";
  for (const Figure& figure : figures) {
    std::string line = "|";
    for (const std::string& cell : cells(figure)) line += " " + cell + " |";
    *out.stream << line << "\n";
  }
  *out.stream << "\n";
}

absl::StatusOr<ExitCode> List(const CatalogueOptions& options, Session& session) {
  const Figures figures = Measure(options);
  if (session.options.json) {
    return session.PrintJson({{"seeds", options.seeds},
                              {"classes", JsonList(figures.classes, ClassJson)},
                              {"materials", JsonList(figures.materials, MaterialJson)}});
  }
  Print(ClassColumns(), figures.classes, ClassCells, options.markdown, session.out());
  Print(MaterialColumns(), figures.materials, MaterialCells, options.markdown, session.out());
  return kExitOk;
}

// Makes the folder of the sheets, before minutes go into their pictures.
absl::Status OpenSheetFolder(const std::string& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return ErrnoError(error.value(), "can't make the folder " + dir);
  if (access(dir.c_str(), W_OK) != 0) return ErrnoError(errno, "can't write to " + dir);
  return absl::OkStatus();
}

absl::StatusOr<ExitCode> DrawSheets(const CatalogueOptions& options, Session& session) {
  RETURN_IF_ERROR(OpenSheetFolder(options.sheet.dir));
  const CancellableScope interrupt;
  const auto progress = [&](double fraction, const std::string& name) {
    if (!session.err().interactive) return;
    *session.err().stream << "\r\033[K" << fmt::format("{:3.0f} % ", 100 * fraction) << name
                          << (fraction < 1 ? "" : "\r\033[K") << std::flush;
  };
  ASSIGN_OR_RETURN(const SheetResult result,
                   WriteCatalogueSheets(options.sheet, interrupt.token(), progress));
  if (session.options.json) {
    return session.PrintJson({{"files", result.files},
                              {"classes", result.classes},
                              {"materials", result.materials},
                              {"seeds_per_class", 6},
                              {"cell_px", options.sheet.cell_px}});
  }
  for (const std::string& file : result.files) *session.out().stream << file << "\n";
  return kExitOk;
}

}  // namespace

void RegisterCatalogue(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "catalogue", "List or draw every class of object and every material",
      "Sizes are those that a class keeps to; triangles and milliseconds (of one core) are the\n"
      "median over --seeds; a material's cost is nanoseconds a point.\n"
      "\n"
      "Examples:\n"
      "  parallax catalogue\n"
      "  parallax catalogue seating Vase --seeds 20\n"
      "  parallax catalogue --json | jq '.classes[] | {name, triangles, ms}'\n"
      "  parallax catalogue --sheet out/sheets            every class in six seeds, rendered\n"
      "  parallax catalogue --sheet out/chairs Chair --cell 320 --samples 64\n");
  auto options = std::make_shared<CatalogueOptions>();
  command->add_option("NAME", options->sheet.only,
                      "Classes, materials or families (default: everything)");
  AddOption(command, "--sheet", "DIR", options->sheet.dir, "Write contact sheets into this folder");
  command->add_option("--seeds", options->seeds, "Seeds measured of each class (default 8)")
      ->check(CLI::Range(1, 1000));
  command->add_option("--first-seed", options->sheet.first_seed, "First seed drawn (default 1)")
      ->check(WhyNotSeed);
  command->add_option("--cell", options->sheet.cell_px, "Pixels of a drawn cell (default 192)")
      ->check(CLI::Range(32, 1024));
  command->add_option("--samples", options->sheet.samples, "Samples a pixel (default 12)")
      ->check(CLI::Range(1, 4096));
  command->add_flag("--markdown", options->markdown, "Tables as Markdown");
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) -> absl::StatusOr<ExitCode> {
    RETURN_IF_ERROR(ResolveNames(options->sheet.only));
    return options->sheet.dir.empty() ? List(*options, session) : DrawSheets(*options, session);
  });
}

}  // namespace parallax::client
