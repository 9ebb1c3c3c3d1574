#include "coordinator/stream/stream_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/coordinator/queue/keeper_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;

class StreamKeeperTest : public KeeperTest<StreamKeeper, v1::StreamStatus> {
 protected:
  StreamKeeperTest() : KeeperTest("drive") {}
  std::unique_ptr<StreamKeeper> MakeKeeper() override {
    return std::make_unique<StreamKeeper>(*queue_, clock_);
  }

  static v1::StudySpec Endless(int64_t chunk_pairs = 4) {
    v1::StudySpec study = MakeStudy({.name = "drive", .pairs = chunk_pairs}).study();
    study.mutable_stream()->set_chunk_pairs(chunk_pairs);
    study.mutable_stream()->set_chunks_ahead(2);
    for (v1::VariantSpec& variant : *study.mutable_variants()) {
      variant.mutable_config()->mutable_filters()->set_min_mean_intensity(10);
    }
    return study;
  }

  void TickStreams() {
    clock_.Advance(1);
    const absl::Status status = keeper_->Tick();
    EXPECT_TRUE(status.ok()) << status;
  }

  // Does all jobs that there are; `mean` is the brightness that the pairs have.
  int Work(double mean = 100) {
    int jobs = 0;
    for (;;) {
      const auto leases = Lease(AnyWorker("w"), 8);
      if (leases.empty()) return jobs;
      for (const v1::Lease& lease : leases) {
        v1::CompleteRequest answer = Answer(lease, "w");
        v1::RenderResult result;
        if (lease.kind() == "render" && result.ParseFromString(answer.result())) {
          for (v1::FrameResult& frame : *result.mutable_frames()) {
            (*frame.mutable_statistics())["mean_intensity"] = frame.rig() == 0 ? mean : 100;
            (*frame.mutable_statistics())["min_depth_m"] = 1;
          }
          SetResult(result, answer);
        }
        EXPECT_EQ(Complete(answer), v1::REPORT_OUTCOME_OK);
        ++jobs;
      }
    }
  }

  static v1::NextPairsRequest Request(int rank = 0, int ranks = 1, int limit = 64) {
    v1::NextPairsRequest request;
    request.set_stream("drive");
    request.set_consumer("train");
    request.set_rank(rank);
    request.set_ranks(ranks);
    request.set_limit(limit);
    request.set_resume(true);
    return request;
  }
  v1::NextPairsReply Next(const v1::NextPairsRequest& request) {
    const auto reply = keeper_->Next(request);
    EXPECT_TRUE(reply.ok()) << reply.status();
    return reply.ok() ? *reply : v1::NextPairsReply();
  }
  // Takes `n` pairs as a consumer does that acknowledges each reply; returns their folders.
  std::vector<std::string> Take(size_t n, int rank = 0, int ranks = 1, int limit = 3) {
    std::vector<std::string> taken;
    v1::NextPairsRequest request = Request(rank, ranks, limit);
    for (int tries = 0; taken.size() < n && tries < 1000; ++tries) {
      request.set_limit(static_cast<int>(std::min<size_t>(limit, n - taken.size())));
      const v1::NextPairsReply reply = Next(request);
      for (const v1::StreamedPair& pair : reply.pairs()) taken.push_back(pair.frame().path());
      request.set_resume(false);
      request.set_position(reply.position());
      request.set_acknowledged(reply.position());
      if (reply.pairs().empty()) {
        TickStreams();
        Work();
      }
    }
    Next(request);  // Acknowledges the last ones.
    EXPECT_EQ(taken.size(), n);
    return taken;
  }
};

TEST_F(StreamKeeperTest, BeginsChunksAheadAndNoMoreWhileNobodyTakesPairs) {
  const v1::StreamStatus status = Open(Endless());
  EXPECT_EQ(status.user(), "submitter ada");
  EXPECT_EQ(status.chunks_begun(), 3);  // Its first, and two ahead.
  Work();
  for (int i = 0; i < 5; ++i) TickStreams();
  EXPECT_EQ(Status().chunks_begun(), 3);
  EXPECT_EQ(Status().chunks_made(), 3);
  EXPECT_EQ(Status().pairs_kept(), 12);
  EXPECT_EQ(Work(), 0);
}

