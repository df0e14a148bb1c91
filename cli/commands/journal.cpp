// Commands that read a job's journal: show, audit and replay.
#include <array>
#include <iostream>
#include <memory>

#include "cli/check/audit/audit.h"
#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/base/bytes.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

using nlohmann::json;

struct JournalCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  bool as_json = false;
};

std::string remedy_without_journal(const std::string& state, const std::string& job) {
  if (state == "done") return "the coordinator no longer keeps it: submit the scene again";
  if (state == "paused") return "it begins with the next result: parray resume " + job;
  if (state == "cancelled" || state == "failed") {
    return "it is " + state + ": parray requeue " + job + " continues it";
  }
  return "wait for its first result";
}

std::vector<JournalEntry> decoded(const std::string& journal, std::uint64_t job) {
  try {
    return read_journal(journal);
  } catch (const DecodeError& error) {
    throw RunError(damaged_journal(job, error.what()));
  }
}

std::vector<JournalEntry> entries_of(const Client::JobJournal& journal, std::uint64_t job) {
  if (journal.journal.empty()) {
    const std::string number = std::to_string(job);
    throw InputError("job " + number + " has no journal: " +
                     remedy_without_journal(journal.job.value("state", std::string()), number));
  }
  return decoded(journal.journal, job);
}

void print_time_spent(const TimeSpent& spent) {
  if (spent.threads == 0) return;
  const auto share = [](double part) { return formatted("%.0f %%", 100 * part); };
  std::cout << duration_text(spent.seconds) << " with " << counted(spent.threads, "thread")
            << " of " << counted(spent.workers, "worker") << ": " << share(spent.tracing)
            << " tracing, " << share(spent.start) << " until they had the scene, "
            << share(spent.between) << " between leases, " << share(spent.tail) << " at the end\n";
}

int show(const JournalCommand& command) {
  FarmClient client(command.farm);
  const json job = client->show(command.job);
  print_job(job, command.as_json);
  const JobStatus status = job_status(job);
  if (!command.as_json && status.frames == 0 && status.ended()) {
    print_time_spent(time_spent(decoded(client->journal(command.job).journal, command.job)));
  }
  return 0;
}

json audit_to_json(const Audit& audit, const std::string& sha256) {
  json workers = json::array();
  for (const Audit::Worker& worker : audit.workers) {
    workers.push_back({{"name", worker.name},
                       {"threads", worker.threads},
                       {"leases", worker.leases},
                       {"cells", worker.cells},
                       {"seconds", worker.seconds}});
  }
  return {
      {"complete", audit.complete()}, {"problems", audit.problems},    {"passes", audit.passes},
      {"cells", audit.cells},         {"merged", audit.merged},        {"set_back", audit.set_back},
      {"leases", audit.leases},       {"workers", std::move(workers)}, {"image_sha256", sha256}};
}

void print_audit(const Audit& audit, const std::string& sha256, std::uint64_t job) {
  for (const std::string& problem : audit.problems) std::cout << problem << "\n";
  std::cout << "job " << job << ": " << audit.merged << " of " << counted(audit.cells, "cell")
            << " of " << (audit.passes == 1 ? "1 pass" : std::to_string(audit.passes) + " passes")
            << " merged, " << (audit.problems.empty() ? "each once" : "with problems") << ", in "
            << counted(audit.leases, "lease") << "; " << counted(audit.set_back, "cell")
            << " removed because of faulty machines\n";
  std::vector<std::vector<std::string>> rows;
  for (const Audit::Worker& worker : audit.workers) {
    rows.push_back({printable(worker.name), std::to_string(worker.threads),
                    std::to_string(worker.leases), std::to_string(worker.cells),
                    duration_text(worker.seconds)});
  }
  std::cout << table_text({"WORKER", "THREADS", "LEASES", "CELLS", "TRACING"}, rows);
  if (!sha256.empty()) std::cout << "the stored picture has this image_sha256: " << sha256 << "\n";
}

int audit(const JournalCommand& command) {
  FarmClient client(command.farm);
  const Client::JobJournal journal = client->journal(command.job);
  const bool done = !journal.report.empty();
  Audit audit = audit_journal(entries_of(journal, command.job));
  if (done && audit.problems.empty() && audit.merged != audit.cells) {
    audit.problems.push_back("the job is done, but " + std::to_string(audit.cells - audit.merged) +
                             " cells have not been merged");
  }
  // fetch() compares the picture with the hash in the report.
  const std::string sha256 =
      done ? client->fetch(command.job).report.value("image_sha256", std::string()) : "";
  command.as_json ? print_json(audit_to_json(audit, sha256))
                  : print_audit(audit, sha256, command.job);
  return audit.problems.empty() ? 0 : 1;
}

int replay(const JournalCommand& command) {
  FarmClient client(command.farm);
  const auto journal = entries_of(client->journal(command.job), command.job);
  constexpr std::array<std::uint32_t, 5> copies = {1, 2, 4, 8, 16};
  json document = json::array();
  std::vector<std::vector<std::string>> rows;
  for (const SchedulePolicy policy : {SchedulePolicy::static_split, SchedulePolicy::guided,
                                      SchedulePolicy::factoring, SchedulePolicy::weighted}) {
    rows.push_back({std::string(name_of(policy))});
    for (const std::uint32_t times : copies) {
      const Replayed replayed = replay_job(journal, policy, times);
      rows.back().push_back(duration_text(replayed.seconds) + ", " +
                            formatted("%.0f %%", 100 * replayed.efficiency));
      document.push_back({{"schedule", name_of(policy)},
                          {"workers_times", times},
                          {"seconds", replayed.seconds},
                          {"efficiency", replayed.efficiency},
                          {"leases", replayed.leases}});
    }
  }
  if (command.as_json) {
    print_json(document);
    return 0;
  }
  std::cout << "time of tracing and efficiency, with 1 to 16 times the job's workers:\n"
            << table_text({"SCHEDULE", "1", "2", "4", "8", "16"}, rows);
  return 0;
}

void add_command(CommandLine& line, const char* name, const char* help, const char* example,
                 int (*run)(const JournalCommand&)) {
  Command command = line.command(name, help);
  const auto options = std::make_shared<JournalCommand>();
  add_job(command, options->job);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray " + std::string(name) + " 7", example);
  command.runs(reading_answers([options, run] { return run(*options); }));
}

}  // namespace

void add_show(CommandLine& line) {
  add_command(line, "show", "Show one job",
              "prints its state, its error so far, what it waits for, and its history", show);
}

void add_journal_commands(CommandLine& line) {
  add_command(
      line, "audit",
      "Check in a job's journal that every sample was merged exactly once; list the job's workers",
      "works also during the render", audit);
  add_command(line, "replay",
              "Predict a job's time with other schedules or more workers, from its recorded costs",
              "compares all schedules, with 1, 2, 4, 8 and 16 times the job's workers", replay);
}

}  // namespace parray::commands
