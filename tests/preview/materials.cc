// materials: each material in two seeds on a ball of 24 cm, a board of 40 cm and a chair, and close
// by on 6 cm of the board.
#include "common/image/io.h"
#include "tests/preview/preview.h"
#include "worker/catalogue/sheet_scene.h"
#include "worker/dataset/sheets/drawing.h"

namespace parallax::preview {
namespace {

constexpr int kCaption = 16, kCells = 8;
constexpr double kClose = 8;  // Times the focal length of the board's picture.

struct Options {
  std::string out;
  std::vector<std::string> names;
  uint64_t first_seed = 1;
  int cell_px = 168, columns = 2, samples = 12;
};

absl::Status Run(const Options& options) {
  std::vector<const MaterialClass*> chosen;
  for (const MaterialClass& c : MaterialCatalogue()) {
    bool wanted = options.names.empty();
    for (const std::string& name : options.names) {
      wanted = wanted || c.name.find(name) != std::string::npos || c.family == name;
    }
    if (wanted) chosen.push_back(&c);
  }
  if (chosen.empty()) return NotFound("no material or family is called '{}'", options.names[0]);
  const int count = static_cast<int>(chosen.size()), cell = options.cell_px;
  const int columns = std::min(options.columns, count), rows = (count + columns - 1) / columns;
  Canvas sheet(columns * kCells * cell, rows * (cell + kCaption));
  for (int i = 0; i < count; ++i) {
    const MaterialClass& material = *chosen[static_cast<size_t>(i)];
    const int left = i % columns * kCells * cell, top = i / columns * (cell + kCaption);
    ASSIGN_OR_RETURN(SheetRow row, MakeMaterialRow(material, options.first_seed, cell));
    v1::Rig close = row.rigs[1];
    close.set_fx_px(kClose * close.fx_px());
    close.set_fy_px(kClose * close.fy_px());
    row.rigs.push_back(close);
    ASSIGN_OR_RETURN(const std::vector<ImageRgb8> cells,
                     RenderRow(std::move(row), cell, options.samples, {}));
    sheet.DrawText(left + 4, top + 12, material.name + " / " + material.family, 8);
    for (int c = 0; c < kCells; ++c) {
      sheet.DrawImage(left + c * cell, top + kCaption, cell, cell, cells[static_cast<size_t>(c)]);
    }
  }
  return WritePng(options.out, sheet.image());
}

}  // namespace

Action Materials(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command.add_option("OUT", options->out, "PNG to write")->required();
  command.add_option("NAME", options->names, "Parts of names, or families; default: all");
  command.add_option("--seed", options->first_seed, "The first of two");
  command.add_option("--cell", options->cell_px, "Pixels");
  command.add_option("--columns", options->columns, "Materials beside each other");
  command.add_option("--spp", options->samples);
  return [options] { return Run(*options); };
}

}  // namespace parallax::preview