TEST_F(StreamKeeperTest, DeliversEachPairOnceInTheSameOrderInEachRun) {
  Open(Endless());
  const std::vector<std::string> first = Take(40);
  EXPECT_EQ(std::set<std::string>(first.begin(), first.end()).size(), 40u);
  // Another farm, whose workers are restarted and whose coordinator is killed all the time.
  BeginAnew();
  Open(Endless());
  std::vector<std::string> second;
  while (second.size() < 40) {
    for (const std::string& path : Take(4, 0, 1, 1)) second.push_back(path);
    Restart();
  }
  // Fences differ, pairs do not.
  const auto key = [](const std::string& path) {
    return path.substr(0, path.find('/')) + path.substr(path.rfind('/'));
  };
  for (size_t i = 0; i < 40; ++i) EXPECT_EQ(key(first[i]), key(second[i])) << i;
}

TEST_F(StreamKeeperTest, RanksSplitAllPairs) {
  Open(Endless());
  std::set<std::string> all;
  std::vector<std::string> of_rank[2];
  for (int i = 0; i < 10; ++i) {
    for (const int rank : {0, 1}) {
      for (const std::string& path : Take(2, rank, 2)) {
        of_rank[rank].push_back(path);
        EXPECT_TRUE(all.insert(path).second) << path << " came twice";
      }
    }
  }
  EXPECT_EQ(all.size(), 40u);
  EXPECT_LE(Status().chunks_begun(), 13);
}

TEST_F(StreamKeeperTest, ForgetsWhatIsUsedUpAndBeginsAsMuchAnew) {
  Open(Endless());
  Take(4);
  Take(1);
  TickStreams();
  EXPECT_EQ(Status().chunks_forgotten(), 1);
  EXPECT_EQ(Status().chunks_begun(), 4);
  EXPECT_LE(Status().pairs_kept(), 12);
  // The forgotten chunk's study is gone.
  const auto studies = queue_->ListStudies(100);
  ASSERT_TRUE(studies.ok());
  for (const v1::StudyStatus& study : *studies) EXPECT_NE(study.name(), "drive-0");
}

TEST_F(StreamKeeperTest, KeepsPairsForAsLongAsAsked) {
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_keep_s(100);
  Open(study);
  Take(9);
  TickStreams();
  EXPECT_EQ(Status().chunks_forgotten(), 0);
  clock_.Advance(101);
  TickStreams();
  EXPECT_EQ(Status().chunks_forgotten(), 2);
}

TEST_F(StreamKeeperTest, UsesDeliverAPairSeveralTimesAtDifferentTimes) {
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_uses(3);
  Open(study);
  // Rounds of 4, 8, 12, 12, 12 pairs.
  const std::vector<std::string> taken = Take(48);
  std::map<std::string, int> times;
  for (const std::string& path : taken) ++times[path];
  int thrice = 0;
  for (const auto& [path, count] : times) {
    EXPECT_LE(count, 3);
    thrice += count == 3;
  }
  EXPECT_EQ(thrice, 12);  // Of the chunks 0, 1 and 2.
}

TEST_F(StreamKeeperTest, ASlowConsumerHoldsAQuickOneBackUntilItIsSilent) {
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_silent_s(60);
  Open(study);
  v1::NextPairsRequest slow = Request();
  slow.set_consumer("slow");
  Work();
  Next(slow);
  v1::NextPairsRequest quick = Request(0, 1, 1);
  int taken = 0;
  std::string waits_for;
  for (int i = 0; i < 60 && waits_for.empty(); ++i) {
    const v1::NextPairsReply reply = Next(quick);
    taken += reply.pairs_size();
    waits_for = reply.waits_for();
    quick.set_resume(false);
    quick.set_position(reply.position());
    quick.set_acknowledged(reply.position());
  }
  EXPECT_EQ(taken, 12);
  EXPECT_THAT(waits_for, HasSubstr("chunk 3 is not begun: slower consumers come first"));
  // The slow one dies.
  for (int i = 0; i < 61; ++i) {
    TickStreams();
    Next(quick);
  }
  TickStreams();
  Work();
  TickStreams();
  EXPECT_GE(Next(quick).pairs_size(), 1);
  // It comes back to pairs that are gone, and hears where it can go on.
  const auto gone = keeper_->Next(slow);
  EXPECT_TRUE(absl::IsOutOfRange(gone.status())) << gone.status();
  EXPECT_THAT(std::string(gone.status().message()), HasSubstr("are forgotten"));
}

