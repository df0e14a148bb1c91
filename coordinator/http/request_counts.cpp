#include "coordinator/http/request_counts.h"

#include <fmt/format.h>

namespace parray::http {

void RequestCounts::add(int status) {
  const auto place = static_cast<std::size_t>(status - least);
  if (status >= least && place < counts_.size()) ++counts_.at(place);
}

std::string RequestCounts::metrics() const {
  constexpr const char* name = "parray_http_requests_total";
  std::string text = fmt::format(
      "# HELP {} HTTP requests that were answered, by status\n# TYPE {} counter\n", name, name);
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const std::uint64_t count = counts_.at(i);
    if (count > 0) text += fmt::format("{}{{status=\"{}\"}} {}\n", name, i + least, count);
  }
  return text;
}

}  // namespace parray::http
