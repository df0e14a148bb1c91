#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/disputes/referee.h"
#include "proto/clock.h"
#include "tests/support/rooms.h"
#include "worker/cell_tracer.h"

namespace parray::test {

/// A referee without a process. It can be slow, dead, silent or expensive.
class SimReferee final : public Referee {
 public:
  struct Ailments {
    Time delay{};           ///< time until the answer
    std::string failure{};  ///< failure that it reports instead of cells; empty: none
    bool silent = false;    ///< the referee never answers
    double seconds = 0.01;  ///< processor time of an answer
  };
  /// `now` is the clock of the test.
  explicit SimReferee(std::function<Time()> now = [] { return Time{}; }) : now_(std::move(now)) {}

  void ask(Question question) override {
    ++asked;
    Answer answer;
    answer.id = question.id;
    answer.seconds = ailments.seconds;
    answer.memory = memory;
    answer.failure = ailments.failure;
    if (answer.failure.empty()) {
      std::atomic<std::uint64_t> count = 0;
      answer.cells = CellsPayload(std::make_shared<const TracedCells>(
          trace_cells(*make_path_tracer(*question.payload.scene(), question.settings),
                      question.cells, 1, count, false)));
      cells += question.cells.range.count();
    }
    if (!ailments.silent) answers_.push_back({now_() + ailments.delay, std::move(answer)});
  }
  std::vector<Answer> take_answers() override {
    std::vector<Answer> ready;
    std::erase_if(answers_, [&](auto& answer) {
      if (answer.first > now_()) return false;
      ready.push_back(std::move(answer.second));
      return true;
    });
    return ready;
  }
  void forget() override {
    ++forgotten;
    answers_.clear();
  }
  /// Returns the time of the next answer; `never` if there is none.
  [[nodiscard]] Time due() const { return answers_.empty() ? never : answers_.front().first; }

  Ailments ailments;
  std::uint64_t memory = 1 << 20;
  std::size_t asked = 0;
  std::size_t forgotten = 0;
  std::uint64_t cells = 0;

 private:
  std::function<Time()> now_;
  std::vector<std::pair<Time, Answer>> answers_;
};

}  // namespace parray::test
