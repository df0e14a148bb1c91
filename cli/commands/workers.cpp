#include <array>
#include <ctime>
#include <iostream>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

struct WorkersCommand {
  std::string action;  ///< empty: list them
  std::string name;
  bool host = false;
  FarmOptions farm;
  bool as_json = false;
};

nlohmann::json ask(const WorkersCommand& command) {
  FarmClient client(command.farm);
  if (command.action.empty()) {
    return client->workers();
  }
  if (command.name.empty()) {
    throw UsageError("workers " + command.action + ": name a worker, or a host with --host");
  }
  const msg::WorkerAction action =
      command.action == "drain" ? msg::WorkerAction::drain : msg::WorkerAction::readmit;
  nlohmann::json list = client->steer_workers(action, command.name, command.host);
  if (list.empty()) {
    std::cerr << "parray: no worker of " << printable(command.name)
              << " is connected now; the action applies to workers that connect later\n";
  }
  return list;
}

/// Why a worker gets no leases, of which machine that is said, and when it ends.
std::string reason_of(const nlohmann::json& worker) {
  std::string reason = worker.at("reason").get<std::string>();
  if (worker.at("state") != "quarantined") {
    return reason;
  }
  reason += "; " + worker.value("machine", std::string("its machine"));
  const auto ends = static_cast<std::time_t>(worker.value("quarantine_ends", 0.0));
  if (ends == 0) {
    return reason + ", until readmitted";
  }
  std::tm local{};
  std::array<char, 32> text{};
  localtime_r(&ends, &local);
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M", &local);
  return reason + ", until " + text.data();
}

int workers(const WorkersCommand& command) {
  const nlohmann::json list = ask(command);
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
                    duration_text(worker.at("seconds_silent").get<double>()),
                    printable(worker.at("host").get<std::string>()),
                    printable(reason_of(worker), 300)});
  }
  std::cout << table_text(
      {"WORKER", "STATE", "THREADS", "LEASES", "SPEED", "LAST HEARD", "HOST", "REASON"}, rows);
  if (rows.empty() && command.action.empty()) {
    std::cerr << "parray: no workers are connected: start parray-worker --coordinator " +
                     command.farm.address() + "\n";
  }
  return 0;
}

}  // namespace

void add_workers(CommandLine& line, Action& chosen) {
  Command command =
      line.command("workers", "List the coordinator's workers; drain or readmit them");
  const auto options = std::make_shared<WorkersCommand>();
  command
      .option("ACTION", options->action,
              "drain: no more leases for it, those that it has are traced; readmit: it gets "
              "leases again, whether it was drained or quarantined")
      .one_of({"drain", "readmit"});
  command.option("NAME", options->name,
                 "Worker name; it also applies to workers of that name that connect later");
  command.flag("--host", options->host, "NAME is a host: all workers there");
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray workers", "with their speed, and when they were last heard");
  command.example("parray workers drain node7 --host",
                  "no more leases for any worker of a machine");
  command.example("parray workers readmit node7-4711", "leases again, also after quarantine");
  command.on_chosen([options, &chosen] { chosen = [options] { return workers(*options); }; });
}

}  // namespace parray::commands
