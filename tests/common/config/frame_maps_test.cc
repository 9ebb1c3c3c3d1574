// The table of maps is one: what CMake made of frame_maps.csv for C++ and for the page says what
// the file says, and the lists of files follow from it.
#include "common/config/frame_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "common/base/system/file.h"
#include "common/config/frame_files.h"

namespace parallax {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

TEST(FrameMaps, AreThoseOfTheFileInEveryLanguage) {
  std::ifstream table(PARALLAX_FRAME_MAPS);
  std::string line;
  ASSERT_TRUE(std::getline(table, line));
  const std::vector<std::string> columns = Split(line);
  const std::string js = *ReadFile(PARALLAX_FRAME_MAPS_JS);
  static constexpr const char* kEncodings[] = {"rgb8",    "grey8",     "index16",
                                               "float_y", "float_rgb", "half_rgb"};
  size_t rows = 0;
  for (; std::getline(table, line); ++rows) {
    const std::vector<std::string> cells = Split(line);
    ASSERT_EQ(cells.size(), columns.size()) << line;
    ASSERT_LT(rows, FrameMaps().size());
    const FrameMap& row = FrameMaps()[rows];
    const std::vector<std::string> seen = {
        std::string(row.map),   row.per == FrameMap::kEye ? "eye" : "direction",
        std::string(row.file),  kEncodings[row.encoding],
        std::string(row.unit),  std::string(row.no_value),
        std::string(row.needs), std::string(row.pass)};
    EXPECT_EQ(seen, std::vector<std::string>(cells.begin(), cells.begin() + 8)) << line;
    EXPECT_DOUBLE_EQ(row.bytes, std::stod(cells[8]));
    EXPECT_EQ(row.sparse, !cells[9].empty()) << line;
    EXPECT_EQ(row.view, cells[10]);
    EXPECT_EQ(row.sheet, cells[11]);
    EXPECT_EQ(row.sample, !cells[12].empty()) << line;
    std::string text = "  {";
    for (size_t i = 0; i < cells.size(); ++i) text += " " + columns[i] + ": \"" + cells[i] + "\",";
    EXPECT_THAT(js, HasSubstr(text + " },"));
  }
  EXPECT_EQ(rows, FrameMaps().size());
}

TEST(FrameMaps, AreThoseThatConfigsMayName) {
  const auto& rule =
      v1::RenderConfig::descriptor()->FindFieldByName("maps")->options().GetExtension(v1::rule);
  EXPECT_EQ(std::vector<std::string>(rule.allowed().begin(), rule.allowed().end()),
            FrameMapNames());
}

TEST(FrameMaps, HaveStemsAndFilesOfTheirOwn) {
  std::set<std::string> stems, files;
  for (const FrameMap& row : FrameMaps()) {
    if (!row.map.empty()) {
      EXPECT_TRUE(stems.emplace(row.stem()).second) << row.file;
    }
    for (const std::string& file : row.Files()) EXPECT_TRUE(files.insert(file).second) << file;
    EXPECT_EQ(row.IsExr(), row.file.ends_with(".exr")) << row.file;
  }
  EXPECT_EQ(MapFile("depth", "left"), "depth_left.exr");
  EXPECT_THAT(FrameMapOf("flow_occlusion").Files(),
              ElementsAre("flow_occlusion_forward_left.png", "flow_occlusion_forward_right.png",
                          "flow_occlusion_backward_left.png", "flow_occlusion_backward_right.png"));
}

TEST(FrameMaps, NeedOnlyWhatThereIs) {
  for (const FrameMap& row : FrameMaps()) {
    std::istringstream needs{std::string(row.needs)};
    for (std::string need; needs >> need;) {
      if (need == "lens" || need == "sequence") continue;
      EXPECT_THAT(FrameMapNames(), ::testing::Contains(need)) << row.file;
    }
  }
}

TEST(FrameFiles, AreThoseOfTheMapsAskedFor) {
  v1::RenderConfig render;
  render.add_maps("disparity");
  const std::vector<std::string> names = {"disparity_left.exr", "disparity_right.exr", "frame.json",
                                          "left.png", "right.png"};
  EXPECT_EQ(FrameFileNames(render), names);
  EXPECT_TRUE(AreFrameFiles(names, render));
  std::vector<std::string> fewer(names.begin() + 1, names.end());
  EXPECT_FALSE(AreFrameFiles(fewer, render));
  std::vector<std::string> more = names;
  more.emplace_back("stray.png");
  EXPECT_FALSE(AreFrameFiles(more, render));
}

}  // namespace
}  // namespace parallax
