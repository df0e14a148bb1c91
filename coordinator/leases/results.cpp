// The ends of leases: a result arrives, the worker reports a failure, or the lease is lost.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/bytes.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

void LeaseDesk::on(Time now, const PeerId& peer, msg::Result& m) {
  WorkerRecord* worker = worker_desk_.heard_from(now, peer);
  if (worker == nullptr) return;
  Job* job = farm_.job_of(m.job);
  LeaseTable::Arrived arrived;
  if (job != nullptr && job->work && job->work->leases && worker->quarantined.empty()) {
    const std::size_t held = job->work->leases->held_by(worker->id);
    arrived = job->work->leases->arrive(worker->id, m.epoch, m.count);
    worker->held -= held - job->work->leases->held_by(worker->id);
    revoke_copies(*job, m.epoch, arrived.dropped);
  }
  if (job == nullptr || arrived.kind == LeaseTable::Arrival::stale) {
    ++farm_.tally.stale;
    farm_.send(peer, msg::ResultVerdict{m.job, m.epoch, msg::Verdict::stale});
    return;
  }
  farm_.grants_due = true;
  take_result(now, *worker, *job, m, arrived);
}

void LeaseDesk::take_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result,
                            const LeaseTable::Arrived& arrived) {
  auto merged = std::make_shared<Merged>();
  merged->worker = worker.id;
  merged->tracer = worker.key;
  merged->machine = worker.machine_key;
  merged->ours = worker.ours;
  merged->process_leases = worker.accepted;
  merged->name = worker.hello.name;
  merged->epoch = result.epoch;
  merged->threads = worker.hello.threads;
  const WorkerRecord::Granted granted = worker.granted(job.record.id, result.epoch, now);
  merged->granted_at = farm_.since_1970(granted.at);
  merged->charged = granted.charged;
  merged->arrived_at = farm_.since_1970(now);
  merged->arrived = arrived;
  merged->seconds = result.seconds;
  merged->build_seconds = result.build_seconds;
  merged->accelerator_bytes = result.accelerator_bytes;
  merged->isa = result.isa;
  const auto work = [merged, kept = farm_.store != nullptr, run = job.work->run,
                     plan = job.work->plan, pass = job.work->pass,
                     payload = std::move(result.cells), depth = max_depth_of(job.record.settings)] {
    JobPicture& picture = run->picture();
    if (picture.plan() != plan) return;
    const CellRange& range = merged->arrived.range;
    const CellBatch batch = plan->batch(range);
    std::shared_ptr<const TracedCells> cells;
    Bulk packed;
    try {
      if (kept) packed = payload.packed(*plan->grid());
      cells = payload.open(batch, depth);
    } catch (const ChecksumError& error) {
      merged->kind = Merged::Kind::damaged;
      merged->fault = error.what();
      return;
    } catch (const DecodeError& error) {
      merged->kind = Merged::Kind::invalid;
      merged->fault = error.what();
      return;
    }
    ResultCollector& collector = picture.collector();
    merged->samples = cells->samples;
    if (merged->arrived.kind == LeaseTable::Arrival::first) {
      merged->taken = run->take(merged->machine, *cells, packed.data.view());
      run->add_to_journal(merged->entries(picture.journal(), pass, packed.checksum));
    } else {
      merged->digests = collector.digests_of(*cells);
      merged->taken = collector.compare(range, merged->digests);
    }
    merged->whole = picture.framebuffer().whole();
    merged->kind = Merged::Kind::taken;
    if (merged->taken.mismatches > 0) {
      merged->kind = Merged::Kind::differs;
      merged->differing = collector.differing(range, merged->digests);
      if (merged->arrived.kind == LeaseTable::Arrival::check) {
        // Not logged. If its machine is faulty, retract() lists these cells for another check.
        collector.note_check(merged->machine, range);
      }
    } else if (merged->arrived.kind != LeaseTable::Arrival::first) {
      run->note_check(merged->machine, range);
    }
  };
  auto task = [this, work, merged, peer = worker.peer, id = job.record.id,
               generation = job.work->generation]() -> JobThread::Completion {
    work();
    return {
        [this, merged, id, generation] {
          if (Job* there = farm_.job_at_work(id, generation)) note_merged(*there, *merged);
        },
        [this, merged, peer, id] {
          using Kind = Merged::Kind;
          const bool first = merged->arrived.kind == LeaseTable::Arrival::first;
          const msg::Verdict verdict =
              merged->kind == Kind::taken
                  ? (first ? msg::Verdict::accepted : msg::Verdict::duplicate)
                  : (merged->kind == Kind::differs ? msg::Verdict::mismatch : msg::Verdict::stale);
          farm_.send(peer, msg::ResultVerdict{id, merged->epoch, verdict});
        }};
  };
  job_book_.for_job(job, "merging a result", std::move(task));
}

