#include "coordinator/jobs/job_index.h"

namespace parray::coordinator {

static std::uint64_t pixels_of(const Job& job) { return pixel_count(job.record.settings); }

void JobIndex::add(Job& job) {
  const JobRecord& record = job.record;
  tokens_[{record.user, name_in_token(record.token)}] = record.id;
  listed_[record.listed_as()][{record.frame, record.id}] = &job;
  if (record.preview_of != 0) previews_.emplace(record.preview_of, record.id);
  if (!job.ended()) {
    note_open(job);
  } else if (open_pixels(record.user, record.listed_as()) == 0) {
    ended_.insert(record.listed_as());
  }
}

void JobIndex::remove(const Job& job) {
  const JobRecord& record = job.record;
  note_ended(job);
  tokens_.erase({record.user, name_in_token(record.token)});
  previews_.erase({record.preview_of, record.id});
  const auto found = listed_.find(record.listed_as());
  found->second.erase({record.frame, record.id});
  if (found->second.empty()) {
    ended_.erase(record.listed_as());
    listed_.erase(found);
  }
}

void JobIndex::note_open(const Job& job) {
  if (!open_.insert(job.record.id).second) return;
  ended_.erase(job.record.listed_as());
  OfUser& user = users_[job.record.user];
  OpenJob& open = user.open[job.record.listed_as()];
  ++open.frames;
  user.pixels -= open.pixels;
  open.pixels = std::max(open.pixels, pixels_of(job));
  user.pixels += open.pixels;
}

void JobIndex::note_ended(const Job& job) {
  if (open_.erase(job.record.id) == 0) return;
  const auto user = users_.find(job.record.user);
  const auto open = user->second.open.find(job.record.listed_as());
  if (--open->second.frames == 0) {
    user->second.pixels -= open->second.pixels;
    user->second.open.erase(open);
    ended_.insert(job.record.listed_as());
  }
  if (user->second.open.empty()) users_.erase(user);
}

JobId JobIndex::by_token(const std::string& user, const std::string& name) const {
  const auto found = tokens_.find({user, name});
  return found == tokens_.end() ? 0 : found->second;
}

std::vector<JobId> JobIndex::previews_of(JobId number) const {
  std::vector<JobId> previews;
  for (auto next = previews_.lower_bound({number, 0});
       next != previews_.end() && next->first == number; ++next) {
    previews.push_back(next->second);
  }
  return previews;
}

const JobIndex::Frames* JobIndex::listed_as(JobId number) const {
  const auto found = listed_.find(number);
  return found == listed_.end() ? nullptr : &found->second;
}

JobIndex::Open JobIndex::open_of(const std::string& user, JobId but) const {
  const auto found = users_.find(user);
  if (found == users_.end()) return {};
  const bool has = found->second.open.contains(but);
  return {found->second.open.size() - (has ? 1 : 0), found->second.pixels - open_pixels(user, but)};
}

std::uint64_t JobIndex::open_pixels(const std::string& user, JobId number) const {
  const auto found = users_.find(user);
  if (found == users_.end()) return 0;
  const auto open = found->second.open.find(number);
  return open == found->second.open.end() ? 0 : open->second.pixels;
}

Series series_of(const JobIndex::Frames& frames) {
  Series series;
  series.reserve(frames.size());
  for (const auto& [key, job] : frames) series.push_back(job);
  return series;
}

}  // namespace parray::coordinator
