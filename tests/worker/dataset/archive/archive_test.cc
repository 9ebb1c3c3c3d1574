#include "worker/dataset/archive/archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_scene.h"
#include "worker/dataset/archive/judge_archive.h"
#include "worker/dataset/frame/frame_writer.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;

class ArchiveTest : public FolderTest {
 protected:
  void SetUp() override {
    store_ = dir_ + "/store";
    out_ = dir_ + "/out";
    study_ = *ParseStudy(
        "study: s\npairs: 4\nrigs_per_scene: 2\nvariants: [{name: a}, {name: b, set: {rigs: "
        "{count: "
        "2}}}]\n",
        "s.yaml");
  }

  // Renders a frame into the store as attempt 7 of a job.
  v1::PublishedFrame Publish(const std::string& variant, uint32_t scene, uint32_t rig,
                             uint8_t first_pixel = 0) {
    StereoFrame frame = RenderSyntheticFrame(scene_, scene_.rigs(static_cast<int>(rig)));
    frame.left.color(0, 0) = first_pixel;
    const std::string path =
        variant + std::to_string(scene) + "/.attempt-7/00" + std::to_string(rig);
    v1::PublishedFrame published;
    published.set_variant(variant);
    published.set_scene(scene);
    *published.mutable_frame() = *WriteFrame({.scene = scene_,
                                              .rig = scene_.rigs(static_cast<int>(rig)),
                                              .frame = frame,
                                              .render = DefaultSceneConfig().render(),
                                              .dir = store_ + "/" + path,
                                              .store_path = path});
    return published;
  }
  std::unique_ptr<ArchiveWriter> Open() {
    auto archive = ArchiveWriter::Open(out_, study_);
    EXPECT_TRUE(archive.ok()) << archive.status();
    return std::move(*archive);
  }
  std::vector<Json> Index(const std::string& variant) {
    std::vector<Json> lines;
    std::istringstream in(*ReadFile(out_ + "/" + variant + "/index.jsonl"));
    for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  std::vector<std::string> Tree() {
    std::vector<std::string> paths;
    for (const auto& entry : fs::recursive_directory_iterator(out_)) {
      if (!entry.is_directory()) paths.push_back(fs::relative(entry.path(), out_));
    }
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  v1::Scene scene_ = MakeSyntheticScene(2, 64, 36);
  v1::StudySpec study_;
  std::string store_, out_;
};

TEST_F(ArchiveTest, BringsFramesIntoTheTreeOfDatasetFormat) {
  auto archive = Open();
  const v1::PublishedFrame frames[] = {Publish("a", 12, 1), Publish("a", 3, 1), Publish("a", 3, 0),
                                       Publish("b", 0, 0)};
  for (const auto& frame : frames) {
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_FALSE(archive->HasScene("b", 7));
    ASSERT_TRUE(archive->AddScene(frame.variant(), frame.scene(), scene_).ok());
    ASSERT_TRUE(archive->HasScene(frame.variant(), frame.scene()));
  }
  ASSERT_TRUE(archive->Finish().ok());
  EXPECT_EQ(archive->totals().frames_added, 4);
  EXPECT_EQ(archive->totals().files_linked, 4 * 17);
  EXPECT_EQ(archive->Frames(), (std::map<std::string, int64_t>{{"a", 3}, {"b", 1}}));

  const std::vector<Json> lines = Index("a");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["path"], "frames/000003/000");
  EXPECT_EQ(lines[1]["path"], "frames/000003/001");
  EXPECT_EQ(lines[2]["path"], "frames/000012/001");
  EXPECT_EQ(lines[2]["scene"], 12);
  EXPECT_EQ(lines[2]["rig"], 1);
  EXPECT_EQ(lines[2]["variant"], "a");
  EXPECT_EQ(lines[2]["filters"]["dark"]["passed"], true);
  EXPECT_EQ(lines[2]["filters"]["near"]["threshold"], 0.125);
  EXPECT_EQ(lines[2]["seconds"]["trace"], 0.5);
  EXPECT_GT(lines[2]["statistics"]["mean_intensity"], 10);
  EXPECT_EQ(lines[2]["files"].size(), 17u);
  for (const v1::FileEntry& file : frames[0].frame().files()) {
    EXPECT_EQ(lines[2]["files"][file.name()], file.sha256());
    EXPECT_TRUE(fs::exists(out_ + "/a/frames/000012/001/" + file.name()));
  }
  v1::Scene recipe;
  EXPECT_TRUE(recipe.ParseFromString(*ReadFile(out_ + "/a/scenes/000012.pb")));
  EXPECT_EQ(recipe.scene_seed(), scene_.scene_seed());
  EXPECT_EQ(*ReadFile(out_ + "/study.yaml"), study_.source_yaml());
  const auto lock = LoadStudy(out_ + "/study.lock.yaml");
  ASSERT_TRUE(lock.ok()) << lock.status();
  EXPECT_EQ(lock->variants(1).config().rigs().count(), 2);
}

TEST_F(ArchiveTest, AddingEverythingAgainChangesNothing) {
  const v1::PublishedFrame frames[] = {Publish("a", 0, 0), Publish("a", 0, 1)};
  for (int run = 0; run < 2; ++run) {
    auto archive = Open();
    for (const auto& frame : frames) ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
    EXPECT_EQ(archive->totals().frames_added, run == 0 ? 2 : 0);
    EXPECT_EQ(archive->totals().frames_present, run == 0 ? 0 : 2);
    if (run == 0) continue;
    EXPECT_EQ(archive->totals().files_linked, 0);
    EXPECT_EQ(Index("a").size(), 2u);
  }
}

TEST_F(ArchiveTest, ARunThatWasInterruptedIsTakenUp) {
  const v1::PublishedFrame first = Publish("a", 0, 0), second = Publish("a", 0, 1);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(first, store_).ok());
    // Killed here: no index; and half a frame lies about.
    fs::create_directories(out_ + "/a/frames/000000/.new-001");
    ASSERT_TRUE(WriteFile(out_ + "/a/frames/000000/.new-001/left.png", "half").ok());
  }
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(first, store_).ok());
  ASSERT_TRUE(archive->AddFrame(second, store_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  EXPECT_EQ(archive->totals().frames_present, 1);
  EXPECT_EQ(archive->totals().frames_added, 1);
  EXPECT_EQ(Index("a").size(), 2u);
  for (const std::string& path : Tree()) EXPECT_EQ(path.find(".new-"), std::string::npos) << path;
}

TEST_F(ArchiveTest, FramesOfEarlierRunsStayInTheIndexUnlessTheyAreGone) {
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
    ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 1), store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  fs::remove_all(out_ + "/a/frames/000000/001");
  auto archive = Open();
  ASSERT_TRUE(archive->Finish().ok());
  ASSERT_EQ(Index("a").size(), 1u);
  EXPECT_EQ(Index("a")[0]["rig"], 0);
}

