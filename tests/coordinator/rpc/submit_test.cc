// A study meets the same verdict in the same words whether a file brings it or a message.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <limits>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/config/check/limits.h"
#include "common/config/config.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/store/content.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr int kHuge = std::numeric_limits<int32_t>::max();

struct Row {
  std::string what;
  std::function<void(v1::StudySpec&)> spoil;
  std::string want;  // Part of the message; empty: any.
  bool refused_in_file = true;
};

v1::SceneConfig& ConfigOf(v1::StudySpec& study) {
  return *study.mutable_variants(0)->mutable_config();
}

// The message and field that "rigs.width_px" names.
std::pair<Message*, const FieldDescriptor*> At(Message& message, const std::string& path) {
  const size_t dot = path.find('.');
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(path.substr(0, dot));
  if (dot == std::string::npos) return {&message, field};
  return At(*message.GetReflection()->MutableMessage(&message, field), path.substr(dot + 1));
}

v1::Distribution& DistributionAt(v1::StudySpec& study, const std::string& path) {
  const auto [message, field] = At(ConfigOf(study), path);
  return *dynamic_cast<v1::Distribution*>(message->GetReflection()->MutableMessage(message, field));
}

void AddDistributions(std::vector<Row>& rows) {
  const struct {
    const char* what;
    void (*spoil)(v1::Distribution&);
  } kinds[] = {
      {"nan", [](v1::Distribution& d) { d.set_constant(kNan); }},
      {"inf", [](v1::Distribution& d) { d.set_constant(kInf); }},
      {"uniform from nan", [](v1::Distribution& d) { d.mutable_uniform()->set_low(kNan); }},
      {"uniform to inf", [](v1::Distribution& d) { d.mutable_uniform()->set_high(kInf); }},
      {"uniform backwards", [](v1::Distribution& d) { d.mutable_uniform()->set_low(1); }},
      {"huge", [](v1::Distribution& d) { d.mutable_uniform_int()->set_high(int64_t{1} << 62); }},
      {"no choice", [](v1::Distribution& d) { d.mutable_choice(); }},
      {"choice of nan", [](v1::Distribution& d) { d.mutable_choice()->add_values(kNan); }},
      {"gaussian without std", [](v1::Distribution& d) { d.mutable_clip_gaussian()->set_high(1); }},
      {"bernoulli 2", [](v1::Distribution& d) { d.mutable_bernoulli()->set_p(2); }},
  };
  for (const char* path :
       {"room.width_m", "room.depth_m", "room.height_m", "room.doors", "room.windows", "room.rooms",
        "floating.count", "floating.size_m", "floating.distance_m", "floating.warp",
        "lighting.point_lights", "lighting.point_power_w", "lighting.sky_strength",
        "lighting.sky_saturation", "lighting.point_distance_m", "rigs.baseline_m",
        "rigs.altitude_m", "rigs.pitch_deg", "rigs.horizontal_fov_deg"}) {
    for (const auto& kind : kinds) {
      rows.push_back({std::string(path) + " " + kind.what,
                      [path, kind](v1::StudySpec& study) {
                        v1::Distribution& distribution = DistributionAt(study, path);
                        distribution.Clear();
                        kind.spoil(distribution);
                      },
                      "variants[0].config." + std::string(path)});
    }
  }
}

