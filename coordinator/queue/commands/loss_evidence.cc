#include "coordinator/queue/commands/loss_evidence.h"

#include <algorithm>

namespace parallax {
namespace {

constexpr size_t kMostRecords = 10'000;  // Jobs that have lost a worker and are not done.

}  // namespace

void LossEvidence::Pass(double now, size_t workers) {
  if (now_ > 0 && now > now_) worker_s_ += (now - now_) * static_cast<double>(workers);
  now_ = std::max(now_, now);
}

void LossEvidence::Begin(int64_t job, uint64_t fence) { leases_[job] = {fence, now_}; }

double LossEvidence::HeldFor(int64_t job, uint64_t fence) const {
  const auto lease = leases_.find(job);
  return lease != leases_.end() && lease->second.fence == fence ? now_ - lease->second.since : 0;
}

void LossEvidence::End(int64_t job, uint64_t fence, LeaseEnd end, const std::string& machine,
                       double progress) {
  const auto lease = leases_.find(job);
  // A lease of an earlier start: nobody knows what became of it while no coordinator looked.
  const bool known = lease != leases_.end() && lease->second.fence == fence;
  const double held_s = HeldFor(job, fence);
  if (known) leases_.erase(lease);
  auto record = records_.find(job);
  if (end == LeaseEnd::kOver) {
    if (record != records_.end()) records_.erase(record);
    return;
  }
  if (record != records_.end() && progress > record->second.progress) {
    records_.erase(record);  // The job lives: an attempt came further than all before.
    record = records_.end();
  }
  if (record != records_.end()) record->second.held_s += held_s;
  if (end != LeaseEnd::kLost || !known) return;
  if (record == records_.end()) {
    if (records_.size() >= kMostRecords) records_.clear();
    record = records_.try_emplace(job).first;
    record->second.lost_before = lost_;
    record->second.worker_s_before = worker_s_;
    record->second.progress = progress;
  }
  record->second.losses[fence] = machine;
}

void LossEvidence::TakeBack(int64_t job, uint64_t fence) {
  const auto record = records_.find(job);
  if (record == records_.end()) return;
  record->second.losses.erase(fence);
  if (record->second.losses.empty()) records_.erase(record);
}

LossHistory LossEvidence::HistoryOf(int64_t job, uint64_t fence, uint64_t lost_now,
                                    const std::string& machine, double progress) const {
  LossHistory history;
  const auto found = records_.find(job);
  const auto lease = leases_.find(job);
  const bool known = lease != leases_.end() && lease->second.fence == fence;
  if (found == records_.end() || !known || progress > found->second.progress) return history;
  const Record& record = found->second;
  history.losses = static_cast<int>(record.losses.size());
  history.all = static_cast<int64_t>(lost_ + lost_now - record.lost_before);
  const double worker_s = worker_s_ - record.worker_s_before;
  const double held_s = record.held_s + HeldFor(job, fence);
  history.share = worker_s > held_s ? held_s / worker_s : 1;
  std::set<std::string> machines{machine};
  for (const auto& [lost, where] : record.losses) machines.insert(where);
  history.machines = static_cast<int>(machines.size());
  return history;
}

}  // namespace parallax
