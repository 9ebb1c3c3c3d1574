// config: check and show study and scene files without making anything.
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "common/base/shell_word.h"
#include "common/base/status.h"
#include "common/config/camera_text.h"
#include "common/config/config.h"
#include "common/config/search/search_values.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/content/own_folders.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/study/expansion.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

struct ConfigOptions {
  std::string file;
  MachineOptions machine;
};

struct CameraOptions {
  std::string source, part;
  std::optional<double> unit_m;
  std::optional<int> width, height;
};

// One of the two kinds of file there are.
struct Config {
  bool is_study = false;
  v1::StudySpec study;
  v1::SceneConfig scene;
};

absl::StatusOr<Config> Load(const std::string& path) {
  Config config;
  ASSIGN_OR_RETURN(config.is_study, IsStudy(path));
  if (config.is_study) {
    ASSIGN_OR_RETURN(config.study, LoadStudy(path));
  } else {
    ASSIGN_OR_RETURN(config.scene, LoadSceneConfig(path));
  }
  return config;
}

absl::StatusOr<ExitCode> Check(const ConfigOptions& options, Session& session) {
  ASSIGN_OR_RETURN(Config config, Load(options.file));
  std::vector<std::string> missing;
  if (config.is_study) {
    RETURN_IF_ERROR(HashContent(config.study, FolderReaders::kOfFarm));
    missing = WhatIsMissing(config.study, options.file, options.machine);
  }
  const int variants = config.study.variants_size();
  const int64_t pairs = TotalPairsOf(config.study);
  const auto bytes = static_cast<double>(EstimateBytes(config.study));
  if (session.options.json) {
    Json json = {
        {"file", options.file}, {"kind", config.is_study ? "study" : "scene"}, {"ok", true}};
    if (config.is_study) {
      json["name"] = config.study.name();
      json["variants"] = variants;
      json["pairs"] = pairs;
      json["disk_bytes"] = bytes;
      json["missing"] = missing;
    }
    return session.PrintJson(json);
  }
  std::ostream& out = *session.out().stream;
  out << options.file << ": " << session.out().Paint(Tone::kGood, "ok");
  if (config.is_study) {
    out << ", study " << config.study.name() << ": " << DescribeSize(config.study) << " ("
        << config.study.rigs_per_scene() << " a scene), about " << FormatBytes(bytes) << " on disk";
  } else {
    out << ", a scene config";
  }
  out << "\n";
  const std::vector<std::string> cameras =
      config.is_study ? DescribeCameras(config.study)
                      : std::vector{"Camera: " + DescribeCamera(config.scene.rigs())};
  for (const std::string& camera : cameras) out << "  " << camera << "\n";
  if (config.study.has_search()) {
    const v1::SearchSpec search = SearchOf(config.study);
    const int64_t points = PointsOfSpace(search, search.trials());
    const std::string fewer =
        points < search.trials() ? fmt::format(" (its space has {} at most)", points) : "";
    out << fmt::format("  Search: {}, {}{}, {}; `parallax search {}` begins it\n",
                       Plural(search.space_size(), "setting"), Plural(search.trials(), "trial"),
                       fewer, Plural(search.rungs_size(), "rung"), ShellWord(options.file));
  }
  out << std::flush;
  PrintMissing(config.study, missing, session);
  return kExitOk;
}

absl::StatusOr<ExitCode> Show(const ConfigOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const Config config, Load(options.file));
  if (!session.options.json) {
    *session.out().stream << (config.is_study ? StudyToYaml(config.study)
                                              : MessageToYaml(config.scene));
    return kExitOk;
  }
  google::protobuf::util::JsonPrintOptions json;
  json.preserve_proto_field_names = true;
  json.add_whitespace = true;
  const google::protobuf::Message& message =
      config.is_study ? static_cast<const google::protobuf::Message&>(config.study) : config.scene;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, json).ok()) {
    return Internal("{}: can't be written as JSON", options.file);
  }
  *session.out().stream << text;
  return kExitOk;
}

struct ContentCommand {
  ContentKind kind;
  const char* name;
  const char* description;
  const char* field;  // That takes the hash.
};

// "a, b and 3 more"
std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kMostShown = 5;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMostShown); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kMostShown) text += fmt::format(" and {} more", names.size() - kMostShown);
  return text;
}

