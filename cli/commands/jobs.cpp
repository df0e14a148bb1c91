#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <span>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::commands {
namespace {

constexpr auto directions = std::span(job_order_names).subspan<1>();

struct JobsCommand {
  FarmOptions farm;
  bool as_json = false;
  msg::ListJobs wanted;
  bool sorted = false;
  bool largest_first = false;
};

/// Requests the jobs that the list ends with, so that the last line is the newest or the largest.
/// With --order desc, requests the largest jobs and lists them first.
nlohmann::json list_jobs(FarmClient& client, const JobsCommand& command) {
  msg::ListJobs wanted = command.wanted;
  if (command.sorted || command.largest_first) wanted.order = msg::JobOrder::descending;
  msg::Jobs answer = client->list(wanted);
  const bool descends = wanted.order == msg::JobOrder::descending;
  if (descends && !command.largest_first) std::ranges::reverse(answer.jobs);
  if (answer.total > answer.jobs.size()) {
    std::cerr << "parray: the " << (command.largest_first ? "first " : "last ")
              << answer.jobs.size() << " of " << answer.total << " jobs\n";
  }
  return std::move(answer.jobs);
}

int jobs(const JobsCommand& command) {
  FarmClient client(command.farm);
  const nlohmann::json list = list_jobs(client, command);
  if (command.as_json) {
    print_json(list);
    return 0;
  }
  std::map<std::string, std::size_t> waiting;
  std::vector<std::vector<std::string>> rows;
  for (const nlohmann::json& map : list) {
    const JobStatus job = job_status(map);
    if (!job.waits_for.empty()) ++waiting[job.waits_for];
    rows.push_back({std::to_string(job.id),
                    printable(job.state) + (job.frames > 0 ? " " + frames_text(job) : ""),
                    progress_cell(job), left_cell(job), queue_cell(job), error_cell(job),
                    std::to_string(job.priority),
                    std::to_string(job.width) + " x " + std::to_string(job.height),
                    samples_cell(job), printable(job.name) + (job.flag.empty() ? "" : "  (!)")});
  }
  std::cout << table_text(
      {"JOB", "STATE", "DONE", "LEFT", "QUEUE", "ERROR", "PRIORITY", "PIXELS", "SAMPLES", "SCENE"},
      rows);
  std::cout << std::flush;
  for (const auto& [what, count] : waiting) {
    std::cerr << "parray: " + counted(count, "job") + (count == 1 ? " waits" : " wait") +
                     " for: " + printable(what, 500) + "\n";
  }
  return 0;
}

void add_filters(Command& command, JobsCommand& options) {
  command.option("--user", options.wanted.user, "List only jobs of this user")
      .type_name("NAME")
      .forbid_empty();
  command.option("--name", options.wanted.name, "List only jobs with this part in their name")
      .type_name("TEXT")
      .forbid_empty();
  command
      .option(
          "--sort",
          [&options](const std::string& word) {
            options.sorted = true;
            options.wanted.sort =
                static_cast<msg::JobSort>(known_place("value", word, job_sort_names));
          },
          "Sort by this value, the largest last")
      .words({job_sort_names.begin(), job_sort_names.end()});
  command
      .option(
          "--order",
          [&options](const std::string& word) {
            options.largest_first = known_place("direction", word, directions) == 1;
          },
          "asc: the newest job or the largest value last (default); desc: first")
      .words({directions.begin(), directions.end()});
  add_whole_number(command, "--limit", 1, msg::most_listed, options.wanted.limit,
                   "List at most this number of jobs, the newest or those with the largest values");
}

}  // namespace

void add_jobs(CommandLine& line) {
  Command command = line.command("jobs", "List the coordinator's jobs");
  const auto options = std::make_shared<JobsCommand>();
  add_filters(command, *options);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray jobs", "lists the jobs of the coordinator on this machine, newest last");
  command.example("parray jobs --user ann --name water --sort progress",
                  "lists ann's jobs with 'water' in their name, those that are almost done last");
  command.example("parray jobs --coordinator tcp://farm:7400 --json",
                  "lists the jobs of the coordinator at this address as JSON, for scripts");
  command.runs(reading_answers([options] { return jobs(*options); }));
}

}  // namespace parray::commands
