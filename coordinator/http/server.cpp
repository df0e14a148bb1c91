#include "coordinator/http/server.h"

#include <httplib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/base/host_port.h"
#include "common/base/printable.h"

namespace parray::http {
namespace {

/// As many threads as are needed, up to a number; whoever hands over more waits, so that
/// connections stay in the kernel's queue. Of low priority: the loop and the workers of this
/// machine go first.
class Pool final : public httplib::TaskQueue {
 public:
  explicit Pool(std::size_t most) : most_(most) {}

  void enqueue(std::function<void()> task) override {
    std::unique_lock lock(mutex_);
    taken_.wait(lock, [this] { return stopped_ || tasks_.size() < most_waiting; });
    tasks_.push_back(std::move(task));
    if (idle_ < tasks_.size() && threads_.size() < most_) add_thread();
    given_.notify_one();
  }

  void shutdown() override {
    {
      const std::scoped_lock lock(mutex_);
      stopped_ = true;
    }
    given_.notify_all();
    taken_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  static constexpr std::size_t most_waiting = 64;

  /// Where the system allows no more, those that there are do all.
  void add_thread() {
    try {
      threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      if (threads_.empty()) throw;
    }
  }

  void work() {
    constexpr int low = 5;
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), low);
    std::unique_lock lock(mutex_);
    for (;;) {
      ++idle_;
      given_.wait(lock, [this] { return stopped_ || !tasks_.empty(); });
      --idle_;
      if (tasks_.empty()) return;
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      taken_.notify_one();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  const std::size_t most_;
  std::mutex mutex_;  // guards all below
  std::condition_variable given_;
  std::condition_variable taken_;
  std::deque<std::function<void()>> tasks_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool stopped_ = false;
};

class Httplib final : public httplib::Server {
 public:
  /// The library asks for 5.
  void lengthen_backlog() const { ::listen(svr_sock_, 512); }
};

HostPort parse_address(const std::string& address) {
  if (const auto parsed = parse_host_port(address)) return *parsed;
  throw InputError("--http " + printable(address) +
                   ": is no address to serve: write HOST:PORT, as 127.0.0.1:7480");
}

/// Bytes of a refused body that are read all the same: an answer that comes before the end of what
/// is sent is lost to most clients.
constexpr std::size_t most_discarded = std::size_t{16} << 20;

/// Runs `work`; what it throws is kept, and what comes after that is discarded.
class Relay {
 public:
  template <typename Work>
  bool run(std::size_t bytes, const Work& work) {
    try {
      if (!thrown_) work();
    } catch (...) {
      thrown_ = std::current_exception();
    }
    discarded_ += thrown_ ? bytes : 0;
    return discarded_ <= most_discarded;
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  std::exception_ptr thrown_;
  std::size_t discarded_ = 0;
};

/// `whole` is set if nothing of the body is left to read.
void read_body(const httplib::ContentReader& reader, BodySink& sink, bool form, bool& whole) {
  Relay relay;
  const auto take = [&](const char* data, std::size_t size) {
    return relay.run(size, [&] { sink.take({data, size}); });
  };
  const auto begin = [&](const httplib::MultipartFormData& part) {
    return relay.run(0, [&] { sink.begin_part(part.name, part.filename); });
  };
  whole = form ? reader(begin, take) : reader(take);
  relay.rethrow();
  if (!whole) throw Problem(400, "the body is damaged or has ended early");
}

bool has_body(const httplib::Request& request) {
  const std::string length = request.get_header_value("Content-Length");
  return request.has_header("Transfer-Encoding") || (!length.empty() && length != "0");
}

/// `whole`: nothing of the body is left to read.
Request request_of(const httplib::Request& from, const httplib::ContentReader* reader,
                   bool& whole) {
  Request request;
  request.method = from.method;
  request.path = from.path;
  for (const auto& [name, value] : from.params) request.query.emplace(name, value);
  request.remote = from.remote_addr;
  request.field = [&from](const char* name) { return from.get_header_value(name); };
  request.read_body = [&from, &whole, reader](BodySink& sink, bool form) {
    // Without a length the library would read until the connection ends.
    if (reader == nullptr || !has_body(from)) return;
    if (form && !from.is_multipart_form_data()) throw Problem(400, "the form has no boundary");
    parray::http::read_body(*reader, sink, form, whole);
  };
  return request;
}

/// Reads what nobody wanted, so that it is not taken for the next request. False: there is too
/// much.
bool discard_body(const httplib::Request& request, const httplib::ContentReader* reader) {
  if (reader == nullptr) return false;
  std::size_t discarded = 0;
  const auto discard = [&](const char* /*data*/, std::size_t size) {
    discarded += size;
    return discarded <= most_discarded;
  };
  // The library knows how to read a form only as one.
  return request.is_multipart_form_data()
             ? (*reader)([](const httplib::MultipartFormData& /*part*/) { return true; }, discard)
             : (*reader)(discard);
}

/// Sends the body and fails then: only so does the library close a connection.
void send_and_close(httplib::Response& response) {
  const std::string body = std::exchange(response.body, {});
  const std::string type = response.get_header_value("Content-Type");
  response.headers.erase("Content-Type");
  response.set_header("Connection", "close");
  response.set_content_provider(
      body.size(), type,
      [body](std::size_t /*offset*/, std::size_t /*length*/, httplib::DataSink& sink) {
        sink.write(body.data(), body.size());
        return false;
      });
}

/// What the library has refused by itself: requests that are none, or of a method unknown to it.
Problem library_problem(const httplib::Request& request, int status) {
  static const std::set<std::string> known = {"GET", "HEAD",  "POST",    "PUT",     "DELETE",
                                              "PRI", "PATCH", "CONNECT", "OPTIONS", "TRACE"};
  if (status == 400 && !request.method.empty() && !known.contains(request.method)) {
    return Problem(405, printable(request.method) + " is no method that this server knows", 0,
                   {{"Allow", "GET, HEAD, POST, PUT, DELETE"}});
  }
  return Problem(status, "this request cannot be read");
}

void send_events(httplib::Response& response, const std::shared_ptr<EventStream>& events) {
  response.set_header("X-Accel-Buffering", "no");
  response.set_chunked_content_provider("text/event-stream",
                                        [events](std::size_t /*offset*/, httplib::DataSink& sink) {
                                          const std::optional<std::string> text = events->next();
                                          if (!text) {
                                            sink.done();
                                            return true;
                                          }
                                          return sink.write(text->data(), text->size());
                                        });
}

/// Large bodies are shared, not copied.
void send_body(httplib::Response& response, const std::shared_ptr<const std::string>& body,
               const std::string& type) {
  static constexpr std::size_t small = std::size_t{1} << 16;
  if (body->size() <= small || !(type.starts_with("image/") || type.ends_with("octet-stream"))) {
    response.set_content(*body, type);
    return;
  }
  response.set_content_provider(
      body->size(), type, [body](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(body->data() + offset, std::min(length, small));
      });
}

void send_reply(httplib::Response& response, const Reply& reply) {
  response.status = reply.status;
  for (const auto& [name, value] : reply.headers) response.set_header(name, value);
  if (!response.has_header("Cache-Control")) response.set_header("Cache-Control", "no-store");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  if (reply.events) {
    send_events(response, reply.events);
  } else if (reply.status != 204 && reply.status != 304) {
    send_body(response, reply.body, reply.type);
  }
}

}  // namespace

class Server::Impl {
 public:
  Impl(const std::string& address, std::size_t threads, std::function<Reply(const Request&)> answer)
      : answer_(std::move(answer)) {
    const HostPort wanted = parse_address(address);
    configure(threads);
    const int port = wanted.port == 0 ? server_.bind_to_any_port(wanted.host)
                     : server_.bind_to_port(wanted.host, wanted.port) ? wanted.port
                                                                      : -1;
    if (port < 0) {
      throw RunError("--http " + printable(address) +
                     ": cannot be bound: is another program there, or is it no address of this "
                     "machine?");
    }
    server_.lengthen_backlog();
    const bool six = wanted.host.find(':') != std::string::npos;
    address_ = (six ? "[" + wanted.host + "]" : wanted.host) + ":" + std::to_string(port);
  }

