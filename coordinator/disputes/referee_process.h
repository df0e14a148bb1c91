#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/disputes/referee.h"

namespace parray::coordinator {

/// The referee as a process: parray-referee (cli/referee/main.cpp), started by the first question,
/// with the lowest priority and one thread. It keeps the scene, and the tree, of the last question.
/// A thread of this object talks to it; the caller never waits.
class RefereeProcess final : public Referee {
 public:
  struct Options {
    std::filesystem::path program;  ///< empty: beside this program, in ../lib/parray
    std::string fingerprint;        ///< trace_fingerprint(): it must trace the same bits
    std::function<void()> wake;     ///< called when there is an answer
  };
  explicit RefereeProcess(Options options);
  ~RefereeProcess() override;
  RefereeProcess(const RefereeProcess&) = delete;
  RefereeProcess& operator=(const RefereeProcess&) = delete;

  void ask(Question question) override;
  std::vector<Answer> take_answers() override;
  void forget() override;

 private:
  class Child;

  void lead();
  Answer answer(const Question& question);
  Answer answer_of_child(const Question& question);

  const Options options_;
  std::string scene_;  ///< that the child has; of the thread alone
  double stated_ = 0;  ///< processor time that its answers have stated; of the thread alone

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::optional<Question> question_;
  std::vector<Answer> answers_;
  std::shared_ptr<Child> child_;
  std::uint64_t given_up_ = 0;  ///< how often forget() was called
  bool quit_ = false;

  std::thread thread_;
};

}  // namespace parray::coordinator
