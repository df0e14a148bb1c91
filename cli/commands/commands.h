#pragma once

#include <CLI/CLI.hpp>
#include <functional>

/// The commands of `parray`, one file each. An add function declares its subcommand and options;
/// once the command line has been understood, `chosen` is what the user asked for.
namespace parray {

/// Does the work and returns the exit status. Throws InputError, RunError or Interrupted.
using Action = std::function<int()>;

void add_render(CLI::App& app, Action& chosen);
void add_submit(CLI::App& app, Action& chosen);
void add_jobs(CLI::App& app, Action& chosen);
void add_show(CLI::App& app, Action& chosen);
void add_watch(CLI::App& app, Action& chosen);
void add_cancel(CLI::App& app, Action& chosen);
void add_fetch(CLI::App& app, Action& chosen);
void add_workers(CLI::App& app, Action& chosen);
void add_validate(CLI::App& app, Action& chosen);
void add_convert(CLI::App& app, Action& chosen);
void add_compare(CLI::App& app, Action& chosen);
void add_plan(CLI::App& app, Action& chosen);
void add_tradeoff(CLI::App& app, Action& chosen);
void add_doctor(CLI::App& app, Action& chosen);

/// All of them, in the order of the help.
void add_commands(CLI::App& app, Action& chosen);

}  // namespace parray
