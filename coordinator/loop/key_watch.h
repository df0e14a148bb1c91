#pragma once

#include <spdlog/logger.h>

#include <memory>
#include <string>

#include "common/base/error.h"
#include "proto/clock.h"
#include "proto/tokens.h"

namespace parray::coordinator {

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

}  // namespace parray::coordinator
