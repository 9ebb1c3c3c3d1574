// Calls of jobs outlive a store that is away or busy for a moment.
#include "worker/agent/attempts/patient_store.h"

#include <gtest/gtest.h>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "tests/folder_test.h"
#include "tests/worker/agent/attempts/scripted_store.h"
#include "worker/agent/attempts/job_run.h"

namespace parallax {
namespace {

class PatientStoreTest : public FolderTest {
 protected:
  // Says `error` to the next `failures` calls.
  void Refuse(const absl::Status& error, int failures) {
    far_->error = error;
    far_->failures = failures;
    far_->calls = alive_ = 0;
  }

  const std::shared_ptr<ScriptedStore> far_ = std::make_shared<ScriptedStore>();
  CancelToken cancel_;
  int alive_ = 0;
  const std::shared_ptr<Store> store_ = MakePatientStore(far_, cancel_, [this] { ++alive_; });
};

TEST_F(PatientStoreTest, CallsAreRepeatedAndEachTryIsASignOfLife) {
  for (const absl::Status& error :
       {Unavailable("away"), DeadlineExceeded("slow"), Cancelled("stalled")}) {
    Refuse(error, 2);
    EXPECT_EQ(store_->GetPiece("a", 0, 9).value_or(""), "bytes") << error;
    EXPECT_EQ(alive_, 3);
    Refuse(error, 1);
    EXPECT_TRUE(store_->Put("a", "b").ok()) << error;
    EXPECT_EQ(alive_, 2);
  }
}

TEST_F(PatientStoreTest, OtherErrorsEndACallAndAFullStoreEndsReadsOnly) {
  for (const absl::Status& error : {NotFound("none"), Aborted("no longer yours")}) {
    Refuse(error, 1);
    EXPECT_EQ(store_->Get("a").status().code(), error.code());
    EXPECT_EQ(far_->calls, 1);
  }
  Refuse(ResourceExhausted("full"), 1);
  EXPECT_TRUE(absl::IsResourceExhausted(store_->List("a").status()));
  Refuse(ResourceExhausted("full"), 1);
  EXPECT_TRUE(store_->Put("a", "b").ok());
}

TEST_F(PatientStoreTest, AfterACancellationACallIsTriedOnce) {
  cancel_.Cancel();
  Refuse(Unavailable("away"), 2);
  EXPECT_TRUE(absl::IsUnavailable(store_->Put("a", "b")));
  EXPECT_EQ(far_->calls, 1);
}

TEST_F(PatientStoreTest, AFolderOfThisMachineIsLeftAsItIs) {
  const std::shared_ptr<Store> local = *OpenStore(dir_ + "/store");
  EXPECT_EQ(MakePatientStore(local, cancel_, [] {}), local);
  EXPECT_EQ(MakePatientStore(nullptr, cancel_, [] {}), nullptr);
}

// Leaves two files for the agent to send.
class TwoFilesJob final : public JobHandler {
 public:
  TwoFilesJob() : JobHandler("two", /*writes_output=*/true) {}
  absl::StatusOr<JobOutcome> Run(std::string_view, const AttemptFolder& folder, const CancelToken&,
                                 const JobProgressFn&) override {
    JobOutcome outcome;
    for (const char* name : {"one", "two"}) {
      RETURN_IF_ERROR(WriteFile(folder.dir + "/" + name, name));
      outcome.files.push_back({name, 3, Sha256Hex(name)});
    }
    return outcome;
  }
};

TEST_F(PatientStoreTest, SendingTellsThatTheJobLivesAtEachTryOfEachFile) {
  Refuse(Unavailable("away"), 2);
  TwoFilesJob job;
  int told = 0, lives = 0;
  const JobProgressFn progress([&](double, std::string_view, const JobFigures&) { ++told; },
                               nullptr, [&] { ++lives; });
  AttemptFolder folder;
  folder.dir = dir_;
  folder.path = "work/.attempt-1";
  folder.send_to = folder.store = far_;
  const auto outcome = RunJob(&job, v1::Lease(), folder, cancel_, progress);
  EXPECT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_EQ(told, 1);
  EXPECT_EQ(lives, 4);
}

}  // namespace
}  // namespace parallax