void LeaseDesk::note_merged(Job& job, const Merged& merged) {
  farm_.grants_due = true;
  const bool again = merged.arrived.kind == LeaseTable::Arrival::again;
  LeaseTable& leases = *job.work->leases;
  switch (merged.kind) {
    case Merged::Kind::late: ++farm_.tally.stale; return;
    case Merged::Kind::damaged:
    case Merged::Kind::invalid:
      ++farm_.tally.malformed;
      if (!again) leases.reject(merged.epoch);
      if (merged.kind == Merged::Kind::invalid) {
        disputes_.quarantine(merged.machine, merged.fault);
      } else {
        farm_.warnings.warn(
            farm_.now,
            fmt::format("job {} lease {}: dropped a result of worker '{}': {}", job.record.id,
                        farm_.lease_number(merged.epoch), merged.name, merged.fault));
      }
      return;
    case Merged::Kind::taken:
    case Merged::Kind::differs: break;
  }
  if (!again) revoke_copies(job, merged.epoch, leases.finish(merged.epoch));
  if (merged.arrived.kind == LeaseTable::Arrival::first) {
    note_accepted(job, merged);
  } else {
    disputes_.compare_result(job, merged);
  }
  if (job.work) job_book_.end_pass_if_done(job);
}

/// Revokes copies of a lease that these workers no longer hold.
void LeaseDesk::revoke_copies(const Job& job, Epoch epoch, const std::vector<WorkerId>& holders) {
  for (const WorkerId holder : holders) {
    if (WorkerRecord* worker = farm_.workers.by_id(holder)) {
      --worker->held;
      farm_.send(worker->peer, msg::Revoke{job.record.id, epoch});
    }
  }
}

void LeaseDesk::note_accepted(Job& job, const Merged& merged) {
  ++farm_.tally.accepted;
  farm_.tally.samples += merged.taken.fresh_samples;
  farm_.log->debug("job {} lease {} accepted from worker {} '{}'", job.record.id,
                   farm_.lease_number(merged.epoch), merged.worker, merged.name);
  JobWork& work = *job.work;
  note_success(job, merged.worker);
  work.samples += merged.taken.fresh_samples;
  work.cells += merged.taken.fresh;
  work.whole = merged.whole;
  work.facts.trace_seconds += merged.seconds;
  work.facts.build_seconds = std::max(work.facts.build_seconds, merged.build_seconds);
  work.facts.accelerator_bytes = std::max(work.facts.accelerator_bytes, merged.accelerator_bytes);
  work.facts.isa = merged.isa;
  disputes_.draw_check(job, merged);
  WorkerRecord* worker = farm_.workers.by_id(merged.worker);
  const double cost = merged.seconds * merged.threads;
  queue_.correct(job.record.user, cost - merged.charged);
  UserAccount& account = farm_.watch.account(job.record.user);
  account.share = job.record.share;
  account.thread_seconds += merged.believable_seconds() * merged.threads;
  const auto fresh = static_cast<double>(merged.taken.fresh_samples);
  farm_.watch.samples.add(farm_.now, fresh);
  if (worker == nullptr) return;
  worker->samples.add(farm_.now, fresh);
  farm_.workers.measure(*worker, merged.samples, merged.seconds);
  ++worker->accepted;
  if (merged.samples > 0) {
    constexpr double least = 1e-10;
    constexpr double most = 1e3;
    const double price = std::clamp(cost / static_cast<double>(merged.samples), least, most);
    work.price = work.price > 0 ? (work.price + price) / 2 : price;
    farm_.price = work.price;
  }
  if (work.contributors.insert(worker->id).second) {
    work.facts.threads += worker->hello.threads;
    ++work.facts.workers;
  }
}

void LeaseDesk::check_losses(Time now, const WorkerRecord& worker) {
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work) continue;
    JobFailures& failures = job.work->failures;
    const bool survived = std::ranges::any_of(failures.all(), [&](const Failure& failure) {
      return failure.by_loss && !failure.excused && failure.worker == worker.key;
    });
    if (survived) {  // another process of its machine joined first, so it was believed dead
      backoff_.forgive(worker.machine, worker.hello.name);
    }
    for (const Failure& death :
         failures.note_joined(worker.machine, worker.key, worker.hello.name)) {
      if (failures.any_success()) {
        backoff_.note_failure(now, death.machine, death.name,
                              !failures.has_succeeded(death.machine));
      }
    }
  }
}

