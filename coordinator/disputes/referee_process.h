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

/// Runs the referee as a process: parray-referee (cli/referee/main.cpp), with the lowest priority
/// and one thread. The first question starts it, and the first one after forget() or a failure
/// starts it again. It keeps scene and accelerator of the last question. A thread of this object
/// communicates with it, so that callers never wait.
class RefereeProcess final : public Referee {
 public:
  struct Options {
    /// Empty: ../lib/parray/parray-referee, relative to the directory of this program.
    std::filesystem::path program;
    std::string fingerprint;     ///< trace_fingerprint() that the referee must have
    std::function<void()> wake;  ///< called in another thread when an answer arrives
  };
  explicit RefereeProcess(Options options);
  ~RefereeProcess() override;
  RefereeProcess& operator=(RefereeProcess&&) = delete;

  void ask(Question question) override;
  std::vector<Answer> take_answers() override;
  void forget() override;

 private:
  class Child;

  void run();
  Answer answer(const Question& question);
  Answer answer_of_child(const Question& question);

  const Options options_;
  std::string scene_;  ///< the child's scene; used only by thread_
  double stated_ = 0;  ///< processor time in the child's answers; used only by thread_

  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::optional<Question> question_;
  std::vector<Answer> answers_;
  std::shared_ptr<Child> child_;
  std::uint64_t forgotten_ = 0;  ///< number of calls of forget()
  bool answering_ = false;       ///< thread_ waits for the child
  bool quit_ = false;

  std::thread thread_;
};

}  // namespace parray::coordinator
