#pragma once

#include <string>

#include "coordinator/http/events.h"
#include "coordinator/http/http_service.h"
#include "coordinator/http/metrics.h"
#include "coordinator/http/picture_cache.h"
#include "coordinator/http/router.h"
#include "coordinator/http/upload_reader.h"
#include "coordinator/http/webhooks.h"

namespace parray::http {

/// Largest number of a job in a request. JavaScript rounds larger numbers.
inline constexpr JobId largest_job = (JobId{1} << 53) - 1;

/// The parts of the coordinator that the handlers of the HTTP interface (openapi.json) use. They
/// must outlive this object.
struct Api {
  Router& router;
  LoopClient& loop;
  UploadReader& uploads;
  PictureCache& pictures;
  Events& events;
  Webhooks& webhooks;
  const RequestCounts& counts;
  const Options& options;
  /// Counts the archives that are being sent. Only its entries are used, not its places.
  Places archives{"archives", {.inside = 8, .one_inside = 2}};

  /// Adds a route to the router; see Router::add(). Any thread may call `handler`.
  void add(const std::string& method, const std::string& pattern,
           std::function<Reply(Api&, const Request&)> handler,
           std::vector<std::string_view> queries = {},
           Router::Access access = Router::Access::guarded) {
    router.add(
        method, pattern,
        [this, handler = std::move(handler)](const Request& request) {
          return handler(*this, request);
        },
        std::move(queries), access);
  }
};

/// Adds a route for every path of openapi.json, except /api/v1/openapi.json itself.
void add_routes(Api& api);

// The parts of add_routes() in other files.
void add_submitting(Api& api);
void add_job_lists(Api& api);
void add_frames_zip(Api& api);
void add_farm(Api& api);

/// Returns the number of the job in the path of the request. Throws Problem 400.
JobId job_in(const Request& request);

}  // namespace parray::http
