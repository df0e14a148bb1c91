#pragma once

#include <memory>
#include <string>

#include "common/base/error.h"
#include "common/log/logger.h"
#include "proto/clock.h"
#include "proto/keys.h"

namespace parray::coordinator {

/// Logs when the lists of allowed keys become unusable (unreadable, or writable by other users),
/// and when they are usable again.
class KeyWatch {
 public:
  /// `keys`: the folder with the lists; empty: there is nothing to watch.
  KeyWatch(const std::string& keys, std::shared_ptr<spdlog::logger> log)
      : keys_(keys), log_(std::move(log)) {}

  /// Checks the lists at most every two seconds, however often it is called.
  void look(Time now) {
    constexpr Time pause = seconds(2);
    if (keys_.empty() || now < look_at_) return;
    look_at_ = now + pause;
    std::string problem;
    try {
      check_key_lists(keys_);
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (problem == problem_) return;
    problem_ = problem;
    if (problem.empty()) {
      log_->info("the lists of keys in {} are readable again and apply", keys_);
    } else {
      log_->error("{}; until you correct it, the previous lists apply", problem);
    }
  }

 private:
  const std::string keys_;
  const std::shared_ptr<spdlog::logger> log_;
  Time look_at_{};
  std::string problem_;
};

}  // namespace parray::coordinator
