#include "common/process/command_line.h"

#include <CLI/CLI.hpp>
#include <sstream>
#include <string_view>
#include <utility>

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
  if (&command == &app && !app.get_subcommands({}).empty()) return unknown_command(app, word);
  return "unexpected argument '" + printable(word) + "'";
}

/// "--spp: 1 required N missing" and "--spp: At Most 1 required but received 2", in other words.
std::string about_mismatch(const std::string& message) {
  const std::string option = message.substr(0, message.find(':'));
  const bool missing = message.ends_with("missing");
  return option + (missing ? " needs a value after it" : " may be given only once");
}

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

template <typename Number>
Option number_option(CLI::App& app, const std::string& names, Number& target, Number least,
                     Number most, const std::string& description) {
  return Option(app.add_option(names, target, description)->check(CLI::Range(least, most)));
}

}  // namespace

Option& Option::required(bool is_required) {
  option_->required(is_required);
  return *this;
}

Option& Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option& Option::group(const std::string& name) {
  option_->group(name);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::environment(const std::string& name) {
  option_->envname(name);
  return *this;
}

Option& Option::only_once() {
  option_->multi_option_policy(CLI::MultiOptionPolicy::Throw);
  return *this;
}

Option& Option::one_value_each() {
  option_->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->expected(1);
  return *this;
}

Option& Option::forbid_empty() {
  option_->check([](const std::string& text) {
    return text.empty() ? std::string("the name is empty") : std::string();
  });
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option Command::option(const std::string& names, std::string& target,
                       const std::string& description) {
  return Option(app_->add_option(names, target, description));
}

Option Command::option(const std::string& names, std::vector<std::string>& target,
                       const std::string& description) {
  return Option(app_->add_option(names, target, description));
}

Option Command::option(const std::string& names, std::function<void(const std::string&)> set,
                       const std::string& description) {
  const auto checked = [names, set = std::move(set)](const std::string& text) {
    try {
      set(text);
    } catch (const InputError& error) {
      throw CLI::ValidationError(names, error.what());
    }
  };
  return Option(app_->add_option_function<std::string>(names, checked, description)->take_last());
}

Option Command::number(const std::string& names, int& target, int least, int most,
                       const std::string& description) {
  return number_option(*app_, names, target, least, most, description);
}

Option Command::number(const std::string& names, std::size_t& target, std::size_t least,
                       std::size_t most, const std::string& description) {
  return number_option(*app_, names, target, least, most, description);
}

Option Command::number(const std::string& names, double& target, double least, double most,
                       const std::string& description) {
  return number_option(*app_, names, target, least, most, description);
}

Option Command::flag(const std::string& names, bool& target, const std::string& description) {
  return Option(app_->add_flag(names, target, description));
}

void Command::on_chosen(std::function<void()> chosen) { app_->callback(std::move(chosen)); }

std::vector<GivenOption> Command::given_options() const {
  std::vector<GivenOption> given;
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    if (option->count() > 0) {
      given.push_back({option->get_name(), option->get_group(), option->results().back()});
    }
  }
  return given;
}

CommandLine::CommandLine(const std::string& description, const std::string& program)
    : Command(nullptr), root_(std::make_unique<CLI::App>(description, program)) {
  app_ = root_.get();
  root_->require_subcommand(0, 1);
}

CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& text) { root_->set_version_flag("--version", text); }

void CommandLine::footer(const std::string& text) { root_->footer(text); }

Command CommandLine::command(const std::string& name, const std::string& description) {
  return Command(root_->add_subcommand(name, description));
}

std::string CommandLine::help() const { return root_->help(); }

std::optional<std::string> CommandLine::parse(int argc, const char* const* argv) {
  try {
    root_->parse(argc, argv);
  } catch (const CLI::Success& asked) {
    std::ostringstream text;
    root_->exit(asked, text, text);
    return text.str();
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_message(*root_, error));
  }
  return std::nullopt;
}

void CommandLine::parse(const std::string& words) {
  try {
    root_->parse(words);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
}

}  // namespace parray
