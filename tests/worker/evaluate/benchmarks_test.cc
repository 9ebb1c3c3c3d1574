// Each benchmark in its own layout: a small tree, predictions, and scores computed by hand.
#include <gmock/gmock.h>

#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/evaluation.h"

namespace parallax {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Opens a benchmark below the tree, scores the files of `predictions`/ and returns the evaluation.
absl::StatusOr<Evaluation> Score(const TestTree& tree, const std::string& what) {
  ASSIGN_OR_RETURN(const Benchmark benchmark, OpenBenchmark(what, tree.dir()));
  const auto predictor = MakeFolderPredictor(tree.dir() + "/predictions");
  return Evaluate(*predictor, benchmark, {.work_dir = tree.dir() + "/work"});
}

double Figure(const Evaluation& evaluation, const std::string& metric) {
  const auto parsed = ParseMetric(metric);
  EXPECT_TRUE(parsed.ok()) << parsed.status();
  return FigureOf(*parsed, evaluation);
}

std::vector<std::string> Names(const Benchmark& benchmark) {
  std::vector<std::string> names;
  for (const BenchmarkPair& pair : benchmark.pairs) names.push_back(pair.name);
  return names;
}

// A scene of Middlebury's evaluation: 8 pixels in a row.
void AddMiddleburyScene(const TestTree& tree, const std::string& at, const std::string& suffix) {
  tree.Pictures(at + "/im0.png", at + "/im1.png", 8, 1);
  tree.Pfm(at + "/disp0" + suffix + ".pfm", Row({kInf, 10, 10, 10, 10, 10, 10, 10}));
}

TEST(Benchmarks, Middlebury2014IsJudgedOnVisiblePixelsPerImage) {
  for (const std::string resolution : {"F", "H", "Q"}) {
    const TestTree tree;
    const std::string root = "Middlebury/MiddEval3/training" + resolution;
    AddMiddleburyScene(tree, root + "/Adirondack", "GT");
    tree.Mask(root + "/Adirondack/mask0nocc.png", RowU8({0, 128, 128, 255, 255, 255, 255, 255}));
    AddMiddleburyScene(tree, root + "/Teddy", "GT");
    tree.Mask(root + "/Teddy/mask0nocc.png", RowU8({0, 255, 255, 255, 255, 255, 255, 255}));
    // Errors: unknown, 50, 0, | 0, 1, 2, 2.5, 0.
    tree.Pfm("predictions/Adirondack.pfm", Row({99, 60, 10, 10, 11, 12, 12.5f, 10}));
    tree.Pfm("predictions/Teddy.pfm", Row({99, 10, 10, 10, 10, 10, 10, 10}));
    const auto evaluation = Score(tree, "middlebury2014-" + resolution);
    ASSERT_TRUE(evaluation.ok()) << evaluation.status();
    EXPECT_EQ(MetricName(evaluation->headline), "bad-2 nocc");
    EXPECT_EQ(evaluation->pairs_published, 15);
    // Adirondack: 1 of 5 visible pixels; Teddy: none.
    EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), (20.0 + 0) / 2);
    // With the occluded ones 2 of 7: the figure that RAFT-Stereo's script prints.
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 all"), (200.0 / 7 + 0) / 2);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe nocc"), (5.5 / 5) / 2);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe all"), (55.5 / 7) / 2);
  }
}

TEST(Benchmarks, Middlebury2014HeldOutTakesThePerfectScenesOutsideOfTheEvaluation) {
  const TestTree tree;
  const std::string root = "Middlebury/2014/";
  for (const char* scene : {"Backpack-perfect", "Backpack-imperfect", "Piano-perfect"}) {
    AddMiddleburyScene(tree, root + scene, "");
    // Seen from the right: the pixels x = 0 and x = 1 of the left are not.
    tree.Pfm(root + scene + "/disp1.pfm", Row({kInf, kInf, kInf, kInf, kInf, kInf, kInf, kInf}));
  }
  // Disparity 2: x1 = x - 2.
  tree.Pfm(root + "Backpack-perfect/disp0.pfm", Row({2, 2, 2, 2, 2, 2, 2, 1500}));
  tree.Pfm(root + "Backpack-perfect/disp1.pfm", Row({2, 2, 2, 2, 9, 2, 2, 2}));
  // Visible: x = 2..5. Of x = 0, 1 the counterpart lies outside; of x = 6 it has disparity 9.
  tree.Pfm("predictions/Backpack.pfm", Row({50, 50, 2, 2, 2, 7, 50, 0}));
  const auto evaluation = Score(tree, "middlebury2014-heldout");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  ASSERT_EQ(evaluation->images.size(), 1);
  EXPECT_EQ(evaluation->pairs_published, 13);
  EXPECT_EQ(evaluation->images[0].regions.at("nocc").pixels, 4);
  EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 25);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 all"), 400.0 / 7);
  const auto sets = OpenBenchmark("middlebury2014-sets", tree.dir());
  ASSERT_TRUE(sets.ok()) << sets.status();
  EXPECT_THAT(Names(*sets), ElementsAre("Backpack", "Piano"));
}

