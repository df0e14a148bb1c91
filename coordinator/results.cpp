// What comes back from workers, and what is believed of it.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/bytes.h"
#include "coordinator/coordinator.h"

namespace parray {

/// What the backroom has made of a result.
struct Coordinator::Merged {
  WorkerId worker = 0;
  TracerKey tracer = 0;
  std::string name;
  Epoch epoch = 0;
  LeaseTable::Arrived arrived;
  enum class Kind : std::uint8_t {
    taken,     ///< merged, or equal to what was there
    differs,   ///< from what was there
    damaged,   ///< on its way: to be traced again
    forged,    ///< numbers that tracing cannot have given
    untimely,  ///< the pass is over
  };
  Kind kind = Kind::untimely;
  std::string fault;
  ResultCollector::Taken taken;
  std::vector<std::uint64_t> digests;         ///< of what has come, where it differs
  std::vector<std::uint64_t> merged_digests;  ///< of what is merged, likewise
  TracerKey owner = 0;                        ///< who traced what is merged, likewise
  bool confirmed = false;                     ///< likewise: two agree on it
  bool whole = false;
  std::uint64_t samples = 0;
  std::uint32_t threads = 0;
  double granted_at = 0;  ///< seconds since 1970
  double arrived_at = 0;
  double seconds = 0;
  double build_seconds = 0;
  std::uint64_t accelerator_bytes = 0;
  std::string isa;

  /// For the job's journal.
  [[nodiscard]] std::vector<JournalEntry> entries(const Journal& journal, std::uint32_t pass,
                                                  std::uint64_t digest) const {
    std::vector<JournalEntry> entries;
    if (!journal.knows(tracer)) {
      entries.emplace_back(JournalWorker{tracer, threads, name});
    }
    entries.emplace_back(JournalMerge{pass, tracer, epoch, arrived.range, samples, granted_at,
                                      arrived_at, seconds, digest});
    return entries;
  }
};

void Coordinator::on(Time now, const PeerId& peer, msg::Result& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) {
    return;
  }
  Job* job = job_of(m.job);
  LeaseTable::Arrived arrived;
  if (job != nullptr && job->work && job->work->leases && worker->quarantined.empty()) {
    const std::size_t held = job->work->leases->held_by(worker->id);
    arrived = job->work->leases->arrive(worker->id, m.epoch);
    worker->held -= held - job->work->leases->held_by(worker->id);
  }
  if (arrived.kind == LeaseTable::Arrival::stale) {
    ++tally_.stale;
    send(peer, msg::ResultVerdict{m.job, m.epoch, msg::Verdict::stale});
    return;
  }
  grants_due_ = true;
  take_result(now, *worker, *job, m, arrived);
}

void Coordinator::take_result(Time now, WorkerRecord& worker, Job& job, msg::Result& result,
                              const LeaseTable::Arrived& arrived) {
  auto merged = std::make_shared<Merged>();
  merged->worker = worker.id;
  merged->tracer = worker.key;
  merged->name = worker.hello.name;
  merged->epoch = result.epoch;
  merged->threads = worker.hello.threads;
  merged->granted_at = since_1970(worker.granted(job.record.id, result.epoch, now));
  merged->arrived_at = since_1970(now);
  merged->arrived = arrived;
  merged->seconds = result.seconds;
  merged->build_seconds = result.build_seconds;
  merged->accelerator_bytes = result.accelerator_bytes;
  merged->isa = result.isa;
  const auto work = [merged, store = store_, id = job.record.id, picture = job.work->picture,
                     plan = job.work->plan, pass = job.work->pass, parcel = std::move(result.cells),
                     depth = job.record.settings.max_depth] {
    if (picture->plan() != plan) {
      return;
    }
    const CellRange& range = merged->arrived.range;
    const CellBatch batch = plan->batch(range);
    std::shared_ptr<const TracedCells> cells;
    Bulk packed;
    try {
      if (store != nullptr) {
        packed = parcel.packed(*plan->grid());
      }
      cells = parcel.open(batch, depth);
    } catch (const ChecksumError& error) {
      merged->kind = Merged::Kind::damaged;
      merged->fault = error.what();
      return;
    } catch (const DecodeError& error) {
      merged->kind = Merged::Kind::forged;
      merged->fault = error.what();
      return;
    }
    ResultCollector& collector = picture->collector();
    merged->samples = cells->samples;
    if (merged->arrived.kind == LeaseTable::Arrival::first) {
      merged->taken = collector.take(merged->tracer, *cells);
      if (store != nullptr) {
        store->append_rows(id, picture->cells_entry(merged->tracer, range, packed.data.view()));
      }
      keep_journal(*picture, store, id, merged->entries(picture->journal(), pass, packed.checksum));
    } else {
      merged->digests = collector.digests_of(*cells);
      merged->taken = collector.compare(range, merged->digests);
    }
    merged->whole = picture->framebuffer().whole();
    merged->kind = Merged::Kind::taken;
    if (merged->taken.mismatches > 0) {
      merged->kind = Merged::Kind::differs;
      merged->merged_digests = collector.digests(range);
      const auto owner = collector.tracer_of(range, merged->digests);
      merged->confirmed = !owner;
      merged->owner = owner.value_or(0);
    }
  };
  const auto errands = for_job(job, "taking in a result");
  errands.give([this, work, merged, peer = worker.peer, id = job.record.id,
                generation = job.work->generation]() -> Backroom::Outcome {
    work();
    return {
        [this, merged, id, generation] {
          if (Job* there = job_at_work(id, generation)) {
            note_merged(*there, *merged);
          }
        },
        [this, merged, peer, id] {
          using Kind = Merged::Kind;
          const bool first = merged->arrived.kind == LeaseTable::Arrival::first;
          const msg::Verdict verdict =
              merged->kind == Kind::taken
                  ? (first ? msg::Verdict::accepted : msg::Verdict::duplicate)
                  : (merged->kind == Kind::differs ? msg::Verdict::mismatch : msg::Verdict::stale);
          send(peer, msg::ResultVerdict{id, merged->epoch, verdict});
        }};
  });
}

