#include "coordinator/queue/commands/queue_news.h"

namespace parallax {

void QueueNews::SetObserver(JobQueueObserver* observer) {
  const std::lock_guard lock(mutex_);
  observer_ = observer;
}

JobQueueStats QueueNews::counted() const {
  const std::lock_guard lock(mutex_);
  return counted_;
}

void QueueNews::Publish(const Effects& effects) {
  for (const LeaseRef& lease : effects.granted) book_.Add(lease);
  for (const LeaseRef& lease : effects.ended) book_.Remove(lease);
  ready_.Apply(effects.ready);
  const std::lock_guard lock(mutex_);
  counted_.leases_granted += effects.granted.size();
  counted_.completions += effects.completions;
  counted_.failures += effects.failures;
  counted_.losses += effects.losses;
  counted_.stale_reports += effects.stale;
  counted_.splits += effects.splits;
  counted_.archived_jobs += effects.archived;
  if (observer_ != nullptr) Tell(effects);
}

void QueueNews::Tell(const Effects& effects) {
  for (const LeaseRef& lease : effects.ended) {
    if (!lease.stop) continue;
    v1::AttemptId attempt;
    attempt.set_job_id(lease.job);
    attempt.set_fence(lease.fence);
    observer_->OnStop(lease.worker, attempt, lease.reason);
  }
  if (effects.drains != nullptr) observer_->OnDrains(*effects.drains);
  if (effects.work_ready) observer_->OnWorkReady();
}

}  // namespace parallax