TEST(Benchmarks, Middlebury2021IsJudgedOnAllPixels) {
  for (const std::string root : {"Middlebury/2021/data/", "Middlebury/2021/all/data/"}) {
    const TestTree tree;
    tree.Pictures(root + "artroom1/im0.png", root + "artroom1/im1.png", 4, 1);
    tree.Pfm(root + "artroom1/disp0.pfm", Row({1, 1, 1, kInf}));
    tree.Pfm(root + "artroom1/disp1.pfm", Row({1, 1, 1, 1}));
    tree.Pfm("predictions/artroom1.pfm", Row({4, 1, 1, 1}));
    const auto evaluation = Score(tree, "middlebury2021");
    ASSERT_TRUE(evaluation.ok()) << evaluation.status();
    EXPECT_EQ(MetricName(evaluation->headline), "bad-2 all");
    EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 100.0 / 3);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 nocc"), 0);  // x = 0 leaves the right image.
  }
}

TEST(Benchmarks, Eth3dIsJudgedAtOnePixel) {
  for (const std::string gt : {"two_view_training_gt", "two_view_training"}) {
    const TestTree tree;
    const std::string root = "ETH3D/two_view_training/";
    tree.Pictures(root + "delivery_area_1l/im0.png", root + "delivery_area_1l/im1.png", 4, 1);
    const std::string truth = "ETH3D/" + gt + "/delivery_area_1l/";
    tree.Pfm(truth + "disp0GT.pfm", Row({5, 5, 5, kInf}));
    tree.Mask(truth + "mask0nocc.png", RowU8({128, 255, 255, 0}));
    tree.Pfm("predictions/delivery_area_1l.pfm", Row({7, 6, 5.5f, 1}));
    const auto evaluation = Score(tree, "eth3d");
    ASSERT_TRUE(evaluation.ok()) << evaluation.status();
    EXPECT_EQ(MetricName(evaluation->headline), "bad-1 all");
    EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 100.0 / 3);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-1 nocc"), 0);  // An error of exactly 1 is not bad.
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe nocc"), 0.75);
  }
}

TEST(Benchmarks, KittiPoolsAllPixelsAndPrintsD1) {
  const struct {
    const char *name, *root, *left, *right, *occ, *noc;
    int published;
  } cases[] = {
      {"kitti2012", "KITTI_2012/training/", "colored_0/", "colored_1/", "disp_occ/", "disp_noc/",
       194},
      {"kitti2012", "KITTI/2012/training/", "image_0/", "image_1/", "disp_occ/", "disp_noc/", 194},
      {"kitti2015", "KITTI_2015/training/", "image_2/", "image_3/", "disp_occ_0/", "disp_noc_0/",
       200},
      {"kitti2015", "KITTI/training/", "image_2/", "image_3/", "disp_occ_0/", "disp_noc_0/", 200}};
  for (const auto& c : cases) {
    const TestTree tree;
    const std::string root = c.root;
    for (const std::string frame : {"000000_10.png", "000001_10.png"}) {
      tree.Pictures(root + c.left + frame, root + c.right + frame, 5, 1);
    }
    tree.Picture(root + c.left + "000000_11.png", 5, 1);  // The next in time: no truth, no pair.
    tree.Png16(root + c.occ + "000000_10.png", Row({100, 100, 10, kNan, kNan}));
    tree.Png16(root + c.noc + "000000_10.png", Row({100, kNan, 10, kNan, kNan}));
    tree.Png16(root + c.occ + "000001_10.png", Row({10, kNan, kNan, kNan, kNan}));
    tree.Png16(root + c.noc + "000001_10.png", Row({10, kNan, kNan, kNan, kNan}));
    // Errors 4 (4 %), 6 (6 %), 3 | 0.
    tree.Pfm("predictions/000000_10.pfm", Row({104, 106, 13, 0, 0}));
    tree.Pfm("predictions/000001_10.pfm", Row({10, 0, 0, 0, 0}));
    const auto evaluation = Score(tree, c.name);
    ASSERT_TRUE(evaluation.ok()) << c.root << ": " << evaluation.status();
    EXPECT_EQ(evaluation->pairs_published, c.published);
    EXPECT_EQ(MetricName(evaluation->headline), "bad-3 all pooled");
    EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 200.0 / 4);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "d1 all pooled"), 100.0 / 4);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-3 nocc pooled"), 100.0 / 3);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-3 nocc"), (50.0 + 0) / 2);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe all"), (13.0 / 3 + 0) / 2);
  }
}

