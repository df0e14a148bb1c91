#include <iostream>
#include <memory>

#include "cli/check/audit/time_spent.h"
#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/base/bytes.h"
#include "common/base/error.h"

namespace parray::commands {
namespace {

TimeSpent time_spent_on(std::uint64_t job, const std::string& journal) {
  try {
    return time_spent(read_journal(journal));
  } catch (const DecodeError& error) {
    throw RunError(damaged_journal(job, error.what()));
  }
}

void print_time_spent(const TimeSpent& spent) {
  if (spent.threads == 0) return;
  const auto share = [](double part) { return formatted("%.0f %%", 100 * part); };
  std::cout << duration_text(spent.seconds) << " with " << counted(spent.threads, "thread")
            << " of " << counted(spent.workers, "worker") << ": " << share(spent.tracing)
            << " tracing, " << share(spent.start) << " until they had the scene, "
            << share(spent.between) << " between leases, " << share(spent.tail) << " at the end\n";
}

struct ShowCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  bool as_json = false;
};

int show(const ShowCommand& command) {
  FarmClient client(command.farm);
  const nlohmann::json job = client->show(command.job);
  print_job(job, command.as_json);
  const JobStatus status = job_status(job);
  if (!command.as_json && status.frames == 0 && status.ended()) {
    print_time_spent(time_spent_on(command.job, client->journal(command.job).journal));
  }
  return 0;
}

}  // namespace

void add_show(CommandLine& line, Action& chosen) {
  Command command = line.command("show", "Show one job");
  const auto options = std::make_shared<ShowCommand>();
  add_job(command, options->job);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray show 7",
                  "prints its state, its error so far, what it waits for, and its history");
  command.on_chosen([options, &chosen] { chosen = [options] { return show(*options); }; });
}

}  // namespace parray::commands
