#include <iostream>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray {
namespace {

struct WorkersCommand {
  FarmOptions farm;
  bool as_json = false;
};

int workers(const WorkersCommand& command) {
  FarmClient client(command.farm);
  const nlohmann::json list = client->workers();
  if (command.as_json) {
    print_json(list);
    return 0;
  }
  std::vector<std::vector<std::string>> rows;
  for (const nlohmann::json& worker : list) {
    const auto speed = worker.at("samples_per_second").get<double>();
    rows.push_back({printable(worker.at("name").get<std::string>()),
                    printable(worker.at("state").get<std::string>()),
                    std::to_string(worker.at("threads").get<std::uint64_t>()),
                    std::to_string(worker.at("leases").get<std::uint64_t>()),
                    speed > 0 ? with_unit(speed, "samples/s") : "not measured",
                    duration_text(worker.at("seconds_silent").get<double>())});
  }
  std::cout << table_text({"WORKER", "STATE", "THREADS", "LEASES", "SPEED", "LAST HEARD"}, rows);
  return 0;
}

}  // namespace

void add_workers(CommandLine& line, Action& chosen) {
  Command command = line.command("workers", "List the coordinator's workers");
  const auto options = std::make_shared<WorkersCommand>();
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.on_chosen([options, &chosen] { chosen = [options] { return workers(*options); }; });
}

}  // namespace parray