void AddNumbers(std::vector<Row>& rows) {
  for (const char* path :
       {"room.two_storeys_p", "solver.budget_s", "materials.replace_probability",
        "lighting.ceiling_removed_p", "lighting.ceiling_dimmed_p", "rigs.min_distance_m",
        "rigs.clearance_baseline_m", "floating.size_at_m", "filters.min_mean_intensity",
        "filters.min_depth_m", "filters.min_distance_m"}) {
    for (const double value : {kNan, kInf, -1e9, 1e9}) {
      rows.push_back({std::string(path) + " " + std::to_string(value),
                      [path, value](v1::StudySpec& study) {
                        const auto [message, field] = At(ConfigOf(study), path);
                        message->GetReflection()->SetDouble(message, field, value);
                      },
                      "variants[0].config." + std::string(path) + ": "});
    }
  }
  for (const char* path : {"solver.steps", "floating.view_rig", "rigs.count", "rigs.width_px",
                           "rigs.height_px", "render.samples_per_pixel", "render.max_bounces"}) {
    for (const int32_t value : {-5, kHuge}) {
      rows.push_back({std::string(path) + " " + std::to_string(value),
                      [path, value](v1::StudySpec& study) {
                        const auto [message, field] = At(ConfigOf(study), path);
                        message->GetReflection()->SetInt32(message, field, value);
                      },
                      "variants[0].config." + std::string(path) + ": " + std::to_string(value) +
                          " is out of range, allowed "});
    }
  }
  rows.push_back({"a huge image",
                  [](v1::StudySpec& study) {
                    ConfigOf(study).mutable_rigs()->set_width_px(8192);
                    ConfigOf(study).mutable_rigs()->set_height_px(8192);
                  },
                  "rigs.height_px: 8192 x 8192 = 67108864 pixels an image, allowed are at most"});
}

void AddTexts(std::vector<Row>& rows) {
  const auto add = [&rows](const std::string& what, auto spoil, const std::string& want) {
    rows.push_back({what, [spoil](v1::StudySpec& study) { spoil(ConfigOf(study)); },
                    "variants[0].config." + want});
  };
  add(
      "class", [](v1::SceneConfig& c) { c.mutable_floating()->add_classes("Chiar"); },
      "floating.classes[0]: \"Chiar\" is not known, did you mean Chair? (allowed: all, bushes");
  add(
      "exclude", [](v1::SceneConfig& c) { c.mutable_assets()->add_exclude("Cacti"); },
      "assets.exclude[3]: \"Cacti\" is not known, did you mean");
  add(
      "material", [](v1::SceneConfig& c) { c.mutable_materials()->set_diffuse_material("Woood"); },
      "materials.diffuse_material: \"Woood\" is not known, did you mean");
  add(
      "profile", [](v1::SceneConfig& c) { c.mutable_render()->set_profile("hihg"); },
      "render.profile: \"hihg\" is not known, did you mean high?");
  add(
      "map", [](v1::SceneConfig& c) { c.mutable_render()->add_maps("detph"); },
      "render.maps[7]: \"detph\" is not known, did you mean depth?");
  add(
      "room", [](v1::SceneConfig& c) { c.mutable_room()->add_kinds("garage"); },
      "room.kinds[4]: \"garage\" is not known");
  add(
      "mode",
      [](v1::SceneConfig& c) {
        c.mutable_materials()->set_mode(static_cast<v1::MaterialConfig::Mode>(99));
      },
      "materials.mode: 99 is not known (allowed: all, none, one_diffuse, metal_glass)");
  add(
      "type", [](v1::SceneConfig& c) { c.set_type(static_cast<v1::SceneType>(-1)); },
      "type: -1 is not known");
  for (const std::string& dir :
       {std::string("/etc"), std::string("../secrets"), std::string("a/../../b"),
        std::string("a//b"), std::string("./a"), std::string("a/"), std::string("a\x1b[31m"),
        std::string(1001, 'a')}) {
    add(
        "picture_dir " + dir,
        [dir](v1::SceneConfig& c) { c.mutable_materials()->set_picture_dir(dir); },
        "materials.picture_dir: ");
    // A file's paths count from its folder, or are absolute.
    const bool is_path = dir.starts_with('/') || dir.find("./") != std::string::npos;
    if (is_path) rows.back().refused_in_file = false;
  }
}