void LeaseDesk::expire_leases(Time now) {
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (!job.work || !job.work->leases) continue;
    for (const auto& expired : job.work->leases->expire(now)) {
      farm_.grants_due = true;
      if (WorkerRecord* worker = farm_.workers.by_id(expired.worker)) {
        --worker->held;
        worker->note_failure(now, id, "it made no progress in time");
      }
      farm_.warnings.warn(now,
                          fmt::format("job {} lease {}: worker {} made no progress in time and "
                                      "lost the lease",
                                      id, farm_.lease_number(expired.lease.epoch), expired.worker));
    }
  }
}

void LeaseDesk::on(Time now, const PeerId& peer, msg::Failed& m) {
  WorkerRecord* worker = worker_desk_.heard_from(now, peer);
  if (worker == nullptr) return;
  farm_.send(peer, msg::Revoke{m.job, m.epoch});  // so that the worker does not repeat it
  Job* job = farm_.job_of(m.job);
  if (job == nullptr || !job->work || !job->work->leases) return;
  const auto range = job->work->leases->range_of(m.epoch);
  if (!range || !job->work->leases->give_back(worker->id, m.epoch)) return;
  --worker->held;
  ++farm_.tally.failed;
  worker->note_failure(now, m.job, m.reason);
  farm_.grants_due = true;
  // Other workers may be able to trace these cells and get leases of this job first.
  worker->denied_jobs[m.job] = now + farm_.options.heartbeat;
  farm_.grant_again_at = std::min(farm_.grant_again_at, now + farm_.options.heartbeat);
  note_failure(now, *job, {*range, worker->machine, worker->key, worker->hello.name, m.reason});
}

void LeaseDesk::note_failure(Time now, Job& job, Failure failure) {
  farm_.warnings.warn(
      now, fmt::format("job {}: worker '{}' could not trace cells [{}, {}): {}", job.record.id,
                       failure.name, failure.range.begin, failure.range.end, failure.reason));
  farm_.note(job,
             fmt::format("worker '{}' could not trace a part: {}", failure.name, failure.reason));
  JobFailures& failures = job.work->failures;
  failures.add(failure);
  const bool others_succeed = std::ranges::any_of(job.work->contributors, [&](WorkerId id) {
    const WorkerRecord* other = farm_.workers.by_id(id);
    return other != nullptr && other->key != failure.worker;
  });
  if (others_succeed && !failure.excused) {
    backoff_.note_failure(now, failure.machine, failure.name,
                          !failures.has_succeeded(failure.machine));
    hold_back(now);
  }
  std::vector<AbleWorker> able;
  for (const auto& [peer, worker] : farm_.workers) {
    if (worker.may_trace()) able.push_back({worker.machine, worker.key});
  }
  const std::uint32_t most =
      job.record.max_failures > 0 ? job.record.max_failures : farm_.options.max_failures;
  if (const auto who = failures.verdict(failure.range, able, most)) {
    job_book_.fail_job(job, fmt::format("{} (failed on {}, last on worker '{}')", failure.reason,
                                        *who, failure.name));
  }
}

/// From the first accepted result on, failures count against the workers, not against the job.
void LeaseDesk::note_success(Job& job, WorkerId id) {
  const WorkerRecord* worker = farm_.workers.by_id(id);
  if (worker == nullptr) return;
  JobFailures& failures = job.work->failures;
  const bool first = !failures.any_success();
  failures.note_success(worker->machine);
  const bool forgiven = backoff_.note_success(worker->machine, worker->hello.name);
  if (!first) {
    if (forgiven) hold_back(farm_.now);
    return;
  }
  for (const Failure& failure : failures.all()) {
    if (!failure.excused && failure.worker != worker->key) {
      backoff_.note_failure(farm_.now, failure.machine, failure.name,
                            failure.machine != worker->machine);
    }
  }
  hold_back(farm_.now);
}

void LeaseDesk::hold_back(Time now) {
  for (auto& [peer, worker] : farm_.workers) {
    const Time until = backoff_.until(worker.machine, worker.hello.name);
    if (until > now && worker.held_back_until != until) {
      farm_.log->warn("worker '{}' failed where others succeed: it gets no leases for {:.0f} s",
                      worker.hello.name, to_seconds(until - now));
      farm_.announce(FarmEventKind::backoff, worker.hello.name,
                     fmt::format("failed where others succeed: no leases for {:.0f} s",
                                 to_seconds(until - now)));
    }
    if ((until > now) != worker.held_back || worker.held_back_until != until) {
      farm_.workers.hold_back(worker, until > now, until);
      farm_.grants_due = true;
    }
    if (until > now) farm_.grant_again_at = std::min(farm_.grant_again_at, until);
  }
}

Time LeaseDesk::next_deadline() const {
  Time next = never;
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.work && job.work->leases) next = std::min(next, job.work->leases->next_deadline());
  }
  return next;
}

void LeaseDesk::forgive(const WorkerRecord& worker) {
  backoff_.forgive(worker.machine, worker.hello.name);
}

}  // namespace parray::coordinator
