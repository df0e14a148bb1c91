#include "coordinator/store/state_tools.h"

#include <fcntl.h>

#include <iostream>
#include <memory>
#include <system_error>

#include "coordinator/store/rebuild.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/row_log.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

/// Locks the database of a state against coordinators until the result is destroyed. `exclusive`:
/// takes the lock; otherwise only checks that no coordinator has it. Throws StateInUse if one has.
std::unique_ptr<OpenPath> lock_state(const fs::path& database, bool exclusive) {
  auto file = std::make_unique<OpenPath>(database, exclusive ? O_RDWR : O_RDONLY);
  std::error_code error;
  if (file->get() < 0 || !fs::is_regular_file(database, error)) {
    return file;  // a coordinator would have a database
  }
  flock lock{};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = 0x40000000;  // the bytes that SQLite locks
  lock.l_len = 512;
  const int failed = fcntl(file->get(), exclusive ? F_OFD_SETLK : F_OFD_GETLK, &lock);
  if (failed != 0 || (!exclusive && lock.l_type != F_UNLCK)) {
    throw StateInUse(database.parent_path().string() +
                     ": another process uses this state (a coordinator, parray-mpi or --repair): "
                     "stop it first");
  }
  return file;
}

StateFiles existing_state(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::is_directory(directory, ignored)) {
    throw InputError(directory.string() + ": no such directory: name the directory of --state");
  }
  return {directory, system_disk()};
}

void append(std::vector<std::string>& lines, const std::vector<std::string>& more) {
  lines.insert(lines.end(), more.begin(), more.end());
}

/// Returns one line for each damage.
std::vector<std::string> damage_lines(const StateFiles& files, const Survey& survey) {
  std::vector<std::string> lines = survey.severe;
  for (const Misplaced& misplaced : survey.misplaced) lines.push_back(misplaced.line);
  append(lines, survey.comparison.minor);
  if (survey.severe.empty()) {
    for (const FileDamage& damage : verify_files(files, survey.database.records)) {
      lines.push_back(damage.line);
    }
  }
  return lines;
}

void refuse_source(const StateFiles& from) {
  std::error_code error;
  if (!fs::exists(from.database(), error) && find_files(from).empty()) {
    throw InputError(from.directory().string() + " holds no state: name the directory of --state");
  }
}

void refuse_target(const StateFiles& from, const fs::path& target) {
  std::error_code error;
  const fs::path inside = fs::weakly_canonical(target, error)
                              .lexically_relative(fs::weakly_canonical(from.directory(), error));
  if (!inside.empty() && *inside.begin() != "..") {
    throw InputError(target.string() +
                     " is inside the directory of the state: name a directory outside it");
  }
  if (fs::exists(target, error) && !fs::is_empty(target, error)) {
    throw InputError(target.string() + " is not empty: name a new directory for the copy");
  }
}

/// Returns the `copy_end` of a standby's state, which identifies its full copy; 0: not a standby.
/// Throws InputError while the standby is receiving a full copy.
std::uint64_t full_copy_in(const StateFiles& from) {
  const auto notes = committed_notes(from);
  if (!notes || !notes->notes.contains(replication_note)) return 0;
  const auto replication = replication_state_from_text(notes->notes.at(replication_note));
  if (!replication || replication->role != ReplicaRole::standby) return 0;
  if (replication->copy_end == 0) {
    throw InputError(from.directory().string() +
                     " is the state of a standby that is receiving a full copy: wait until the "
                     "copy is complete, or back up the primary");
  }
  return replication->copy_end;
}

/// Removes the files of a failed backup from `target`, which was empty or missing before. Returns
/// the remedy for the message.
std::string remove_copy(const fs::path& target, bool existed) {
  std::error_code error;
  if (!existed) {
    fs::remove_all(target, error);
  } else {
    for (fs::directory_iterator entry(target, error), end; !error && entry != end;) {
      const fs::path path = entry->path();
      entry.increment(error);
      fs::remove_all(path, error);
    }
  }
  return error ? "remove the unfinished copy and name another directory"
               : "make room there, or name another directory";
}

std::vector<std::string> write_copy(const StateFiles& from, const fs::path& target, double now) {
  const std::uint64_t full_copy = full_copy_in(from);
  StateFiles onto(target, system_disk());
  onto.write(onto.incomplete(), "parray-coordinator --backup has not finished this copy\n");
  std::vector<std::string> lines = copy_state(from, onto);
  if (const std::uint64_t later = full_copy_in(from); later != 0 && later != full_copy) {
    throw InputError(from.directory().string() +
                     ": this standby received a full copy meanwhile: back it up again");
  }
  Survey backup;
  backup.found = find_files(onto);
  backup.severe = {"there is no database"};
  backup.is_backup = true;
  append(lines, rebuild_state(onto, backup, now));
  StateFiles::remove(onto.incomplete());
  return lines;
}

}  // namespace

std::vector<std::string> find_damage(const fs::path& directory) {
  const StateFiles files = existing_state(directory);
  const auto lock = lock_state(files.database(), false);
  return damage_lines(files, survey_state(files));
}

std::vector<std::string> repair_state(const fs::path& directory, double now) {
  StateFiles files = existing_state(directory);
  const auto lock = lock_state(files.database(), true);
  const Survey survey = survey_state(files);
  std::vector<std::string> lines = damage_lines(files, survey);
  if (!lines.empty()) {
    append(lines, rebuild_state(files, survey, now));
    StateFiles::remove(files.incomplete());
  }
  return lines;
}

std::vector<std::string> back_up_state(const fs::path& directory, const fs::path& target,
                                       double now) {
  const StateFiles from = existing_state(directory);
  refuse_source(from);
  refuse_target(from, target);
  std::error_code error;
  const bool existed = fs::exists(target, error);
  try {
    return write_copy(from, target, now);
  } catch (const InputError&) {
    remove_copy(target, existed);
    throw;
  } catch (const StorageFull&) {
    throw InputError(target.string() +
                     ": the copy was not finished, because the disk is full or read-only: " +
                     remove_copy(target, existed));
  } catch (const RunError& failure) {
    throw InputError(target.string() + ": the copy was not finished (" + failure.what() +
                     "): if the target is the cause, " + remove_copy(target, existed));
  }
}

static int print_damage(const std::vector<std::string>& lines, const std::string& if_none) {
  for (const std::string& line : lines) std::cout << line << '\n';
  if (lines.empty()) std::cout << if_none << '\n';
  return lines.empty() ? 0 : 1;
}

int check_command(const std::string& directory) {
  return print_damage(find_damage(directory), directory + ": no damage");
}

int repair_command(const std::string& directory, double now) {
  print_damage(repair_state(directory, now), directory + ": there was no damage");
  return 0;
}

int backup_command(const std::vector<std::string>& places, double now) {
  if (places.size() != 2) {
    throw InputError(
        "--backup needs two directories: write --backup DIR TARGET. DIR has the state, and TARGET "
        "is new or empty");
  }
  return print_damage(back_up_state(places[0], places[1], now), places[1] + ": a complete copy");
}

}  // namespace parray::store
