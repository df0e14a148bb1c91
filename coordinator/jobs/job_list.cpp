#include "coordinator/jobs/job_list.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tuple>

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::coordinator {
namespace {

using Frames = JobIndex::Frames;

/// A job or series with the values that a list needs.
class Row {
 public:
  Row(const Frames& frames, Time now) : frames_(&frames), now_(now) {}

  [[nodiscard]] const JobRecord& record() const { return first().record; }
  [[nodiscard]] std::string_view state() const {
    return is_series() ? name_of(state_of(series(), now_)) : first().shown_state();
  }

  /// Returns the value by which the list is sorted, if it is a number. Unknown: less than all.
  [[nodiscard]] double number(msg::JobSort sort) const {
    constexpr double unknown = -1;
    const auto times = [this] {
      return is_series() ? times_of(series(), now_) : times_of(first(), now_);
    };
    switch (sort) {
      case msg::JobSort::priority: return is_series() ? priority_of(series()) : record().priority;
      case msg::JobSort::submitted: return times().submitted.value_or(unknown);
      case msg::JobSort::finished: return times().finished.value_or(unknown);
      case msg::JobSort::taken: return times().taken.value_or(unknown);
      case msg::JobSort::progress:
        return is_series() ? progress_of(series(), now_) : first().progress(now_);
      default: return 0;
    }
  }
  [[nodiscard]] std::string text(msg::JobSort sort) const {
    switch (sort) {
      case msg::JobSort::name: return lower_case(record().name);
      case msg::JobSort::user: return record().user;
      case msg::JobSort::state: return std::string(state());
      default: return {};
    }
  }

 private:
  [[nodiscard]] const Job& first() const { return *frames_->begin()->second; }
  [[nodiscard]] bool is_series() const { return record().series_id != 0; }
  [[nodiscard]] Series series() const { return series_of(*frames_); }

  const Frames* frames_;
  Time now_;
};

/// The conditions of a request, which must outlive it.
class Filter {
 public:
  explicit Filter(const msg::ListJobs& request)
      : request_(request),
        part_(lower_case(request.name)),
        states_(words_of(request.states, ",")) {}

  [[nodiscard]] bool fits(const Row& row) const {
    return (request_.user.empty() || row.record().user == request_.user) &&
           (part_.empty() || lower_case(row.record().name).find(part_) != std::string::npos) &&
           (request_.states.empty() || place_in(states_, row.state()));
  }

 private:
  const msg::ListJobs& request_;
  std::string part_;
  std::vector<std::string_view> states_;
};

struct Sorted {
  double number;
  std::string text;
  JobId id;
  const Frames* frames;
};

void cut_page(std::vector<Sorted>& rows, const msg::ListJobs& request, JobList& list) {
  const std::size_t begin = std::min<std::size_t>(request.offset, rows.size());
  const std::size_t end = std::min<std::size_t>(begin + request.limit, rows.size());
  const bool ascending = request.order == msg::JobOrder::ascending;
  const auto before = [&](const Sorted& a, const Sorted& b) {
    const auto key = [](const Sorted& row) { return std::tie(row.number, row.text); };
    if (request.sort == msg::JobSort::id) return ascending ? a.id < b.id : b.id < a.id;
    if (key(a) != key(b)) return ascending ? key(a) < key(b) : key(b) < key(a);
    return b.id < a.id;
  };
  std::partial_sort(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(end), rows.end(),
                    before);
  for (std::size_t i = begin; i < end; ++i) list.page.push_back(rows[i].frames);
}

}  // namespace

JobList list_of(const JobIndex& index, const msg::ListJobs& request, Time now) {
  const Filter filter(request);
  const auto& listed = index.listed();
  const auto end = request.before == 0 ? listed.end() : listed.lower_bound(request.before);
  JobList list;
  if (request.order == msg::JobOrder::newest) {
    for (auto entry = std::make_reverse_iterator(end);
         entry != listed.rend() && list.page.size() < request.limit; ++entry) {
      if (filter.fits({entry->second, now})) list.page.push_back(&entry->second);
    }
    std::ranges::reverse(list.page);
    return list;
  }
  std::vector<Sorted> rows;
  for (const auto& [id, frames] : listed) {
    const Row row(frames, now);
    if (!filter.fits(row)) continue;
    ++list.total;
    if (request.before == 0 || id < request.before) {
      rows.push_back({row.number(request.sort), row.text(request.sort), id, &frames});
    }
  }
  cut_page(rows, request, list);
  return list;
}

nlohmann::json short_map(nlohmann::json map, std::size_t count) {
  constexpr std::size_t of_all = 100'000;  // bytes of one text in all maps
  for (const char* key : {"reason", "waits_for", "flag", "warning"}) {
    if (map.contains(key) && map[key].get_ref<const std::string&>().size() > of_all / count) {
      map[key] = printable(map[key].get<std::string>(), of_all / count);
    }
  }
  return map;
}

}  // namespace parray::coordinator
