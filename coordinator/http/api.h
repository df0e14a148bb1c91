#pragma once

#include <string>

#include "coordinator/http/events.h"
#include "coordinator/http/metrics.h"
#include "coordinator/http/picture_cache.h"
#include "coordinator/http/router.h"
#include "coordinator/http/upload_reader.h"
#include "coordinator/http/webhooks.h"

namespace parray::http {

/// Largest number of a job in a request. JavaScript rounds larger numbers.
inline constexpr JobId largest_job = (JobId{1} << 53) - 1;

/// Throws Problem 404 if no worker can have this name.
void check_worker_name(const std::string& name);

/// Facts about the server, as GET /api/v1/server shows them.
struct ApiFacts {
  std::uint64_t body_bytes = 0;  ///< limit of a request's body
  std::size_t parts = 0;         ///< limit of the parts of a form
  std::size_t streams = 0;       ///< limit of event streams
  std::string worker_address{};  ///< where workers connect: tcp://HOST:PORT
  bool loopback = false;         ///< only workers of this machine can use worker_address
  bool keys = false;             ///< workers need a key, and HTTP requests need a token
  bool webhooks = false;         ///< at least one host may receive webhooks
};

/// Answers the requests that openapi.json describes. Callable from any thread.
class Api {
 public:
  /// All references must outlive this object.
  Api(LoopClient& loop, UploadReader& uploads, PictureCache& pictures, Events& events,
      Webhooks& webhooks, const RequestCounts& counts, ApiFacts facts)
      : loop_(loop),
        uploads_(uploads),
        pictures_(pictures),
        events_(events),
        webhooks_(webhooks),
        counts_(counts),
        facts_(facts) {}

  /// Registers a handler for every path of openapi.json, except /api/v1/openapi.json itself.
  void add_to(Router& router);

 private:
  void add_jobs(Router& router);
  void add_job_lists(Router& router);
  void add_pictures(Router& router);
  void add_workers(Router& router);
  void add_farm(Router& router);
  /// Returns a handler that calls a member of this class with the request and `more`.
  auto plain(auto answer, auto... more) {
    return [this, answer, more...](const Request& request, const std::vector<std::string>&) {
      return (this->*answer)(request, more...);
    };
  }
  /// Returns a handler that passes also the number of the job, which the path contains.
  auto of_job(auto answer, auto... more);
  Reply submit(const Request& request);
  Reply plan(const Request& request);
  JobId submit_job(const Request& request, Upload& upload, const std::string& series);
  Reply list_jobs(const Request& request);
  Reply steer_many(const Request& request, msg::JobAction action);
  Reply show_job(const Request& request, JobId job);
  Reply steer(const Request& request, JobId job, msg::JobAction action);
  Reply forget(const Request& request, JobId job);
  Reply report(const Request& request, JobId job);
  Reply picture(const Request& request, JobId job, PictureCache::Kind kind);
  Reply frames_zip(const Request& request, JobId series);
  Reply list_workers(const Request& request);
  Reply steer_workers(const Request& request, const std::string& name, msg::WorkerAction action);
  Reply server(const Request& request) const;

  LoopClient& loop_;
  UploadReader& uploads_;
  PictureCache& pictures_;
  Events& events_;
  Webhooks& webhooks_;
  const RequestCounts& counts_;
  const ApiFacts facts_;
  /// Counts the archives that are being sent. Only its entries are used, not its places.
  Places archives_{"archives", {.inside = 8, .one_inside = 2}};
};

}  // namespace parray::http
