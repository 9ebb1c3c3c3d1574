// A simulated training that takes the pairs of a stream: one or two ranks that ask, acknowledge,
// die and resume. It knows the order in which the pairs must come.
#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "coordinator/stream/stream_order.h"
#include "tests/faults/simulate/coordinator.h"
#include "tests/faults/simulate/users/client.h"
#include "tests/faults/simulate/world.h"

namespace parallax::faults {

class SimConsumer {
 public:
  // `client`, whose network it shares, and the others must outlive the consumer.
  SimConsumer(World& world, SimCoordinator& coordinator, SimClient& client);

  void Start();
  // Returns whether it has had all its pairs, and its stream is closed and gone.
  bool is_done() const { return is_done_; }

 private:
  struct Rank {
    uint32_t number = 0;
    bool resumes = true;
    uint64_t position = 0;      // The first that it wants.
    uint64_t used = 0;          // It has used up everything before; a death forgets it.
    uint64_t acknowledged = 0;  // Answered: nothing before comes again.
    uint64_t told = 0;          // The highest that was sent.
    int64_t call = 0;           // The newest.
  };
  using Pair = std::tuple<int64_t, std::string, uint32_t, uint32_t>;  // Chunk, variant, scene, rig.

  uint32_t PairsOfRound(int64_t round) const;
  // Returns the rank's first place at a position or after it.
  uint64_t FirstFrom(const Rank& rank, uint64_t position) const;
  void Ask(Rank& rank);
  void AskLater(Rank& rank);
  void Take(Rank& rank, const v1::NextPairsRequest& request, const v1::NextPairsReply& reply);
  void CheckReply(const Rank& rank, const v1::NextPairsRequest& request,
                  const v1::NextPairsReply& reply);
  bool HasAll() const;
  void CheckOrder();
  void Close();
  void RetryChunks();

  World& world_;
  SimCoordinator& coordinator_;
  SimClient& client_;
  Rng dice_;
  const v1::StudySpec study_;
  const int64_t rounds_;  // It takes so many.
  std::vector<Rank> ranks_;
  std::map<uint64_t, Pair> pairs_;  // All that came, by position.
  bool closes_ = false;
  bool is_done_ = false;
};

}  // namespace parallax::faults
