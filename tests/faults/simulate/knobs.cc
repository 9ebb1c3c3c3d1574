#include "tests/faults/simulate/knobs.h"

#include <fmt/core.h>

#include "tests/faults/simulate/exact_math.h"

namespace parallax::faults {
namespace {

double LogUniform(Rng& rng, double low, double high) {
  return low * Power(high / low, rng.Uniform());
}
// Mostly absent, so that each fault also comes without the others.
double Sometimes(Rng& rng, double probability, double low, double high) {
  const double value = LogUniform(rng, low, high);
  return rng.Bernoulli(probability) ? value : 0;
}

void DrawCoordinator(Rng& rng, Knobs& knobs) {
  JobQueueOptions& queue = knobs.queue;
  queue.lease_s = knobs.scale * LogUniform(rng, 5, 120);
  queue.scenes_ahead = rng.UniformInt(1, 16);
  queue.max_batch = static_cast<int>(LogUniform(rng, 1, 512));
  queue.checkpoint_pages = static_cast<int>(LogUniform(rng, 8, 2000));
  queue.readers = 1;
  queue.read_deadline_s = 0;  // It is of real time.
  queue.linger_s = 0;
  queue.own_threads = false;
  queue.retry.max_app_failures = rng.UniformInt(1, 4);
  queue.retry.quarantine_workers = rng.UniformInt(2, 4);
  queue.retry.backoff_min_s = knobs.scale * LogUniform(rng, 0.5, 20);
  queue.retry.backoff_max_s = queue.retry.backoff_min_s * LogUniform(rng, 1, 60);
  queue.archive_after_s = rng.Bernoulli(0.3) ? knobs.scale * LogUniform(rng, 5, 500) : 0;
  if (rng.Bernoulli(0.5)) queue.notice_targets = {"webhook"};
  if (rng.Bernoulli(0.2)) {
    knobs.user_running = rng.UniformInt(1, 4);
    queue.limits = *LimitRules::Parse(
        fmt::format("default: {{max_running: {}}}", knobs.user_running), "limits");
  }
  knobs.reconnect_grace_s = queue.lease_s * LogUniform(rng, 0.05, 2);
  knobs.turn_s = queue.lease_s * LogUniform(rng, 1e-5, 1e-2);
  knobs.coordinator_life_s = queue.lease_s * Sometimes(rng, 0.75, 1, 50);
  knobs.power_cut_p = rng.Uniform();
  knobs.disk_errs = rng.Bernoulli(0.2);
  knobs.lie = rng.Bernoulli(0.3) ? static_cast<Lie>(rng.UniformInt(1, 5)) : Lie::kNone;
  knobs.lie_at = rng.UniformInt(2, 5);
  if (knobs.lie != Lie::kNone || knobs.disk_errs) {
    knobs.coordinator_life_s = queue.lease_s * LogUniform(rng, 1, 10);
  }
}

void DrawNetwork(Rng& rng, Knobs& knobs) {
  const double lease_s = knobs.queue.lease_s;
  knobs.delay_s = lease_s * LogUniform(rng, 1e-4, 0.1);
  knobs.loss_p = Sometimes(rng, 0.7, 0.005, 0.3);
  knobs.repeat_p = Sometimes(rng, 0.7, 0.005, 0.3);
  knobs.cut_every_s = lease_s * Sometimes(rng, 0.6, 1, 50);
  knobs.cut_s = lease_s * LogUniform(rng, 0.05, 3);
  knobs.break_every_s = lease_s * Sometimes(rng, 0.6, 0.5, 30);
}

void DrawMachines(Rng& rng, Knobs& knobs) {
  const double lease_s = knobs.queue.lease_s;
  knobs.workers = rng.UniformInt(1, 5);
  knobs.slots = rng.UniformInt(1, 3);
  knobs.drift = LogUniform(rng, 1e-7, 1e-2);
  knobs.worker_life_s = lease_s * Sometimes(rng, 0.6, 1, 50);
  knobs.worker_away_s = lease_s * LogUniform(rng, 0.01, 3);
  knobs.leave_every_s = lease_s * Sometimes(rng, 0.4, 2, 50);
  AgentOptions& agent = knobs.agent;
  agent.slots = knobs.slots;
  agent.grace_s = lease_s * LogUniform(rng, 0.05, 5);
  agent.long_grace_s = 3 * agent.grace_s;
  agent.hand_back_s = lease_s * LogUniform(rng, 0.01, 0.3);
  agent.idle_exit_s = lease_s * Sometimes(rng, 0.2, 0.5, 20);
  agent.connect_timeout_s = lease_s * LogUniform(rng, 0.05, 0.5);
  agent.ahead_s = rng.Bernoulli(0.3) ? 0 : lease_s * LogUniform(rng, 0.005, 0.2);
  agent.max_pending_reports = rng.UniformInt(1, 16);
  agent.backoff_base_s = lease_s * LogUniform(rng, 1e-3, 0.05);
  agent.backoff_cap_s = agent.backoff_base_s * LogUniform(rng, 1, 50);
  agent.reports.timeout_s = lease_s * LogUniform(rng, 0.2, 2);
  agent.reports.backoff_base_s = lease_s * LogUniform(rng, 1e-3, 0.05);
  agent.reports.backoff_cap_s = agent.reports.backoff_base_s * LogUniform(rng, 1, 100);
}

void DrawWork(Rng& rng, Knobs& knobs) {
  const double lease_s = knobs.queue.lease_s;
  knobs.studies = rng.UniformInt(1, 3);
  knobs.pairs = rng.UniformInt(1, 10);
  knobs.trainings_p = rng.Bernoulli(0.5) ? rng.Uniform() : 0;
  knobs.job_s = lease_s * LogUniform(rng, 0.02, 3);
  knobs.fail_p = Sometimes(rng, 0.6, 0.01, 0.3);
  knobs.reject_p = Sometimes(rng, 0.4, 0.01, 0.2);
  knobs.kill_p = Sometimes(rng, 0.4, 0.005, 0.1);
  knobs.order_every_s = lease_s * Sometimes(rng, 0.7, 1, 20);
}

}  // namespace

Knobs DrawKnobs(Rng rng) {
  Knobs knobs;
  knobs.scale = rng.Bernoulli(0.25) ? 0.01 : 1;
  DrawCoordinator(rng, knobs);
  DrawNetwork(rng, knobs);
  DrawMachines(rng, knobs);
  DrawWork(rng, knobs);
  knobs.faults_s = knobs.queue.lease_s * LogUniform(rng, 5, 40);
  knobs.has_files = rng.Bernoulli(0.2) || knobs.lie == Lie::kNoStore;
  knobs.store_lie_every_s = knobs.faults_s * Sometimes(rng, 0.8, 0.1, 1);
  knobs.upgrade_at_s = knobs.faults_s * Sometimes(rng, 0.2, 0.1, 0.9);
  if (knobs.lie != Lie::kNone) return knobs;  // A backup has old positions and leases.
  knobs.has_stream = rng.Bernoulli(0.2);
  knobs.has_search = !knobs.has_stream && rng.Bernoulli(0.1);
  // Failed jobs are retried in the end, and no setting is given up by chance.
  if (knobs.has_stream || knobs.has_search) knobs.queue.archive_after_s = 0;
  if (knobs.has_search) knobs.reject_p = 0;
  if (!knobs.disk_errs && rng.Bernoulli(0.15)) {
    knobs.faults_s = std::max(knobs.faults_s, 15 * knobs.queue.lease_s);
    knobs.crash_loop_at_s = rng.Uniform(0.1, 0.5) * knobs.faults_s;
  }
  return knobs;
}

Knobs WithoutEnd(Knobs knobs) {
  knobs.coordinator_life_s = 0;
  knobs.crash_loop_at_s = 0;
  knobs.upgrade_at_s = 0;
  knobs.disk_errs = false;
  knobs.lie = Lie::kNone;
  knobs.has_files = false;
  knobs.has_stream = false;
  knobs.has_search = false;
  // The model looks at all jobs that ever were to check it.
  knobs.user_running = 0;
  knobs.queue.limits = LimitRules();
  knobs.replaces_studies = true;
  return knobs;
}

}  // namespace parallax::faults