TEST_F(StreamKeeperTest, ConsumersThatAreAllSilentLoseNothing) {
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_silent_s(10);
  Open(study);
  const std::vector<std::string> before = Take(3);
  clock_.Advance(100'000);
  for (int i = 0; i < 3; ++i) TickStreams();
  Restart();
  const std::vector<std::string> after = Take(9);
  std::set<std::string> all(before.begin(), before.end());
  all.insert(after.begin(), after.end());
  EXPECT_EQ(all.size(), 12u);
}

TEST_F(StreamKeeperTest, WhatWasTakenAndNotAcknowledgedComesAgain) {
  Open(Endless());
  Work();
  const v1::NextPairsReply lost = Next(Request(0, 1, 2));  // The consumer dies with it.
  ASSERT_EQ(lost.pairs_size(), 2);
  Restart();
  const v1::NextPairsReply again = Next(Request(0, 1, 2));
  ASSERT_EQ(again.pairs_size(), 2);
  EXPECT_EQ(again.pairs(0).frame().path(), lost.pairs(0).frame().path());
}

TEST_F(StreamKeeperTest, WhatTheDatabaseDidNotKeepDoesNotCount) {
  FailingCommand failing(options_);
  Restart();
  Open(Endless());
  Work();
  v1::NextPairsRequest request = Request(0, 1, 2);
  const auto insist = [&] {
    failing.Set("stream");
    for (int tries = 0; tries < 2; ++tries) EXPECT_FALSE(keeper_->Next(request).ok());
    failing.Clear();
    return Next(request);
  };
  const v1::NextPairsReply first = insist();  // A new consumer.
  ASSERT_EQ(first.pairs_size(), 2);
  request.set_acknowledged(first.position());
  insist();
  options_.fail_point = nullptr;
  Restart();
  const v1::NextPairsReply second = Next(Request(0, 1, 2));
  ASSERT_EQ(second.pairs_size(), 2);
  EXPECT_EQ(second.pairs(0).position(), first.position());
}

TEST_F(StreamKeeperTest, AConsumerMayBeginWithPairsThatAreKept) {
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_keep_s(1000);
  Open(study);
  const std::vector<std::string> first = Take(9);
  v1::NextPairsRequest late = Request(0, 1, 2);
  late.set_consumer("late");
  late.set_resume(false);
  EXPECT_EQ(Next(late).pairs(0).frame().path(), first[0]);
  late.set_resume(true);  // It dies, and goes on where it was.
  EXPECT_EQ(Next(late).pairs(0).frame().path(), first[0]);
}

TEST_F(StreamKeeperTest, PairsThatFailAFilterAreNotDelivered) {
  Open(Endless());
  Work(/*mean=*/3);  // The first rig of each scene is dark.
  TickStreams();
  EXPECT_EQ(Status().pairs_kept(), 6);
  EXPECT_EQ(Status().pairs_filtered_out(), 6);
  const v1::NextPairsReply reply = Next(Request());
  EXPECT_EQ(reply.pairs_size(), 6);
  for (const v1::StreamedPair& pair : reply.pairs()) EXPECT_NE(pair.frame().rig(), 0u);
}

TEST_F(StreamKeeperTest, AChunkThatWasCancelledSaysWhatToDo) {
  Open(Endless());
  ASSERT_TRUE(queue_->Cancel(StudyId{1}, "", "tester").ok());
  TickStreams();
  EXPECT_THAT(Next(Request()).waits_for(), HasSubstr("chunk 0 (study 1) was cancelled"));
  EXPECT_THAT(Status().needs(), HasSubstr("`parallax stream drive --close`"));
}

TEST_F(StreamKeeperTest, AChunkThatFailedIsBegunAgainWhenNobodyCanRetryIt) {
  options_.archive_after_s = 1000;
  Restart();
  Open(Endless());
  while (queue_->GetStudy(StudyId{1})->finished_unix_s() == 0) {
    Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false));
  }
  TickStreams();
  EXPECT_THAT(Status().needs(), HasSubstr("chunk 0 failed: `parallax retry 1` tries again"));
  clock_.Advance(1001);
  while (!*queue_->IsArchived(StudyId{1})) ASSERT_TRUE(queue_->Tick().ok());
  ASSERT_TRUE(absl::IsFailedPrecondition(queue_->Retry(StudyId{1}, "t").status()));
  TickStreams();
  EXPECT_TRUE(absl::IsNotFound(queue_->GetStudy(StudyId{1}).status())) << "nobody needs it";
  TickStreams();
  EXPECT_EQ(Status().needs(), "");
  Restart();
  EXPECT_EQ(Take(12).size(), 12u);
}

