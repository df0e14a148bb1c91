#include "common/process/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <string_view>
#include <utility>

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::process {
namespace {

std::string did_you_mean(const NearestWord& nearest) {
  return nearest.best().empty() ? "" : ": did you mean " + nearest.best() + "?";
}

std::string unknown_option(const CLI::App& command, const std::string& word) {
  if (word == "-v" || word == "-V") return "unknown option " + word + ": did you mean --version?";
  NearestWord nearest(word);
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) nearest.offer("--" + name);
  }
  return "unknown option " + printable(word) + did_you_mean(nearest);
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  if (word == "version") return "unknown command 'version': did you mean --version?";
  NearestWord nearest(word);
  for (const CLI::App* command : app.get_subcommands({})) nearest.offer(command->get_name());
  return "unknown command '" + printable(word) + "'" + did_you_mean(nearest);
}

/// Returns the message about the first unexpected word.
std::string about_extra(const CLI::App& app, const CLI::App& command, const std::string& word) {
  if (word.starts_with("-")) {
    const std::string name = word.substr(0, word.find('='));
    return unknown_option(command, name);
  }
  if (&command == &app && !app.get_subcommands({}).empty()) return unknown_command(app, word);
  return "unexpected argument '" + printable(word) + "'";
}

/// Rewords CLI11's messages "--spp: 1 required N missing" and "--spp: At Most 1 required but
/// received 2".
std::string about_mismatch(const std::string& message) {
  const std::string option = message.substr(0, message.find(':'));
  if (!message.ends_with("missing")) return option + " may be given only once";
  const std::size_t type = message.find("required ") + 9;
  const std::string values = message.substr(type, message.rfind(' ') - type);
  const bool known = values.find('|') != std::string::npos;
  return option + " needs a value after it" + (known ? ": " + values : "");
}

/// Rewords CLI11's message "--name excludes --remove".
std::string about_exclusion(std::string message) {
  constexpr std::string_view between = " excludes ";
  message.replace(message.find(between), between.size(), " and ");
  return message + " exclude each other: leave one of them out";
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
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    message = about_exclusion(message);
  }
  const std::string help =
      app.get_name() + (chosen.empty() ? "" : " " + command.get_name()) + " --help";
  return message + (message.ends_with("?") ? " See `" : "; see `") + help + "`";
}

/// Returns "-o" and "--output" of "-o,--output", and nothing for an argument such as "SCENE".
std::vector<std::string> names_in(const std::string& names) {
  std::vector<std::string> found;
  for (const std::string_view name : split_at(',', names)) {
    if (name.starts_with("-")) found.emplace_back(name);
  }
  return found;
}

/// Returns the digits of a bound: "0.1", "1000000".
std::string bound_text(double bound) {
  constexpr std::size_t longest = 512;
  std::array<char, longest> digits{};
  char* const end = digits.data() + digits.size();
  return {digits.data(), std::to_chars(digits.data(), end, bound, std::chars_format::fixed).ptr};
}
std::string bound_text(std::integral auto bound) { return std::to_string(bound); }

/// Throws CLI::RequiresError if an option with an environment variable is given without the option
/// that it needs.
void check_needs(const CLI::App& command, const CommandText& text) {
  for (const OptionText& option : text.options) {
    if (option.environment.empty() || option.with.empty()) continue;
    const std::string& name = option.names.back();
    const bool given = std::ranges::count(command.parse_order(), command.get_option(name)) > 0;
    if (given && command.count(option.with) == 0) throw CLI::RequiresError(name, option.with);
  }
}

OptionText help_option() {
  return {.names = {"-h", "--help"}, .value = {}, .text = "Print this help", .heading = "Help"};
}

}  // namespace

Option& Option::required(bool is_required) {
  option_->required(is_required);
  text_->required = is_required;
  return *this;
}

Option& Option::in_order() {
  option_->trigger_on_parse();
  return *this;
}

Option& Option::type_name(const std::string& name) {
  option_->type_name(name);
  text_->value = name;
  return *this;
}

Option& Option::group(const std::string& name) {
  option_->group(name);
  text_->heading = name;
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  text_->default_value = option_->get_default_str();
  return *this;
}

