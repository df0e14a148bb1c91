// Answers requests about the farm, its workers and this server.
#include <nlohmann/json.hpp>

#include "common/base/printable.h"
#include "coordinator/http/api.h"
#include "coordinator/http/loop_client.h"

namespace parray::http {
namespace {

using Arguments = std::vector<std::string>;

/// Sends a request about one worker. Throws Problem 404 if no worker of this name is connected.
template <typename Answer, typename Asked>
Answer ask_about_worker(LoopClient& loop, const Request& request, const std::string& name) {
  check_worker_name(name);
  return with_status(409, 404, [&] { return loop.ask<Answer>(request.sender, Asked{0, name}); });
}

Reply worker_log(LoopClient& loop, const Request& request, const std::string& name) {
  return with_status(500, 502, [&] {  // the worker does not answer
    return json_reply(
        {{"lines", ask_about_worker<msg::Log, msg::ShowLog>(loop, request, name).lines}});
  });
}

}  // namespace

void check_worker_name(const std::string& name) {
  if (name.empty() || name.size() > max_name || printable(name, max_name) != name) {
    throw Problem(404, "'" + printable(name) + "' is not a worker name", 2);
  }
}

void Api::add_farm(Router& router) {
  const auto farm = [this](const Request& request, bool history) {
    return json_reply(loop_.ask<msg::Farm>(request.sender, msg::ShowFarm{0, history}).farm);
  };
  router.add("GET", "/api/v1/farm",
             [farm](const Request& request, const Arguments&) { return farm(request, false); });
  router.add("GET", "/api/v1/farm/history",
             [farm](const Request& request, const Arguments&) { return farm(request, true); });
  router.add(
      "GET", "/api/v1/workers/{name}", [this](const Request& request, const Arguments& arguments) {
        return json_reply(
            ask_about_worker<msg::Worker, msg::ShowWorker>(loop_, request, arguments.at(0)).worker);
      });
  router.add("GET", "/api/v1/workers/{name}/log",
             [this](const Request& request, const Arguments& arguments) {
               return worker_log(loop_, request, arguments.at(0));
             });
  router.add("GET", "/api/v1/server", plain(&Api::server));
}

Reply Api::server(const Request& request) const {
  const Sender& sender = request.sender;
  return json_reply({{"version", PARRAY_VERSION},
                     {"user", sender.name},
                     {"role", name_of(sender.role)},
                     {"worker_address", facts_.worker_address},
                     {"worker_command", "parray-worker --coordinator " + facts_.worker_address +
                                            (facts_.keys ? " --keys worker.key" : "")},
                     {"loopback", facts_.loopback},
                     {"keys", facts_.keys},
                     {"webhooks", facts_.webhooks},
                     {"limits",
                      {{"body_bytes", facts_.body_bytes},
                       {"parts", facts_.parts},
                       {"streams", facts_.streams}}}});
}

}  // namespace parray::http