TEST(Benchmarks, Kitti2015SplitsForegroundByItsObjectMap) {
  const TestTree tree;
  const std::string root = "KITTI_2015/training/", frame = "000000_10.png";
  tree.Pictures(root + "image_2/" + frame, root + "image_3/" + frame, 3, 1);
  tree.Png16(root + "disp_occ_0/" + frame, Row({10, 10, 10}));
  tree.Png16(root + "disp_noc_0/" + frame, Row({10, 10, 10}));
  tree.Mask(root + "obj_map/" + frame, RowU8({0, 1, 7}));
  tree.Png16("predictions/000000_10.png", Row({10, 10, 20}));
  const auto evaluation = Score(tree, "kitti2015");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "d1 foreground pooled"), 50);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "d1 background pooled"), 0);
}

TEST(Benchmarks, BoosterIsJudgedAtQuarterResolution) {
  const TestTree tree;
  const std::string root = "Booster/train/balanced/Bathroom/";
  for (const char* image : {"im0.png", "im1.png"}) {
    tree.Pictures(root + "camera_00/" + image, root + "camera_02/" + image, 16, 8);
  }
  // Full size; only pixels whose x and y are multiples of 4 count.
  ImageF truth(16, 8, 3.0f);
  ImageU8 visible(16, 8, 0), classes(16, 8, 1);
  for (int y = 0; y < 8; y += 4) {
    for (int x = 0; x < 16; x += 4) {
      truth(x, y) = 40;
      visible(x, y) = 255;
    }
  }
  truth(0, 0) = 0;    // Unknown.
  visible(4, 0) = 0;  // Occluded.
  classes(8, 4) = 3;  // Transparent or mirror.
  tree.Npy(root + "disp_00.npy", truth);
  tree.Mask(root + "mask_00.png", visible);
  tree.Mask(root + "mask_cat.png", classes);
  // Quarter size: truth 10 but at (0, 0).
  ImageF predicted(4, 2, 10.0f);
  predicted(1, 0) = 15;
  predicted(2, 1) = 13;
  tree.Pfm("predictions/Bathroom_im0.pfm", predicted);
  tree.Pfm("predictions/Bathroom_im1.pfm", ImageF(4, 2, 12.0f));
  const auto evaluation = Score(tree, "booster-Q");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->pairs_published, 228);
  ASSERT_EQ(evaluation->images.size(), 2);
  EXPECT_EQ(evaluation->images[0].width_px, 4);
  EXPECT_EQ(evaluation->images[0].regions.at("all").pixels, 7);
  EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), (200.0 / 7 + 0) / 2);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 nocc"), (100.0 / 6 + 0) / 2);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 class3"), (100.0 + 0) / 2);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe all"), (8.0 / 7 + 2.0) / 2);
}

TEST(Benchmarks, BoosterGivesThePredictorQuarterPictures) {
  const TestTree tree;
  const std::string root = "Booster/train/balanced/Bathroom/";
  tree.Pictures(root + "camera_00/im0.png", root + "camera_02/im0.png", 128, 64);
  tree.Npy(root + "disp_00.npy", ImageF(128, 64, 4.0f));
  tree.Mask(root + "mask_00.png", ImageU8(128, 64, 255));
  tree.Mask(root + "mask_cat.png", ImageU8(128, 64, 0));
  const auto benchmark = OpenBenchmark("booster-Q", tree.dir());
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  const auto evaluation =
      Evaluate(*MakeSgbmPredictor(), *benchmark, {.work_dir = tree.dir() + "/work"});
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->images[0].width_px, 32);
}

