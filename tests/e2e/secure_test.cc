// A farm with certificates, as a person sets it up: `coordinator init`, coordinator, worker and
// client as processes, no shared folder. And each way of getting it wrong with its one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/rpc/certificate.h"
#include "common/store/content.h"
#include "tests/e2e/process.h"
#include "tests/folder_test.h"
#include "tests/worker/assets/own_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kCoordinator[] = PARALLAX_COORDINATOR_PROGRAM;
constexpr char kWorker[] = PARALLAX_WORKER_PROGRAM;
constexpr char kClient[] = PARALLAX_CLIENT_PROGRAM;

struct Outcome {
  int exit = -1;
  std::string out, err;
};

class SecureTest : public FolderTest {
 protected:
  ~SecureTest() override {
    worker_.reset();
    coordinator_.reset();
  }

  static Outcome Run(const std::vector<std::string>& command) {
    Process process(command);
    Outcome outcome;
    outcome.exit = process.Wait(Process::Seconds(60));
    outcome.out = process.Out();
    outcome.err = process.Err();
    return outcome;
  }
  Outcome Client(const std::vector<std::string>& arguments, const std::string& tls) const {
    std::vector<std::string> command = {kClient};
    command.insert(command.end(), arguments.begin(), arguments.end());
    command.insert(command.end(), {"--coordinator", address_});
    if (!tls.empty()) command.insert(command.end(), {"--tls", tls});
    return Run(At(place_, command));
  }
  // Returns the command that runs `command` with `folder` as its working folder.
  static std::vector<std::string> At(const std::string& folder, std::vector<std::string> command) {
    command.insert(command.begin(), {"/usr/bin/env", "-C", folder});
    return command;
  }
  // One line on standard error, with this in it.
  static void ExpectLine(const Outcome& outcome, int exit_status, const std::string& text) {
    EXPECT_EQ(outcome.exit, exit_status) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  }

  std::string Tls(const std::string& folder) const { return dir_ + "/tls/" + folder; }

  void Init() {
    const Outcome init =
        Run({kCoordinator, "init", dir_ + "/tls", "--issue", "worker", "pool", "--issue",
             "submitter", "ada", "--issue", "operator", "olga", "--issue", "read-only", "board"});
    ASSERT_EQ(init.exit, 0) << init.err;
  }
  void Serve(const std::vector<std::string>& more) {
    std::vector<std::string> command = {kCoordinator, "serve", "--db",     dir_ + "/queue.db",
                                        "--store",    store_,  "--listen", "127.0.0.1:0",
                                        "--http",     ""};
    command.insert(command.end(), more.begin(), more.end());
    coordinator_ = std::make_unique<Process>(At(place_, command));
    std::string line;
    ASSERT_TRUE(coordinator_->ReadLine(&line)) << coordinator_->Err();
    const std::string prefix = "listening on ";
    ASSERT_EQ(line.rfind(prefix, 0), 0u) << line;
    address_ = line.substr(prefix.size());
  }
  std::vector<std::string> WorkerCommand(const std::string& tls) const {
    std::vector<std::string> command = {kWorker,  "--role", "all",      "--coordinator", address_,
                                        "--name", "w",      "--outbox", dir_ + "/outbox"};
    if (!tls.empty()) command.insert(command.end(), {"--tls", tls});
    return command;
  }
  std::string WriteStudy(const std::string& set = "") const {
    const std::string path = dir_ + "/study.yaml";
    EXPECT_TRUE(WriteFile(path,
                          "study: tiny\nbase: indoor\nseed: 5\npairs: 4\nrigs_per_scene: 2\n"
                          "variants:\n  - name: v\n" +
                              set)
                    .ok());
    return path;
  }
  Outcome Submit(const std::string& study, const std::string& tls) const {
    return Client({"submit", study, "--width", "64", "--height", "48", "--samples", "1",
                   "--profile", "preview"},
                  tls);
  }
  // Submits, waits for the end and fetches.
  void MakeDataset(const std::string& tls) {
    const Outcome submit = Submit(WriteStudy(), tls);
    ASSERT_EQ(submit.exit, 0) << submit.err;
    const Outcome watch = Client({"watch", "tiny", "--json"}, tls);
    ASSERT_EQ(watch.exit, 0) << watch.err << watch.out;
    const Outcome fetch = Client({"fetch", "tiny", "--out", dir_ + "/out", "--json"}, tls);
    ASSERT_EQ(fetch.exit, 0) << fetch.err;
    EXPECT_THAT(fetch.out, HasSubstr("\"frames\": 4"));
    EXPECT_THAT(fetch.out, HasSubstr("\"frames_added\": 4"));
    for (const char* rig : {"000", "001"}) {
      EXPECT_TRUE(fs::exists(dir_ + "/out/v/frames/000000/" + rig + "/left.png"));
    }
    fetched_ = fetch.out;
  }
  void StopWorker() {
    worker_->Signal(SIGTERM);
    EXPECT_EQ(worker_->Wait(), 0) << worker_->Err();
  }

