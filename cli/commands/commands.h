#pragma once

#include "common/process/command_line.h"

/// The commands of `parray`. Each function declares a command, its options and what it runs. `line`
/// must outlive the parsing and the run.
namespace parray::commands {

void add_render(CommandLine& line);
void add_film(CommandLine& line);
void add_submit(CommandLine& line);
void add_jobs(CommandLine& line);
void add_show(CommandLine& line);
void add_watch(CommandLine& line);
/// Adds the commands that change a job: pause, resume, cancel, requeue, forget, priority.
void add_steering(CommandLine& line);
void add_fetch(CommandLine& line);
/// Adds the commands that read a job's journal: audit, replay.
void add_journal_commands(CommandLine& line);
void add_workers(CommandLine& line);
void add_keygen(CommandLine& line);
void add_validate(CommandLine& line);
void add_convert(CommandLine& line);
void add_compare(CommandLine& line);
void add_verify(CommandLine& line);
void add_plan(CommandLine& line);
void add_tradeoff(CommandLine& line);
void add_doctor(CommandLine& line);

}  // namespace parray::commands