void AddStudyFields(std::vector<Row>& rows) {
  for (const std::string& name :
       {std::string(), std::string("My Study"), std::string("A"), std::string("../../etc/passwd"),
        std::string("\x1b[31mred"), std::string("a\0b", 3), std::string("a\nb"),
        std::string("a\u202eb"), std::string("-a"), std::string(65, 'a'), std::string("a.b")}) {
    const std::string want = WhyNotFolderName(name);
    rows.push_back(
        {"study " + name, [name](v1::StudySpec& s) { s.set_name(name); }, "study: " + want});
    rows.push_back({"variant " + name,
                    [name](v1::StudySpec& s) { s.mutable_variants(0)->set_name(name); },
                    "variants[0].name: " + want});
    if (IsName(name)) continue;
    rows.push_back({"tag " + name, [name](v1::StudySpec& s) { s.add_tags(name); },
                    "tags[0]: " + WhyNotName(name)});
  }
  const std::vector<Row> more = {
      {"no variant", [](v1::StudySpec& s) { s.clear_variants(); }, "variants: an empty list"},
      {"twins", [](v1::StudySpec& s) { *s.add_variants() = s.variants(0); },
       "variants[1].name: \"only\" names another variant too"},
      {"pairs 0", [](v1::StudySpec& s) { s.set_pairs(0); }, "pairs: 0 is out of range"},
      {"pairs -1", [](v1::StudySpec& s) { s.set_pairs(-1); }, "pairs: -1 is out of range"},
      {"pairs 1e9", [](v1::StudySpec& s) { s.set_pairs(1'000'000'000); },
       "pairs: 1000000000 is out of range, allowed 1 to 100000000"},
      {"own pairs", [](v1::StudySpec& s) { s.mutable_variants(0)->set_pairs(-1); },
       "variants[0].pairs: -1 is out of range"},
      {"rigs", [](v1::StudySpec& s) { s.set_rigs_per_scene(21); },
       "rigs_per_scene: 21 is more than variant \"only\" has, allowed 1 to rigs.count = 20"},
      {"own rigs", [](v1::StudySpec& s) { s.mutable_variants(0)->set_rigs_per_scene(21); },
       "variants[0].rigs_per_scene: 21 is more than the variant has"},
      {"rigs 0", [](v1::StudySpec& s) { s.set_rigs_per_scene(-1); }, "rigs_per_scene: -1 is out"},
      {"priority", [](v1::StudySpec& s) { s.set_priority(kHuge); }, "priority: 2147483647 is out"},
      {"a receiver without an address",
       [](v1::StudySpec& s) { s.mutable_notify()->add_on("done"); }, "notify.url: missing"},
      {"memory", [](v1::StudySpec& s) { s.set_memory_mb(int64_t{1} << 40); },
       "memory_mb: 1099511627776 is out of range, allowed 0 to 1073741824 MB"},
      {"memory -1", [](v1::StudySpec& s) { s.set_memory_mb(-1); }, "memory_mb: -1 is out"},
      {"one tag twice",
       [](v1::StudySpec& s) {
         s.add_tags("a");
         s.add_tags("a");
       },
       "tags[1]: \"a\" is there already"},
      {"tags",
       [](v1::StudySpec& s) {
         for (int i = 0; i < 70; ++i) s.add_tags("t" + std::to_string(i));
       },
       "tags: a list of 70, allowed are at most 64"},
  };
  rows.insert(rows.end(), more.begin(), more.end());
}

v1::StudySpec GoodStudy() {
  v1::StudySpec study;
  study.set_name("good");
  study.set_seed(7);
  study.set_pairs(4);
  study.set_rigs_per_scene(2);
  v1::VariantSpec& variant = *study.add_variants();
  variant.set_name("only");
  *variant.mutable_config() = DefaultSceneConfig();
  return study;
}

// A folder that counts questions, and is away when told.
class CountingStore final : public Store {
 public:
  explicit CountingStore(std::unique_ptr<Store> store) : store_(std::move(store)) {}
  std::string Uri() const override { return store_->Uri(); }
  absl::Status Put(std::string_view path, std::string_view bytes) override {
    return store_->Put(path, bytes);
  }
  absl::StatusOr<std::string> Get(std::string_view path) const override {
    ++reads;
    return store_->Get(path);
  }
  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    ++reads;
    return store_->GetPiece(path, offset, max_bytes);
  }
  absl::StatusOr<bool> Has(std::string_view path) const override {
    ++questions;
    if (away) return Unavailable("the store is away");
    return store_->Has(path);
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    ++reads;
    return store_->List(prefix);
  }
  absl::Status RemoveTree(std::string_view path) override { return store_->RemoveTree(path); }
  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    return store_->LocalPath(path);
  }
  mutable std::atomic<int> questions = 0, reads = 0;
  std::atomic<bool> away = false;

 private:
  const std::unique_ptr<Store> store_;
};

