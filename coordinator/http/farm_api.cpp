// Answers requests about the farm, its workers and this server.
#include <nlohmann/json.hpp>

#include "common/base/printable.h"
#include "coordinator/http/api.h"
#include "proto/zmq_link.h"

namespace parray::http {
namespace {

bool flag_in(const Request& request, const std::string& name) {
  const auto found = request.query.find(name);
  if (found == request.query.end() || found->second == "false") return false;
  if (found->second != "true") {
    throw Problem(400, name + ": '" + printable(found->second) + "' is not true or false", 2);
  }
  return true;
}

/// Throws Problem 404 if no worker can have this name.
void check_worker_name(const std::string& name) {
  if (name.empty() || name.size() > max_name || printable(name, max_name) != name) {
    throw Problem(404, "'" + printable(name) + "' is not a worker name", 2);
  }
}

/// Sends a request about one worker. Throws Problem 404 if no worker of this name is connected.
template <typename Answer, typename Asked>
Answer ask_about_worker(Api& api, const Request& request) {
  const std::string& name = request.arguments.at(0);
  check_worker_name(name);
  return with_status(409, 404, [&] {
    return api.loop.ask<Answer>(request.sender, Asked{0, name});
  });
}

Reply worker(Api& api, const Request& request) {
  return json_reply(ask_about_worker<msg::Worker, msg::ShowWorker>(api, request).worker);
}

Reply worker_log(Api& api, const Request& request) {
  return with_status(500, 502, [&] {  // the worker does not answer
    return json_reply({{"lines", ask_about_worker<msg::Log, msg::ShowLog>(api, request).lines}});
  });
}

Reply workers_reply(const msg::Workers& answer) {
  return json_reply({{"workers", answer.workers}, {"total", answer.total}});
}

Reply list_workers(Api& api, const Request& request) {
  const auto limit =
      number_parameter<std::uint32_t>(request, "limit", 1, msg::most_listed, msg::most_listed);
  const auto offset = number_parameter<std::uint32_t>(request, "offset", 0, 1'000'000, 0);
  return workers_reply(
      api.loop.ask<msg::Workers>(request.sender, msg::ListWorkers{0, offset, limit}));
}

Reply steer_workers(Api& api, const Request& request, msg::WorkerAction action) {
  const std::string& name = request.arguments.at(0);
  check_worker_name(name);
  return with_status(409, 403, [&] {
    return workers_reply(api.loop.ask<msg::Workers>(
        request.sender, msg::SteerWorkers{0, action, flag_in(request, "host"), name}));
  });
}

Reply farm(Api& api, const Request& request, bool history) {
  return json_reply(api.loop.ask<msg::Farm>(request.sender, msg::ShowFarm{0, history}).farm);
}

Reply server(Api& api, const Request& request) {
  const Sender& sender = request.sender;
  const Options& options = api.options;
  const bool keys = !options.keys.empty();
  return json_reply({{"version", PARRAY_VERSION},
                     {"user", sender.name},
                     {"role", name_of(sender.role)},
                     {"worker_address", options.worker_address},
                     {"worker_command", "parray-worker --coordinator " + options.worker_address +
                                            (keys ? " --keys worker.key" : "")},
                     {"loopback", is_loopback(options.worker_address)},
                     {"keys", keys},
                     {"webhooks", !options.webhook_hosts.empty()},
                     {"limits",
                      {{"body_bytes", options.uploads.body_bytes},
                       {"parts", options.uploads.parts},
                       {"streams", options.streams}}}});
}

}  // namespace

void add_farm(Api& api) {
  api.add("GET", "/api/v1/workers", list_workers, {"limit", "offset"});
  for (const msg::WorkerAction action : {msg::WorkerAction::drain, msg::WorkerAction::readmit}) {
    const std::string name(worker_action_names[static_cast<std::size_t>(action)]);
    api.add("POST", "/api/v1/workers/{name}/" + name,
            [action](Api& with, const Request& request) {
              return steer_workers(with, request, action);
            },
            {"host"});
  }
  for (const bool history : {false, true}) {
    api.add("GET", history ? "/api/v1/farm/history" : "/api/v1/farm",
            [history](Api& with, const Request& request) { return farm(with, request, history); });
  }
  api.add("GET", "/api/v1/workers/{name}", worker);
  api.add("GET", "/api/v1/workers/{name}/log", worker_log);
  api.add("GET", "/api/v1/server", server);
}

}  // namespace parray::http
