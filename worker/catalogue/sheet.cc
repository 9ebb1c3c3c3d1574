#include "worker/catalogue/sheet.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "worker/catalogue/sheet_scene.h"
#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr int kRowsAPage = 12;
constexpr int kCaption = 22;
constexpr Rgb kPaper = {246, 246, 244}, kInk = {30, 32, 36};
// The reduced sheets: small enough for a README.
constexpr int kSmallCell = 88, kSmallCaption = 13, kSmallColumns = 4, kSmallQuality = 80;

struct Strip {
  std::string name, family;
  std::vector<ImageRgb8> cells;
};

std::string CellText(const Strip& strip) { return strip.name + "  (" + strip.family + ")"; }

// Writes the page that the last of `strips` stands on.
absl::Status WriteLastPage(const std::string& stem, const std::vector<Strip>& strips, int cell_px,
                           std::vector<std::string>& files) {
  const size_t first = (strips.size() - 1) / kRowsAPage * kRowsAPage;
  const size_t rows = strips.size() - first;
  Canvas page(kRowCells * cell_px, static_cast<int>(rows) * (cell_px + kCaption));
  page.FillBox(0, 0, page.image().width(), page.image().height(), kPaper);
  for (size_t r = 0; r < rows; ++r) {
    const Strip& strip = strips[first + r];
    const int y = static_cast<int>(r) * (cell_px + kCaption);
    page.DrawText(6, y + 16, CellText(strip), 10, kInk);
    for (size_t c = 0; c < strip.cells.size(); ++c) {
      page.DrawImage(static_cast<int>(c) * cell_px, y + kCaption, cell_px, cell_px, strip.cells[c]);
    }
  }
  files.push_back(fmt::format("{}-{:02}.png", stem, first / kRowsAPage + 1));
  return WritePng(files.back(), page.image());
}

// Every class with the cells in `shown`.
absl::Status WriteReduced(const std::string& path, const std::vector<Strip>& strips,
                          const std::vector<size_t>& shown, std::vector<std::string>& files) {
  if (strips.empty()) return absl::OkStatus();
  const int count = static_cast<int>(strips.size());
  const int columns = std::min(kSmallColumns, count);
  const int width = static_cast<int>(shown.size()) * kSmallCell + 4;
  const int rows = (count + columns - 1) / columns;
  Canvas page(columns * width, rows * (kSmallCell + kSmallCaption));
  page.FillBox(0, 0, page.image().width(), page.image().height(), kPaper);
  for (int i = 0; i < count; ++i) {
    const Strip& strip = strips[static_cast<size_t>(i)];
    const int x = i % columns * width, y = i / columns * (kSmallCell + kSmallCaption);
    page.DrawText(x + 2, y + 10, strip.name, 6.5, kInk);
    for (size_t c = 0; c < shown.size(); ++c) {
      page.DrawImage(x + static_cast<int>(c) * kSmallCell, y + kSmallCaption, kSmallCell,
                     kSmallCell, strip.cells[shown[c]]);
    }
  }
  files.push_back(path);
  return WriteJpeg(path, page.image(), kSmallQuality);
}

bool Wanted(const SheetOptions& options, const std::string& name, const std::string& family) {
  if (options.only.empty()) return true;
  return std::any_of(options.only.begin(), options.only.end(),
                     [&](const std::string& wanted) { return wanted == name || wanted == family; });
}

absl::Status CheckNames(const SheetOptions& options) {
  for (const std::string& name : options.only) {
    const bool family = std::any_of(AssetCatalogue().begin(), AssetCatalogue().end(),
                                    [&](const AssetClass& c) { return c.family == name; }) ||
                        std::any_of(MaterialCatalogue().begin(), MaterialCatalogue().end(),
                                    [&](const MaterialClass& c) { return c.family == name; });
    if (!family && FindAssetClass(name) == nullptr && FindMaterialClass(name) == nullptr) {
      return NotFound("no class, material or family is called '{}'", name);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SheetResult> WriteCatalogueSheets(
    const SheetOptions& options, const CancelToken& cancel,
    const std::function<void(double, const std::string&)>& progress) {
  RETURN_IF_ERROR(CheckNames(options));
  std::error_code error;
  std::filesystem::create_directories(options.dir, error);
  std::vector<const AssetClass*> classes;
  for (const AssetClass& c : AssetCatalogue()) {
    if (Wanted(options, c.name, c.family)) classes.push_back(&c);
  }
  std::vector<const MaterialClass*> materials;
  for (const MaterialClass& c : MaterialCatalogue()) {
    if (Wanted(options, c.name, c.family)) materials.push_back(&c);
  }
  const auto total = static_cast<double>(classes.size() + materials.size());
  const std::string dir = options.dir + "/";
  double done = 0;
  SheetResult result;
  // A page is written as soon as it is full: what a cancelled run drew is there to be looked at.
  const auto add = [&](const std::string& stem, bool last, std::vector<Strip>& strips,
                       const std::string& name, const std::string& family,
                       absl::StatusOr<SheetRow> row) -> absl::Status {
    if (progress) progress(done / total, name);
    if (!row.ok()) return WithContext(row.status(), name);
    ASSIGN_OR_RETURN(auto cells,
                     RenderRow(*std::move(row), options.cell_px, options.samples, cancel));
    strips.push_back({name, family, std::move(cells)});
    ++done;
    if (!last && strips.size() % kRowsAPage != 0) return absl::OkStatus();
    return WriteLastPage(dir + stem, strips, options.cell_px, result.files);
  };
  std::vector<Strip> asset_strips, material_strips;
  for (const AssetClass* c : classes) {
    RETURN_IF_ERROR(add("assets", c == classes.back(), asset_strips, c->name, c->family,
                        MakeAssetRow(*c, options.first_seed, options.cell_px)));
  }
  for (const MaterialClass* c : materials) {
    RETURN_IF_ERROR(add("materials", c == materials.back(), material_strips, c->name, c->family,
                        MakeMaterialRow(*c, options.first_seed, options.cell_px)));
  }
  RETURN_IF_ERROR(WriteReduced(dir + "assets.jpg", asset_strips, {0, 1, 2}, result.files));
  // Ball, board and chair of the first seed.
  RETURN_IF_ERROR(WriteReduced(dir + "materials.jpg", material_strips, {0, 2, 4}, result.files));
  result.classes = static_cast<int>(asset_strips.size());
  result.materials = static_cast<int>(material_strips.size());
  if (progress) progress(1, "");
  return result;
}

}  // namespace parallax
