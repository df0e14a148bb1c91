// Commands that change a job: pause, resume, cancel, requeue, forget, priority.
#include <cstdint>
#include <memory>
#include <string>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"

namespace parray::commands {
namespace {

struct SteeringCommand {
  std::uint64_t job = 0;
  std::uint32_t priority = 0;
  FarmOptions farm;
  bool as_json = false;
};

void add_action(CommandLine& line, Action& chosen, const char* help, const char* example,
                msg::JobAction action) {
  const bool prioritise = action == msg::JobAction::prioritise;
  const std::string name(job_action_names[static_cast<std::size_t>(action)]);
  Command command = line.command(prioritise ? "priority" : name, help);
  const auto options = std::make_shared<SteeringCommand>();
  add_job(command, options->job);
  if (prioritise) {
    add_whole_number(
        command, "PRIORITY", 0, 100,
        [options](std::uint64_t value) { options->priority = static_cast<std::uint32_t>(value); },
        "Among the jobs of a user, those with a higher priority are rendered first")
        .required();
  }
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray " + std::string(prioritise ? "priority 7 80" : name + " 7"), example);
  command.on_chosen([options, &chosen, action] {
    chosen = [options, action] {
      FarmClient client(options->farm);
      print_job(client->steer(options->job, action, options->priority), options->as_json);
      return 0;
    };
  });
}

}  // namespace

void add_steering(CommandLine& line, Action& chosen) {
  using enum msg::JobAction;
  add_action(line, chosen, "Grant no more work of a job until it is resumed",
             "keeps the results so far", pause);
  add_action(line, chosen, "Continue a paused job", "continues with the results so far", resume);
  add_action(line, chosen, "Cancel a job; does not change a job that has ended",
             "keeps its results, for requeue", cancel);
  add_action(line, chosen, "Continue a job that has failed or was cancelled",
             "continues with the results so far", requeue);
  add_action(line, chosen, "Delete a job that has ended, with its picture",
             "its number is not used again", forget);
  add_action(line, chosen,
             "Change the priority of a job, from 0 to 100 (submit sets 50 by default)",
             "renders it before your other jobs", prioritise);
}

}  // namespace parray::commands