Option& Option::environment(const std::string& name) {
  option_->envname(name);
  text_->environment = name;
  return *this;
}

Option& Option::only_once() {
  option_->multi_option_policy(CLI::MultiOptionPolicy::Throw);
  return *this;
}

Option& Option::one_value_each() {
  option_->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->expected(1);
  text_->repeats = true;
  return *this;
}

Option& Option::forbid_empty() {
  option_->check([](const std::string& text) {
    return text.empty() ? std::string("the value is empty") : std::string();
  });
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& known) {
  option_->check([known](const std::string& text) -> std::string {
    if (std::ranges::find(known, text) != known.end()) return {};
    return "'" + printable(text) + "' is unknown: use one of " + joined(known, ", ");
  });
  return words(known);
}

Option& Option::words(const std::vector<std::string>& words, bool list) {
  text_->words = words;
  text_->list = list;
  return type_name(list ? "WORD,..." : joined(words, "|"));
}

Option& Option::completes(Completes what) {
  text_->completes = what;
  return *this;
}

Option& Option::special() {
  text_->special = true;
  return *this;
}

Option& Option::needs(const Option& other) {
  // CLI11 would also refuse the environment variable alone, so check_needs() does this.
  if (text_->environment.empty()) option_->needs(other.option_);
  if (!other.text_->required) {
    text_->with = other.text_->is_argument() ? other.text_->value : other.text_->names.back();
  }
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option Command::added(CLI::Option* option, const std::string& names, const std::string& value,
                      const std::string& description) {
  OptionText text;
  text.names = names_in(names);
  text.value = text.is_argument() ? names : value;
  text.text = description;
  text_->options.push_back(std::move(text));
  Option made(option, &text_->options.back());
  if (!section_.empty()) made.group(section_);
  if (section_needs_) made.needs(*section_needs_);
  return made;
}

void Command::section(const std::string& heading, std::optional<Option> required) {
  section_ = heading;
  section_needs_ = required;
}

Option Command::option(const std::string& names, std::string& target,
                       const std::string& description) {
  return added(app_->add_option(names, target), names, "TEXT", description);
}

Option Command::option(const std::string& names, std::vector<std::string>& target,
                       const std::string& description) {
  const Option option = added(app_->add_option(names, target), names, "TEXT", description);
  text_->options.back().repeats = true;
  return option;
}

Option Command::option(const std::string& names, std::function<void(const std::string&)> set,
                       const std::string& description) {
  const auto values = std::make_shared<std::vector<std::string>>();
  const auto checked = [names, values, set = std::move(set)](const std::string& text) {
    values->push_back(text);
    try {
      set(text);
    } catch (const InputError& error) {
      throw CLI::ValidationError(names, error.what());
    }
  };
  CLI::Option* option = app_->add_option_function<std::string>(names, checked)->take_last();
  (*called_with_)[option] = values;
  return added(option, names, "TEXT", description);
}

template <typename Number>
Option Command::number(const std::string& names, Number& target, std::type_identity_t<Number> least,
                       std::type_identity_t<Number> most, const std::string& description) {
  const auto check = [least, most](const std::string& text) {
    Number value{};
    const bool converted = CLI::detail::lexical_cast(text, value);
    return converted && value >= least && value <= most  // unlike CLI::Range, refuses NaN
               ? std::string()
               : "Value " + text + " not in range " + bound_text(least) + " to " + bound_text(most);
  };
  return added(app_->add_option(names, target)->check(check), names,
               std::is_integral_v<Number> ? "N" : "X", description);
}

template Option Command::number(const std::string&, int&, int, int, const std::string&);
template Option Command::number(const std::string&, std::size_t&, std::size_t, std::size_t,
                                const std::string&);
template Option Command::number(const std::string&, double&, double, double, const std::string&);

Option Command::flag(const std::string& names, bool& target, const std::string& description) {
  return added(app_->add_flag(names, target), names, "", description);
}

Option Command::on_off(const std::string& name, std::optional<bool>& target,
                       const std::string& description) {
  return option(
             name, [&target](const std::string& text) { target = text == "on"; }, description)
      .one_of({"on", "off"});
}

void Command::renamed(const std::string& old, const std::string& now) {
  app_->add_flag_callback(old, [old, now] { throw CLI::ValidationError(old + " is now " + now); });
}

void Command::example(const std::string& command, const std::string& about) {
  text_->examples.push_back({command, about});
}

void Command::runs(Action action) {
  app_->callback([chosen = chosen_, action = std::move(action)] { *chosen = action; });
}

std::vector<GivenOption> Command::given_options() const {
  std::vector<GivenOption> given;
  const auto add = [&](const CLI::Option* option, const std::string& value) {
    const bool is_flag = option->get_items_expected_max() == 0;
    given.push_back({option->get_name(), option->get_group(), is_flag ? "" : value});
  };
  const std::vector<CLI::Option*> parsed = app_->parse_order();
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    const bool once = std::ranges::count(parsed, option) > 0 && !option->get_trigger_on_parse();
    if (once) add(option, option->results().back());
  }
  std::map<const CLI::Option*, std::size_t> occurrences;
  for (const CLI::Option* option : parsed) {
    if (!option->get_trigger_on_parse()) continue;
    // CLI11 forgets the earlier values of these options.
    const auto values = called_with_->find(option);
    const std::size_t occurrence = occurrences[option]++;
    add(option, values == called_with_->end() ? "" : values->second->at(occurrence));
  }
  return given;
}

