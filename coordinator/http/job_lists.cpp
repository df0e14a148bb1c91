// Lists jobs, and changes many jobs with one request.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "coordinator/http/api.h"

namespace parray::http {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 7> states = {"queued", "running", "paused",   "finishing",
                                                    "done",   "failed",  "cancelled"};
constexpr auto directions = std::span(job_order_names).subspan<1>();

[[noreturn]] void fail_word(const std::string& parameter, std::string_view word,
                            std::span<const std::string_view> known) {
  throw Problem(
      400, parameter + ": '" + printable(word) + "' is unknown: " + remedy_for_name(word, known),
      2);
}

/// Returns the states of the query, separated by commas, each once; empty if the query has none.
std::string states_in(const Request& request) {
  const auto found = request.query.find("state");
  if (found == request.query.end()) return "";
  std::set<std::string_view> names;
  for (const std::string_view name : split_at(',', found->second)) {
    if (std::ranges::find(states, name) == states.end()) fail_word("state", name, states);
    names.insert(name);
  }
  return joined(names, ",");
}

/// Returns the place in `known` of the query's word. None: the query has no such parameter.
std::optional<std::size_t> word_in(const Request& request, const std::string& parameter,
                                   std::span<const std::string_view> known) {
  const auto found = request.query.find(parameter);
  if (found == request.query.end()) return {};
  const auto word = std::ranges::find(known, found->second);
  if (word == known.end()) fail_word(parameter, found->second, known);
  return static_cast<std::size_t>(word - known.begin());
}

std::string text_parameter(const Request& request, const std::string& parameter) {
  const auto found = request.query.find(parameter);
  if (found == request.query.end()) return "";
  if (found->second.size() > max_name) {
    throw Problem(400, parameter + ": use at most " + std::to_string(max_name) + " bytes", 2);
  }
  return found->second;
}

/// Jobs to change, as the body of a request names them.
struct Named {
  std::vector<JobId> ids;
  std::uint32_t priority = 50;
};

Named named_in(const Request& request, bool with_priority) {
  constexpr std::size_t most_bytes = std::size_t{1} << 15;
  const std::string form =
      with_priority ? R"({"ids": [3, 4], "priority": 70})" : R"({"ids": [3, 4]})";
  const json body = json_body(request, most_bytes, form);
  if (!body.is_object() || body.size() != (with_priority ? 2 : 1) || !body.contains("ids") ||
      !body.at("ids").is_array()) {
    throw Problem(422, "the body is not of this form: " + form, 2);
  }
  Named named;
  for (const json& value : body.at("ids")) {
    const auto id = whole_in(value);
    if (!id || *id < 1 || *id > largest_job) {
      throw Problem(422, "ids: use only numbers of jobs, such as 3", 2);
    }
    if (named.ids.size() == msg::most_steered) {
      throw Problem(422,
                    "ids: use at most " + std::to_string(msg::most_steered) +
                        " numbers of jobs: send several requests for more",
                    2);
    }
    named.ids.push_back(*id);
  }
  if (named.ids.empty()) throw Problem(422, "ids: name at least one job", 2);
  if (with_priority) {
    const auto priority = whole_in(body.value("priority", json()));
    if (!priority || *priority > 100) {
      throw Problem(422, "priority: use a whole number from 0 to 100", 2);
    }
    named.priority = static_cast<std::uint32_t>(*priority);
  }
  return named;
}

int status_of(const std::string& refusal) {
  return refusal == refusal_names[0] ? 404 : refusal == refusal_names[1] ? 403 : 409;
}

/// Returns the entry of `results` for an entry of msg::Steered.
json http_result(json result) {
  if (!result.contains("refusal")) return result;
  return {
      {"id", result.at("id")},
      {"problem", {{"status", status_of(result.at("refusal"))}, {"detail", result.at("message")}}}};
}

Reply list_jobs(Api& api, const Request& request) {
  msg::ListJobs asked;
  asked.limit = number_parameter<std::uint32_t>(request, "limit", 1, msg::most_listed, 100);
  asked.before = number_parameter<JobId>(request, "before", 1, largest_job, 0);
  asked.offset = number_parameter<std::uint32_t>(request, "offset", 0, 1'000'000'000, 0);
  asked.states = states_in(request);
  asked.user = text_parameter(request, "user");
  asked.name = text_parameter(request, "name");
  asked.sort = static_cast<msg::JobSort>(word_in(request, "sort", job_sort_names).value_or(0));
  const bool descending = word_in(request, "order", directions).value_or(1) == 1;
  asked.order = descending ? msg::JobOrder::descending : msg::JobOrder::ascending;
  const bool by_id = asked.sort == msg::JobSort::id && descending && asked.offset == 0;
  const std::uint32_t limit = asked.limit;
  auto answer = api.loop.ask<msg::Jobs>(request.sender, std::move(asked));
  const json next =
      by_id && answer.jobs.size() == limit ? json(answer.jobs.back().at("id")) : json();
  return json_reply({{"jobs", std::move(answer.jobs)}, {"next", next}, {"total", answer.total}});
}

Reply steer_many(Api& api, const Request& request, msg::JobAction action) {
  Named named = named_in(request, action == msg::JobAction::prioritise);
  msg::SteerJobs asked{0, std::move(named.ids), action, named.priority};
  json results = json::array();
  for (json& result : api.loop.ask<msg::Steered>(request.sender, std::move(asked)).results) {
    if (action == msg::JobAction::forget && result.contains("job")) {
      api.events.forgotten(result.at("id"));
    }
    results.push_back(http_result(std::move(result)));
  }
  return json_reply({{"results", std::move(results)}});
}

}  // namespace

void add_job_lists(Api& api) {
  api.add("GET", "/api/v1/jobs", list_jobs,
          {"limit", "before", "offset", "state", "user", "name", "sort", "order"});
  for (std::size_t i = 0; i < job_action_names.size(); ++i) {
    const auto action = static_cast<msg::JobAction>(i);
    const bool prioritise = action == msg::JobAction::prioritise;
    api.add(
        "POST", "/api/v1/jobs/" + std::string(prioritise ? "priority" : job_action_names.at(i)),
        [action](Api& with, const Request& request) { return steer_many(with, request, action); });
  }
}

}  // namespace parray::http
