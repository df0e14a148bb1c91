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

void check(const WorkersCommand& command) {
  const bool reads = command.action == "show" || command.action == "log";
  if (!command.action.empty() && command.name.empty()) {
    throw UsageError("workers " + command.action + " needs the name of a worker" +
                     (reads ? "" : ", or of a host with --host"));
  }
  if (command.action.empty() && command.host) {
    throw UsageError("--host needs an action and the name of a host: workers drain NODE --host");
  }
  if (reads && command.host) {
    throw UsageError("workers " + command.action + " shows one worker: leave out --host");
  }
}

nlohmann::json ask(const WorkersCommand& command) {
  FarmClient client(command.farm);
  if (command.action.empty()) return client->workers();
  const msg::WorkerAction action =
      command.action == "drain" ? msg::WorkerAction::drain : msg::WorkerAction::readmit;
  nlohmann::json list = client->steer_workers(action, command.name, command.host);
  if (list.empty()) {
    std::cerr << "parray: no worker " << (command.host ? "of host " : "named ")
              << printable(command.name) << " is connected now; "
              << (action == msg::WorkerAction::drain
                      ? "the action applies to workers that connect later\n"
                      : "if it was drained or in quarantine, that has ended\n");
  }
  return list;
}

/// Returns why a worker gets no leases. For a quarantine, also the machine and the end.
std::string reason_of(const nlohmann::json& worker) {
  std::string reason = worker.at("reason").get<std::string>();
  if (worker.at("state") != "quarantined") return reason;
  reason += "; " + worker.value("machine", std::string("its machine"));
  const double ends = worker.value("quarantine_ends", 0.0);
  if (ends == 0) return reason + ", until readmitted";
  const std::string end = moment_text(ends);
  return reason + ", until " + end.substr(0, end.rfind(':'));  // without seconds
}

/// Returns a speed as text. Empty: `speed` is 0 or missing.
std::string speed_cell(const nlohmann::json& worker, const char* key) {
  const double speed = worker.value(key, 0.0);
  return speed > 0 ? with_unit(speed, "samples/s") : "";
}

/// Returns a number of a map, or 0 if it is null or missing.
double number_in(const nlohmann::json& map, const char* key) {
  const auto found = map.find(key);
  return found != map.end() && found->is_number() ? found->get<double>() : 0;
}

std::string tracing_cell(const nlohmann::json& worker) {
  const auto found = worker.find("tracing");
  return found == worker.end() || !found->is_object()
             ? "nothing"
             : "job " + std::to_string(found->at("job").get<std::uint64_t>()) + " for " +
                   duration_text(found->at("seconds").get<double>());
}

/// Returns facts about the machine: "16 processors, 62.8 GiB, load 3.5".
std::string machine_cell(const nlohmann::json& worker) {
  std::string text = printable(worker.value("machine", std::string()), 200);
  if (const double processors = number_in(worker, "processors"); processors > 0) {
    text += ", " + counted(static_cast<std::uint64_t>(processors), "processor");
  }
  if (const double bytes = number_in(worker, "memory_bytes"); bytes > 0) {
    text += ", " + bytes_text(static_cast<std::uint64_t>(bytes));
  }
  const auto load = worker.find("load");
  return load != worker.end() && load->is_number()
             ? text + formatted(", load %.2f", load->get<double>())
             : text;
}

