// Submits scenes, and forecasts their jobs.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <utility>

#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "coordinator/http/api.h"

namespace parray::http {
namespace {

using nlohmann::json;

/// Returns the Idempotency-Key of the request. Empty: none. Throws Problem 400 if it is invalid.
std::string idempotency_key(const Request& request) {
  constexpr std::size_t longest = 48;
  std::string key = request.field("idempotency-key");
  const bool plain = key.size() <= longest && std::ranges::all_of(key, [](char c) {
                       return ascii::is_letter_or_digit(c) || c == '_' || c == '.' || c == '-';
                     });
  if (!plain) {
    throw Problem(400, "Idempotency-Key: '" + printable(key) +
                           "' is invalid: use 1 to 48 letters, digits, '_', '.' or '-'");
  }
  return key;
}

std::string random_name() {
  std::random_device device;
  std::string name = "http:";
  for (int i = 0; i < 4; ++i) name += std::to_string(device()) + ".";
  return name;
}

/// Returns the token of the series that a request makes. A repeated request with an
/// Idempotency-Key has the same one.
std::string series_token_of(const std::string& key) {
  constexpr std::size_t digits = 32;
  const std::string text = key.empty() ? random_name() : key;
  return "http-" + sha256_hex(std::as_bytes(std::span(text))).substr(0, digits);
}

/// Returns the submit token, which identifies a job before it has a number.
std::string token_of(const std::string& key, const std::string& series, const Upload& upload) {
  constexpr std::size_t digits = 10;  // enough to detect mistakes, not forgeries
  const std::string digest = "#" + upload.digest.substr(0, digits);
  // The first frame has the token that a single job would have: a key belongs to one request.
  if (upload.place > 0) return series + "-" + std::to_string(upload.submit.frame) + digest;
  return key.empty() ? random_name() : "http-" + key + digest;
}

/// Gives the upload to the loop and returns the number of the job.
JobId submit_job(Api& api, const Request& request, Upload& upload, const std::string& series) {
  upload.submit.token = token_of(idempotency_key(request), series, upload);
  upload.submit.user.clear();
  if (upload.submit.frames > 0) upload.submit.series = series;
  return with_status(409, 422, [&] {  // a limit, or the scene
    return api.loop.ask<msg::Submitted>(request.sender, std::move(upload.submit)).job;
  });
}

Reply submit(Api& api, const Request& request) {
  // Refuses a bad key before the body is read.
  const std::string series = series_token_of(idempotency_key(request));
  JobId id = 0;
  JobId first = 0;
  std::uint64_t frames = 0;
  std::uint64_t submitted = 0;
  std::string webhook;
  try {
    api.uploads.receive(request, [&](Upload& upload) {
      if (submitted == 0) {
        webhook = upload.webhook;
        if (!webhook.empty()) api.webhooks.check(webhook);
        frames = upload.submit.frames;
      }
      const JobId job = submit_job(api, request, upload, series);
      if (submitted++ > 0) return;
      first = job;
      id = frames == 0 ? job
                       : api.loop.ask<msg::Job>(request.sender, msg::ShowJob{0, job})
                             .job.at("series")
                             .get<JobId>();
    });
  } catch (const Problem& problem) {
    if (submitted == 0) throw;
    const std::string named =
        id != 0 ? fmt::format("series {}", id) : fmt::format("the series of job {}", first);
    const bool repeatable = !idempotency_key(request).empty();
    throw Problem(
        problem.status(),
        fmt::format("{}: {} has {} of {} frames: cancel it{}", problem.what(), named, submitted,
                    frames,
                    repeatable ? ", or repeat the request with the same Idempotency-Key" : ""),
        problem.exit_status(), problem.headers());
  }
  if (!webhook.empty()) api.webhooks.add(id, webhook);
  json answer = {{"id", id}};
  if (frames > 0) answer["frames"] = frames;
  Reply reply = json_reply(answer, 201);
  reply.headers.emplace_back("Location", "/api/v1/jobs/" + std::to_string(id));
  return reply;
}

Reply plan(Api& api, const Request& request) {
  const json farm = api.loop.ask<msg::Farm>(request.sender, msg::ShowFarm{}).farm;
  const auto threads = farm.at("threads").get<std::size_t>();
  json answer = api.uploads.forecast(request, threads);
  answer["queue_seconds"] = threads > 0 ? farm.at("seconds_left") : json();
  return json_reply(answer);
}

}  // namespace

void add_submitting(Api& api) {
  api.add("POST", "/api/v1/jobs", submit);
  api.add("POST", "/api/v1/plan", plan);
}

}  // namespace parray::http