TEST(Benchmarks, DrivingStereoFindsItsThreeFoldersHoweverUnpacked) {
  const struct {
    const char *left, *right, *truth;
  } cases[] = {
      {"test-left-image/left-image-half-size/s/", "test-right-image/right-image-half-size/s/",
       "test-disparity-map/disparity-map-half-size/s/"},
      {"test/left-image-half-size/", "test/right-image-half-size/",
       "test/disparity-map-half-size/"}};
  for (const auto& c : cases) {
    const TestTree tree;
    const std::string root = "DrivingStereo/", name = "2018-07-11-14-48-52_2018-07-11-14-50-09-376";
    tree.Pictures(root + c.left + name + ".png", root + c.right + name + ".png", 4, 1);
    tree.Png16(root + c.truth + name + ".png", Row({10, 100, 10, kNan}));
    tree.Png16(root + "train/disparity-map-half-size/other.png", Row({10}));  // Not for training.
    tree.Pfm("predictions/" + name + ".pfm", Row({13.5f, 104, 10, 7}));
    const auto evaluation = Score(tree, "drivingstereo");
    ASSERT_TRUE(evaluation.ok()) << evaluation.status();
    ASSERT_EQ(evaluation->images.size(), 1);
    EXPECT_EQ(MetricName(evaluation->headline), "bad-3 all");
    EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 200.0 / 3);
    EXPECT_DOUBLE_EQ(Figure(*evaluation, "d1 all"), 100.0 / 3);
  }
}

TEST(Benchmarks, DrivingStereoTakesTheSame200PairsEachTime) {
  const TestTree tree;
  const std::string root = "DrivingStereo/test/";
  for (int i = 0; i < 230; ++i) {
    const std::string name = "/" + std::to_string(1000 + i);
    tree.Text(root + "left-image-half-size" + name + ".jpg", "");
    tree.Text(root + "right-image-half-size" + name + ".jpg", "");
    tree.Text(root + "disparity-map-half-size" + name + ".png", "");
  }
  const auto once = OpenBenchmark("drivingstereo", tree.dir());
  const auto again = OpenBenchmark("drivingstereo", tree.dir());
  ASSERT_TRUE(once.ok()) << once.status();
  EXPECT_EQ(once->pairs.size(), 200);
  EXPECT_EQ(Names(*once), Names(*again));
  std::vector<std::string> first_200;
  for (int i = 0; i < 200; ++i) first_200.push_back(std::to_string(1000 + i));
  EXPECT_NE(Names(*once), first_200);
}

// Adds the files of DrivingStereo's pairs `first` to `last` below `folder`.
void AddDrivingPairs(const TestTree& tree, const std::string& folder, int first, int last) {
  for (int i = first; i <= last; ++i) {
    for (const char* kind : {"left-image", "right-image", "disparity-map"}) {
      tree.Text("DrivingStereo/" + folder + "/" + kind + "-half-size/" + std::to_string(i) + ".png",
                "");
    }
  }
}

TEST(Benchmarks, DrivingStereoDrawsFromTheTestPairsWhereTheyAre) {
  const TestTree tree;
  AddDrivingPairs(tree, "sunny", 1, 3);
  EXPECT_EQ(OpenBenchmark("drivingstereo", tree.dir())->pairs.size(), 3);
  AddDrivingPairs(tree, "test", 4, 5);
  EXPECT_THAT(Names(*OpenBenchmark("drivingstereo", tree.dir())), ElementsAre("4", "5"));
}

TEST(Benchmarks, APartOfDrivingStereoGivesThePairsThatTheWholeGives) {
  const TestTree whole, part;
  AddDrivingPairs(whole, "test", 1000, 1299);
  AddDrivingPairs(part, "test", 1000, 1239);
  const std::vector<std::string> of_whole = Names(*OpenBenchmark("drivingstereo", whole.dir()));
  const std::vector<std::string> of_part = Names(*OpenBenchmark("drivingstereo", part.dir()));
  ASSERT_EQ(of_whole.size(), 200);
  for (const std::string& name : of_whole) {
    if (name < "1240") {
      EXPECT_THAT(of_part, ::testing::Contains(name));
    }
  }
}

TEST(Benchmarks, OnlyWhatCanBeOpenedIsInstalled) {
  const TestTree tree;
  EXPECT_THAT(InstalledBenchmarks(""), ::testing::IsEmpty());
  AddDrivingPairs(tree, "test", 1, 1);
  AddMiddleburyScene(tree, "ETH3D/two_view_training/a", "GT");
  EXPECT_THAT(InstalledBenchmarks(tree.dir()), ElementsAre("drivingstereo")) << "a mask is missing";
  tree.Mask("ETH3D/two_view_training/a/mask0nocc.png", ImageU8(8, 1, 255));
  EXPECT_THAT(InstalledBenchmarks(tree.dir()), ElementsAre("eth3d", "drivingstereo"));
}