// Prints a line for each mesh, set, sky or picture, and last the hash.
absl::StatusOr<ExitCode> ShowContent(const ContentCommand& command,
                                     const std::vector<std::string>& dirs, Session& session) {
  ASSIGN_OR_RETURN(const ContentReport report, CheckContent(command.kind, dirs));
  if (session.options.json) {
    const std::string field = command.field;
    Json json = {{field.substr(field.find('.') + 1), report.sha256},
                 {"content", Json::array()},
                 {"left_out", report.left_out}};
    for (const ContentItem& item : report.items) {
      json["content"].push_back(
          {{"name", item.name}, {"text", item.text}, {"left_out", item.left_out}});
    }
    return session.PrintJson(json);
  }
  std::ostream& out = *session.out().stream;
  for (const ContentItem& item : report.items) {
    out << item.name << ": " << item.text;
    for (size_t i = 0; i < item.left_out.size(); ++i) {
      out << (i == 0 ? "; left out: " : ", ") << item.left_out[i];
    }
    out << "\n";
  }
  if (!report.left_out.empty()) out << "left out: " << Listed(report.left_out) << "\n";
  out << report.sha256 << "\n";
  return kExitOk;
}

// Removes from each line of `message` its "SOURCE:3: rigs.camera.": the text that was read is none
// that the user wrote.
std::string OfCamera(const std::string& message, const std::string& source) {
  std::string text;
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(source + ":")) {
      const size_t end = line.find_first_not_of("0123456789", source.size() + 1);
      if (line.compare(std::min(end, line.size()), 2, ": ") == 0) line.erase(0, end + 2);
    }
    if (line.starts_with("rigs.camera.")) line.erase(0, std::strlen("rigs.camera."));
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

// Prints the `rigs` that a preset or a calibration file resolves to.
absl::StatusOr<ExitCode> Camera(const CameraOptions& options, Session& session) {
  std::error_code error;
  const bool is_file = std::filesystem::exists(options.source, error);
  v1::CameraConfig given;
  if (is_file) {
    given.set_calibration(std::filesystem::absolute(options.source));
  } else {
    given.set_preset(options.source);
  }
  if (!options.part.empty()) given.set_calibration_part(options.part);
  if (options.unit_m) given.set_calibration_unit_m(*options.unit_m);
  v1::SceneConfig wanted;
  *wanted.mutable_rigs()->mutable_camera() = given;
  if (options.width && options.height) {
    wanted.mutable_rigs()->set_width_px(*options.width);
    wanted.mutable_rigs()->set_height_px(*options.height);
  }
  const absl::StatusOr<v1::SceneConfig> parsed =
      ParseSceneConfig(MessageToYaml(wanted), options.source);
  if (!parsed.ok()) {
    std::string why = OfCamera(std::string(ToStd(parsed.status().message())), options.source);
    if (!is_file && why.starts_with("preset: ")) why.erase(0, std::strlen("preset: "));
    return MakeError(parsed.status().code(),
                     is_file ? why : options.source + ": no such file; as a preset: " + why);
  }
  const v1::SceneConfig& read = *parsed;
  v1::SceneConfig shown;
  v1::RigConfig& rigs = *shown.mutable_rigs();
  *rigs.mutable_baseline_m() = read.rigs().baseline_m();
  rigs.set_width_px(read.rigs().width_px());
  rigs.set_height_px(read.rigs().height_px());
  *rigs.mutable_camera() = read.rigs().camera();
  *session.out().stream << MessageToYaml(shown);
  return kExitOk;
}

void AddContentCommand(Registry& registry, CLI::App& parent, const ContentCommand& command) {
  CLI::App* app = registry.AddCommand(
      parent, command.name, command.description,
      std::string("Prints a line for each item, or the first mistake. The last line is the hash\n"
                  "of the content: write it as ") +
          command.field +
          " in\nstudies that are submitted where the folder can't be seen; otherwise `run` and "
          "`submit`\nfind it themselves.\n");
  auto dirs = std::make_shared<std::vector<std::string>>();
  CLI::Option* option = app->add_option("DIR", *dirs, "The folder")->required();
  if (command.kind != ContentKind::kMeshes) option->expected(1);
  AddFollowLinksOption(*app);
  registry.AddJsonOption(app);
  registry.SetAction(
      app, [command, dirs](Session& session) { return ShowContent(command, *dirs, session); });
}

