// export and verify: a dataset in other layouts, and whether one is what it says.
#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/study/expansion.h"
#include "worker/dataset/export/export.h"
#include "worker/dataset/verify/verify.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ExportCommandOptions {
  std::string dir, out;
  ExportOptions options;
};

std::string Percent(double part) { return fmt::format("{:.2f} %", 100 * part); }

absl::StatusOr<ExitCode> Export(const ExportCommandOptions& command, Session& session) {
  if (command.options.flat && command.options.layout != "crestereo") {
    return InvalidArgument("--flat is for the layout crestereo, not for {}",
                           command.options.layout);
  }
  ASSIGN_OR_RETURN(const ExportResult result,
                   ExportDataset(command.dir, command.out, command.options));
  for (const std::string& note : result.notes) session.PrintNote(note);
  if (session.options.json) {
    Json limits = Json::object();
    for (const auto& [limit, part] : result.below_limit) limits[std::to_string(limit)] = part;
    return session.PrintJson(
        {{"out", command.out},
         {"layout", command.options.layout},
         {"filtered", !command.options.unfiltered},
         {"pairs", result.pairs},
         {"pairs_test", result.pairs_test},
         {"pairs_filtered_out", result.pairs_filtered_out},
         {"scenes", result.scenes},
         {"scenes_test", result.scenes_test},
         {"files_linked", result.files_linked},
         {"files_written", result.files_written},
         {"bytes_written", result.bytes_written},
         {"pixels_out_of_range", result.pixels_out_of_range},
         {"disparity_histogram",
          {{"bin_px", result.disparity.bin_width}, {"counts", result.disparity.counts}}},
         {"disparity_fraction_below_px", limits},
         {"notes", result.notes}});
  }
  const Terminal& out = session.out();
  *out.stream << command.out << ": " << Plural(result.pairs, "pair") << " of "
              << Plural(result.scenes, "scene") << " as " << command.options.layout << " ("
              << FormatCount(result.pairs_test) << " for TEST), "
              << FormatCount(result.files_linked) << " files linked, "
              << FormatCount(result.files_written) << " written ("
              << FormatBytes(static_cast<double>(result.bytes_written)) << ")\n";
  if (result.pairs_filtered_out > 0) {
    *out.stream << Plural(result.pairs_filtered_out, "pair")
                << " left out by filters; --unfiltered takes them\n";
  }
  *out.stream << "Disparities, with the limits that training code applies:\n";
  Table table({Right("below"), Right("pixels"), ""});
  for (const auto& [limit, part] : result.below_limit) {
    table.AddRow({fmt::format("{} px", limit), Percent(part),
                  std::string(static_cast<size_t>(part * 40 + 0.5), '#')});
  }
  table.Print(out, 2);
  return kExitOk;
}

struct VerifyCommandOptions {
  std::string dir;
  bool no_hashes = false, no_geometry = false;
};

// The pairs that were asked for, from the study's lock file in the dataset or above its variant; 0
// if it is not there or can't be read.
int64_t PairsWanted(const std::string& dir) {
  std::error_code error;
  const fs::path here = fs::weakly_canonical(fs::absolute(dir, error), error);
  const bool whole = fs::exists(here / "study.lock.yaml", error);
  const fs::path root = whole ? here : here.parent_path();
  if (!fs::exists(root / "study.lock.yaml", error)) return 0;
  const absl::StatusOr<v1::StudySpec> study = LoadStudy(root / "study.lock.yaml");
  if (!study.ok()) return 0;
  int64_t pairs = 0;
  for (const v1::VariantSpec& variant : study->variants()) {
    if (whole || variant.name() == here.filename()) pairs += PairsOf(*study, variant);
  }
  return pairs;
}

// "8 pairs", or "2 of 4 pairs asked for".
std::string PairsText(int64_t pairs, int64_t wanted) {
  if (pairs >= wanted) return Plural(pairs, "pair");
  return FormatCount(pairs) + " of " + Plural(wanted, "pair") + " asked for";
}

