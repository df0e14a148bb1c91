#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/store/inspection.h"
#include "coordinator/store/misplaced.h"
#include "coordinator/store/records.h"
#include "coordinator/store/state_files.h"

namespace parray::store {

/// The database of a state, read from a copy of it, so that the original stays as it is.
struct DatabaseContent {
  bool present = false;
  std::uint64_t version = 0;  ///< of its tables; 0: it has none
  std::string damage{};       ///< why it cannot be read; empty: it can
  Records records{};          ///< empty unless it can be read and has the present version
};

/// Throws RunError when there is no room for the copy.
DatabaseContent read_database_copy(const StateFiles& files);

/// What is wrong with one file of a job.
struct FileDamage {
  enum class Kind : std::uint8_t { rows, picture, scene };
  JobId job = 0;
  Kind kind = Kind::rows;
  std::string line{};
};

/// Reads all rows, pictures and scenes that the records name.
std::vector<FileDamage> verify_files(const StateFiles& files, const Records& records);

/// Whether the file is as `expected` or, where that is null, holds the scene of this digest: its
/// SHA-256.
bool is_scene(const std::filesystem::path& file, const std::string& digest,
              const WholeFile* expected);

/// Everything that is known of a state.
struct Survey {
  DatabaseContent database;
  FoundFiles found;
  Comparison comparison;
  /// Damage of the database, a line each. Not empty: its copies are to be believed.
  std::vector<std::string> grave;
  std::vector<Misplaced> misplaced{};  ///< what has to move away first
  bool copied = false;                 ///< the state is a copy, which never had a database
};

/// Throws InputError when `files` is no state, or one of another version.
Survey survey_state(const StateFiles& files);

}  // namespace parray::store