TEST_F(ArchiveTest, OtherContentReplacesTheFrameAsAWhole) {
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
  fs::remove_all(store_);
  const v1::PublishedFrame other = Publish("a", 0, 0, 200);
  ASSERT_TRUE(archive->AddFrame(other, store_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  EXPECT_EQ(archive->totals().frames_replaced, 1);
  for (const v1::FileEntry& file : other.frame().files()) {
    EXPECT_EQ(Index("a")[0]["files"][file.name()], file.sha256());
  }
  EXPECT_THAT(Tree(), ::testing::Not(::testing::Contains(HasSubstr(".old-"))));
}

TEST_F(ArchiveTest, ATruncatedFrameIsBroughtAgain) {
  const v1::PublishedFrame frame = Publish("a", 0, 0);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  fs::remove(out_ + "/a/frames/000000/000/left.png");
  ASSERT_TRUE(WriteFile(out_ + "/a/frames/000000/000/left.png", "cut").ok());
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
  EXPECT_EQ(archive->totals().frames_replaced, 1);
  EXPECT_GT(fs::file_size(out_ + "/a/frames/000000/000/left.png"), 100u);
}

TEST_F(ArchiveTest, ABrokenRecipeIsBroughtAgain) {
  const v1::PublishedFrame frame = Publish("a", 0, 0);
  const std::string path = out_ + "/a/scenes/000000.pb";
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->AddScene("a", 0, scene_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  for (const char* broken : {"", "cut"}) {
    ASSERT_TRUE(WriteFile(path, broken).ok());
    auto archive = Open();
    ASSERT_FALSE(archive->HasScene("a", 0));
    ASSERT_TRUE(archive->AddScene("a", 0, scene_).ok());
    EXPECT_TRUE(archive->HasScene("a", 0));
    EXPECT_TRUE(archive->Finish().ok());
  }
}

// A bit that rots in the store rots in the link to it, too; another attempt makes the pair anew.
TEST_F(ArchiveTest, ARottenLinkIsReplacedByTheStoresNewFile) {
  v1::PublishedFrame frame = Publish("a", 0, 0);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  const std::string first = frame.frame().path(), second = first + "-again";
  const std::string picture = out_ + "/a/frames/000000/000/left.png", good = *ReadFile(picture);
  fs::copy(store_ + "/" + first, store_ + "/" + second, fs::copy_options::recursive);
  frame.mutable_frame()->set_path(second);
  const auto rot = [&good](const std::string& path) {
    fs::permissions(path, fs::perms::owner_write, fs::perm_options::add);
    std::fstream(path, std::ios::in | std::ios::out | std::ios::binary)
        .seekp(50)
        .put(static_cast<char>(good[50] ^ 1));
  };
  rot(picture);
  ASSERT_NE(*ReadFile(picture), good);
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
  EXPECT_EQ(archive->totals().frames_replaced, 1);
  EXPECT_EQ(*ReadFile(picture), good);
  ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
  EXPECT_EQ(archive->totals().frames_present, 1);

  frame.mutable_frame()->set_path(first);  // Rotten as the link was.
  rot(picture);
  EXPECT_EQ(archive->AddFrame(frame, store_).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(archive->totals().frames_replaced, 1);
}

TEST_F(ArchiveTest, AStoreOnAnotherDeviceIsCopied) {
  const std::string shm = "/dev/shm/parallax_archive_test_" + std::to_string(::getpid());
  struct stat here {
  }, there{};
  fs::create_directories(dir_);
  if (::stat("/dev/shm", &there) != 0 || ::stat(dir_.c_str(), &here) != 0 ||
      here.st_dev == there.st_dev) {
    GTEST_SKIP() << "no second device";
  }
  store_ = shm;
  auto archive = Open();
  const v1::PublishedFrame frame = Publish("a", 0, 0);
  ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  EXPECT_EQ(archive->totals().files_copied, 17);
  EXPECT_EQ(*ReadFile(shm + "/" + frame.frame().path() + "/left.png"),
            *ReadFile(out_ + "/a/frames/000000/000/left.png"));
  ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
  EXPECT_EQ(archive->totals().frames_present, 1);
  fs::remove_all(shm);
}

TEST_F(ArchiveTest, WhatTheStoreLacksOrBreaksIsToldAndLeavesNoFrame) {
  auto archive = Open();
  v1::PublishedFrame frame = Publish("a", 0, 0);
  fs::remove(store_ + "/" + frame.frame().path() + "/left.png");
  EXPECT_EQ(archive->AddFrame(frame, store_).code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(WriteFile(store_ + "/" + frame.frame().path() + "/left.png", "cut").ok());
  const absl::Status cut = archive->AddFrame(frame, store_);
  EXPECT_EQ(cut.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(cut.message()), HasSubstr("left.png: 3 bytes, its manifest says"));
  EXPECT_FALSE(fs::exists(out_ + "/a/frames/000000/000"));
  frame.set_variant("zzz");
  EXPECT_EQ(archive->AddFrame(frame, store_).code(), absl::StatusCode::kInvalidArgument);
  frame.set_variant("a");
  frame.mutable_frame()->mutable_files(0)->set_name("../../../evil");
  EXPECT_EQ(archive->AddFrame(frame, store_).code(), absl::StatusCode::kInvalidArgument);
  frame.mutable_frame()->set_path("../outside");
  EXPECT_EQ(archive->AddFrame(frame, store_).code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ArchiveTest, AnotherStudysFolderIsRefusedButMorePairsAreWelcome) {
  ASSERT_NE(Open(), nullptr);
  study_.set_pairs(400);
  ASSERT_NE(Open(), nullptr);
  study_.set_seed(2);
  const absl::Status status = ArchiveWriter::Open(out_, study_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(std::string(status.message()),
            out_ +
                "/study.lock.yaml belongs to another study (there \"seed: 1\", now \"seed: 2\"): "
                "choose another folder");
}

TEST_F(ArchiveTest, WhatAChangedStudyNoLongerAsksForIsKeptAside) {
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  const v1::StudySpec before = study_;
  *study_.add_variants() = study_.variants(0);
  study_.mutable_variants(study_.variants_size() - 1)->set_name("added");
  archive = Open();
  EXPECT_THAT(archive->set_aside(), testing::IsEmpty()) << "one variant more drops nothing";
  EXPECT_EQ(archive->Frames()["a"], 1);

  study_.mutable_variants(0)->mutable_config()->mutable_render()->set_max_bounces(7);
  archive = Open();
  ASSERT_EQ(archive->set_aside().size(), 1u);
  const std::string aside = out_ + "/.parallax/aside/001";
  EXPECT_THAT(archive->set_aside()[0],
              testing::AllOf(HasSubstr("variant a: other settings"), HasSubstr("max_bounces: 7"),
                             HasSubstr(aside)));
  EXPECT_EQ(archive->Frames()["a"], 0);
  EXPECT_TRUE(fs::exists(aside + "/a/frames/000000/000/left.png"));
  EXPECT_TRUE(fs::exists(aside + "/study.lock.yaml"));

  study_ = before;
  study_.mutable_variants(0)->set_name("another");
  archive = Open();
  EXPECT_THAT(archive->set_aside(),
              testing::Contains(HasSubstr("variant a: no longer in the study")));
}

TEST_F(ArchiveTest, TrainingsAndScoresOfOtherSettingsAreKeptAside) {
  study_.mutable_train()->set_seeds(3);
  study_.mutable_train()->set_steps(400);
  study_.mutable_evaluate()->add_benchmarks("shipped");
  study_.mutable_evaluate()->add_baselines("sgbm");
  const absl::StatusOr<v1::StudySpec> complete = ParseStudy(StudyToYaml(study_), "study.yaml");
  ASSERT_TRUE(complete.ok()) << complete.status();
  study_ = *complete;
  ASSERT_NE(Open(), nullptr);
  fs::create_directories(out_ + "/training/a/builtin/seed-0");
  fs::create_directories(out_ + "/scores");
  const std::string of_a = "scores/shipped.a.builtin.seed-0.jsonl";
  const std::string of_sgbm = "scores/shipped.sgbm.opencv.jsonl";
  for (const std::string& file : {of_a, of_sgbm})
    ASSERT_TRUE(WriteFile(out_ + "/" + file, "x").ok());
  study_.mutable_train()->set_seeds(5);
  study_.mutable_evaluate()->add_benchmarks("eth3d");
  EXPECT_THAT(Open()->set_aside(), testing::IsEmpty()) << "seeds and benchmarks are added";
  study_.mutable_train()->set_steps(800);
  EXPECT_THAT(Open()->set_aside(),
              testing::ElementsAre(testing::AllOf(HasSubstr("training and scores of a"),
                                                  HasSubstr("(was \"steps: 400\", is "))));
  EXPECT_FALSE(fs::exists(out_ + "/training/a"));
  EXPECT_FALSE(fs::exists(out_ + "/" + of_a));
  EXPECT_TRUE(fs::exists(out_ + "/.parallax/aside/001/" + of_a));
  EXPECT_TRUE(fs::exists(out_ + "/" + of_sgbm));
  study_.mutable_evaluate()->set_max_pairs(1);
  EXPECT_THAT(Open()->set_aside(), testing::ElementsAre(HasSubstr("scores on shipped")));
  EXPECT_FALSE(fs::exists(out_ + "/" + of_sgbm));
}

TEST_F(ArchiveTest, PicturesMayMoveButNotChange) {
  v1::MaterialConfig& materials =
      *study_.mutable_variants(0)->mutable_config()->mutable_materials();
  materials.set_picture_dir("old/place");
  materials.set_pictures_sha256(std::string(64, 'a'));
  ASSERT_NE(Open(), nullptr);
  materials.set_picture_dir("new/place");
  EXPECT_THAT(Open()->set_aside(), testing::IsEmpty());
  materials.set_pictures_sha256(std::string(64, 'b'));
  EXPECT_THAT(Open()->set_aside(), testing::ElementsAre(HasSubstr("pictures_sha256")));
}

TEST_F(ArchiveTest, AnotherVersionsFolderIsRefusedInItsOwnWords) {
  ASSERT_NE(Open(), nullptr);
  const std::string lock = *ReadFile(out_ + "/study.lock.yaml");
  ASSERT_TRUE(
      WriteFile(out_ + "/study.lock.yaml", "# Parallax generator 17" + lock.substr(lock.find('\n')))
          .ok());
  const absl::Status status = ArchiveWriter::Open(out_, study_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(
      std::string(status.message()),
      HasSubstr("comes from another version of Parallax (there \"# Parallax generator 17\", now"));
}

// Verdicts also change for frames that an earlier run left and this run does not copy again.
TEST_F(ArchiveTest, OtherFiltersRewriteTheVerdictsAndNothingElse) {
  const v1::PublishedFrame first = Publish("a", 0, 0), second = Publish("a", 0, 1);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(first, store_).ok());
    ASSERT_TRUE(archive->AddFrame(second, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  std::vector<Json> before = Index("a");
  const double nearest = before[0]["filters"]["near"]["value"];
  const std::vector<std::string> tree = Tree();
  for (v1::VariantSpec& variant : *study_.mutable_variants()) {
    variant.mutable_config()->mutable_filters()->set_min_depth_m(nearest + 0.001);
  }
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(second, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
    EXPECT_EQ(archive->totals().frames_present, 1);
    EXPECT_EQ(archive->totals().frames_added + archive->totals().frames_replaced, 0);
  }
  std::vector<Json> after = Index("a");
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0]["passed"], false);
  EXPECT_EQ(after[0]["filters"]["near"]["passed"], false);
  EXPECT_EQ(after[1]["filters"]["near"]["threshold"], nearest + 0.001);
  EXPECT_EQ(Tree(), tree);
  for (size_t i = 0; i < 2; ++i) {
    for (const char* key : {"passed", "filters"}) {
      before[i].erase(key);
      after[i].erase(key);
    }
    EXPECT_EQ(before[i], after[i]);
  }
  const Json card = Json::parse(*ReadFile(out_ + "/a/dataset.json"));
  EXPECT_GE(card["filters_failed"]["near"].get<int>(), 1);
  EXPECT_EQ(LoadStudy(out_ + "/study.lock.yaml")->variants(0).config().filters().min_depth_m(),
            nearest + 0.001);
}

// The coordinator knows nothing of curation: frames that come again keep what networks said of
// these very files.
TEST_F(ArchiveTest, ScoresOfCurationStayWithTheirFiles) {
  const v1::PublishedFrame frame = Publish("a", 0, 0);
  for (v1::VariantSpec& variant : *study_.mutable_variants()) {
    variant.mutable_config()->mutable_filters()->set_max_ambiguous_share(0.6);
  }
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  EXPECT_FALSE(Index("a")[0]["filters"].contains("ambiguous"));
  const v1::VariantSpec& variant = study_.variants(0);
  const auto judged = JudgeVariant(out_ + "/a", study_, variant, {{{0, 0}, 0.7}});
  ASSERT_TRUE(judged.ok()) << judged.status();
  EXPECT_EQ(judged->frames, 1);
  EXPECT_EQ(judged->passed, 0);
  EXPECT_EQ(judged->ambiguous, 1);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(frame, store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  EXPECT_EQ(Index("a")[0]["statistics"]["ambiguous_share"], 0.7);
  EXPECT_EQ(Index("a")[0]["passed"], false);
  EXPECT_EQ(Json::parse(*ReadFile(out_ + "/a/dataset.json"))["filters_failed"]["ambiguous"], 1);
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0, /*first_pixel=*/9), store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  EXPECT_FALSE(Index("a")[0]["statistics"].contains("ambiguous_share"));
  EXPECT_EQ(Index("a")[0]["passed"], true);
}

TEST_F(ArchiveTest, AFrameThatLacksWhatAFilterNeedsIsNamed) {
  {
    auto archive = Open();
    ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
    ASSERT_TRUE(archive->Finish().ok());
  }
  Json line = Index("a")[0];
  line["statistics"].erase("min_depth_m");
  ASSERT_TRUE(WriteFile(out_ + "/a/index.jsonl", line.dump() + "\n").ok());
  const absl::Status status = ArchiveWriter::Open(out_, study_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("/a/index.jsonl: frames/000000/000: filter near: there is no statistic"));
}

TEST_F(ArchiveTest, TheCardCountsWhatIsThere) {
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
  ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 1), store_).ok());
  ASSERT_TRUE(archive->AddScene("a", 0, scene_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  const Json card = Json::parse(*ReadFile(out_ + "/a/dataset.json"));
  EXPECT_EQ(card["pairs"], 2);
  EXPECT_EQ(card["pairs_wanted"], 4);
  EXPECT_EQ(card["scenes"], 1);
  EXPECT_EQ(card["rooms"], Json({{"office", 1}}));
  EXPECT_EQ(card["filters_failed"], Json({{"dark", 0}, {"near", 0}}));
  EXPECT_EQ(card["classes"]["Ball"]["made"], 4);
  EXPECT_EQ(card["classes"]["Ball"]["frames"], 2);
  EXPECT_EQ(card["classes"]["Floor"]["made"], 1);
  EXPECT_EQ(card["wall_seconds"]["trace"], 1.0);
  // Every pixel that sees a surface is counted once, in both histograms.
  int64_t surface = 0, disparity = 0, depth = 0;
  for (int rig = 0; rig < 2; ++rig) {
    const StereoFrame frame = RenderSyntheticFrame(scene_, scene_.rigs(rig));
    for (const float value : frame.left.depth_m.values()) surface += value > 0;
  }
  for (const auto& count : card["disparity_histogram"]["counts"]) disparity += count.get<int64_t>();
  for (const auto& count : card["depth_histogram"]["counts"]) depth += count.get<int64_t>();
  EXPECT_EQ(disparity, surface);
  EXPECT_EQ(depth, surface);
  EXPECT_EQ(card["disparity_fraction_below_px"]["192"], 1.0);
  const std::string readme = *ReadFile(out_ + "/a/README.md");
  EXPECT_THAT(readme, StartsWith("---\nlicense: cc-by-4.0\n"));
  EXPECT_THAT(readme, HasSubstr("size_categories:\n- n<1K\nviewer: false\n---\n# s / a\n"));
  EXPECT_THAT(readme, HasSubstr("@inproceedings{yan2026stereo"));
  EXPECT_THAT(readme, HasSubstr("2 stereo pairs of 1 procedural scenes"));
  EXPECT_THAT(readme, HasSubstr("**Incomplete:** 4 pairs were asked for."));
  EXPECT_THAT(readme, HasSubstr("| Ball | 4 | 2 |"));
  EXPECT_THAT(readme, HasSubstr("baseline_m: {uniform: [0.04, 0.4]}"));
  const Json empty = Json::parse(*ReadFile(out_ + "/b/dataset.json"));
  EXPECT_EQ(empty["pairs"], 0);
}

TEST_F(ArchiveTest, CroissantNamesTheIndexByItsHashAndAnotherLicenceStays) {
  auto archive = Open();
  ASSERT_TRUE(archive->AddFrame(Publish("a", 0, 0), store_).ok());
  ASSERT_TRUE(archive->Finish().ok());
  const std::string index = *ReadFile(out_ + "/a/index.jsonl");
  Json croissant = Json::parse(*ReadFile(out_ + "/a/croissant.json"));
  EXPECT_EQ(croissant["name"], "s-a");
  EXPECT_EQ(croissant["license"], "https://creativecommons.org/licenses/by/4.0/");
  EXPECT_EQ(croissant["distribution"][0]["sha256"], Sha256Hex(index));
  const Json row = Json::parse(index);
  for (const Json& field : croissant["recordSet"][0]["field"]) {
    EXPECT_TRUE(row.contains(field["source"]["extract"]["column"].get<std::string>())) << field;
    EXPECT_EQ(field["source"]["fileObject"]["@id"], croissant["distribution"][0]["@id"]);
  }
  EXPECT_THAT(*ReadFile(out_ + "/a/LICENSE"), HasSubstr("CC BY 4.0"));

  ASSERT_TRUE(WriteFile(out_ + "/a/LICENSE", "Ask me.\n").ok());
  ASSERT_TRUE(archive->Finish().ok());
  EXPECT_EQ(*ReadFile(out_ + "/a/LICENSE"), "Ask me.\n");
  EXPECT_THAT(*ReadFile(out_ + "/a/README.md"), StartsWith("---\nlicense: other\n"));
  croissant = Json::parse(*ReadFile(out_ + "/a/croissant.json"));
  EXPECT_EQ(croissant["license"], "LICENSE");
}

TEST_F(ArchiveTest, WhatTheMakerBroughtAlongKeepsItsLicence) {
  const auto licence_of = [&](void (*give)(v1::SceneConfig&)) {
    fs::remove_all(out_);
    study_.mutable_variants(0)->mutable_config()->CopyFrom(DefaultSceneConfig());
    give(*study_.mutable_variants(0)->mutable_config());
    EXPECT_TRUE(Open()->Finish().ok());
    EXPECT_THAT(*ReadFile(out_ + "/a/LICENSE"), HasSubstr("CC BY 4.0"));
    return *ReadFile(out_ + "/a/LICENSE") + *ReadFile(out_ + "/a/README.md");
  };
  EXPECT_THAT(licence_of([](v1::SceneConfig&) {}),
              AllOf(Not(HasSubstr("own licence")), HasSubstr("license: cc-by-4.0")));
  for (const auto give : {+[](v1::SceneConfig& c) { c.mutable_materials()->set_picture_dir("x"); },
                          +[](v1::SceneConfig& c) { c.mutable_materials()->set_texture_dir("x"); },
                          +[](v1::SceneConfig& c) { c.mutable_lighting()->set_hdri_dir("x"); },
                          +[](v1::SceneConfig& c) { c.mutable_assets()->add_include("x"); }}) {
    EXPECT_THAT(licence_of(give),
                AllOf(HasSubstr("assets.include"), HasSubstr("keep their own licence"),
                      HasSubstr("license: other")));
  }
}

}  // namespace
}  // namespace parallax