absl::StatusOr<ExitCode> Verify(const VerifyCommandOptions& command, Session& session) {
  VerifyOptions options{.hashes = !command.no_hashes, .geometry = !command.no_geometry};
  ASSIGN_OR_RETURN(const VerifyResult result, VerifyDataset(command.dir, options));
  const bool ok = result.findings_total == 0;
  const bool is_archive = result.kind == "archive";
  const int64_t pairs_wanted = is_archive ? PairsWanted(command.dir) : 0;
  if (session.options.json) {
    Json findings = Json::array();
    for (const Finding& finding : result.findings) {
      findings.push_back(
          {{"check", finding.check}, {"path", finding.path}, {"message", finding.message}});
    }
    session.PrintJson({{"dir", command.dir},
                       {"kind", result.kind},
                       {"ok", ok},
                       {"variants", result.variants},
                       {"frames", result.frames},
                       {"pairs_wanted", pairs_wanted},
                       {"files", result.files},
                       {"bytes", result.bytes},
                       {"findings_total", result.findings_total},
                       {"findings", findings}});
    return ok ? kExitOk : kExitFailed;
  }
  const Terminal& out = session.out();
  for (const Finding& finding : result.findings) {
    *out.stream << out.Paint(Tone::kBad, finding.check) << " " << finding.path << ": "
                << finding.message << "\n";
  }
  if (result.findings_total > static_cast<int64_t>(result.findings.size())) {
    *out.stream << "and "
                << FormatCount(result.findings_total - static_cast<int64_t>(result.findings.size()))
                << " more\n";
  }
  const bool nothing = is_archive && result.frames == 0;
  *out.stream << command.dir << ": "
              << (is_archive ? PairsText(result.frames, pairs_wanted) + ", " : std::string())
              << Plural(result.files, "file") << " ("
              << FormatBytes(static_cast<double>(result.bytes)) << "), "
              << (!ok       ? out.Paint(Tone::kBad, Plural(result.findings_total, "finding"))
                  : nothing ? out.Paint(Tone::kWarning, "nothing to check yet")
                            : out.Paint(Tone::kGood, "all as it should be"))
              << "\n";
  return ok ? kExitOk : kExitFailed;
}

}  // namespace

void RegisterExport(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "export", "Write a dataset in a layout that public training code reads",
      "Images are hard links where the layout takes PNG. Pairs that fail a filter are left out\n"
      "unless --unfiltered; a dataset with holes is refused. Scenes of the TEST split are listed "
      "in\n"
      "test.txt; SHA256SUMS lets `parallax verify` check the export later.\n"
      "\n"
      "Examples:\n"
      "  parallax export out/quickstart --out out/things          FlyingThings3D, for "
      "RAFT-Stereo...\n"
      "  parallax export out/table1 --variant default --layout kitti --out out/kitti\n"
      "  parallax export out/mix --variant 'm-10-80-10_*' --layout webdataset --out shards\n");
  auto options = std::make_shared<ExportCommandOptions>();
  command->add_option("DIR", options->dir, "A dataset, or one of its variants")->required();
  AddOption(command, "-o,--out", "DIR2", options->out, "The new folder")->required();
  AddOption(command, "-l,--layout", "LAYOUT", options->options.layout,
            "flyingthings (default), fsd, crestereo, wmgstereo, middlebury, kitti or "
            "webdataset; for sequences with flow flyingthings-flow, sintel or dynamic-replica");
  AddOption(command, "--variant", "NAME", options->options.variants,
            "Only this variant; may be repeated, and end in * (default: all but heldout)");
  command->add_flag("--unfiltered", options->options.unfiltered,
                    "Take pairs that fail a filter too");
  command->add_flag("--infrared", options->options.infrared,
                    "Take the infrared pictures (render.maps: infrared) for the pair");
  command->add_flag("--flat", options->options.flat, "crestereo: no folder for each scene");
  command->add_flag("--allow-incomplete", options->options.allow_incomplete,
                    "Export although pairs or variants are missing");
  command
      ->add_option("--test-every", options->options.test_every,
                   "Every Nth scene goes to TEST (default 20; always at least one)")
      ->check(CLI::Range(2, 1000000));
  command
      ->add_option("--shard-pairs", options->options.shard_pairs,
                   "webdataset: pairs of a shard (default 500)")
      ->check(CLI::Range(1, 1000000));
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return Export(*options, session); });
}

void RegisterVerify(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "verify", "Check the hashes and the geometry of a dataset",
      "Every file against its SHA-256; in each pair: disparity = fx * baseline / depth, poses,\n"
      "finite maps, occlusion by re-projection, indices against their tables, normals, masks,\n"
      "flow of sequences, and the filter verdicts. A folder of `parallax export` is compared with "
      "its SHA256SUMS.\n"
      "Exit status 1 when something is wrong, one line each; pairs that are still to be made are\n"
      "counted and are no fault.\n"
      "\n"
      "Example:\n"
      "  parallax verify out/quickstart\n");
  auto options = std::make_shared<VerifyCommandOptions>();
  command->add_option("DIR", options->dir, "A dataset, one of its variants, or an export")
      ->required();
  command->add_flag("--no-hashes", options->no_hashes, "Do not check the hashes");
  command->add_flag("--no-geometry", options->no_geometry, "Do not check the maps");
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return Verify(*options, session); });
}

}  // namespace parallax::client
