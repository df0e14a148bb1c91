#include "coordinator/disputes/referee_process.h"

#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <system_error>
#include <utility>

#include "common/base/error.h"
#include "common/process/child.h"
#include "proto/messages.h"
#include "proto/stream_frames.h"

namespace parray::coordinator {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t most_answer_bytes = std::uint64_t{1} << 32;

/// Address space in bytes for the referee's code, threads and allocator, without scene and tree.
constexpr std::uint64_t program_bytes = std::uint64_t{1} << 30;

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

/// A process that this object ends in its destructor. Any thread may kill it.
class RefereeProcess::Child {
 public:
  /// Starts the process. Throws RunError.
  Child(const fs::path& program, std::uint64_t memory) {
    if (!executable(program)) {
      throw RunError("the coordinator's machine has no executable " + program.string() +
                     ": install ParRay there again");
    }
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      throw RunError("cannot make a socket to start parray-referee: " +
                     std::generic_category().message(errno) +
                     ": raise ulimit -n of the coordinator");
    }
    socket_ = ends[0];
    try {
      pid_ = start_child(
          {.arguments = {program.string(), "--memory=" + std::to_string(memory + program_bytes)},
           .environment = helper_environment(1),
           .input = ends[1]});
    } catch (...) {
      close(ends[1]);
      close(socket_);
      throw;
    }
    close(ends[1]);
  }
  ~Child() {
    end();
    close(socket_);
  }
  Child& operator=(Child&&) = delete;

  [[nodiscard]] int socket() const { return socket_; }

  void kill_child() {
    const std::scoped_lock lock(mutex_);
    if (!ended_) kill(pid_, SIGKILL);
  }

  /// Kills the process if it is running. Returns how it ended.
  struct End {
    std::string why;
    double seconds = 0;  ///< its total processor time
  };
  const End& end() {
    kill_child();
    const std::scoped_lock lock(mutex_);
    if (!ended_) {
      int status = 0;
      rusage used{};
      while (wait4(pid_, &status, 0, &used) < 0 && errno == EINTR) {
      }
      end_.why = WIFSIGNALED(status)
                     ? "it was killed by signal " + std::to_string(WTERMSIG(status))
                     : "it ended with status " + std::to_string(WEXITSTATUS(status));
      end_.seconds = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
      ended_ = true;
    }
    return end_;
  }

  /// Returns the bytes of memory that it uses now. 0: unknown.
  [[nodiscard]] std::uint64_t memory() const {
    std::ifstream in("/proc/" + std::to_string(pid_) + "/statm");
    std::uint64_t all = 0;
    std::uint64_t resident = 0;
    in >> all >> resident;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  }

 private:
  pid_t pid_ = 0;
  int socket_ = -1;
  std::mutex mutex_;  // guards the members below, and against the reuse of pid_
  bool ended_ = false;
  End end_;
};

RefereeProcess::RefereeProcess(Options options)
    : options_(std::move(options)), thread_([this] { run(); }) {}

RefereeProcess::~RefereeProcess() {
  {
    const std::scoped_lock lock(mutex_);
    quit_ = true;
    if (child_) child_->kill_child();
  }
  changed_.notify_all();
  thread_.join();
}

void RefereeProcess::ask(Question question) {
  {
    const std::scoped_lock lock(mutex_);
    question_ = std::move(question);
  }
  changed_.notify_all();
}

std::vector<Referee::Answer> RefereeProcess::take_answers() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(answers_, {});
}

void RefereeProcess::forget() {
  const std::scoped_lock lock(mutex_);
  ++forgotten_;
  question_.reset();
  answers_.clear();
  if (child_) child_->kill_child();
  if (!answering_) {
    child_.reset();  // else run() does it
  }
}

void RefereeProcess::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return quit_ || question_; });
    if (quit_) break;
    const Question question = std::move(*question_);
    question_.reset();
    const std::uint64_t round = forgotten_;
    answering_ = true;
    lock.unlock();
    Answer found = answer(question);
    lock.lock();
    answering_ = false;
    if (round != forgotten_) {
      child_.reset();
      found = Answer{0, "cancelled", {}, found.seconds, 0};
    }
    answers_.push_back(std::move(found));
    if (options_.wake && !quit_) options_.wake();
  }
  child_.reset();
}

/// Ends a child that fails. The next question starts another one.
Referee::Answer RefereeProcess::answer(const Question& question) {
  Answer found;
  found.id = question.id;
  try {
    return answer_of_child(question);
  } catch (const std::exception& error) {
    found.failure = error.what();
  }
  std::shared_ptr<Child> child;
  {
    const std::scoped_lock lock(mutex_);
    child = std::exchange(child_, nullptr);
  }
  if (child) found.seconds = std::max(child->end().seconds - stated_, 0.0);
  return found;
}

/// Throws if no child can be started or the answer is invalid.
Referee::Answer RefereeProcess::answer_of_child(const Question& question) {
  std::shared_ptr<Child> child;
  {
    const std::scoped_lock lock(mutex_);
    child = child_;
  }
  const auto read_message = [&] {
    const auto frames = read_frames(child->socket(), most_answer_bytes);
    if (!frames) throw RunError(child->end().why);
    return decode(*frames);
  };
  if (!child) {
    child = std::make_shared<Child>(
        options_.program.empty() ? helper_program("parray-referee") : options_.program,
        question.memory);
    {
      const std::scoped_lock lock(mutex_);
      child_ = child;
      if (quit_) child->kill_child();
    }
    scene_.clear();
    stated_ = 0;
    const Message message = read_message();
    const auto* hello = std::get_if<msg::Hello>(&message);
    if (hello == nullptr || hello->version != protocol_version || hello->trace != trace_version ||
        hello->fingerprint != options_.fingerprint) {
      throw RunError("it is of another release than this coordinator: install the same release");
    }
  }
  bool sent = true;
  if (scene_ != question.scene) {
    scene_ = question.scene;
    sent =
        write_frames(child->socket(), {std::string("scene"), Frame(question.payload.bytes().data)});
  }
  sent =
      sent && write_frames(child->socket(), encode(msg::Grant{1, 0, question.id, question.cells,
                                                              question.scene, question.settings}));
  if (!sent) throw RunError(child->end().why);
  Message message = read_message();
  Answer found;
  found.id = question.id;
  found.memory = child->memory();
  if (auto* result = std::get_if<msg::Result>(&message)) {
    found.cells = std::move(result->cells);
    found.seconds = result->seconds;
    stated_ += result->seconds;
    return found;
  }
  const auto* failed = std::get_if<msg::Failed>(&message);
  throw RunError(failed == nullptr ? "its message is not an answer" : failed->reason);
}

}  // namespace parray::coordinator
