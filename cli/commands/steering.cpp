// What changes a job: cancel, pause, resume.
#include <functional>
#include <memory>
#include <string>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"

namespace parray {
namespace {

using Change = nlohmann::json (Client::*)(JobId);

struct SteeringCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  bool as_json = false;
};

void add_steering(CommandLine& line, Action& chosen, const char* name, const char* help,
                  Change change) {
  Command command = line.command(name, help);
  const auto options = std::make_shared<SteeringCommand>();
  add_job(command, options->job);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.on_chosen([options, &chosen, change] {
    chosen = [options, change] {
      FarmClient client(options->farm);
      print_job(((*client).*change)(options->job), options->as_json);
      return 0;
    };
  });
}

}  // namespace

void add_cancel(CommandLine& line, Action& chosen) {
  add_steering(line, chosen, "cancel", "Cancel a job; one that has ended stays as it is",
               &Client::cancel);
}

void add_pause(CommandLine& line, Action& chosen) {
  add_steering(line, chosen, "pause", "Grant no more work of a job until it is resumed",
               &Client::pause);
}

void add_resume(CommandLine& line, Action& chosen) {
  add_steering(line, chosen, "resume", "Go on with a paused job", &Client::resume);
}

}  // namespace parray
