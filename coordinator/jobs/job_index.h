#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coordinator/jobs/job.h"
#include "coordinator/jobs/series.h"

namespace parray::coordinator {

/// Returns the name in a submit's token, which is NAME or NAME#DIGEST. The name identifies the job,
/// so that a repeated submit makes no second job. The digest of the submitted content shows if
/// another content has the same name.
inline std::string name_in_token(std::string_view token) {
  return std::string(token.substr(0, std::min(token.find('#'), token.size())));
}

/// Returns whether two tokens with the same name may stand for the same content. A token without a
/// digest may stand for any content.
inline bool may_be_same_content(std::string_view a, std::string_view b) {
  const bool both = a.find('#') != std::string_view::npos && b.find('#') != std::string_view::npos;
  return !both || a == b;
}

/// Finds jobs by the keys in messages, so that no message needs to look at all jobs. Every call
/// takes logarithmic time in the number of jobs, plus linear time in the frames that it returns.
///
/// Holds pointers: a job must not move in memory until remove(). Not thread-safe.
class JobIndex {
 public:
  /// The jobs that clients see under one number, by frame number: a series or a single job.
  using Frames = std::map<std::pair<std::uint32_t, JobId>, Job*>;

  /// Adds a job, which may have ended. Its user, token, series, frame and size must not change
  /// afterwards.
  void add(Job& job);
  void remove(const Job& job);
  /// Notes that the job has ended, or that it is queued again. A second call changes nothing.
  void note_ended(const Job& job);
  void note_open(const Job& job);

  /// Finds the job whose token has this name (see name_in_token()). 0: none has it.
  [[nodiscard]] JobId by_token(const std::string& user, const std::string& name) const;
  /// Returns all jobs by the number under which clients see them.
  [[nodiscard]] const std::map<JobId, Frames>& listed() const { return listed_; }
  /// Finds the frames with this number. Null: there are none.
  [[nodiscard]] const Frames* listed_as(JobId number) const;
  /// Returns the jobs that have not ended, oldest first.
  [[nodiscard]] const std::set<JobId>& open() const { return open_; }

  /// Returns the numbers of the quick looks of a job or series (JobHead::preview_of).
  [[nodiscard]] std::vector<JobId> previews_of(JobId number) const;

  /// Returns the numbers under which no job is unfinished. A series may still get more frames.
  [[nodiscard]] const std::set<JobId>& ended() const { return ended_; }

  /// The unfinished jobs of a user. A series is one job with the pixels of its largest frame.
  struct Open {
    std::size_t jobs = 0;
    std::uint64_t pixels = 0;
  };
  /// Counts a user's unfinished jobs, except those with the number `but` in listed(). 0: all count.
  [[nodiscard]] Open open_of(const std::string& user, JobId but) const;
  /// Returns the pixels of the largest frame under a number with unfinished frames. 0: it has none.
  [[nodiscard]] std::uint64_t open_pixels(const std::string& user, JobId number) const;

 private:
  struct OpenJob {
    std::size_t frames = 0;
    std::uint64_t pixels = 0;
  };
  struct OfUser {
    std::map<JobId, OpenJob> open;
    std::uint64_t pixels = 0;
  };

  std::map<std::pair<std::string, std::string>, JobId> tokens_;
  std::map<JobId, Frames> listed_;
  std::set<JobId> open_;
  std::set<JobId> ended_;
  std::set<std::pair<JobId, JobId>> previews_;  ///< of which job, number of the quick look
  std::map<std::string, OfUser> users_;
};

/// Converts frames for the functions of series.h.
Series series_of(const JobIndex::Frames& frames);

}  // namespace parray::coordinator
