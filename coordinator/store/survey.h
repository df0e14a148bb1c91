#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/store/inspection.h"
#include "coordinator/store/records.h"
#include "coordinator/store/state_files.h"

namespace parray::store {

/// The content of a state's database.
struct DatabaseContent {
  bool present = false;       ///< the file exists
  std::uint64_t version = 0;  ///< of its tables; 0: it has none
  std::string damage{};       ///< why it cannot be read; empty: undamaged
  Records records{};          ///< empty unless the database is readable and of the present version
};

/// A damaged or missing file of a job.
struct FileDamage {
  enum class Kind : std::uint8_t { rows, picture, scene };
  JobId job = 0;
  Kind kind = Kind::rows;
  std::string line{};  ///< the message
};

/// Reads all results, pictures and scenes that the records name. Returns the damaged and missing
/// ones.
std::vector<FileDamage> verify_files(const StateFiles& files, const Records& records);

/// Returns whether the file has the `expected` size and checksum or, if that is null, the SHA-256
/// `digest`.
bool is_scene(const std::filesystem::path& file, const std::string& digest,
              const WholeFile* expected);

/// Everything that is known about a state.
struct Survey {
  DatabaseContent database;
  FoundFiles found;
  Comparison comparison;
  /// Damage of the database, or an unfinished backup; one line each. If there is any, only the
  /// copies are reliable.
  std::vector<std::string> severe;
  std::vector<Misplaced> misplaced{};  ///< paths that a repair must move away first
  bool is_backup = false;              ///< a new backup, which has no database yet
};

/// Examines a state. Throws InputError if `files` is no state or one of another version.
Survey survey_state(const StateFiles& files);

}  // namespace parray::store
