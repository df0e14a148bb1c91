#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "coordinator/jobs/job.h"
#include "coordinator/jobs/series.h"

namespace parray::coordinator {

/// Finds jobs by what messages ask for, so that no message looks at all jobs. Every call takes
/// logarithmic time in the number of jobs; those that return frames, linear time in the frames.
///
/// Holds pointers: a job stays where it is until remove(). Plain state. One thread.
class JobIndex {
 public:
  /// The jobs that people see as one, by number of the frame: a series, or a single job.
  using Frames = std::map<std::pair<std::uint32_t, JobId>, Job*>;

  /// A new job. Its user, token, series, frame and size do not change from now on.
  void add(Job& job);
  void remove(const Job& job);
  /// The job has ended, or is queued again.
  void note_ended(const Job& job);
  void note_open(const Job& job);

  /// The job that was submitted with a token of that name (see name_in_token()). 0: there is none.
  [[nodiscard]] JobId by_token(const std::string& user, const std::string& name) const;
  /// By the number that people see.
  [[nodiscard]] const std::map<JobId, Frames>& listed() const { return listed_; }
  /// Null: no job is listed under that number.
  [[nodiscard]] const Frames* listed_as(JobId number) const;
  /// Of jobs that have not ended, oldest first.
  [[nodiscard]] const std::set<JobId>& open() const { return open_; }

  /// The numbers under which no job is unfinished; frames of a series may still be to come.
  [[nodiscard]] const std::set<JobId>& ended() const { return ended_; }

  /// What a user has in unfinished jobs, without those listed under `but`. A series counts as one
  /// job, with the pixels of its largest frame.
  struct Open {
    std::size_t jobs = 0;
    std::uint64_t pixels = 0;
  };
  [[nodiscard]] Open open_of(const std::string& user, JobId but) const;
  /// The pixels of the largest frame that is listed under a number and unfinished; 0: none is.
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
  std::map<std::string, OfUser> users_;
};

/// The same frames, for the functions of series.h.
Series series_of(const JobIndex::Frames& frames);

}  // namespace parray::coordinator