TEST_F(StreamKeeperTest, MoreRanksThanPairsInARoundAreRefused) {
  Open(Endless());
  const auto refused = keeper_->Next(Request(0, 5));
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status())) << refused.status();
  EXPECT_THAT(
      std::string(refused.status().message()),
      HasSubstr("consumer 'train' has 5 ranks, and a round of stream 'drive' has 4 pairs, so "
                "some ranks would get none: wanted is a stream whose stream.chunk_pairs is "
                "at least 5"));
  EXPECT_TRUE(keeper_->Next(Request(0, 4)).ok());
}

TEST_F(StreamKeeperTest, EveryRankGetsPairsWhereFiltersLeaveFewerThanRanks) {
  Open(Endless());
  std::vector<v1::NextPairsRequest> requests;
  for (int rank = 0; rank < 3; ++rank) requests.push_back(Request(rank, 3));
  std::map<int, int> taken;
  std::set<std::string> all;
  for (int look = 0; look < 30; ++look) {
    Work(/*mean=*/3);  // Two of the four pairs of a chunk pass.
    TickStreams();
    for (v1::NextPairsRequest& request : requests) {
      const v1::NextPairsReply reply = Next(request);
      request.set_resume(false);
      request.set_position(reply.position());
      request.set_acknowledged(reply.position());
      taken[request.rank()] += reply.pairs_size();
      for (const v1::StreamedPair& pair : reply.pairs()) {
        EXPECT_TRUE(all.insert(pair.frame().path()).second) << "twice";
      }
    }
  }
  const int64_t rounds = Status().chunks_begun() - 3;
  EXPECT_GT(rounds, 9);
  EXPECT_GE(static_cast<int64_t>(all.size()), 2 * rounds) << "none is lost";
  for (int rank = 0; rank < 3; ++rank) EXPECT_GE(taken[rank], rounds / 2) << rank;
}

TEST_F(StreamKeeperTest, TheOpenerMayGiveAStreamAnotherReceiverOfNotices) {
  v1::StudySpec study = Endless();
  study.mutable_notify()->set_url("http://host/secret");
  EXPECT_FALSE(Open(study).study().has_notify()) << "others may open it too";
  study.mutable_notify()->set_url("http://host/other");
  study.set_source_yaml("# to http://host/other");
  const v1::StreamStatus status = Open(study);
  EXPECT_EQ(status.chunks_begun(), 3);
  EXPECT_EQ(status.study().source_yaml(), "# to <host>");
}

TEST_F(StreamKeeperTest, APausedChunkSaysSoAndGoesOn) {
  Open(Endless());
  ASSERT_TRUE(queue_->Pause(StudyId{1}, "", "tester").ok());
  TickStreams();
  EXPECT_THAT(Next(Request()).waits_for(), HasSubstr("chunk 0 is paused: `parallax resume 1`"));
  ASSERT_TRUE(queue_->Resume(StudyId{1}, "", "tester").ok());
  Work();
  TickStreams();
  EXPECT_EQ(Status().needs(), "");
  EXPECT_EQ(Next(Request()).pairs_size(), 12);
}

TEST_F(StreamKeeperTest, ClosingCancelsAndForgetsAndFreesTheName) {
  Open(Endless());
  Take(4);
  ASSERT_TRUE(keeper_->Close("drive").ok());
  EXPECT_TRUE(absl::IsNotFound(keeper_->Next(Request()).status()));
  EXPECT_TRUE(absl::IsAlreadyExists(keeper_->Open(Endless(), "a").status()));
  Restart();
  TickStreams();
  Restart();
  EXPECT_TRUE(absl::IsNotFound(keeper_->List("drive").status()));
  const auto studies = queue_->ListStudies(100);
  ASSERT_TRUE(studies.ok());
  EXPECT_THAT(*studies, testing::IsEmpty());
  EXPECT_EQ(Open(Endless()).chunks_begun(), 3);
}

TEST_F(StreamKeeperTest, ClosingForgetsAChunkThatWasSubmittedAndNotEntered) {
  FailingCommand failing(options_);
  Restart();
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_keep_s(1000);  // Nothing is forgotten before the next chunk is begun.
  Open(study);
  Take(5);  // The second round is begun, so that chunk 3 is wanted.
  failing.Set("stream");
  clock_.Advance(1);
  EXPECT_FALSE(keeper_->Tick().ok());
  failing.Clear();
  Restart();
  ASSERT_EQ(Status().chunks_begun(), 3);
  ASSERT_EQ(queue_->ListStudies(100)->size(), 4u);
  ASSERT_TRUE(keeper_->Close("drive").ok());
  for (int i = 0; i < 2; ++i) TickStreams();
  EXPECT_TRUE(absl::IsNotFound(keeper_->List("drive").status()));
  EXPECT_THAT(*queue_->ListStudies(100), testing::IsEmpty());
}

