#include <iostream>
#include <map>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

struct JobsCommand {
  FarmOptions farm;
  bool as_json = false;
};

int jobs(const JobsCommand& command) {
  FarmClient client(command.farm);
  const nlohmann::json list = client->jobs();
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
                    progress_cell(job), left_cell(job), error_cell(job),
                    std::to_string(job.priority),
                    std::to_string(job.width) + " x " + std::to_string(job.height),
                    samples_cell(job), printable(job.name) + (job.flag.empty() ? "" : "  (!)")});
  }
  std::cout << table_text(
      {"JOB", "STATE", "DONE", "LEFT", "ERROR", "PRIORITY", "PIXELS", "SAMPLES", "SCENE"}, rows);
  std::cout << std::flush;
  for (const auto& [what, count] : waiting) {
    std::cerr << "parray: " + counted(count, "job") + (count == 1 ? " waits" : " wait") +
                     " for: " + printable(what, 500) + "\n";
  }
  return 0;
}

}  // namespace

void add_jobs(CommandLine& line, Action& chosen) {
  Command command = line.command("jobs", "List the coordinator's jobs");
  const auto options = std::make_shared<JobsCommand>();
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray jobs", "lists the jobs of the coordinator on this machine, newest last");
  command.example("parray jobs --coordinator tcp://farm:7400 --json",
                  "asks a coordinator on another machine, for scripts");
  command.on_chosen([options, &chosen] { chosen = [options] { return jobs(*options); }; });
}

}  // namespace parray::commands