class SubmitTest : public FolderTest {
 protected:
  SubmitTest() {
    JobQueueOptions queue;
    queue.db_path = dir_ + "/queue.db";
    queue_ = *JobQueue::Open(queue);
    store_ = std::make_unique<CountingStore>(*OpenStore(dir_ + "/store"));
    CoordinatorServerOptions options;
    options.store = store_.get();
    options.spool_dir = dir_ + "/store/.tmp-incoming";
    options.listen = {"unix:" + dir_ + "/socket"};
    options.store_uri = "file://" + dir_ + "/store";
    server_ = *CoordinatorServer::Start(options, *queue_);
    stub_ = v1::Coordinator::NewStub(*ConnectRpc(*ParseRpcAddress(options.listen[0]), {}));
  }
  ~SubmitTest() override {
    server_.reset();
    queue_.reset();
  }

  absl::Status Submit(const v1::StudySpec& study) {
    v1::SubmitRequest request;
    *request.mutable_study() = study;
    v1::SubmitReply reply;
    return Call(
        [&](grpc::ClientContext& context) { return stub_->Submit(&context, request, &reply); });
  }

  template <typename Method>
  absl::Status Call(Method method) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(60));
    return FromGrpc(method(context));
  }

  std::unique_ptr<CountingStore> store_;
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorServer> server_;
  std::unique_ptr<v1::Coordinator::Stub> stub_;
};

// "f.yaml:12: where: what" -> "where: what".
std::string WithoutLine(const absl::Status& status) {
  const std::string message(ToStd(status.message()));
  return message.substr(0, 7) == "f.yaml:" ? message.substr(message.find(": ") + 2) : message;
}

TEST_F(SubmitTest, TwoHundredBadStudiesAreRefusedInTheSameWordsFromFileAndMessage) {
  std::vector<Row> rows;
  AddDistributions(rows);
  AddNumbers(rows);
  AddTexts(rows);
  AddStudyFields(rows);
  EXPECT_GE(rows.size(), 200u);
  for (const Row& row : rows) {
    SCOPED_TRACE(Printable(row.what));
    v1::StudySpec study = GoodStudy();
    row.spoil(study);
    const absl::Status sent = Submit(study);
    const absl::Status read = ParseStudy(StudyToYaml(study), "f.yaml").status();
    EXPECT_EQ(sent.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(read.ok(), !row.refused_in_file) << read;
    if (row.refused_in_file) {
      EXPECT_EQ(read.code(), absl::StatusCode::kInvalidArgument);
      EXPECT_EQ(std::string(sent.message()), WithoutLine(read));
    }
    EXPECT_THAT(std::string(sent.message()), HasSubstr(row.want));
    EXPECT_TRUE(IsPlainText(ToStd(sent.message())));
  }
  EXPECT_TRUE(queue_->ListStudies(10)->empty());
}

TEST_F(SubmitTest, NoticesGoToAllowedHostsOnly) {
  v1::StudySpec study = GoodStudy();
  study.mutable_notify()->set_url("http://host/secret");
  const absl::Status refused = Submit(study);
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("notify.url: this coordinator posts no notices to host: leave notify out"));
}