void Coordinator::note_merged(Job& job, const Merged& merged) {
  grants_due_ = true;
  const bool again = merged.arrived.kind == LeaseTable::Arrival::again;
  LeaseTable& leases = *job.work->leases;
  switch (merged.kind) {
    case Merged::Kind::untimely:
      ++tally_.stale;
      return;
    case Merged::Kind::damaged:
    case Merged::Kind::forged:
      ++tally_.malformed;
      if (!again) {
        leases.give_back(merged.worker, merged.epoch);
      }
      if (merged.kind == Merged::Kind::forged) {
        convict(merged.tracer, merged.name, merged.fault);
      } else {
        warnings_.warn(
            now_, fmt::format("job {} lease {}: result of worker '{}' dropped: {}", job.record.id,
                              lease_number(merged.epoch), merged.name, merged.fault));
      }
      return;
    case Merged::Kind::taken:
    case Merged::Kind::differs:
      break;
  }
  if (!again) {
    for (const WorkerId other : leases.finish(merged.epoch)) {
      if (WorkerRecord* worker = workers_.by_id(other)) {
        --worker->held;
        send(worker->peer, msg::Revoke{job.record.id, merged.epoch});
      }
    }
  }
  if (merged.arrived.kind == LeaseTable::Arrival::first) {
    note_accepted(job, merged);
  } else {
    settle(job, merged);
  }
  if (job.work) {
    end_pass_if_done(job);
  }
}

void Coordinator::note_accepted(Job& job, const Merged& merged) {
  ++tally_.accepted;
  tally_.samples += merged.taken.fresh_samples;
  log_->debug("job {} lease {} accepted from worker {} '{}'", job.record.id,
              lease_number(merged.epoch), merged.worker, merged.name);
  JobWork& work = *job.work;
  work.old_failures = work.failures.size();
  work.samples += merged.taken.fresh_samples;
  work.cells += merged.taken.fresh;
  work.whole = merged.whole;
  work.facts.trace_seconds += merged.seconds;
  work.facts.build_seconds = std::max(work.facts.build_seconds, merged.build_seconds);
  work.facts.accelerator_bytes = std::max(work.facts.accelerator_bytes, merged.accelerator_bytes);
  work.facts.isa = merged.isa;
  WorkerRecord* worker = workers_.by_id(merged.worker);
  if (worker == nullptr) {
    return;
  }
  workers_.measure(*worker, merged.samples, merged.seconds);
  ++worker->accepted;
  if (merged.samples > 0) {
    constexpr double least = 1e-10;
    constexpr double most = 1e3;
    const double price = std::clamp(
        merged.seconds * worker->hello.threads / static_cast<double>(merged.samples), least, most);
    work.price = work.price > 0 ? (work.price + price) / 2 : price;
    price_ = work.price;
  }
  if (work.contributors.insert(worker->id).second) {
    work.facts.threads += worker->hello.threads;
    ++work.facts.workers;
  }
  // Which leases are checked depends on their epochs alone, scattered evenly.
  constexpr std::uint64_t scatter = 0x9E3779B97F4A7C15;
  const double lot = static_cast<double>((merged.epoch * scatter) >> 11) * 0x1p-53;
  if (lot < options_.spot_checks) {
    if (workers_.usable() > 1) {
      work.leases->want_check(merged.arrived.range, {merged.worker});
    } else {
      ++work.unchecked;
    }
  }
}

