#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/log/logger.h"
#include "coordinator/http/upload_reader.h"
#include "coordinator/http/webhooks.h"
#include "proto/inproc_link.h"

namespace parray::http {

/// Settings of the HTTP interface.
struct Options {
  std::string address;         ///< HOST:PORT; empty: no HTTP interface
  std::string worker_address;  ///< where workers connect: tcp://HOST:PORT
  std::string keys;   ///< directory of the farm's keys; empty: no keys, and requests need no token
  std::string state;  ///< directory of the state; empty: nothing outlives the process
  std::string webhooks;            ///< text of the pending webhooks that an earlier process stored
  Webhooks::Keep keep_webhooks;    ///< stores that text; empty: webhooks end with the process
  std::vector<std::string> hosts;  ///< accepted host names besides localhost and IP addresses
  std::vector<std::string> webhook_hosts;         ///< hosts that webhooks may address
  std::size_t connections = 1024;                 ///< limit of all connections
  std::size_t address_connections = 256;          ///< limit of connections per address
  std::size_t streams = 128;                      ///< limit of event streams
  std::uint64_t memory = std::uint64_t{1} << 30;  ///< bytes of memory for pictures and scenes
  std::size_t requests = 1000;                    ///< limit of requests per second and address
  UploadLimits uploads{};
};

/// Throws InputError unless `address` is empty or HOST:PORT.
void check_address(const std::string& address);

/// A running HTTP interface.
struct HttpService {
  std::string address;                ///< the bound address as HOST:PORT
  std::shared_ptr<const void> parts;  ///< the destruction ends all requests
};

/// Serves the coordinator's HTTP interface (openapi.json) and its web page. It accesses no data
/// of the coordinator's loop. It sends messages through a hub, as clients do. It works in threads
/// and child processes of its own. `hub` must outlive the result. Throws InputError for unusable
/// options, RunError if the address cannot be bound or a program is missing.
HttpService serve_http(const Options& options, InprocHub& hub,
                       const std::shared_ptr<spdlog::logger>& log);

}  // namespace parray::http