TEST_F(SubmitTest, GoodStudiesPassFromFileAndMessage) {
  const std::function<void(v1::StudySpec&)> rows[] = {
      [](v1::StudySpec&) {},
      [](v1::StudySpec& s) { s.set_name(std::string(64, 'a')); },
      [](v1::StudySpec& s) { s.add_tags("GPU.box_7"); },
      [](v1::StudySpec& s) { s.set_priority(-1000); },
      [](v1::StudySpec& s) { s.set_pairs(100'000'000); },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_rigs()->set_width_px(7680); },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_floating()->add_classes("Chair"); },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_floating()->add_classes("shelves"); },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_materials()->set_diffuse_material("WOOD"); },
      [](v1::StudySpec& s) {
        ConfigOf(s).mutable_materials()->set_picture_dir("a/b c/..d");
        ConfigOf(s).mutable_materials()->set_pictures_sha256(std::string(64, 'a'));
      },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_rigs()->mutable_baseline_m()->set_constant(2); },
      [](v1::StudySpec& s) { ConfigOf(s).mutable_solver()->set_steps(100'000); },
  };
  for (const auto& row : rows) {
    v1::StudySpec study = GoodStudy();
    row(study);
    EXPECT_TRUE(Submit(study).ok()) << Submit(study) << StudyToYaml(study);
    const auto read = ParseStudy(StudyToYaml(study), "f.yaml");
    EXPECT_TRUE(read.ok()) << read.status();
  }
}

TEST_F(SubmitTest, ContentThatIsNotInTheStoreIsRefused) {
  const std::string list = ContentListText({{"a.hdr", 3, Sha256Hex("sky")}});
  const std::string reference = ContentReferenceText({Sha256Hex(list), "srv/hdris"});
  v1::StudySpec study = GoodStudy();
  for (const char* variant : {"second", "third"}) {
    *study.add_variants() = study.variants(0);
    study.mutable_variants(study.variants_size() - 1)->set_name(variant);
  }
  for (int i : {1, 2}) {
    v1::SceneConfig& config = *study.mutable_variants(i)->mutable_config();
    config.mutable_rigs()->mutable_baseline_m()->set_constant(0.1 * i);
    config.mutable_lighting()->set_hdri_dir(reference);
    config.mutable_lighting()->set_hdris_sha256(std::string(64, 'a'));
    config.mutable_assets()->add_include("srv/meshes");  // Each worker's own copy.
    config.mutable_assets()->set_include_sha256(std::string(64, 'b'));
  }
  const absl::Status absent = Submit(study);
  EXPECT_EQ(absent.code(), absl::StatusCode::kFailedPrecondition) << absent;
  EXPECT_THAT(std::string(absent.message()),
              HasSubstr("variant second: own content \"/srv/hdris\" (list " + Sha256Hex(list) +
                        ") is not in this coordinator's store"));
  EXPECT_TRUE(queue_->ListStudies(10)->empty());
  store_->away = true;
  EXPECT_EQ(Submit(study).code(), absl::StatusCode::kUnavailable);
  store_->away = false;

  // As a client does that is told so.
  ASSERT_TRUE(store_->Put(ContentPath(Sha256Hex(list)), list).ok());
  EXPECT_THAT(std::string(Submit(study).message()), HasSubstr("\"a.hdr\" (" + Sha256Hex("sky")));
  ASSERT_TRUE(store_->Put(ContentPath(Sha256Hex("sky")), "sky").ok());
  store_->questions = store_->reads = 0;
  EXPECT_TRUE(Submit(study).ok()) << Submit(study);
  EXPECT_EQ(store_->questions, 1) << "one list, which two variants name";
  EXPECT_EQ(store_->reads, 2) << "the list is read once, and the sizes of all files";
  EXPECT_EQ(queue_->ListStudies(10)->size(), 1u);
}

