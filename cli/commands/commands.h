#pragma once

#include "common/process/command_line.h"
#include "common/process/run_main.h"

/// The commands of `parray`. An add function declares its subcommand and options.
/// After parsing, `chosen` runs the command that the user named; it is empty if the user named
/// none. `line` and `chosen` must outlive the parsing.
namespace parray::commands {

void add_render(CommandLine& line, Action& chosen);
void add_film(CommandLine& line, Action& chosen);
void add_submit(CommandLine& line, Action& chosen);
void add_jobs(CommandLine& line, Action& chosen);
void add_show(CommandLine& line, Action& chosen);
void add_watch(CommandLine& line, Action& chosen);
/// Adds the commands that change a job: pause, resume, cancel, requeue, forget, priority.
void add_steering(CommandLine& line, Action& chosen);
void add_fetch(CommandLine& line, Action& chosen);
/// Adds the commands that read a job's journal: audit, replay.
void add_journal_commands(CommandLine& line, Action& chosen);
void add_workers(CommandLine& line, Action& chosen);
void add_keygen(CommandLine& line, Action& chosen);
void add_validate(CommandLine& line, Action& chosen);
void add_convert(CommandLine& line, Action& chosen);
void add_compare(CommandLine& line, Action& chosen);
void add_verify(CommandLine& line, Action& chosen);
void add_plan(CommandLine& line, Action& chosen);
void add_tradeoff(CommandLine& line, Action& chosen);
void add_doctor(CommandLine& line, Action& chosen);

}  // namespace parray::commands
