// `parallax run` of a small study in a folder of its own, for the tests of runs.
#pragma once

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/e2e/process.h"
#include "tests/folder_test.h"

namespace parallax::e2e {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Small, but with all parts: furniture, floating objects, materials, lights, every map.
inline constexpr char kStudy[] =
    "study: tiny\n"
    "seed: 5\n"
    "pairs: 2\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: narrow\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 64, height_px: 48, baseline_m: {uniform: [0.04, 0.1]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "  - name: wide\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 64, height_px: 48, baseline_m: {uniform: [0.2, 0.3]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n";

inline constexpr const char* kTruth[] = {
    "depth_left.exr",     "depth_right.exr",     "disparity_left.exr", "disparity_right.exr",
    "occlusion_left.png", "occlusion_right.png", "objects_left.png",   "objects_right.png",
    "materials_left.png", "materials_right.png", "normals_left.exr",   "normals_right.exr",
    "masks_left.png",     "masks_right.png"};

class RunTest : public FolderTest {
 protected:
  void SetUp() override {
    study_ = dir_ + "/tiny.yaml";
    std::ofstream(study_) << kStudy;
  }
  void TearDown() override {
    if (HasFailure()) {
      for (const auto& entry : fs::recursive_directory_iterator(dir_)) {
        if (entry.path().extension() != ".log") continue;
        std::cerr << "---- " << entry.path() << "\n" << ReadText(entry.path());
      }
    }
  }

  std::vector<std::string> Command(const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> command = {PARALLAX_BINARY, "run", study_, "--out", out, "--json"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  std::unique_ptr<Process> Start(const std::string& out, std::vector<std::string> more = {}) {
    return std::make_unique<Process>(Command(out, std::move(more)));
  }
  // Runs to the end, which must be a success; its report.
  Json Run(const std::string& out, std::vector<std::string> more = {}) {
    const auto process = Start(out, std::move(more));
    EXPECT_EQ(process->Wait(), 0) << process->Err();
    return Json::parse(process->Out(), nullptr, false);
  }

  static std::vector<Json> Index(const std::string& out, const std::string& variant) {
    std::vector<Json> lines;
    std::istringstream text(ReadText(out + "/" + variant + "/index.jsonl"));
    for (std::string line; std::getline(text, line);) lines.push_back(Json::parse(line));
    return lines;
  }

  // Every frame wanted is in the index once, complete on disk.
  static void ExpectComplete(const std::string& out, size_t pairs) {
    for (const char* variant : {"narrow", "wide"}) {
      const std::vector<Json> index = Index(out, variant);
      EXPECT_EQ(index.size(), pairs) << variant;
      std::set<std::pair<int, int>> seen;
      for (const Json& line : index) {
        const auto key = std::make_pair(line["scene"].get<int>(), line["rig"].get<int>());
        EXPECT_TRUE(seen.insert(key).second) << line;
        char folder[32];
        std::snprintf(folder, sizeof folder, "/%06d/%03d/", key.first, key.second);
        const std::string frame = out + "/" + variant + "/frames" + folder;
        for (const char* name : kTruth) EXPECT_TRUE(fs::exists(frame + name)) << frame << name;
        for (const char* name : {"left.png", "right.png", "frame.json"}) {
          EXPECT_TRUE(fs::exists(frame + name)) << frame << name;
        }
      }
      size_t folders = 0;
      for (const auto& entry : fs::recursive_directory_iterator(out + "/" + variant + "/frames")) {
        folders += entry.path().filename() == "frame.json";
      }
      EXPECT_EQ(folders, pairs) << variant;
    }
  }

  // An attempt to render has begun, and is not published yet.
  static bool Rendering(const std::string& out) {
    std::error_code error;
    const fs::recursive_directory_iterator end;
    for (fs::recursive_directory_iterator it(out + "/.parallax/store", error); !error && it != end;
         it.increment(error)) {
      if (it->path().filename().string().rfind(".attempt-", 0) == 0) return true;
    }
    return false;
  }

  // Content of the files that must be the same, by path.
  static std::map<std::string, std::string> Content(const std::string& out) {
    std::map<std::string, std::string> content;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      const std::string path = fs::relative(entry.path(), out);
      if (!entry.is_regular_file() || path.rfind(".parallax", 0) == 0) continue;
      const std::string name = entry.path().filename();
      const bool truth = std::find(std::begin(kTruth), std::end(kTruth), name) != std::end(kTruth);
      if (truth || entry.path().extension() == ".pb") content[path] = ReadText(entry.path());
    }
    return content;
  }

  std::string study_;
};

}  // namespace parallax::e2e