absl::StatusOr<ExitCode> ListConfigs(Session& session) {
  if (session.options.json) {
    return session.PrintJson({{"studies", BuiltinStudies()}, {"scenes", BuiltinSceneConfigs()}});
  }
  const auto print = [&](const char* title, const std::vector<std::string>& names) {
    *session.out().stream << session.out().Paint(Tone::kBold, title) << "\n";
    for (const std::string& name : names) *session.out().stream << "  " << name << "\n";
  };
  print("Studies", BuiltinStudies());
  print("Scenes", BuiltinSceneConfigs());
  return kExitOk;
}

CLI::App* AddFileCommand(Registry& registry, CLI::App& parent, const char* name,
                         const char* description, const char* example,
                         const std::shared_ptr<ConfigOptions>& options) {
  CLI::App* command = registry.AddCommand(parent, name, description, example);
  command->add_option("FILE", options->file, "Study or scene file, or the name of a built-in one")
      ->required();
  registry.AddJsonOption(command);
  return command;
}

}  // namespace

void RegisterConfig(Registry& registry) {
  CLI::App* config =
      registry.AddCommand(registry.app, "config", "Check and show study and scene files");
  config->require_subcommand(1);
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* check = AddFileCommand(
      registry, *config, "check", "Check a file: print its mistakes by line, or \"ok\"",
      "Examples:\n  parallax config check my.yaml\n  parallax config check quickstart\n", options);
  AddMachineOptions(*check, options->machine);
  AddFollowLinksOption(*check);
  registry.SetAction(check, [options](Session& session) { return Check(*options, session); });
  CLI::App* show =
      AddFileCommand(registry, *config, "show",
                     "Show a file with its base merged in and every default written out",
                     "The output is itself a file that can be run.\n\n"
                     "Example:\n  parallax config show baseline > baseline-full.yaml\n",
                     options);
  registry.SetAction(show, [options](Session& session) { return Show(*options, session); });
  const ContentCommand contents[] = {
      {ContentKind::kPictures, "pictures", "Check a folder of pictures; its content hash",
       "materials.pictures_sha256"},
      {ContentKind::kMeshes, "meshes", "Check folders of your own meshes; their content hash",
       "assets.include_sha256"},
      {ContentKind::kTextures, "textures", "Check a folder of texture sets; its content hash",
       "materials.textures_sha256"},
      {ContentKind::kHdris, "hdris",
       "Check a folder of .hdr and .exr surroundings; its content hash", "lighting.hdris_sha256"}};
  for (const ContentCommand& content : contents) AddContentCommand(registry, *config, content);
  RegisterOwnFiles(registry, *config);
  auto camera_options = std::make_shared<CameraOptions>();
  CLI::App* camera = registry.AddCommand(
      *config, "camera", "Show a calibration file or a preset as `rigs` of a study",
      "Examples:\n  parallax config camera SN8452341.conf --part 2K\n"
      "  parallax config camera kitti\n");
  camera->add_option("SOURCE", camera_options->source, "A calibration file, or a preset")
      ->required();
  camera->add_option("--part", camera_options->part,
                     "ZED: HD (default), 2K, FHD, VGA, FHD1200, SVGA; KITTI: 02 (default) or 00");
  camera->add_option("--unit-m", camera_options->unit_m,
                     "Length of the file's unit in metres (default: its format's)");
  CLI::Option* width =
      camera->add_option("--width", camera_options->width,
                         "Width of the pictures in pixels, if the file does not have it");
  CLI::Option* height =
      camera->add_option("--height", camera_options->height,
                         "Height of the pictures in pixels, if the file does not have it");
  width->needs(height);
  height->needs(width);
  registry.SetAction(
      camera, [camera_options](Session& session) { return Camera(*camera_options, session); });
  CLI::App* list =
      registry.AddCommand(*config, "list", "List the names of the built-in studies and scenes");
  registry.AddJsonOption(list);
  registry.SetAction(list, ListConfigs);
}

}  // namespace parallax::client
