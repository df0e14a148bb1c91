#include "coordinator/http/http_service.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "coordinator/http/api.h"
#include "coordinator/http/assets.h"
#include "coordinator/http/guard.h"
#include "coordinator/http/server.h"
#include "coordinator/jobs/log_budget.h"
#include "coordinator/loop/limits.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;

/// Returns the directory for files of running requests: STATE/http/requests, or a temporary one.
/// Its content is deleted at the beginning and at the end.
OwnedPath requests_directory(const std::string& state) {
  std::error_code error;
  if (state.empty()) {
    const fs::path start = fs::temp_directory_path(error) / "parray-http-";
    fs::path path = make_directory(start);
    if (path.empty()) throw RunError("creating " + start.string() + "XXXXXX failed");
    return OwnedPath(std::move(path));
  }
  fs::path path = fs::path(state) / "http" / "requests";
  fs::remove_all(path, error);
  fs::create_directories(path, error);
  if (error) throw RunError("creating " + path.string() + ": " + error.message());
  fs::permissions(path, fs::perms::owner_all, error);
  return OwnedPath(std::move(path));
}

/// Permits only files of this server: no inline scripts or styles, nothing from other sites.
constexpr const char* page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; manifest-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Limit of requests that are answered at the same time. Event streams, waits for jobs and large
/// uploads do not count.
constexpr std::size_t most_requests = 80;

class Service {
 public:
  Service(const Options& options, InprocHub& hub, std::shared_ptr<spdlog::logger> log)
      : log_(std::move(log)),
        options_(options),
        directory_(requests_directory(options.state)),
        guard_(options.keys, options.hosts),
        request_budget_(options.requests),
        loop_(hub),
        memory_(options.memory),
        uploads_(runner_, memory_, directory_.path(), options.uploads),
        pictures_(loop_, runner_, memory_, std::max(options.memory, std::uint64_t{1} << 28),
                  directory_.path()),
        events_(loop_, options.streams),
        webhooks_(loop_, options.webhook_hosts, options.webhooks, options.keep_webhooks),
        api_{router_, loop_, uploads_, pictures_, events_, webhooks_, counts_, options_},
        warnings_(log_, 1),
        server_(options.address,
                most_requests + 2 * options.streams,  // streams, and waits for jobs
                {.connections = options.connections, .of_address = options.address_connections},
                [this](const Request& request) { return answer(request); },
                {[this](const RequestHead& head, const std::string& address, bool reserve) {
                   return answer_early(head, address, reserve);
                 },
                 [this](const std::string& line) { warnings_.warn(SteadyClock().now(), line); },
                 [this](int status) { counts_.add(status); }}) {
    add_routes(api_);
    for (const Asset& asset : assets()) serve_asset(asset);
  }

  ~Service() {
    loop_.stop();
    runner_.stop();
    uploads_.stop();
    pictures_.stop();
    if (confinement_check_.joinable()) confinement_check_.join();
    events_.stop();
    webhooks_.stop();
  }

  void start() {
    confinement_check_ = std::thread([this] { check_confinement(); });
    server_.start();
  }
  [[nodiscard]] const std::string& address() const { return server_.address(); }

 private:
  /// Logs a warning if this kernel cannot confine child processes.
  void check_confinement() {
    try {
      const OwnedPath own = work_directory(directory_.path());
      const OwnedPath foreign = work_directory(directory_.path());
      const fs::path inside = own.path() / "inside";
      const fs::path outside = foreign.path() / "outside";
      fs::create_directory(inside);
      std::ofstream(outside) << "secret";
      const ChildEnd end = runner_.run({"confinement", outside.string()}, inside, ChildLimits{});
      if (end.status != 0) throw RunError(end.message);
      if (end.message.empty()) return;
      log_->warn(
          "HTTP: this kernel (Landlock, seccomp) does not fully confine the process that reads "
          "uploaded scenes: {}",
          printable(end.message, 500));
    } catch (const RunError& error) {
      log_->debug(
          "HTTP: the check whether the process that reads uploaded scenes is confined did not "
          "complete: {}",
          error.what());
    }
  }

