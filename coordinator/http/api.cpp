#include "coordinator/http/api.h"

#include <nlohmann/json.hpp>

namespace parray::http {
namespace {

using nlohmann::json;

std::uint32_t priority_in(const Request& request) {
  const json body = json_body(request, small_body, R"({"priority": 70})");
  const auto priority = body.is_object() && body.size() == 1
                            ? whole_in(body.value("priority", json()))
                            : std::nullopt;
  if (!priority || *priority > 100) {
    throw Problem(422, "priority: send {\"priority\": N} with a whole number N from 0 to 100", 2);
  }
  return static_cast<std::uint32_t>(*priority);
}

Reply show_job(Api& api, const Request& request) {
  const JobId job = job_in(request);
  const auto from = number_parameter<std::uint32_t>(request, "from_frame", 0, 999'999'999, 0);
  const Time patience = seconds(number_parameter<std::uint64_t>(request, "wait", 1, 60, 0));
  const auto show = [&] {
    return api.loop.ask<msg::Job>(request.sender, msg::ShowJob{0, job, from}).job;
  };
  return with_status(409, 404, [&] {
    json shown = show();
    if (patience > Time(0) && !has_ended(shown)) {
      api.events.await_end(job, owner_of(request), patience);
      shown = show();
    }
    return json_reply(shown);
  });
}

/// Returns a stream of the events of a job, or of all.
Reply event_stream(Api& api, const Request& request, std::optional<JobId> job) {
  Reply reply{.type = "text/event-stream"};
  if (request.method != "HEAD") reply.stream = api.events.listen(job);
  return reply;
}

Reply job_events(Api& api, const Request& request) {
  show_job(api, request);  // throws Problem 404 if the job does not exist
  return event_stream(api, request, job_in(request));
}

/// Returns the result of `act()`. Replaces status 409 of a Problem by 404 if the job does not
/// exist, or by 403 if it belongs to another user than `sender`.
auto with_precise_status(Api& api, const Sender& sender, JobId job, const auto& act) {
  try {
    return act();
  } catch (const Problem& problem) {
    if (problem.status() != 409) throw;
    int status = 409;
    try {
      const json shown = api.loop.ask<msg::Job>(sender, msg::ShowJob{0, job}).job;
      if (sender.role == Role::client && shown.at("user") != sender.name) status = 403;
    } catch (const Problem& missing) {
      if (missing.status() == 409) status = 404;
    }
    throw Problem(status, problem.what(), problem.exit_status());
  }
}

Reply steer(Api& api, const Request& request, msg::JobAction action) {
  const JobId job = job_in(request);
  const std::uint32_t priority = action == msg::JobAction::prioritise ? priority_in(request) : 50;
  return with_precise_status(api, request.sender, job, [&] {
    return json_reply(
        api.loop.ask<msg::Job>(request.sender, msg::SteerJob{0, job, action, priority}).job);
  });
}

Reply forget(Api& api, const Request& request) {
  steer(api, request, msg::JobAction::forget);
  api.events.forgotten(job_in(request));
  return {.status = 204};
}

Reply report(Api& api, const Request& request) {
  const JobId job = job_in(request);
  return with_precise_status(api, {}, job, [&] {
    return json_reply(
        api.loop.ask<msg::ImageData>(request.sender, msg::Fetch{0, job, false, false, false})
            .report);
  });
}

Reply picture(Api& api, const Request& request, const PictureFile& shown) {
  const JobId job = job_in(request);
  const auto width = number_parameter<std::uint32_t>(request, "width", 16, 1024, 0);
  const PictureCache::File picture = with_precise_status(api, {}, job, [&] {
    return api.pictures.get(request.sender, owner_of(request), job, shown.kind, width);
  });
  Reply reply{.type = shown.type,
              .headers = {{"ETag", picture.etag},
                          {"Cache-Control", "no-cache"},
                          {"Parray-Width", std::to_string(picture.width)},
                          {"Parray-Height", std::to_string(picture.height)},
                          {"Parray-Partial", picture.partial ? "1" : "0"}}};
  if (picture.samples) {
    reply.headers.emplace_back("Parray-Samples", std::to_string(*picture.samples));
  }
  const std::string known_tags = request.field("if-none-match");
  if (known_tags == "*" || known_tags.find(picture.etag) != std::string::npos) {
    reply.status = 304;
  } else if (picture.thumbnail) {
    reply.body = picture.thumbnail;
  } else {
    reply.file = picture.file;
  }
  return reply;
}

void add_jobs(Api& api) {
  api.add("GET", "/api/v1/jobs/{id}", show_job, {"from_frame", "wait"});
  api.add("DELETE", "/api/v1/jobs/{id}", forget);
  const auto steering = [](msg::JobAction action) {
    return [action](Api& with, const Request& request) { return steer(with, request, action); };
  };
  using enum msg::JobAction;
  for (const msg::JobAction action : {pause, resume, cancel, requeue}) {
    const std::string name(job_action_names[static_cast<std::size_t>(action)]);
    api.add("POST", "/api/v1/jobs/{id}/" + name, steering(action));
  }
  api.add("PUT", "/api/v1/jobs/{id}/priority", steering(prioritise));
  api.add("GET", "/api/v1/jobs/{id}/events", job_events);
  api.add("GET", "/api/v1/jobs/{id}/report", report);
  for (const PictureFile& file : picture_files) {
    std::vector<std::string_view> queries;
    if (file.kind == PictureCache::Kind::png) queries = {"width"};
    api.add(
        "GET", std::string("/api/v1/jobs/{id}/") + file.name,
        [&file](Api& with, const Request& request) { return picture(with, request, file); },
        std::move(queries));
  }
}

}  // namespace

JobId job_in(const Request& request) {
  return whole_number("id", request.arguments.at(0), 1, largest_job);
}

void add_routes(Api& api) {
  add_submitting(api);
  add_jobs(api);
  add_job_lists(api);
  add_frames_zip(api);
  add_farm(api);
  api.add("GET", "/api/v1/events",
          [](Api& with, const Request& request) { return event_stream(with, request, {}); });
  api.add("GET", "/metrics", [](Api& with, const Request& request) {
    const json farm = with.loop.ask<msg::Farm>(request.sender, msg::ShowFarm{}).farm;
    return text_reply(metrics_text(farm) + with.counts.metrics(), metrics_type);
  });
  api.add(
      "GET", "/healthz", [](Api&, const Request&) { return text_reply("ok\n"); }, {},
      Router::Access::open);
  api.add(
      "GET", "/readyz",
      [](Api& with, const Request&) {
        with.loop.ask<msg::Workers>({}, msg::ListWorkers{0, 0, 1});
        return text_reply("ok\n");
      },
      {}, Router::Access::open);
}

}  // namespace parray::http
