#include "coordinator/http/api.h"

#include <nlohmann/json.hpp>

#include "common/base/printable.h"
#include "coordinator/http/metrics.h"

namespace parray::http {
namespace {

using nlohmann::json;
using Arguments = std::vector<std::string>;

JobId job_in(const Arguments& arguments) {
  return whole_number("id", arguments.at(0), 1, largest_job);
}

bool flag_in(const Request& request, const std::string& name) {
  const auto found = request.query.find(name);
  if (found == request.query.end() || found->second == "false") return false;
  if (found->second != "true") {
    throw Problem(400, name + ": '" + printable(found->second) + "' is not true or false", 2);
  }
  return true;
}

std::uint32_t priority_in(const Request& request) {
  if (media_type(request) != "application/json") {
    throw Problem(415, wrong_media_type(request) + ": send {\"priority\": 70} with the header " +
                           json_header);
  }
  const json body = json::parse(read_text(request, small_body), nullptr, false);
  const auto priority = body.is_object() && body.size() == 1
                            ? whole_in(body.value("priority", json()))
                            : std::nullopt;
  if (!priority || *priority > 100) {
    throw Problem(422, "priority: send {\"priority\": N} with a whole number N from 0 to 100", 2);
  }
  return static_cast<std::uint32_t>(*priority);
}

bool has_tag(const std::string& list, const std::string& etag) {
  return list == "*" || list.find(etag) != std::string::npos;
}

}  // namespace

auto Api::of_job(auto answer, auto... more) {
  return [this, answer, more...](const Request& request, const Arguments& arguments) {
    return (this->*answer)(request, job_in(arguments), more...);
  };
}

void Api::add_to(Router& router) {
  add_jobs(router);
  add_job_lists(router);
  add_pictures(router);
  add_workers(router);
  add_farm(router);
  router.add("GET", "/api/v1/events", [this](const Request& request, const Arguments&) {
    Reply reply;
    reply.type = "text/event-stream";
    if (request.method != "HEAD") reply.stream = events_.listen({});
    return reply;
  });
  router.add("GET", "/metrics", [this](const Request& request, const Arguments&) {
    const json farm = loop_.ask<msg::Farm>(request.sender, msg::ShowFarm{}).farm;
    return text_reply(metrics_text(farm) + counts_.metrics(), metrics_type);
  });
  router.add(
      "GET", "/healthz", [](const Request&, const Arguments&) { return text_reply("ok\n"); }, {},
      Router::Access::open);
  router.add(
      "GET", "/readyz",
      [this](const Request&, const Arguments&) {
        loop_.ask<msg::Workers>({}, msg::ListWorkers{0, 0, 1});
        return text_reply("ok\n");
      },
      {}, Router::Access::open);
}

void Api::add_jobs(Router& router) {
  router.add("POST", "/api/v1/jobs", plain(&Api::submit));
  router.add("POST", "/api/v1/plan", plain(&Api::plan));
  router.add("GET", "/api/v1/jobs/{id}", of_job(&Api::show_job), {"from_frame", "wait"});
  router.add("DELETE", "/api/v1/jobs/{id}", of_job(&Api::forget));
  using enum msg::JobAction;
  for (const msg::JobAction action : {pause, resume, cancel, requeue}) {
    const std::string name(job_action_names[static_cast<std::size_t>(action)]);
    router.add("POST", "/api/v1/jobs/{id}/" + name, of_job(&Api::steer, action));
  }
  router.add("PUT", "/api/v1/jobs/{id}/priority", of_job(&Api::steer, prioritise));
  router.add("GET", "/api/v1/jobs/{id}/events",
             [this](const Request& request, const Arguments& arguments) {
               const JobId job = job_in(arguments);
               show_job(request, job);  // throws Problem 404 if the job does not exist
               Reply reply;
               reply.type = "text/event-stream";
               if (request.method != "HEAD") reply.stream = events_.listen(job);
               return reply;
             });
}

void Api::add_pictures(Router& router) {
  router.add("GET", "/api/v1/jobs/{id}/report", of_job(&Api::report));
  for (const auto& [kind, name, type] : picture_files) {
    std::vector<std::string_view> queries;
    if (kind == PictureCache::Kind::png) queries = {"width"};
    router.add("GET", std::string("/api/v1/jobs/{id}/") + name, of_job(&Api::picture, kind),
               std::move(queries));
  }
  router.add("GET", "/api/v1/jobs/{id}/frames.zip", of_job(&Api::frames_zip));
}

void Api::add_workers(Router& router) {
  router.add("GET", "/api/v1/workers", plain(&Api::list_workers), {"limit", "offset"});
  for (const msg::WorkerAction action : {msg::WorkerAction::drain, msg::WorkerAction::readmit}) {
    const std::string name(worker_action_names[static_cast<std::size_t>(action)]);
    router.add("POST", "/api/v1/workers/{name}/" + name,
               [this, action](const Request& request, const Arguments& arguments) {
                 return steer_workers(request, arguments.at(0), action);
               },
               {"host"});
  }
}

Reply Api::show_job(const Request& request, JobId job) {
  const auto from =
      static_cast<std::uint32_t>(number_parameter(request, "from_frame", 0, 999'999'999, 0));
  const Time patience = seconds(number_parameter(request, "wait", 1, 60, 0));
  const auto show = [&] {
    return loop_.ask<msg::Job>(request.sender, msg::ShowJob{0, job, from}).job;
  };
  return with_status(409, 404, [&] {
    json shown = show();
    if (patience > Time(0) && !has_ended(shown)) {
      events_.await_end(job, owner_of(request), patience);
      shown = show();
    }
    return json_reply(shown);
  });
}

/// Throws `problem` again. Replaces status 409 with 404 if the job does not exist, or with 403 if
/// it belongs to another user. To be called in the handler that caught `problem`.
[[noreturn]] static void fail_precisely(LoopClient& loop, const Sender& sender, JobId job,
                                        const Problem& problem) {
  if (problem.status() != 409) throw;
  int status = 409;
  try {
    const json shown = loop.ask<msg::Job>(sender, msg::ShowJob{0, job}).job;
    if (sender.role == Role::client && shown.at("user") != sender.name) status = 403;
  } catch (const Problem& missing) {
    if (missing.status() == 409) status = 404;
  }
  throw Problem(status, problem.what(), problem.exit_status());
}

Reply Api::steer(const Request& request, JobId job, msg::JobAction action) {
  const std::uint32_t priority = action == msg::JobAction::prioritise ? priority_in(request) : 50;
  try {
    const auto answer =
        loop_.ask<msg::Job>(request.sender, msg::SteerJob{0, job, action, priority});
    return json_reply(answer.job);
  } catch (const Problem& problem) {
    fail_precisely(loop_, request.sender, job, problem);
  }
}

Reply Api::forget(const Request& request, JobId job) {
  steer(request, job, msg::JobAction::forget);
  events_.forgotten(job);
  Reply reply;
  reply.status = 204;
  return reply;
}

Reply Api::report(const Request& request, JobId job) {
  try {
    const auto answer =
        loop_.ask<msg::ImageData>(request.sender, msg::Fetch{0, job, false, false, false});
    return json_reply(answer.report);
  } catch (const Problem& problem) {
    fail_precisely(loop_, {}, job, problem);
  }
}

Reply Api::picture(const Request& request, JobId job, PictureCache::Kind kind) {
  const auto width = static_cast<std::uint32_t>(number_parameter(request, "width", 16, 1024, 0));
  PictureCache::File picture;
  try {
    picture = pictures_.get(request.sender, owner_of(request), job, kind, width);
  } catch (const Problem& problem) {
    fail_precisely(loop_, {}, job, problem);
  }
  Reply reply;
  reply.type = file_of(kind).type;
  reply.headers = {{"ETag", picture.etag},
                   {"Cache-Control", "no-cache"},
                   {"Parray-Width", std::to_string(picture.width)},
                   {"Parray-Height", std::to_string(picture.height)},
                   {"Parray-Partial", picture.partial ? "1" : "0"}};
  if (picture.samples) {
    reply.headers.emplace_back("Parray-Samples", std::to_string(*picture.samples));
  }
  if (has_tag(request.field("if-none-match"), picture.etag)) {
    reply.status = 304;
  } else if (picture.thumbnail) {
    reply.body = picture.thumbnail;
  } else {
    reply.file = picture.file;
  }
  return reply;
}

static Reply workers_reply(const msg::Workers& answer) {
  return json_reply({{"workers", answer.workers}, {"total", answer.total}});
}

Reply Api::list_workers(const Request& request) {
  const auto limit = static_cast<std::uint32_t>(
      number_parameter(request, "limit", 1, msg::most_listed, msg::most_listed));
  const auto offset =
      static_cast<std::uint32_t>(number_parameter(request, "offset", 0, 1'000'000, 0));
  return workers_reply(loop_.ask<msg::Workers>(request.sender, msg::ListWorkers{0, offset, limit}));
}

Reply Api::steer_workers(const Request& request, const std::string& name,
                         msg::WorkerAction action) {
  check_worker_name(name);
  return with_status(409, 403, [&] {
    return workers_reply(loop_.ask<msg::Workers>(
        request.sender, msg::SteerWorkers{0, action, flag_in(request, "host"), name}));
  });
}

}  // namespace parray::http