  void serve_asset(const Asset& asset) {
    const std::string etag =
        '"' + sha256_hex(std::as_bytes(std::span(asset.bytes))).substr(0, 32) + '"';
    const auto answer = [&asset, etag](const Request& request) {
      Reply reply{.type = std::string(asset.type),
                  .headers = {{"ETag", etag}, {"Cache-Control", "no-cache"}}};
      if (asset.type.starts_with("text/html")) {
        reply.headers.emplace_back("Content-Security-Policy", page_policy);
      }
      if (request.field("if-none-match").find(etag) != std::string::npos) {
        reply.status = 304;
      } else {
        reply.body = std::make_shared<const std::string>(asset.bytes);
      }
      return reply;
    };
    router_.add("GET", std::string(asset.path), answer, {}, Router::Access::open);
  }

  /// Answers /healthz at once, however busy the server is, and refuses connections beyond the
  /// limit.
  [[nodiscard]] std::optional<Reply> answer_early(const RequestHead& head,
                                                  const std::string& address, bool reserve) const {
    const bool looks = head.method == "GET" || head.method == "HEAD";
    if (looks && head.target == "/healthz") {
      Request request;
      request.method = head.method;
      request.path = head.target;
      request.remote = address;
      request.field = [&head](const char* name) { return head.field(name); };
      try {
        check_origin(request);
      } catch (const Problem& problem) {
        return problem_reply(problem);
      }
      return text_reply("ok\n");
    }
    if (!reserve || (looks && head.target == "/readyz")) return {};
    return problem_reply(Problem(503,
                                 "the limit of connections is reached (--http-connections, "
                                 "--http-connections-per-address): try again later",
                                 0, {{"Retry-After", "5"}}));
  }

  /// Checks the origin as the guard does. Health probes may omit Host, as HTTP/1.0 permits;
  /// browsers always send it.
  void check_origin(const Request& request) const {
    const bool probe = request.path == "/healthz" || request.path == "/readyz";
    if (!probe || !request.field("host").empty()) guard_.check_origin(request);
  }

  Reply answer(const Request& from) {
    Reply reply = [&] {
      try {
        return answer_or_throw(from);
      } catch (const Problem& problem) {
        return problem_reply(problem);
      } catch (const InputError& error) {
        return problem_reply(Problem(422, error.what(), 2));
      } catch (const std::bad_alloc&) {
        return problem_reply(Problem(503, "the coordinator is out of memory: try again later", 1));
      } catch (const RunError& error) {
        log_->warn("HTTP {} {}: {}", from.method, printable(from.path, 200), error.what());
        return problem_reply(Problem(500, error.what(), 1));
      } catch (const std::exception& error) {
        log_->error("HTTP {} {}: {}", from.method, printable(from.path, 200), error.what());
        return problem_reply(Problem(500, std::string("internal error: ") + error.what(), 1));
      }
    }();
    log_->debug("HTTP {} {} {}: {}", from.remote, printable(from.method), printable(from.path, 200),
                reply.status);
    return reply;
  }

  Reply answer_or_throw(const Request& from) {
    check_origin(from);
    {
      const std::scoped_lock lock(mutex_);
      if (!request_budget_.allow(SteadyClock().now(), from.remote)) {
        throw Problem(429, "too many requests per second (--max-requests): send fewer", 0,
                      {{"Retry-After", "1"}});
      }
    }
    Router::Match match = router_.find(from);
    Request request = from;
    request.arguments = std::move(match.arguments);
    if (match.route->access == Router::Access::guarded) request.sender = guard_.admit(from);
    return match.route->answer(request);
  }

  const std::shared_ptr<spdlog::logger> log_;
  const Options options_;
  const OwnedPath directory_;
  Guard guard_;
  std::mutex mutex_;              // guards request_budget_
  RequestBudget request_budget_;  ///< requests per second and address
  Router router_;
  LoopClient loop_;
  ChildRunner runner_;
  Budget memory_;
  UploadReader uploads_;
  PictureCache pictures_;
  Events events_;
  Webhooks webhooks_;
  RequestCounts counts_;
  Api api_;
  std::thread confinement_check_;
  LogBudget warnings_;  ///< used by the connection manager's thread
  Server server_;       ///< declared last, so that it is destroyed first
};

}  // namespace

void check_address(const std::string& address) {
  if (!address.empty()) static_cast<void>(parse_address(address));
}

HttpService serve_http(const Options& options, InprocHub& hub,
                       const std::shared_ptr<spdlog::logger>& log) {
  const auto service = std::make_shared<Service>(options, hub, log);
  service->start();
  return {service->address(), service};
}

}  // namespace parray::http
