#pragma once

#include <spdlog/logger.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/http/upload_reader.h"
#include "proto/inproc_link.h"

namespace parray::http {

struct Options {
  std::string address;  ///< HOST:PORT; empty: no HTTP
  std::string keys;     ///< directory of the farm's keys; empty: none, and no tokens are asked for
  std::string state;    ///< directory; empty: nothing outlives the process
  std::vector<std::string> hosts;          ///< names that it is called by, beside localhost
  std::vector<std::string> webhook_hosts;  ///< that are told when jobs have ended
  std::size_t threads = 80;                ///< requests answered at once, event streams aside
  std::size_t connections = 1024;          ///< in all
  std::size_t address_connections = 256;   ///< of one address
  std::size_t streams = 128;
  std::uint64_t memory = std::uint64_t{1} << 30;  ///< bytes that pictures and scenes may take here
  std::size_t requests = 1000;                    ///< a second of one address
  UploadLimits uploads{};
};

/// The coordinator's HTTP interface (openapi.json), its page and whatever else is served as text.
/// It owns nothing of the loop: it asks through a hub, as clients do. All it does happens in
/// threads of its own and in children.
class HttpService {
 public:
  /// Listens when it returns. `hub` must outlive this. Throws InputError, RunError.
  HttpService(const Options& options, InprocHub& hub, std::shared_ptr<spdlog::logger> log);
  ~HttpService();
  HttpService(const HttpService&) = delete;
  HttpService& operator=(const HttpService&) = delete;

  /// GET `path` is answered by `text` from now on. Before start(); `text`: any thread.
  void serve_text(const std::string& path, const std::string& type,
                  std::function<std::string()> text);
  void start();
  /// HOST:PORT as bound.
  [[nodiscard]] const std::string& address() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parray::http