TEST(Benchmarks, ShippedPairReadsItsThreeFiles) {
  const TestTree tree;
  tree.Pictures("shipped/motorcycle_left.png", "shipped/motorcycle_right.png", 4, 1);
  tree.Npy("shipped/motorcycle_disp.npy", Row({20, 20, kInf, 20}));
  tree.Pfm("predictions/Motorcycle.pfm", Row({20, 21.5f, 0, 23}));
  const auto evaluation = Score(tree, "shipped");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-1 all"), 200.0 / 3);
  EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 100.0 / 3);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "epe all"), 1.5);
}

TEST(Benchmarks, FoldersOfPairsTakeMasksWhereTheyAre) {
  const TestTree tree;
  AddMiddleburyScene(tree, "mine/a", "GT");
  AddMiddleburyScene(tree, "mine/b", "GT");
  tree.Mask("mine/b/mask0nocc.png", RowU8({0, 255, 255, 128, 128, 128, 128, 128}));
  for (const char* name : {"a", "b"}) {
    tree.Pfm(std::string("predictions/") + name + ".pfm", Row({0, 20, 10, 10, 10, 10, 10, 10}));
  }
  const auto evaluation = Score(tree, "folder:" + tree.dir() + "/mine");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->benchmark, "mine");
  EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 100.0 / 7);
  EXPECT_DOUBLE_EQ(Figure(*evaluation, "bad-2 nocc"), 50);  // Pair b alone.
  // The folder of one pair.
  const auto one = OpenBenchmark("single=folder:" + tree.dir() + "/mine/a", "");
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->name, "single");
  EXPECT_THAT(Names(*one), ElementsAre("a"));
}

