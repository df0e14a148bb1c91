// Commands that change jobs: pause, resume, cancel, requeue, forget, priority.
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::commands {
namespace {

struct SteeringCommand {
  std::vector<std::string> named;
  FarmOptions farm;
  bool as_json = false;
};

std::vector<std::uint64_t> jobs_in(const std::vector<std::string>& named) {
  if (named.size() > msg::most_steered) {
    throw InputError("JOB: name at most " + std::to_string(msg::most_steered) + " jobs");
  }
  std::vector<std::uint64_t> jobs;
  for (const std::string& text : named) {
    const auto job = natural_in(text);
    if (!job) throw InputError("JOB: '" + printable(text) + "' is not the number of a job");
    jobs.push_back(*job);
  }
  return jobs;
}

/// Takes the last word, the priority, from the others, which are jobs.
std::uint32_t take_priority(std::vector<std::string>& words) {
  const auto priority = words.size() < 2 ? std::nullopt : natural_in(words.back());
  if (!priority || *priority > 100) {
    throw InputError("PRIORITY: end with a whole number from 0 to 100: parray priority JOB 80");
  }
  words.pop_back();
  return static_cast<std::uint32_t>(*priority);
}

std::string outcome_text(const nlohmann::json& job, msg::JobAction action) {
  if (action == msg::JobAction::forget) return "deleted";
  if (action == msg::JobAction::prioritise) return "priority " + job.at("priority").dump();
  return printable(job.at("state").get<std::string>());
}

/// Prints a line for each job. Returns the exit status: 2 if a job was not changed.
int print_results(const nlohmann::json& results, msg::JobAction action) {
  int status = 0;
  for (const nlohmann::json& result : results) {
    const std::string number = result.at("id").dump();
    if (result.contains("job")) {
      std::cout << "job " + number + ": " + outcome_text(result.at("job"), action) + "\n";
    } else {
      std::cerr << "parray: " + printable(result.at("message").get<std::string>(), 500) + "\n";
      status = 2;
    }
  }
  return status;
}

int steer(const SteeringCommand& command, msg::JobAction action) {
  std::vector<std::string> words = command.named;
  const std::uint32_t priority = action == msg::JobAction::prioritise ? take_priority(words) : 50;
  const std::vector<std::uint64_t> jobs = jobs_in(words);
  FarmClient client(command.farm);
  if (jobs.size() == 1) {
    print_job(client->steer(jobs.front(), action, priority), command.as_json);
    return 0;
  }
  const nlohmann::json results = client->steer(jobs, action, priority);
  if (!command.as_json) return print_results(results, action);
  print_json(results);
  const auto refused = [](const nlohmann::json& result) { return !result.contains("job"); };
  return std::ranges::any_of(results, refused) ? 2 : 0;
}

void add_action(CommandLine& line, const char* help, const char* example, msg::JobAction action) {
  const bool prioritise = action == msg::JobAction::prioritise;
  const std::string name(job_action_names[static_cast<std::size_t>(action)]);
  Command command = line.command(prioritise ? "priority" : name, help);
  const auto options = std::make_shared<SteeringCommand>();
  command
      .option("JOB", options->named,
              prioritise ? "Numbers of jobs, then the priority from 0 to 100: among the jobs of a "
                           "user, those with a higher priority are rendered first"
                         : "Numbers of jobs, as submit prints them")
      .required()
      .type_name(prioritise ? "JOB PRIORITY" : "JOB")
      .completes(Completes::jobs);
  add_json(command, options->as_json);
  options->farm.add_to(command);
  command.example("parray " + std::string(prioritise ? "priority 7 80" : name + " 7"), example);
  command.runs(reading_answers([options, action] { return steer(*options, action); }));
}

}  // namespace

void add_steering(CommandLine& line) {
  using enum msg::JobAction;
  add_action(line, "Grant no more work of a job until it is resumed", "keeps the results so far",
             pause);
  add_action(line, "Continue a paused job", "continues with the results so far", resume);
  add_action(line, "Cancel jobs that have not ended", "keeps its results, for requeue", cancel);
  add_action(line, "Continue a job that has failed or was cancelled",
             "continues with the results so far", requeue);
  add_action(line, "Delete a job that has ended, with its picture", "its number is not used again",
             forget);
  add_action(line, "Change the priority of a job, from 0 to 100 (submit sets 50 by default)",
             "renders it before your jobs of lower priority", prioritise);
}

}  // namespace parray::commands