/// A second opinion has come.
void Coordinator::settle(Job& job, const Merged& merged) {
  auto& disputes = job.work->disputes;
  const auto open = std::find_if(disputes.begin(), disputes.end(),
                                 [&](const Dispute& d) { return d.range == merged.arrived.range; });
  if (open != disputes.end()) {
    decide_dispute(job, static_cast<std::size_t>(open - disputes.begin()), merged);
  } else if (merged.kind == Merged::Kind::differs) {
    ++tally_.mismatch;
    open_dispute(job, merged);
  } else {
    ++tally_.duplicate;
  }
}

void Coordinator::open_dispute(Job& job, const Merged& merged) {
  if (convicted_.contains(merged.owner) || convicted_.contains(merged.tracer)) {
    return;  // compared before what a liar has traced was set back
  }
  if (merged.confirmed) {
    convict(merged.tracer, merged.name, "two others agree on other bits for the same samples");
    return;
  }
  const WorkerRecord* owner = workers_.by_key(merged.owner);
  Dispute dispute;
  dispute.range = merged.arrived.range;
  dispute.claims.push_back({merged.owner, owner == nullptr ? 0 : owner->id,
                            owner == nullptr ? "one that has left" : owner->hello.name,
                            merged.merged_digests});
  dispute.claims.push_back({merged.tracer, merged.worker, merged.name, merged.digests});
  log_->error(
      "job {} lease {}: workers '{}' and '{}' returned different bits for the same samples; a "
      "third "
      "decides",
      job.record.id, lease_number(merged.epoch), dispute.claims[0].name, dispute.claims[1].name);
  job.record.flag =
      fmt::format("workers '{}' and '{}' returned different bits for the same samples",
                  dispute.claims[0].name, dispute.claims[1].name);
  note(job, job.record.flag);
  keep(job);
  job.work->disputes.push_back(std::move(dispute));
  ask_another(job, job.work->disputes.back());
}

/// Another worker is to trace the cells of a dispute; without one the job waits.
void Coordinator::ask_another(Job& job, Dispute& dispute) {
  std::set<WorkerId> heard;
  std::string names;
  for (const Dispute::Claim& claim : dispute.claims) {
    heard.insert(claim.worker);
    names += (names.empty() ? "'" : ", '") + claim.name + "'";
  }
  job.work->leases->want_check(dispute.range, heard);
  const bool somebody = std::any_of(workers_.begin(), workers_.end(), [&](const auto& worker) {
    return worker.second.may_trace() && !heard.contains(worker.second.id);
  });
  if (!somebody) {
    job.pause_reason = "workers " + names +
                       " returned different bits for the same samples, and there is no other to "
                       "decide: start one more worker";
    log_->error("job {} is paused: {}", job.record.id, job.pause_reason);
  }
  grants_due_ = true;
}

void Coordinator::decide_dispute(Job& job, std::size_t index, const Merged& merged) {
  Dispute& dispute = job.work->disputes[index];
  if (std::ranges::any_of(dispute.claims, [&](const auto& claim) {
        return claim.tracer == merged.tracer;  // who says it again is not a second one
      })) {
    ++tally_.duplicate;
    return;
  }
  const std::vector<std::uint64_t>& digests = merged.digests;
  const bool agrees =
      std::any_of(dispute.claims.begin(), dispute.claims.end(),
                  [&](const Dispute::Claim& claim) { return claim.digests == digests; });
  if (!agrees) {
    dispute.claims.push_back({merged.tracer, merged.worker, merged.name, merged.digests});
    ask_another(job, dispute);
    return;
  }
  const std::vector<Dispute::Claim> claims = std::move(dispute.claims);
  job.work->disputes.erase(job.work->disputes.begin() + static_cast<std::ptrdiff_t>(index));
  for (const Dispute::Claim& claim : claims) {
    if (claim.digests != digests) {
      convict(claim.tracer, claim.name, "two others agree on other bits for the same samples");
    }
  }
}