  ~Impl() {
    if (thread_.joinable()) {
      server_.stop();
      thread_.join();
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void start() {
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }

  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  void configure(std::size_t threads) {
    server_.new_task_queue = [threads] { return new Pool(threads); };
    server_.set_tcp_nodelay(true);
    server_.set_keep_alive_max_count(1000);
    server_.set_keep_alive_timeout(2);
    server_.set_read_timeout(10);
    server_.set_write_timeout(10);
    server_.set_socket_options([](int socket) {
      const int yes = 1;  // not SO_REUSEPORT: two coordinators would share a port unseen
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    // What has no body is answered before the library looks for one.
    server_.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
          constexpr std::size_t longest_path = 1000;  // it goes through a regular expression
          const bool with_body = request.method == "POST" || request.method == "PUT" ||
                                 request.method == "PATCH" || request.method == "DELETE";
          if (with_body && request.path.size() <= longest_path) {
            return httplib::Server::HandlerResponse::Unhandled;
          }
          serve(request, response, nullptr);
          return httplib::Server::HandlerResponse::Handled;
        });
    const auto handler = [this](const httplib::Request& request, httplib::Response& response,
                                const httplib::ContentReader& reader) {
      serve(request, response, &reader);
    };
    const std::string everything = "[\\s\\S]*";
    server_.Post(everything, handler);
    server_.Put(everything, handler);
    server_.Patch(everything, handler);
    server_.Delete(everything, handler);
    // What the library refuses by itself has no body of ours yet.
    server_.set_error_handler([](const httplib::Request& request, httplib::Response& response) {
      if (!response.body.empty() || response.content_provider_ || response.status < 400) return;
      send_reply(response, problem_reply(library_problem(request, response.status)));
      send_and_close(response);  // nobody knows where the next request begins
    });
  }

  void serve(const httplib::Request& from, httplib::Response& response,
             const httplib::ContentReader* reader) {
    // Parts of pictures are of no use to anybody, and the library's arithmetic for them is not
    // ours.
    const_cast<httplib::Request&>(from).ranges.clear();
    const bool had_body = has_body(from);
    bool whole = !had_body;
    if (had_body && (from.method == "GET" || from.method == "HEAD")) {
      const_cast<httplib::Request&>(from).method = "GET";  // the library closes by a body alone
      const Reply reply = answer_(request_of(from, nullptr, whole));
      const bool refused = reply.status >= 400;
      send_reply(response,
                 refused ? reply : problem_reply(Problem(400, "this method takes no body")));
      send_and_close(response);
      return;
    }
    bool asked = false;
    Request request = request_of(from, reader, whole);
    request.read_body = [&asked, read = request.read_body](BodySink& sink, bool form) {
      asked = true;
      read(sink, form);
    };
    const Reply reply = answer_(request);
    if (had_body && !asked) whole = discard_body(from, reader);
    send_reply(response, reply);
    if (whole) return;
    if (response.body.empty()) {
      send_reply(response, problem_reply(Problem(413, "this request takes no such body")));
    }
    send_and_close(response);
  }

  const std::function<Reply(const Request&)> answer_;
  Httplib server_;
  std::string address_;
  std::thread thread_;
};

Server::Server(const std::string& address, std::size_t threads,
               std::function<Reply(const Request&)> answer)
    : impl_(std::make_unique<Impl>(address, threads, std::move(answer))) {}
Server::~Server() = default;
void Server::start() { impl_->start(); }
const std::string& Server::address() const { return impl_->address(); }

}  // namespace parray::http
