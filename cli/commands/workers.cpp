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
    throw UsageError("workers " + command.action +
                     " needs the name of a worker, or of a host with --host");
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

/// Returns why a worker gets no leases. For a quarantine, also the machine and the end.
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
  if (std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M", &local) == 0) text[0] = '\0';
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
              "drain: the worker finishes its leases and gets no more. readmit: a drained or "
              "quarantined worker gets leases again")
      .one_of({"drain", "readmit"});
  command.option("NAME", options->name,
                 "Name of the worker. The action also applies to workers of that name that connect "
                 "later");
  command.flag("--host", options->host, "NAME is a host: apply the action to all workers there");
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray workers", "lists them, with speed and time since the last message");
  command.example("parray workers drain node7 --host",
                  "grants no more leases to the workers of a machine");
  command.example("parray workers readmit node7-4711",
                  "grants leases again, also after a quarantine");
  command.on_chosen([options, &chosen] { chosen = [options] { return workers(*options); }; });
}

}  // namespace parray::commands