CommandLine::CommandLine(const std::string& description, const std::string& program)
    : Command(nullptr, nullptr, &chosen_action_),
      root_(std::make_unique<CLI::App>(description, program)) {
  app_ = root_.get();
  text_ = &program_.self;
  text_->name = program;
  text_->about = description;
  root_->require_subcommand(0, 1);
}

CommandLine::~CommandLine() = default;

void CommandLine::version(const std::string& text) {
  added(root_->set_version_flag("--version", text), "--version", "", "Print the version")
      .group("Help");
}

Command CommandLine::command(const std::string& name, const std::string& description) {
  CommandText text;
  text.name = text_->name + " " + name;
  text.heading = heading_;
  text.about = description;
  program_.commands.push_back(std::move(text));
  return {root_->add_subcommand(name, description), &program_.commands.back(), &chosen_action_};
}

void CommandLine::add_help_command() {
  Command help = command("help", "Print the help of a command, or the list of all");
  help.option("COMMAND", topic_, "Command to explain").completes(Completes::commands);
  help.flag("--all", all_options_, "Show all options, also those that are rarely needed");
  help.example(text_->name + " help " + program_.commands.front().word(),
               "prints the same as --help after the command");
}

ProgramText CommandLine::description() const {
  ProgramText described = program_;
  described.self.options.push_back(help_option());
  for (CommandText& command : described.commands) command.options.push_back(help_option());
  return described;
}

std::string CommandLine::help() const { return help_text(description(), help_columns()); }

/// Returns the help of the command `name`. Throws UsageError if there is none.
std::string CommandLine::help_of(const std::string& name) const {
  for (const CommandText& command : description().commands) {
    if (command.word() == name) return help_text(command, help_columns(), all_options_);
  }
  throw UsageError(unknown_command(*root_, name) + "; see `" + root_->get_name() + " help`");
}

void CommandLine::check_needs() const {
  process::check_needs(*root_, program_.self);
  for (const CommandText& command : program_.commands) {
    process::check_needs(*root_->get_subcommand(command.word()), command);
  }
}

std::optional<std::string> CommandLine::parse(int argc, const char* const* argv) {
  const auto chosen = [this] {
    const std::vector<CLI::App*> commands = root_->get_subcommands();
    return commands.empty() ? std::string() : commands.front()->get_name();
  };
  try {
    root_->parse(argc, argv);
    check_needs();
  } catch (const CLI::CallForHelp&) {
    return chosen().empty() ? help() : help_of(chosen());
  } catch (const CLI::CallForVersion& version) {
    return std::string(version.what()) + "\n";
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_message(*root_, error));
  }
  if (chosen() == "help") return topic_.empty() ? help() : help_of(topic_);
  return std::nullopt;
}

void CommandLine::parse(const std::string& words) {
  try {
    root_->parse(words);
    check_needs();
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
}

}  // namespace parray::process
