#include "cli/usage_error.h"

#include <string_view>
#include <vector>

#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray {
namespace {

std::string did_you_mean(const NearestWord& nearest) {
  return nearest.best().empty() ? "" : ": did you mean " + nearest.best() + "?";
}

std::string unknown_option(const CLI::App& command, const std::string& word) {
  NearestWord nearest(word);
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) nearest.offer("--" + name);
  }
  return "unknown option " + printable(word) + did_you_mean(nearest);
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  NearestWord nearest(word);
  for (const CLI::App* command : app.get_subcommands({})) nearest.offer(command->get_name());
  return "unknown command '" + printable(word) + "'" + did_you_mean(nearest);
}

/// About the first word that nobody expected.
std::string about_extra(const CLI::App& app, const CLI::App& command, const std::string& word) {
  if (word.starts_with("-")) {
    const std::string name = word.substr(0, word.find('='));
    return unknown_option(command, name);
  }
  if (&command == &app) return unknown_command(app, word);
  return "unexpected argument '" + printable(word) + "'";
}

/// "--spp: 1 required N missing" and "--spp: At Most 1 required but received 2", in other words.
std::string about_mismatch(const std::string& message) {
  const std::string option = message.substr(0, message.find(':'));
  const bool missing = message.ends_with("missing");
  return option + (missing ? " needs a value after it" : " may be given only once");
}

}  // namespace

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::vector<std::string> extra = app.remaining(true);
    if (!extra.empty()) message = about_extra(app, command, extra.front());
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    message = about_mismatch(message);
  }
  const std::string help =
      app.get_name() + (chosen.empty() ? "" : " " + command.get_name()) + " --help";
  return message + (message.ends_with("?") ? " See `" : "; see `") + help + "`";
}

}  // namespace parray