TEST(Benchmarks, NamesOfFoldersOfPairsHaveNoSpacesAndDiffer) {
  TestTree tree;
  for (const std::string pair : {"mine/pair 1", "mine/pair 2", "clash/a b", "clash/a_b"}) {
    tree.Pictures(pair + "/im0.png", pair + "/im1.png", 4, 1);
    tree.Pfm(pair + "/disp0GT.pfm", Row({10, 10, 10, 10}));
  }
  const auto mine = OpenBenchmark("folder:" + tree.dir() + "/mine", "");
  ASSERT_TRUE(mine.ok()) << mine.status();
  EXPECT_EQ(mine->pairs[0].name, "pair_1");
  EXPECT_EQ(mine->pairs[1].name, "pair_2");
  const auto clash = OpenBenchmark("folder:" + tree.dir() + "/clash", "");
  EXPECT_EQ(clash.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Benchmarks, ListsTakeAnyEncodingAndAMask) {
  const TestTree tree;
  tree.Pictures("l.png", "r.png", 4, 1);
  tree.Pfm("d.pfm", Row({10, 10, 10, kInf}));
  tree.Png16("d16.png", Row({10, 10, 10, kNan}));
  tree.Npy("d.npy", Row({10, 10, 10, kNan}));
  tree.Mask("mask.png", RowU8({0, 128, 255, 255}));
  tree.Text("pairs.txt",
            "# left right disparity mask\nl.png r.png d.pfm\n\n  l.png r.png d16.png\n"
            "l.png r.png d.npy mask.png  # with a mask\n");
  const auto benchmark = OpenBenchmark("list:" + tree.dir() + "/pairs.txt", "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  EXPECT_EQ(benchmark->name, "pairs");
  EXPECT_THAT(Names(*benchmark), ElementsAre("0000_l", "0001_l", "0002_l"));
  for (const std::string& name : Names(*benchmark)) {
    tree.Pfm("predictions/" + name + ".pfm", Row({20, 20, 10, 0}));
  }
  const auto evaluation = Score(tree, "list:" + tree.dir() + "/pairs.txt");
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const auto bad = [&](int image, const char* region) {
    return FigureOf(BadAt(2), evaluation->images[static_cast<size_t>(image)].regions.at(region));
  };
  EXPECT_DOUBLE_EQ(bad(0, "all"), 200.0 / 3);
  EXPECT_DOUBLE_EQ(bad(1, "all"), 200.0 / 3);
  EXPECT_DOUBLE_EQ(bad(2, "all"), 50);  // The mask's 0 leaves the first pixel out.
  EXPECT_DOUBLE_EQ(bad(2, "nocc"), 0);
}

// ---- What is wrong is told

TEST(Benchmarks, MissingFilesAreNamedForEveryLayout) {
  const struct {
    const char* what;
    std::vector<std::string> there;
    const char* missing;
  } cases[] = {
      {"middlebury2014-H",
       {"Middlebury/MiddEval3/trainingH/A/im0.png", "Middlebury/MiddEval3/trainingH/A/im1.png",
        "Middlebury/MiddEval3/trainingH/A/disp0GT.pfm"},
       "trainingH/A/mask0nocc.png"},
      {"middlebury2014-heldout",
       {"Middlebury/2014/Mask-perfect/im0.png", "Middlebury/2014/Mask-perfect/disp0.pfm",
        "Middlebury/2014/Mask-perfect/disp1.pfm"},
       "Mask-perfect/im1.png"},
      {"middlebury2021",
       {"Middlebury/2021/data/a/im0.png", "Middlebury/2021/data/a/im1.png",
        "Middlebury/2021/data/a/disp1.pfm"},
       "data/a/disp0.pfm"},
      {"eth3d",
       {"ETH3D/two_view_training/a/im0.png", "ETH3D/two_view_training/a/im1.png"},
       "two_view_training_gt/a/disp0GT.pfm"},
      {"kitti2012",
       {"KITTI_2012/training/colored_0/000000_10.png", "KITTI_2012/training/disp_occ/000000_10.png",
        "KITTI_2012/training/disp_noc/000000_10.png"},
       "colored_1/000000_10.png"},
      {"kitti2015",
       {"KITTI_2015/training/image_2/000000_10.png", "KITTI_2015/training/image_3/000000_10.png",
        "KITTI_2015/training/disp_noc_0/000000_10.png"},
       "disp_occ_0/000000_10.png"},
      {"booster-Q",
       {"Booster/train/balanced/a/camera_00/im0.png", "Booster/train/balanced/a/disp_00.npy",
        "Booster/train/balanced/a/mask_00.png", "Booster/train/balanced/a/mask_cat.png"},
       "camera_02/im0.png"},
      {"drivingstereo",
       {"DrivingStereo/test/disparity-map-half-size/a.png",
        "DrivingStereo/test/left-image-half-size/a.jpg"},
       "right-image-half-size/a.jpg"},
      {"shipped",
       {"shipped/motorcycle_left.png", "shipped/motorcycle_right.png"},
       "motorcycle_disp.npy"},
  };
  for (const auto& c : cases) {
    const TestTree tree;
    for (const std::string& file : c.there) tree.Text(file, "");
    const absl::Status status = OpenBenchmark(c.what, tree.dir()).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << c.what << ": " << status;
    EXPECT_THAT(std::string(ToStd(status.message())), HasSubstr(c.missing)) << c.what;
  }
}

TEST(Benchmarks, AbsentOrEmptyFoldersAreErrors) {
  const TestTree tree;
  for (const BenchmarkKind& kind : BenchmarkKinds()) {
    if (kind.takes_path || kind.name == "shipped") continue;
    const absl::Status status = OpenBenchmark(kind.name, tree.dir()).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << kind.name << ": " << status;
    EXPECT_THAT(std::string(ToStd(status.message())), HasSubstr(tree.dir())) << kind.name;
  }
  std::filesystem::create_directories(tree.dir() + "/ETH3D/two_view_training");
  EXPECT_EQ(OpenBenchmark("eth3d", tree.dir()).status().code(), absl::StatusCode::kDataLoss);
}

TEST(Benchmarks, NamesAndPathsAreChecked) {
  const TestTree tree;
  tree.Text("bad.txt", "only two\n");
  tree.Text("gone.txt", "a.png b.png c.pfm\n");
  const struct {
    std::string what;
    const char* wanted;
  } cases[] = {{"sintel", "middlebury2014-H"},
               {"eth3d:somewhere", "there is no benchmark"},
               {"list", "list:PATH"},
               {"list:", "list:PATH"},
               {"list:" + tree.dir() + "/bad.txt", "bad.txt:1: 2 fields"},
               {"list:" + tree.dir() + "/gone.txt", "a.png: missing, and 2 more files"},
               {"folder:" + tree.dir() + "/nowhere", "no such folder"},
               {"archive:" + tree.dir(), "no dataset"}};
  for (const auto& c : cases) {
    EXPECT_THAT(std::string(ToStd(OpenBenchmark(c.what, tree.dir()).status().message())),
                HasSubstr(c.wanted))
        << c.what;
  }
}

}  // namespace
}  // namespace parallax
