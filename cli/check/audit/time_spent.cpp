#include "cli/check/audit/time_spent.h"

#include <algorithm>
#include <limits>
#include <map>

namespace parray::audit {
namespace {

struct Span {
  std::uint32_t threads = 0;
  double first_granted = std::numeric_limits<double>::infinity();
  double first_arrived = 0;
  double first_traced = 0;
  double last_arrived = 0;
  double traced = 0;
};

std::map<TracerKey, Span> spans_of(const std::vector<JournalEntry>& journal) {
  std::map<TracerKey, Span> spans;
  for (const JournalEntry& entry : journal) {
    if (const auto* worker = std::get_if<JournalWorker>(&entry)) {
      spans[worker->tracer].threads = worker->threads;
    } else if (const auto* merge = std::get_if<JournalMerge>(&entry)) {
      Span& span = spans[merge->tracer];
      if (merge->granted < span.first_granted) {
        span.first_granted = merge->granted;
        span.first_arrived = merge->arrived;
        span.first_traced = merge->seconds;
      }
      span.last_arrived = std::max(span.last_arrived, merge->arrived);
      span.traced += merge->seconds;
    }
  }
  std::erase_if(spans, [](const auto& span) { return span.second.last_arrived == 0; });
  return spans;
}

}  // namespace

TimeSpent time_spent(const std::vector<JournalEntry>& journal) {
  const auto spans = spans_of(journal);
  if (spans.empty()) return {};
  double begin = std::numeric_limits<double>::infinity();
  double end = 0;
  for (const auto& [tracer, span] : spans) {
    begin = std::min(begin, span.first_granted);
    end = std::max(end, span.last_arrived);
  }
  TimeSpent spent;
  spent.seconds = end - begin;
  spent.workers = spans.size();
  double had = 0;
  for (const auto& [tracer, span] : spans) {
    const double start = std::max(span.first_arrived - span.first_granted - span.first_traced, 0.0);
    spent.threads += span.threads;
    had += span.threads * (end - span.first_granted);
    spent.tracing += span.threads * span.traced;
    spent.start += span.threads * start;
    spent.tail += span.threads * (end - span.last_arrived);
  }
  had = std::max(had, std::numeric_limits<double>::min());
  for (double* const part : {&spent.tracing, &spent.start, &spent.tail}) {
    *part = std::min(*part / had, 1.0);
  }
  spent.between = std::max(1 - spent.tracing - spent.start - spent.tail, 0.0);
  return spent;
}

}  // namespace parray::audit
