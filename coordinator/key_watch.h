#pragma once

#include <spdlog/logger.h>

#include <memory>
#include <string>

#include "common/base/error.h"
#include "proto/clock.h"
#include "proto/tokens.h"

namespace parray {

/// Tells when the lists of keys are not followed any more, and when they are again.
class KeyWatch {
 public:
  KeyWatch(const std::string& keys, std::shared_ptr<spdlog::logger> log)
      : keys_(keys), log_(std::move(log)) {}

  void look(Time now) {
    constexpr Time rest = seconds(2);
    if (keys_.empty() || now < look_at_) return;
    look_at_ = now + rest;
    std::string problem;
    try {
      check_key_lists(keys_);
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (problem == problem_) return;
    problem_ = problem;
    if (problem.empty()) {
      log_->info("the lists in {} are followed again", keys_);
    } else {
      log_->error("{}; until then what the lists said before counts", problem);
    }
  }

 private:
  const std::string keys_;
  const std::shared_ptr<spdlog::logger> log_;
  Time look_at_{};
  std::string problem_;
};

int print_lines(const std::vector<std::string>& lines, const std::string& if_none) {
  for (const std::string& text : lines) {
    std::cout << text << '\n';
  }
  if (lines.empty()) {
    std::cout << if_none << '\n';
  }
  return lines.empty() ? 0 : 1;
}

int check_state_of(const Arguments& a) {
  return print_lines(find_damage(a.check), a.check + ": no damage");
}

int repair_state_of(const Arguments& a) {
  print_lines(repair_state(a.repair, seconds_since_1970()), a.repair + ": there was no damage");
  return 0;
}

int back_up_state_of(const Arguments& a) {
  if (a.backup.size() != 2) {
    throw InputError("--backup takes two directories: that of --state, and a new one for the copy");
  }
  return print_lines(back_up_state(a.backup[0], a.backup[1], seconds_since_1970()),
                     a.backup[1] + ": a complete copy");
}

}  // namespace parray