TEST_F(StreamKeeperTest, AStudyWhoseChunkWasBegunAgainGoesWithItsChunkAtTheLatest) {
  FailingCommand failing(options_);
  options_.archive_after_s = 1000;
  Restart();
  Open(Endless());
  while (queue_->GetStudy(StudyId{1})->finished_unix_s() == 0) {
    Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false));
  }
  TickStreams();
  clock_.Advance(1001);
  while (!*queue_->IsArchived(StudyId{1})) ASSERT_TRUE(queue_->Tick().ok());
  failing.Set("forget");
  EXPECT_FALSE(keeper_->Tick().ok());
  failing.Clear();
  Restart();
  ASSERT_TRUE(queue_->GetStudy(StudyId{1}).ok());
  Take(12);
  for (int i = 0; i < 2; ++i) TickStreams();
  EXPECT_TRUE(absl::IsNotFound(queue_->GetStudy(StudyId{1}).status()));
}

TEST_F(StreamKeeperTest, TheSameStudyAgainIsTheSameStreamAndAnotherIsRefused) {
  Open(Endless());
  EXPECT_EQ(Open(Endless()).chunks_begun(), 3);
  v1::StudySpec other = Endless();
  other.set_seed(99);
  const auto refused = keeper_->Open(other, "tester");
  EXPECT_TRUE(absl::IsAlreadyExists(refused.status())) << refused.status();
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("with other settings"));
}

TEST_F(StreamKeeperTest, AFiniteStudyIsNoStreamAndAnEndlessOneIsNotSubmitted) {
  const auto finite = keeper_->Open(MakeStudy().study(), "tester");
  EXPECT_TRUE(absl::IsInvalidArgument(finite.status()));
  EXPECT_THAT(std::string(finite.status().message()), HasSubstr("`pairs: endless`"));
  v1::SubmitRequest request;
  *request.mutable_study() = Endless();
  const auto submitted = queue_->Submit(request, "tester");
  EXPECT_TRUE(absl::IsInvalidArgument(submitted.status()));
  EXPECT_THAT(std::string(submitted.status().message()), HasSubstr("`parallax stream FILE`"));
}

TEST_F(StreamKeeperTest, AConsumerKeepsItsNumberOfRanks) {
  Open(Endless());
  Next(Request(0, 2));
  const auto other = keeper_->Next(Request(0, 3));
  EXPECT_TRUE(absl::IsInvalidArgument(other.status()));
  EXPECT_THAT(std::string(other.status().message()),
              HasSubstr("consumer 'train' has 2 ranks, and one of 3 asks"));
}

TEST_F(StreamKeeperTest, AConsumerThatLiesBeginsNoChunksAndFillsNoDatabase) {
  Open(Endless());
  v1::NextPairsRequest far = Request();
  far.set_resume(false);
  far.set_position(StreamPosition{.round = 1'000'000, .place = 0}.Packed());
  EXPECT_TRUE(absl::IsOutOfRange(keeper_->Next(far).status()));
  far = Request();
  far.set_acknowledged(StreamPosition{.round = 1'000'000, .place = 0}.Packed());
  EXPECT_TRUE(absl::IsOutOfRange(keeper_->Next(far).status()));
  v1::NextPairsRequest many = Request(0, 5000);
  many.set_consumer("many");
  EXPECT_TRUE(absl::IsResourceExhausted(keeper_->Next(many).status()));
  TickStreams();
  EXPECT_EQ(Status().chunks_begun(), 3);
  EXPECT_EQ(Status().consumers_size(), 1);
}

TEST_F(StreamKeeperTest, AUsersLimitIsSaidAndWaitedFor) {
  options_.limits = *LimitRules::Parse("default: {max_studies: 2}\n", "limits.yaml");
  Restart();
  const v1::StreamStatus status = Open(Endless());
  EXPECT_EQ(status.chunks_begun(), 2);
  EXPECT_THAT(status.needs(), HasSubstr("max_studies 2"));
  Work();
  TickStreams();
  TickStreams();
  EXPECT_EQ(Status().chunks_begun(), 3);
  EXPECT_EQ(Status().needs(), "");
}

}  // namespace
}  // namespace parallax