  std::string place_ = dir_;  // The working folder of coordinator and client.
  std::string store_ = dir_ + "/store";
  std::string address_;
  std::string fetched_;
  std::unique_ptr<Process> coordinator_;
  std::unique_ptr<Process> worker_;
};

TEST_F(SecureTest, AFarmWithCertificatesAndWithoutASharedFolderMakesADataset) {
  Init();
  Serve({"--tls", Tls("server"), "--store-access", "stream"});
  worker_ = std::make_unique<Process>(WorkerCommand(Tls("worker-pool")));
  MakeDataset(Tls("submitter-ada"));
  StopWorker();
  const std::string staging = dir_ + "/outbox/w/staging";
  for (const auto& left : fs::directory_iterator(staging)) {
    EXPECT_EQ(left.path().filename(), "cores") << "what was sent is not kept; locks may stay";
  }

  const Outcome audit = Client({"audit", "--json"}, Tls("operator-olga"));
  EXPECT_EQ(audit.exit, 0) << audit.err;
  EXPECT_THAT(audit.out, HasSubstr("submitter ada ipv4:127.0.0.1:"));
  ExpectLine(Client({"audit"}, Tls("submitter-ada")), 4, "ListAudit is for the role operator");
}

// Two machines' worth of workers, each with its own copy of the user's content at another place.
TEST_F(SecureTest, OwnContentIsTheSameOnWorkersThatShareNoDisk) {
  const std::string here = dir_ + "/a/content", there = dir_ + "/b/content";
  fs::create_directories(here + "/meshes/crates");
  fs::create_directories(here + "/hdris");
  ASSERT_TRUE(WriteFile(here + "/meshes/crates/one.glb", test::GlbBox(1, 2, 1)).ok());
  std::string grey;
  for (int i = 0; i < 8; ++i) grey += "\x80\x80\x80\x81";
  ASSERT_TRUE(WriteFile(here + "/hdris/grey.hdr",
                        std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n") + grey)
                  .ok());
  fs::copy(dir_ + "/a", dir_ + "/b", fs::copy_options::recursive);
  const auto hash_of = [&](const char* kind, const std::string& dir) {
    const Outcome outcome = Run({kClient, "config", kind, dir});
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return outcome.out.substr(std::max<size_t>(outcome.out.size(), 65) - 65, 64);
  };
  const std::string set =
      "    set:\n"
      "      floating: {count: 4, classes: [own]}\n"
      "      assets: {include: [content/meshes], include_sha256: '" +
      hash_of("meshes", here + "/meshes") + "'}\n" +
      "      lighting: {hdri_dir: content/hdris, hdris_sha256: '" +
      hash_of("hdris", here + "/hdris") + "'}\n";

  Serve({"--store-access", "stream"});
  std::vector<std::unique_ptr<Process>> workers;
  for (const char* name : {"a", "b"}) {
    std::vector<std::string> command = WorkerCommand("");
    command[6] = name;
    command[8] = dir_ + "/outbox-" + name;
    command.insert(command.end(), {"--picture-root", dir_ + "/" + name});
    workers.push_back(std::make_unique<Process>(command));
  }
  const Outcome submit = Submit(WriteStudy(set), "");
  ASSERT_EQ(submit.exit, 0) << submit.err;
  const Outcome watch = Client({"watch", "tiny", "--json"}, "");
  ASSERT_EQ(watch.exit, 0) << watch.err << watch.out;
  const Outcome fetch = Client({"fetch", "tiny", "--out", dir_ + "/out", "--json"}, "");
  ASSERT_EQ(fetch.exit, 0) << fetch.err;
  for (const char* rig : {"000", "001"}) {
    EXPECT_THAT(*ReadFile(dir_ + "/out/v/frames/000000/" + rig + "/frame.json"),
                HasSubstr("\"class\":\"own:crates\""));
  }
  EXPECT_EQ(Run({kClient, "verify", dir_ + "/out"}).exit, 0);

  // Another mesh on one of them is not taken for the study's.
  ASSERT_TRUE(WriteFile(there + "/meshes/crates/one.glb", test::GlbBox(2, 1, 1)).ok());
  EXPECT_NE(hash_of("meshes", there + "/meshes"), hash_of("meshes", here + "/meshes"));
  const Outcome bad = Run({kClient, "config", "meshes", dir_ + "/b/content/hdris"});
  ExpectLine(bad, bad.exit, "no file of .glb, .obj, .ply");
  for (const auto& worker : workers) worker->Signal(SIGTERM);
  for (const auto& worker : workers) EXPECT_EQ(worker->Wait(), 0) << worker->Err();
}

// The same without any copy: the content comes through the coordinator's store, whose disk neither
// worker sees.
TEST_F(SecureTest, OwnContentComesThroughTheStoreToWorkersWithoutACopy) {
  const std::string content = dir_ + "/mine";
  for (const char* folder : {"/meshes/crates", "/hdris", "/textures"}) {
    fs::create_directories(content + folder);
  }
  ASSERT_TRUE(WriteFile(content + "/meshes/crates/one.glb", test::GlbBox(1, 2, 1)).ok());
  std::string grey;
  for (int i = 0; i < 8; ++i) grey += "\x80\x80\x80\x81";
  ASSERT_TRUE(WriteFile(content + "/hdris/grey.hdr",
                        std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n") + grey)
                  .ok());
  ASSERT_TRUE(WritePng(content + "/textures/moss_albedo.png", ImageRgb8(8, 8, 90)).ok());
  ASSERT_TRUE(WritePng(content + "/textures/moss_roughness.png", ImageU8(8, 8, 200)).ok());
  const std::string at = content.substr(1);  // As a worker whose picture root is "/" would see it.
  const std::string set =
      "    set:\n"
      "      floating: {count: 4, classes: [own]}\n"
      "      assets: {include: [" +
      at +
      "/meshes]}\n"
      "      materials: {texture_dir: " +
      at +
      "/textures, texture_p: 1, replace_probability: 1}\n"
      "      lighting: {hdri_dir: " +
      at + "/hdris}\n";

  Init();
  Serve({"--tls", Tls("server"), "--store-access", "stream"});
  std::vector<std::unique_ptr<Process>> workers;
  for (const char* name : {"a", "b"}) {
    std::vector<std::string> command = WorkerCommand(Tls("worker-pool"));
    command[6] = name;
    command[8] = dir_ + "/outbox-" + name;
    command.insert(command.end(), {"--cache", dir_ + "/cache-" + name});
    // An operator's folder without the content.
    command.insert(command.end(), {"--picture-root", dir_ + "/outbox-" + name});
    fs::create_directories(dir_ + "/outbox-" + name);
    workers.push_back(std::make_unique<Process>(command));
  }
  const std::string ada = Tls("submitter-ada");
  const Outcome submit = Submit(WriteStudy(set), ada);
  ASSERT_EQ(submit.exit, 0) << submit.err;
  EXPECT_THAT(submit.err, HasSubstr("own content: 3 folders, 4 files"));
  fs::rename(content, dir_ + "/gone");  // Nobody reads it where it was.
  const Outcome watch = Client({"watch", "tiny", "--json"}, ada);
  ASSERT_EQ(watch.exit, 0) << watch.err << watch.out;
  const Outcome fetch = Client({"fetch", "tiny", "--out", dir_ + "/out", "--json"}, ada);
  ASSERT_EQ(fetch.exit, 0) << fetch.err;
  const std::string facts = *ReadFile(dir_ + "/out/v/frames/000000/000/frame.json");
  EXPECT_THAT(facts, HasSubstr("\"class\":\"own:crates\""));
  EXPECT_THAT(facts, HasSubstr("\"class\":\"own:moss\""));
  const Outcome verify = Run({kClient, "verify", dir_ + "/out"});
  EXPECT_EQ(verify.exit, 0) << verify.out;

  // Content that a worker used lies in its cache, and nothing of it anywhere else below.
  int brought = 0;
  for (const char* name : {"a", "b"}) {
    const std::string cache = dir_ + "/cache-" + name + "/content";
    std::error_code error;
    for (const auto& folder : fs::directory_iterator(cache, error)) {
      ++brought;
      EXPECT_TRUE(fs::exists(folder.path() / ".list")) << folder.path();
    }
  }
  EXPECT_GE(brought, 3);
  // A submitter puts content, and nothing else; whatever else is put there is refused.
  EXPECT_TRUE(
      fs::exists(dir_ + "/store/" + ContentPath(*Sha256HexOfFile(dir_ + "/gone/hdris/grey.hdr"))));
  for (const auto& worker : workers) worker->Signal(SIGTERM);
  for (const auto& worker : workers) EXPECT_EQ(worker->Wait(), 0) << worker->Err();
}

TEST_F(SecureTest, AClientThatDoesNotSeeTheStoreStreamsItAndBringsNothingTwice) {
  // A path that leads every process to a disk of its own, by its working folder.
  for (const char* machine : {"/near/store", "/far/store"}) fs::create_directories(dir_ + machine);
  place_ = dir_ + "/near";
  store_ = "/proc/self/cwd/store";
  Serve({"--store-access", "direct"});
  worker_ = std::make_unique<Process>(At(place_, WorkerCommand("")));
  MakeDataset("");
  EXPECT_THAT(fetched_, HasSubstr("\"files_streamed\": 0"));
  StopWorker();
  ASSERT_TRUE(WriteFile(dir_ + "/far/store/.parallax-store", "{\"store\": \"0123\"}\n").ok());
  place_ = dir_ + "/far";
  const auto published = std::count_if(fs::recursive_directory_iterator(dir_ + "/out/v/frames"),
                                       fs::recursive_directory_iterator(),
                                       [](const auto& entry) { return entry.is_regular_file(); });
  EXPECT_GT(published, 4 * 10) << "four pairs with all their maps";
  fs::remove_all(dir_ + "/out");
  const std::vector<std::string> again = {"fetch", "tiny", "--out", dir_ + "/out", "--json"};
  const Outcome streamed = Client(again, "");
  EXPECT_EQ(streamed.exit, 0) << streamed.err;
  EXPECT_THAT(streamed.out, HasSubstr("\"files_streamed\": " + std::to_string(published) + ","));
  EXPECT_THAT(streamed.out, HasSubstr("\"frames_added\": 4"));
  EXPECT_TRUE(ReadFile(dir_ + "/out/v/frames/000000/000/left.png").ok());
  const Outcome nothing_new = Client(again, "");
  EXPECT_THAT(nothing_new.out, HasSubstr("\"files_streamed\": 0"));
  EXPECT_THAT(nothing_new.out, HasSubstr("\"frames_present\": 4"));
}

TEST_F(SecureTest, OtherFiltersNeedNoWorkerAndFetchRewritesTheVerdicts) {
  Serve({"--store-access", "direct"});
  worker_ = std::make_unique<Process>(WorkerCommand(""));
  MakeDataset("");
  StopWorker();
  const std::string index = dir_ + "/out/v/index.jsonl";
  EXPECT_THAT(*ReadFile(index), Not(HasSubstr("\"threshold\":50.0")));

  const Outcome submit = Submit(WriteStudy("    set: {filters: {min_depth_m: 50}}\n"), "");
  ASSERT_EQ(submit.exit, 0) << submit.err;
  const Outcome watch = Client({"watch", "tiny", "--json"}, "");
  ASSERT_EQ(watch.exit, 0) << watch.err << watch.out;
  const Outcome fetch = Client({"fetch", "tiny", "--out", dir_ + "/out", "--json"}, "");
  ASSERT_EQ(fetch.exit, 0) << fetch.err;
  EXPECT_THAT(fetch.out, HasSubstr("\"frames_present\": 4"));
  EXPECT_THAT(fetch.out, HasSubstr("\"frames_added\": 0"));
  EXPECT_THAT(*ReadFile(index), HasSubstr("\"threshold\":50.0"));
  EXPECT_THAT(*ReadFile(dir_ + "/out/v/dataset.json"), HasSubstr("\"pairs_passing_filters\": 0"));
}

TEST_F(SecureTest, AWorkerWithoutTheSharedDiskRefusesAndMakesNothing) {
  Serve({"--store-access", "direct"});
  std::vector<std::string> command = WorkerCommand("");
  command.insert(command.end(), {"--store", dir_ + "/mnt", "--log-level", "error"});
  ExpectLine(Run(command), 1, "there is no such folder on this machine; mount");
  EXPECT_FALSE(fs::exists(dir_ + "/mnt"));
  fs::create_directories(dir_ + "/mnt");
  ExpectLine(Run(command), 1, "is the shared disk mounted here?");
  EXPECT_TRUE(fs::is_empty(dir_ + "/mnt"));
}

TEST_F(SecureTest, EachRoleIsHeldToItsOwn) {
  Init();
  Serve({"--tls", Tls("server")});
  ExpectLine(Client({"submit", WriteStudy()}, Tls("worker-pool")), 4,
             "Submit is for the role submitter or operator");
  ExpectLine(Client({"submit", WriteStudy()}, Tls("read-only-board")), 4, "has the role read-only");
  EXPECT_EQ(Client({"status"}, Tls("read-only-board")).exit, 0);
  std::vector<std::string> command = WorkerCommand(Tls("submitter-ada"));
  command.insert(command.end(), {"--log-level", "error"});
  ExpectLine(Run(command), 3, "Work is for the role worker");
}

TEST_F(SecureTest, ARevokedCertificateIsRefusedWithoutARestart) {
  Init();
  Serve({"--tls", Tls("server")});
  EXPECT_EQ(Client({"status"}, Tls("submitter-ada")).exit, 0);
  fs::copy(Tls("submitter-ada"), dir_ + "/stolen");
  const Outcome init = Run({kCoordinator, "init", dir_ + "/tls", "--revoke", "submitter-ada",
                            "--renew", "submitter-ada"});
  ASSERT_EQ(init.exit, 0) << init.err;
  usleep(1'100'000);  // The coordinator looks once a second.
  ExpectLine(Client({"status"}, dir_ + "/stolen"), 2, "the certificate of 'ada' is revoked");
  EXPECT_EQ(Client({"status"}, Tls("submitter-ada")).exit, 0);
}

TEST_F(SecureTest, AClientOrWorkerWithoutCertificateIsToldWhatToDo) {
  Init();
  Serve({"--tls", Tls("server")});
  ExpectLine(Client({"status"}, ""), 2, "speaks TLS; give --tls DIR");
  std::vector<std::string> command = WorkerCommand("");
  command.insert(command.end(), {"--log-level", "error"});
  ExpectLine(Run(command), 3, "speaks TLS; give --tls DIR");
  ExpectLine(Client({"status"}, dir_), 2, "coordinator init DIR --issue ROLE NAME");
}

TEST_F(SecureTest, WrongAuthorityHostAndDateHaveOneLineEach) {
  Init();
  Serve({"--tls", Tls("server")});
  const std::string other = dir_ + "/other";
  ASSERT_EQ(Run({kCoordinator, "init", other, "--issue", "submitter", "ada"}).exit, 0);
  ExpectLine(Client({"status"}, other + "/submitter-ada"), 2, "/ca.crt did not sign");

  // Certificates of the same authority that `coordinator init` would not make.
  const KeyPair ca = {*ReadFile(Tls("ca/ca.crt")), *ReadFile(Tls("ca/ca.key"))};
  const double now_s = Clock::System().UnixSeconds();
  const auto write = [&](const std::string& folder, const KeyPair& own) {
    fs::create_directories(folder);
    ASSERT_TRUE(WriteFile(folder + "/ca.crt", ca.certificate_pem).ok());
    ASSERT_TRUE(WriteFile(folder + "/tls.crt", own.certificate_pem).ok());
    ASSERT_TRUE(WriteFile(folder + "/tls.key", own.key_pem).ok());
    ASSERT_TRUE(WriteFile(folder + "/revoked", "# none\n").ok());
  };
  const CertificateOrder past = {.name = "ada", .now_unix_s = now_s - 864000, .days = 1};
  write(dir_ + "/expired", *IssueClient(ca, past, Role::kSubmitter));
  ExpectLine(Client({"status"}, dir_ + "/expired"), 2, "/expired/tls.crt expired on ");
  ExpectLine(Run({kCoordinator, "serve", "--db", dir_ + "/x.db", "--store", dir_ + "/store",
                  "--tls", dir_ + "/expired"}),
             2, "/expired/tls.crt expired on ");

  const CertificateOrder today = {.name = "coordinator", .now_unix_s = now_s, .days = 1};
  write(dir_ + "/elsewhere", *IssueServer(ca, today, {"farm.example.org"}));
  coordinator_.reset();
  Serve({"--tls", dir_ + "/elsewhere"});
  ExpectLine(Client({"status"}, Tls("submitter-ada")), 2,
             "certificate for farm.example.org and not for 127.0.0.1");
  coordinator_.reset();
  Serve({});
  ExpectLine(Client({"status"}, Tls("submitter-ada")), 2, "does not speak TLS");
}

TEST_F(SecureTest, OtherAddressesNeedTlsAndThePageNeedsItsToken) {
  Init();
  const std::vector<std::string> serve = {
      kCoordinator,    "serve",    "--db",        dir_ + "/queue.db", "--store",
      dir_ + "/store", "--listen", "127.0.0.1:0", "--http",           "0.0.0.0:0"};
  ExpectLine(Run(serve), 2, "--tls DIR");
  ASSERT_TRUE(WriteFile(Tls("worker-pool") + "/revoked", "# none\n").ok());
  std::vector<std::string> no_token = serve;
  no_token.insert(no_token.end(), {"--tls", Tls("worker-pool")});
  ExpectLine(Run(no_token), 2, "http.token");
  std::vector<std::string> both = serve;
  both.insert(both.end(), {"--tls", Tls("server"), "--insecure"});
  ExpectLine(Run(both), 2, "--tls and --insecure exclude each other");
}

}  // namespace
}  // namespace parallax
