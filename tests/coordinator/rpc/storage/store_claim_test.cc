// Whether results' files are in a store that is far away: the queue waits for each answer.
#include "coordinator/rpc/storage/store_claim.h"

#include <fmt/core.h>

#include <map>

#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

// Lists what it is told, each time after some seconds.
class FarStore final : public Store {
 public:
  explicit FarStore(FakeClock& clock) : clock_(clock) {}
  std::string Uri() const override { return "far://store"; }
  absl::Status Put(std::string_view, std::string_view) override { return Unimplemented("far"); }
  absl::StatusOr<std::string> Get(std::string_view) const override { return Unimplemented("far"); }
  absl::StatusOr<std::string> GetPiece(std::string_view, int64_t, size_t) const override {
    return Unimplemented("far");
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    ++lists;
    clock_.Advance(6);
    if (is_away) return Unavailable("away");
    std::vector<StoreEntry> found;
    for (const auto& [path, size] : files) {
      if (path.starts_with(std::string(prefix) + "/")) found.push_back({path, size});
    }
    return found;
  }
  absl::Status RemoveTree(std::string_view) override { return Unimplemented("far"); }
  absl::StatusOr<std::string> LocalPath(std::string_view) const override {
    return FailedPrecondition("far");
  }

  std::map<std::string, int64_t> files;
  bool is_away = false;
  mutable int lists = 0;

 private:
  FakeClock& clock_;
};

std::vector<JobKind::OutputFile> FarFrame(int rig) {
  JobKind::OutputFile file;
  file.path = fmt::format("ab/abc/.attempt-7/{:03}/left.png", rig);
  file.size = 3;
  return {file};
}

TEST(FilePresence, AnAttemptIsListedOnceForItsResultsInARowAndAgainBeforeOneIsMissed) {
  FakeClock clock;
  FarStore store(clock);
  FilePresence presence(store, clock);
  for (int rig = 0; rig < 20; ++rig) store.files[FarFrame(rig)[0].path] = 3;
  for (int rig = 0; rig < 20; ++rig) EXPECT_TRUE(presence.Has(FarFrame(rig)));
  EXPECT_EQ(store.lists, 1);
  EXPECT_FALSE(presence.Has(FarFrame(20)));
  EXPECT_EQ(store.lists, 2);
  store.files[FarFrame(20)[0].path] = 3;
  EXPECT_TRUE(presence.Has(FarFrame(20)));
}

TEST(FilePresence, AStoreThatIsAwayIsAskedForATenthOfTheTime) {
  FakeClock clock;
  FarStore store(clock);
  FilePresence presence(store, clock);
  store.is_away = true;
  for (int rig = 0; rig < 20; ++rig) EXPECT_TRUE(presence.Has(FarFrame(rig)));
  EXPECT_EQ(store.lists, 1);
  clock.Advance(61);
  store.is_away = false;
  EXPECT_FALSE(presence.Has(FarFrame(0)));
}

}  // namespace
}  // namespace parallax
