#include "coordinator/client/farm/farm_policy.h"

#include <algorithm>
#include <cmath>

namespace parallax::client {

Demand DemandOf(const std::vector<v1::StudyStatus>& studies) {
  Demand demand;
  for (const v1::StudyStatus& study : studies) {
    const bool running = study.state() == v1::STUDY_STATE_RUNNING;
    if (running) demand.waiting -= study.held_jobs();
    for (const v1::VariantStatus& variant : study.variants()) {
      for (const v1::JobCount& count : variant.jobs()) {
        // A paused study's workers finish what they have.
        if (count.state() == "LEASED") demand.leased += count.jobs();
        if (running && (count.state() == "READY" || count.state() == "RETRY_WAIT")) {
          demand.waiting += count.jobs();
        }
      }
    }
  }
  return demand;
}

int64_t OtherSlots(const std::vector<v1::WorkerStatus>& workers, const std::string& pilot_prefix) {
  int64_t slots = 0;
  for (const v1::WorkerStatus& worker : workers) {
    const bool takes_work = worker.state() == "idle" || worker.state() == "busy";
    if (takes_work && !worker.name().starts_with(pilot_prefix)) slots += worker.slots();
  }
  return slots;
}

FarmDecision Decide(const FarmView& view, const FarmLimits& limits) {
  FarmDecision decision;
  for (const Pilot& pilot : view.pilots) {
    if (pilot.state == Pilot::State::kPending) ++decision.pending;
    if (pilot.state == Pilot::State::kRunning) ++decision.running;
  }
  const int64_t slots =
      std::max<int64_t>(0, view.demand.waiting + view.demand.leased - view.other_slots);
  const int64_t pilots = (slots + limits.slots_per_pilot - 1) / limits.slots_per_pilot;
  decision.wanted =
      static_cast<int>(std::clamp<int64_t>(pilots, limits.min, std::max(limits.min, limits.max)));

  int excess = decision.pending + decision.running - decision.wanted;
  decision.submit = std::max(0, -excess);
  for (auto pilot = view.pilots.rbegin(); pilot != view.pilots.rend() && excess > 0; ++pilot) {
    if (pilot->state != Pilot::State::kPending) continue;
    decision.cancel.push_back(pilot->id);
    --excess;
  }
  return decision;
}

double SubmissionPause(double interval_s, int fruitless) {
  constexpr double kLongestPause_s = 600;
  const double pause_s = interval_s * std::exp2(std::clamp(fruitless - 1, 0, 20));
  return std::min(pause_s, std::max(interval_s, kLongestPause_s));
}

}  // namespace parallax::client
