#include "coordinator/http/conversation.h"

#include <httplib.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <set>
#include <utility>

#include "common/base/printable.h"
#include "coordinator/http/connection.h"
#include "coordinator/http/request_head.h"

namespace parray::http {
namespace {

/// What the library reads and writes: the connection, within limits of time and of the length of a
/// line. What it writes is kept until it is asked for more or has ended, unless it is to go at
/// once.
class LimitedStream final : public httplib::Stream {
 public:
  explicit LimitedStream(Connection& connection) : connection_(connection) {}

  /// From now on what is written is sent before write() returns.
  void send_at_once() { at_once_ = true; }
  /// Sends bytes that lie in the memory of `file` from the file itself, without a copy.
  void share(std::shared_ptr<const FileBody> file) { file_ = std::move(file); }
  [[nodiscard]] bool failed() const { return failed_; }

  bool is_readable() const override { return !failed_; }
  bool is_writable() const override { return !failed_; }

  ssize_t read(char* bytes, std::size_t size) override {
    if (failed_ || !has_input()) return -1;
    const std::string_view there = connection_.input().substr(0, size);
    std::ranges::copy(there, bytes);
    connection_.consume(there.size());
    return in_short_line(there, size) ? static_cast<ssize_t>(there.size()) : -1;
  }

  ssize_t write(const char* bytes, std::size_t size) override {
    if (failed_) return -1;
    if (is_of_file(bytes)) {
      connection_.put(file_, {bytes, size});
    } else {
      connection_.put({bytes, size});
    }
    if (at_once_) {
      to_send_.restart();
      failed_ = !connection_.await_flush(to_send_);
    }
    return failed_ ? -1 : static_cast<ssize_t>(size);
  }

  void get_remote_ip_and_port(std::string& address, int& port) const override {
    address = connection_.address();
    port = 0;
  }
  void get_local_ip_and_port(std::string& address, int& port) const override {
    address.clear();
    port = 0;
  }
  /// The library refuses numbers from FD_SETSIZE on, which matter to nobody here.
  socket_t socket() const override { return 0; }

 private:
  [[nodiscard]] bool is_of_file(const char* bytes) const {
    if (!file_) return false;
    const std::string_view all = file_->bytes();
    return std::less_equal<>()(all.data(), bytes) && std::less<>()(bytes, all.data() + all.size());
  }

  bool has_input() {
    if (!connection_.input().empty()) return true;
    constexpr std::size_t most = std::size_t{1} << 16;
    // Who waits for "100 Continue" has to get it first.
    const bool asks = !connection_.has_output() || connection_.await_flush(to_send_);
    failed_ = !asks || connection_.await_input(most, due_) != Connection::Moved::some;
    return !failed_;
  }

  /// The library reads lines, those of chunks' sizes, byte by byte and however long they are.
  bool in_short_line(std::string_view read, std::size_t asked) {
    constexpr std::size_t longest = most_head_bytes;
    line_ = asked == 1 && read != "\n" ? line_ + 1 : 0;
    failed_ = failed_ || line_ > longest;
    return !failed_;
  }

  Connection& connection_;
  Pace due_ = usual_pace();
  Pace to_send_ = usual_pace();
  std::shared_ptr<const FileBody> file_;
  std::size_t line_ = 0;
  bool at_once_ = false;
  bool failed_ = false;
};

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

/// Reads and drops a body that no handler used. The next request begins behind it. Returns false if
/// the body is too long for that.
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

/// The library's server without its sockets.
class Engine final : public httplib::Server {
 public:
  explicit Engine(const std::function<Reply(const Request&)>& answer) : answer_(answer) {
    svr_sock_ = 0;  // it takes a server without one for one that is stopping
    configure();
  }

  bool converse(LimitedStream& stream) {
    stream_ = &stream;
    bool closed = false;
    const bool whole = process_request(stream, false, closed, nullptr);
    return whole && !closed && !stream.failed();
  }

 private:
  void configure() {
    set_keep_alive_max_count(1000);
    set_keep_alive_timeout(static_cast<time_t>(SeatLimits{}.idle_time / seconds(1)));
    // What has no body is answered before the library looks for one.
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
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
    Post(everything, handler);
    Put(everything, handler);
    Patch(everything, handler);
    Delete(everything, handler);
    // What the library refuses by itself has no body of ours yet.
    set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
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
      response.headers.clear();
      send_reply(response, problem_reply(Problem(413, "this request takes no such body")));
    }
    send_and_close(response);
  }

  void send_events(httplib::Response& response, const std::shared_ptr<EventStream>& events) {
    stream_->send_at_once();
    response.set_header("X-Accel-Buffering", "no");
    response.set_chunked_content_provider(
        "text/event-stream", [events](std::size_t /*offset*/, httplib::DataSink& sink) {
          const std::optional<std::string> text = events->next();
          if (!text) {
            sink.done();
            return true;
          }
          return sink.write(text->data(), text->size());
        });
  }

  void send_file(httplib::Response& response, const std::shared_ptr<const FileBody>& file,
                 const std::string& type) {
    stream_->share(file);
    response.set_content_provider(
        file->bytes().size(), type,
        [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          return sink.write(file->bytes().data() + offset, length);
        });
  }

  void send_reply(httplib::Response& response, const Reply& reply) {
    response.status = reply.status;
    for (const auto& [name, value] : fields_of(reply)) response.set_header(name, value);
    if (reply.events) {
      send_events(response, reply.events);
    } else if (reply.file && !reply.file->bytes().empty()) {
      send_file(response, reply.file, reply.type);
    } else if (reply.status != 204 && reply.status != 304) {
      response.set_content(*reply.body, reply.type);
    }
  }

  const std::function<Reply(const Request&)>& answer_;
  LimitedStream* stream_ = nullptr;  ///< of the request that is being answered
};

}  // namespace

Pace usual_pace() {
  constexpr Time patience = seconds(10);
  constexpr double bytes_a_second = 32768;
  return {patience, bytes_a_second};
}

class Conversation::Impl {
 public:
  explicit Impl(std::function<Reply(const Request&)> answer)
      : answer_(std::move(answer)), engine_(answer_) {}

  bool answer(Connection& connection) {
    LimitedStream stream(connection);
    return engine_.converse(stream);
  }

 private:
  const std::function<Reply(const Request&)> answer_;
  Engine engine_;
};

Conversation::Conversation(std::function<Reply(const Request&)> answer)
    : impl_(std::make_unique<Impl>(std::move(answer))) {}
Conversation::~Conversation() = default;
bool Conversation::answer(Connection& connection) { return impl_->answer(connection); }

}  // namespace parray::http