TEST_F(SubmitTest, BrokenListsOfContentAreRefused) {
  const auto line = [](const std::string& name, int64_t size) {
    return Sha256Hex("sky") + " " + std::to_string(size) + " " + name + "\n";
  };
  std::string many = "parallax-content 1\n";
  for (int i = 0; i <= 20'000; ++i) many += line(std::to_string(i), 3);
  const struct {
    std::string list;
    const char* says;
  } rows[] = {{"parallax-content 1\n" + line("../x", 3), "line 2: store path \"../x\""},
              {"parallax-content 1\n" + line("a", 3) + line("a", 3), "line 3: a is listed twice"},
              {"parallax-content 1\n" + line("a", 4), "\"a\" of 4 bytes, and the file has 3"},
              {"no list\n", "line 1: wanted is \"parallax-content 1\""},
              {many, "20001 files, allowed are 20000"}};
  ASSERT_TRUE(store_->Put(ContentPath(Sha256Hex("sky")), "sky").ok());
  for (const auto& row : rows) {
    ASSERT_TRUE(store_->Put(ContentPath(Sha256Hex(row.list)), row.list).ok());
    v1::StudySpec study = GoodStudy();
    ConfigOf(study).mutable_lighting()->set_hdri_dir(
        ContentReferenceText({Sha256Hex(row.list), "srv/hdris"}));
    ConfigOf(study).mutable_lighting()->set_hdris_sha256(std::string(64, 'a'));
    const absl::Status status = Submit(study);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(row.says));
  }
}

TEST_F(SubmitTest, EveryBuiltInStudyIsAccepted) {
  for (const std::string& name : BuiltinStudies()) {
    const v1::StudySpec study = *LoadStudy(name);
    const absl::Status status = Submit(study);
    if (study.has_search()) {
      EXPECT_THAT(std::string(status.message()), HasSubstr("`parallax search FILE`")) << name;
    } else if (study.has_stream()) {
      EXPECT_THAT(std::string(status.message()), HasSubstr("`parallax stream FILE`")) << name;
    } else {
      EXPECT_TRUE(status.ok()) << name << ": " << status;
    }
  }
}

TEST_F(SubmitTest, AHugeStudyIsRefusedByItsSizeBeforeAnythingReadsIt) {
  v1::StudySpec many = GoodStudy();
  for (int i = 0; i < 1'000'000; ++i) ConfigOf(many).mutable_floating()->add_classes("Chair");
  v1::StudySpec large = GoodStudy();
  large.set_source_yaml(std::string(60 << 20, ' '));
  for (const v1::StudySpec& study : {many, large}) {
    ASSERT_GT(study.ByteSizeLong(), kMaxStudyBytes);
    const SteadyTime begin = Clock::System().Steady();
    const absl::Status status = Submit(study);
    const std::chrono::duration<double> took = Clock::System().Steady() - begin;
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("bytes with every default written out"));
    EXPECT_LT(took.count(), 10);
  }
  v1::StudySpec wordy = GoodStudy();
  wordy.set_source_yaml(std::string(kMaxYamlBytes + 1, ' '));
  EXPECT_THAT(std::string(Submit(wordy).message()), HasSubstr("source_yaml: a text of"));
}

TEST_F(SubmitTest, ReasonsAndNamesOfOtherCallsAreBoundedToo) {
  ASSERT_TRUE(Submit(GoodStudy()).ok());
  for (const std::string& reason :
       {std::string(1 << 20, 'x'), std::string("\x1b]0;owned\a"), std::string("a\nb")}) {
    v1::StudyRequest request;
    request.set_study_id(1);
    request.set_reason(reason);
    v1::StudyStatus study;
    v1::RetryReply retry;
    for (const absl::Status& status :
         {Call([&](auto& context) { return stub_->Pause(&context, request, &study); }),
          Call([&](auto& context) { return stub_->Resume(&context, request, &study); }),
          Call([&](auto& context) { return stub_->Cancel(&context, request, &study); }),
          Call([&](auto& context) { return stub_->Retry(&context, request, &retry); })}) {
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
      EXPECT_THAT(std::string(status.message()), HasSubstr("reason "));
    }
  }
  v1::SubmitRequest request;
  *request.mutable_study() = GoodStudy();
  request.set_idempotency_key("key\x1b[2J");
  v1::SubmitReply reply;
  EXPECT_EQ(Call([&](auto& context) { return stub_->Submit(&context, request, &reply); }).code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