/// No more leases for this process of a worker, and none of its results counts any more, in any
/// job.
void Coordinator::convict(TracerKey tracer, const std::string& name, const std::string& why) {
  log_->error(
      "worker '{}' returns wrong bits ({}): it gets no more leases, and what it alone has "
      "traced is traced again: test that machine",
      name, why);
  convicted_[tracer] = name;
  keep_worker_notes();
  WorkerRecord* worker = workers_.by_key(tracer);
  if (worker != nullptr) {
    workers_.bar(*worker, why, worker->drained);
    scenes_.forget_worker(worker->id);
    worker->held = 0;
  }
  for (const JobId id : std::vector<JobId>(open_jobs_)) {
    Job& job = jobs_.at(id);
    const bool made = job.phase == JobPhase::finishing && job.retry_at == never;
    if (made || !job.work || !job.work->leases) {
      continue;
    }
    if (job.phase == JobPhase::finishing) {  // there was no room for its picture: not yet, then
      job.phase = JobPhase::tracing;
      job.retry_at = never;
    }
    if (worker != nullptr) {
      job.work->leases->drop_worker(worker->id);
    }
    // What it claims decides nothing any more.
    std::erase_if(job.work->disputes, [&](const Dispute& dispute) {
      return std::any_of(dispute.claims.begin(), dispute.claims.end(),
                         [&](const auto& claim) { return claim.tracer == tracer; });
    });
    retract(job, tracer, name);
  }
  grants_due_ = true;
}

/// What a job says of a liar.
static std::string flag_of(const JobPicture::Retraction& retraction, const std::string& name) {
  if (retraction.restarted) {
    return fmt::format("worker '{}' returned wrong bits: the picture was begun again", name);
  }
  std::uint64_t cells = 0;
  for (const CellRange& range : retraction.cells) {
    cells += range.count();
  }
  return fmt::format("worker '{}' returned wrong bits: {} cells were traced again", name, cells);
}

void Coordinator::retract(Job& job, TracerKey tracer, const std::string& name) {
  struct Retracted {
    JobPicture::Retraction retraction;
    bool relied = false;
    std::string flag;
    std::shared_ptr<const WorkPlan> plan;
    std::uint64_t samples = 0;
    std::uint64_t cells = 0;
  };
  const auto retracted = std::make_shared<Retracted>();
  ++job.work->errands;
  const auto errands = for_job(job, "setting back wrong results");
  errands.give([this, retracted, tracer, name, at = since_1970(now_), store = store_,
                id = job.record.id, record = job.record, picture = job.work->picture,
                generation = job.work->generation]() mutable -> Backroom::Outcome {
    retracted->relied = picture->relies_on(tracer);
    if (retracted->relied) {
      retracted->retraction = picture->retract(tracer);
      retracted->flag = flag_of(retracted->retraction, name);
      if (store != nullptr && retracted->retraction.restarted) {
        store->drop_rows(id);
        record.passes = {};  // with the rows: another life must not repeat what lies have decided
      } else if (store != nullptr) {
        store->append_rows(id, picture->retraction_entry(retracted->retraction.cells));
      }
      keep_journal(*picture, store, id,
                   retracted->retraction.restarted
                       ? begun_entries(*picture, at)
                       : std::vector<JournalEntry>{JournalRetraction{picture->passes().pass(), at,
                                                                     retracted->retraction.cells}});
      if (store != nullptr) {
        record.flag = retracted->flag;
        store->put_job(record);
      }
    }
    retracted->plan = picture->plan();
    retracted->samples = picture->framebuffer().counts().samples;
    retracted->cells = picture->collector().done_cells();
    return {[this, retracted, id, generation] {
              Job* there = job_at_work(id, generation);
              if (there == nullptr) {
                return;
              }
              JobWork& work = *there->work;
              --work.errands;
              if (retracted->relied) {
                there->record.flag = retracted->flag;
                note(*there, retracted->flag);
                work.samples = retracted->samples;
                work.cells = retracted->cells;
                if (retracted->retraction.restarted) {
                  there->record.passes = {};
                  restart_leases(*there, *retracted->plan);
                } else {
                  work.leases->put_back(retracted->retraction.cells);
                }
              }
              there->pause_reason.clear();
              grants_due_ = true;
              end_pass_if_done(*there);
            },
            {}};
  });
}

}  // namespace parray