void print_worker(const nlohmann::json& worker) {
  const auto text = [&](const char* key) {
    return printable(worker.value(key, std::string()), 300);
  };
  std::vector<std::pair<std::string, std::string>> facts = {
      {"worker", text("name")},
      {"state", text("state")},
      {"reason", reason_of(worker)},
      {"version", text("version")},
      {"host", text("host")},
      {"machine", machine_cell(worker)},
      {"since", moment_text(worker.value("since", 0.0))},
      {"last heard", duration_text(worker.at("seconds_silent").get<double>()) + " ago"},
      {"threads", std::to_string(worker.at("threads").get<std::uint64_t>())},
      {"traces", tracing_cell(worker)},
      {"speed", speed_cell(worker, "samples_per_second")},
      {"last minute", speed_cell(worker, "contribution")},
      {"results", std::to_string(worker.at("accepted").get<std::uint64_t>())},
      {"failures", std::to_string(worker.value("failures", std::uint64_t{0}))}};
  std::erase_if(facts, [](const auto& fact) { return fact.second.empty(); });
  std::cout << list_text(facts);
  for (const nlohmann::json& failure : worker.value("recent_failures", nlohmann::json::array())) {
    std::cout << moment_text(failure.at("at").get<double>()) << "  job "
              << failure.at("job").get<std::uint64_t>() << ": "
              << printable(failure.at("reason").get<std::string>(), 300) << "\n";
  }
}

int show_worker(const WorkersCommand& command) {
  const nlohmann::json worker = FarmClient(command.farm)->worker(command.name);
  command.as_json ? print_json(worker) : print_worker(worker);
  return 0;
}

int show_log(const WorkersCommand& command) {
  const std::vector<std::string> lines = FarmClient(command.farm)->worker_log(command.name);
  if (command.as_json) {
    print_json({{"lines", lines}});
    return 0;
  }
  for (const std::string& line : lines) std::cout << printable(line, msg::most_log_line) << "\n";
  return 0;
}

int workers(const WorkersCommand& command) {
  check(command);
  if (command.action == "show") return show_worker(command);
  if (command.action == "log") return show_log(command);
  const nlohmann::json list = ask(command);
  if (command.as_json) {
    print_json(list);
    return 0;
  }
  std::vector<std::vector<std::string>> rows;
  for (const nlohmann::json& worker : list) {
    const std::string speed = speed_cell(worker, "samples_per_second");
    rows.push_back({printable(worker.at("name").get<std::string>()),
                    printable(worker.at("state").get<std::string>()),
                    std::to_string(worker.at("threads").get<std::uint64_t>()),
                    std::to_string(worker.at("leases").get<std::uint64_t>()),
                    speed.empty() ? "not measured" : speed, speed_cell(worker, "contribution"),
                    duration_text(worker.at("seconds_silent").get<double>()),
                    printable(worker.at("host").get<std::string>()),
                    printable(reason_of(worker), 300)});
  }
  std::cout << table_text({"WORKER", "STATE", "THREADS", "LEASES", "SPEED", "LAST MINUTE",
                           "LAST HEARD", "HOST", "REASON"},
                          rows);
  if (rows.empty() && command.action.empty()) {
    std::cerr << "parray: no workers are connected: start parray-worker --coordinator " +
                     command.farm.address + "\n";
  }
  return 0;
}

}  // namespace

void add_workers(CommandLine& line) {
  Command command =
      line.command("workers", "List the coordinator's workers; show, drain or readmit them");
  const auto options = std::make_shared<WorkersCommand>();
  command
      .option("ACTION", options->action,
              "show: prints facts about one worker. log: prints the last lines of its log. drain: "
              "the worker finishes its leases and gets no more. readmit: a drained or "
              "quarantined worker gets leases again")
      .one_of({"show", "log", "drain", "readmit"});
  command.option("NAME", options->name,
                 "Name of the worker. drain and readmit also apply to workers of that name that "
                 "connect later");
  command.flag("--host", options->host, "NAME is a host: apply the action to all workers there");
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray workers",
                  "lists them: SPEED is measured while a worker traces, LAST "
                  "MINUTE is what the farm got from it per second");
  command.example("parray workers show node7-4711",
                  "prints its machine, load, failures and what it traces now");
  command.example("parray workers log node7-4711", "prints the last 100 lines of its log");
  command.example("parray workers drain node7 --host",
                  "grants no more leases to the workers of a machine");
  command.example("parray workers readmit node7-4711",
                  "grants leases again, also after a quarantine");
  command.runs(reading_answers([options] { return workers(*options); }));
}

}  // namespace parray::commands
