#pragma once

#include <functional>
#include <string>

#include "coordinator/http/events.h"
#include "coordinator/http/picture_cache.h"
#include "coordinator/http/router.h"
#include "coordinator/http/upload_reader.h"
#include "coordinator/http/webhooks.h"

namespace parray::http {

/// Limits of the server, as GET /api/v1/server shows them: bytes of a body, parts of a form, event
/// streams.
struct ApiFacts {
  std::uint64_t body_bytes = 0;
  std::size_t parts = 0;
  std::size_t streams = 0;
};

/// Answers the requests that openapi.json describes. Callable from any thread.
class Api {
 public:
  /// All references must outlive this object.
  Api(LoopClient& loop, UploadReader& uploads, PictureCache& pictures, Events& events,
      Webhooks& webhooks, ApiFacts facts)
      : loop_(loop),
        uploads_(uploads),
        pictures_(pictures),
        events_(events),
        webhooks_(webhooks),
        facts_(facts) {}

  /// Registers a handler for every path of the interface, and for /metrics, /healthz and /readyz.
  void add_to(Router& router);

 private:
  void add_jobs(Router& router);
  void add_pictures(Router& router);
  void add_workers(Router& router);
  // In submit_api.cpp:
  Reply submit(const Request& request);
  Reply plan(const Request& request);
  JobId submit_job(const Request& request, Upload& upload, const std::string& series);
  Reply list_jobs(const Request& request);
  Reply show_job(const Request& request, JobId job);
  Reply steer(const Request& request, JobId job, msg::JobAction action);
  Reply forget(const Request& request, JobId job);
  Reply report(const Request& request, JobId job);
  Reply picture(const Request& request, JobId job, PictureCache::Kind kind);
  Reply list_workers(const Request& request);
  Reply steer_workers(const Request& request, const std::string& name, msg::WorkerAction action);
  Reply server(const Request& request) const;

  LoopClient& loop_;
  UploadReader& uploads_;
  PictureCache& pictures_;
  Events& events_;
  Webhooks& webhooks_;
  const ApiFacts facts_;
};

}  // namespace parray::http
