#include "coordinator/http/conversation.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "common/base/printable.h"
#include "common/base/text.h"
#include "coordinator/http/framing.h"

namespace parray::http {
namespace {

/// Lets cpp-httplib read one request and write the answer, within time limits. The library reads
/// the head in normalized form and simple chunks. Answers stay in the connection's output until
/// more input is needed or the request has ended, unless send_at_once() was called.
class LimitedStream final : public httplib::Stream {
 public:
  /// `connection`: its input begins with `head`.
  LimitedStream(Connection& connection, const RequestHead& head)
      : connection_(connection), text_(text_of(head)), chunked_(head.chunked) {
    connection_.consume(head.bytes);
    sends_continue_ = head.expects && connection_.input().empty();
  }

  /// Makes write() send its bytes before it returns.
  void send_at_once() { at_once_ = true; }
  /// Sends bytes that lie in the memory of `file` directly from the file, without a copy.
  void share(std::shared_ptr<const FileBody> file) { file_ = std::move(file); }
  /// Returns whether reading or writing failed. The connection must be closed then.
  [[nodiscard]] bool failed() const { return problem_ || write_failed_; }
  /// Returns why reading failed.
  [[nodiscard]] Problem problem() const {
    return problem_.value_or(Problem(
        400, "the request body is damaged: check the parts of the form, or the compression"));
  }

  bool is_readable() const override { return !problem_; }
  bool is_writable() const override { return !write_failed_; }

  ssize_t read(char* bytes, std::size_t size) override {
    if (problem_) return -1;
    if (text_.size() > used_) return take_text(bytes, size);
    try {
      if (chunked_) return next_chunk() ? take_text(bytes, size) : -1;
      if (connection_.input().empty()) await_input();
    } catch (const Problem& problem) {
      problem_ = problem;
      return -1;
    }
    const std::string_view there = connection_.input().substr(0, size);
    std::ranges::copy(there, bytes);
    connection_.consume(there.size());
    return static_cast<ssize_t>(there.size());
  }

  ssize_t write(const char* bytes, std::size_t size) override {
    if (write_failed_) return -1;
    if (is_of_file(bytes)) {
      connection_.put(file_, {bytes, size});
    } else {
      connection_.put({bytes, size});
    }
    if (at_once_) {
      send_pace_.restart();
      write_failed_ = !connection_.await_flush(send_pace_);
    }
    return write_failed_ ? -1 : static_cast<ssize_t>(size);
  }

  void get_remote_ip_and_port(std::string& address, int& port) const override {
    address = connection_.address();
    port = 0;
  }
  void get_local_ip_and_port(std::string& address, int& port) const override {
    address.clear();
    port = 0;
  }
  /// Returns 0: the library rejects descriptors of FD_SETSIZE and above, and never uses this one.
  socket_t socket() const override { return 0; }

 private:
  [[nodiscard]] bool is_of_file(const char* bytes) const {
    if (!file_) return false;
    const std::string_view all = file_->bytes();
    return std::less_equal<>()(all.data(), bytes) && std::less<>()(bytes, all.data() + all.size());
  }

  ssize_t take_text(char* bytes, std::size_t size) {
    const std::string_view taken = std::string_view(text_).substr(used_, size);
    std::ranges::copy(taken, bytes);
    used_ += taken.size();
    return static_cast<ssize_t>(taken.size());
  }

  /// Puts the next piece of a chunked body into text_. Returns false if the body has ended. Throws
  /// Problem.
  bool next_chunk() {
    while (!chunks_.done()) {
      const ChunkDecoder::Step step = chunks_.step(connection_.input());
      used_ = 0;
      text_ = chunks_.done()      ? "0\r\n\r\n"
              : step.data.empty() ? ""
                                  : fmt::format("{:x}\r\n{}\r\n", step.data.size(), step.data);
      connection_.consume(step.used);
      if (!text_.empty()) return true;
      if (step.used == 0) await_input();
    }
    return false;
  }

  /// Throws Problem if no more input arrives.
  void await_input() {
    constexpr std::size_t most = std::size_t{1} << 16;
    if (std::exchange(sends_continue_, false)) connection_.put(continue_line);
    const bool sent = !connection_.has_output() || connection_.await_flush(send_pace_);
    if (sent && connection_.await_input(most, read_pace_) == Connection::Moved::some) return;
    throw read_pace_.over()
        ? Problem(408, "the request body arrives too slowly: send at least 32 KiB a second")
        : Problem(400, "the request body ended early: send as many bytes as announced");
  }

  Connection& connection_;
  Pace read_pace_;
  Pace send_pace_;
  std::shared_ptr<const FileBody> file_;
  std::string text_;      ///< read next: the head, then a chunk
  std::size_t used_ = 0;  ///< bytes of text_ that were read
  const bool chunked_;
  ChunkDecoder chunks_;
  bool sends_continue_ = false;
  bool at_once_ = false;
  std::optional<Problem> problem_;  ///< why reading failed
  bool write_failed_ = false;
};

/// Passes a body to `sink`, and sets `whole` if no byte of the body is left to read. Rethrows the
/// sink's exceptions at once; the connection manager discards the rest.
void read_body(const httplib::ContentReader& reader, BodySink& sink, bool form, bool& whole) {
  std::exception_ptr thrown;
  const auto guarded = [&](const auto& work) {
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    return !thrown;
  };
  const auto take = [&](const char* data, std::size_t size) {
    return guarded([&] { sink.take({data, size}); });
  };
  const auto begin = [&](const httplib::MultipartFormData& part) {
    return guarded([&] { sink.begin_part(part.name, part.filename); });
  };
  whole = form ? reader(begin, take) : reader(take);
  if (thrown) std::rethrow_exception(thrown);
}

/// Reads and discards a body that the handler did not read.
bool discard_body(const httplib::Request& request, const httplib::ContentReader& reader) {
  const auto discard = [](const char* /*data*/, std::size_t /*size*/) { return true; };
  // The library reads a form only with the callbacks for forms.
  return request.is_multipart_form_data()
             ? reader([](const httplib::MultipartFormData& /*part*/) { return true; }, discard)
             : reader(discard);
}

/// Returns the problem for a request that the library rejected itself: invalid, or with an unknown
/// method.
Problem library_problem(const httplib::Request& request, int status) {
  static const std::set<std::string> known = {"GET", "HEAD",  "POST",    "PUT",     "DELETE",
                                              "PRI", "PATCH", "CONNECT", "OPTIONS", "TRACE"};
  if (status == 400 && !request.method.empty() && !known.contains(request.method)) {
    return Problem(405, printable(request.method) + " is not a method of this server", 0,
                   {{"Allow", "GET, HEAD, POST, PUT, DELETE"}});
  }
  if (status == 414) {
    return Problem(414, "the URL of the request is too long: use at most 8000 bytes");
  }
  return Problem(status,
                 "this request is not valid HTTP: check its first line, and its headers of at most "
                 "8000 bytes each");
}

/// Makes the library compress with gzip or not at all. The library prefers brotli, at its slowest
/// level: 0.7 s for a list of 500 jobs, where gzip takes some milliseconds.
void permit_only_gzip(httplib::Request& request) {
  const std::string name = "Accept-Encoding";
  const bool gzip = request.get_header_value(name).find("gzip") != std::string::npos;
  request.headers.erase(name);
  if (gzip) request.headers.emplace(name, "gzip");
}

/// Writes the names in a form's Content-Type in lower case. The library accepts no others.
void lower_form_type(httplib::Request& request) {
  const auto found = request.headers.find("Content-Type");
  if (found == request.headers.end()) return;
  constexpr std::string_view last = "boundary=";
  std::string& type = found->second;
  const std::string lower = lower_case(type);
  const std::size_t end = std::min(lower.find(last), lower.size()) + last.size();
  type.replace(0, end, lower, 0, end);
}

/// The library's server without sockets.
class Engine final : public httplib::Server {
 public:
  Engine(Answer answer, std::function<void(int)> answered) : answer_(std::move(answer)) {
    svr_sock_ = 0;  // the library treats an invalid socket as a stopped server
    set_logger([answered = std::move(answered)](const httplib::Request& /*request*/,
                                                const httplib::Response& response) {
      answered(response.status);
    });
    set_keep_alive_max_count(1000);
    set_keep_alive_timeout(static_cast<time_t>(SeatLimits{}.idle_time / seconds(1)));
    // Requests without a body are answered before the library looks for one.
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      constexpr std::size_t longest_path = 1000;  // a regular expression matches it
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
    // Requests that the library rejects have no error document yet.
    set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
      if (!response.body.empty() || response.content_provider_ || response.status < 400) return;
      // The next request begins at an unknown byte.
      send_last(response, problem_reply(library_problem(request, response.status)));
    });
  }

  /// Answers one request. Returns false if the connection must be closed.
  bool converse(Connection& connection) {
    const std::string_view input = connection.input();
    const RequestHead head = parse_head(input.substr(0, end_of_head(input, 0).value_or(0)));
    LimitedStream stream(connection, head);
    stream_ = &stream;
    head_ = &head;
    is_whole_ = connection.is_whole();
    bool closed = false;
    const bool answered = process_request(stream, false, closed, nullptr);
    return answered && !closed && !stream.failed();
  }

 private:
  void serve(const httplib::Request& from, httplib::Response& response,
             const httplib::ContentReader* reader) {
    // Ranges are ignored: no client needs them, and nothing here checks the library's code for
    // them.
    const_cast<httplib::Request&>(from).ranges.clear();
    permit_only_gzip(const_cast<httplib::Request&>(from));
    lower_form_type(const_cast<httplib::Request&>(from));
    const bool had_body = head_->has_body();
    bool whole = !had_body;
    if (had_body && (from.method == "GET" || from.method == "HEAD")) {
      const_cast<httplib::Request&>(from).method = "GET";  // so that the library closes
      const Reply reply = answer_(request_of(from, nullptr, whole));
      const bool refused = reply.status >= 400;
      if (refused) return send_last(response, reply);
      return send_last(response,
                       problem_reply(Problem(400, "this method does not take a body: send none")));
    }
    // The answer to DELETE has no content, so it could not make the client stop sending.
    if (had_body && from.method == "DELETE") {
      whole = is_whole_ && reader != nullptr && discard_body(from, *reader);
      if (!whole) {
        const Problem problem(413, "this request does not take a body: send none");
        return send_last(response, problem_reply(problem));
      }
    }
    const Reply reply = answer_(request_of(from, reader, whole));
    if (!whole && !asked_ && is_whole_ && reader != nullptr) whole = discard_body(from, *reader);
    return whole ? send_reply(response, reply) : send_last(response, reply);
  }

  /// Converts the library's request. Reading its body sets `whole` if no byte is left to read.
  Request request_of(const httplib::Request& from, const httplib::ContentReader* reader,
                     bool& whole) {
    Request request;
    request.method = from.method;
    request.path = from.path;
    request.query = from.params;
    request.remote = from.remote_addr;
    request.is_whole = is_whole_;
    request.field = [&from](const char* name) { return from.get_header_value(name); };
    asked_ = false;
    request.read_body = [this, &from, &whole, reader](BodySink& sink, bool form) {
      asked_ = true;
      // Without a length the library would read until the connection ends.
      if (reader == nullptr || !head_->has_body()) return;
      if (form && from.get_header_value("Content-Type").find("boundary=") == std::string::npos) {
        throw Problem(400, "the form has no boundary: name it in Content-Type");
      }
      if (form && !from.is_multipart_form_data()) {
        throw Problem(400, "the Content-Type has blanks within multipart/form-data: remove them");
      }
      sink.expect(head_->length.value_or(0));
      read_body(*reader, sink, form, whole);
      if (!whole) throw stream_->problem();
    };
    return request;
  }

  void send_stream(httplib::Response& response, const Reply& reply) {
    stream_->send_at_once();
    response.set_header("X-Accel-Buffering", "no");
    const auto provide = [body = reply.stream](std::size_t /*offset*/, httplib::DataSink& sink) {
      const std::optional<std::string> text = body->next();
      if (text) return sink.write(text->data(), text->size());
      sink.done();
      return true;
    };
    if (head_->old) {  // HTTP/1.0 has no chunks: closing the connection ends the stream
      response.set_content_provider(reply.type, provide);
    } else {
      response.set_chunked_content_provider(reply.type, provide);
    }
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
    if (reply.stream) {
      send_stream(response, reply);
    } else if (reply.file && !reply.file->bytes().empty()) {
      send_file(response, reply.file, reply.type);
    } else if (reply.status != 204 && reply.status != 304) {
      response.set_content(*reply.body, reply.type);
    }
  }

  /// Sends a reply, and then reports failure, which is the only way to make the library close the
  /// connection.
  void send_last(httplib::Response& response, const Reply& reply) {
    send_reply(response, reply);
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

  const Answer answer_;
  // The request that is being answered.
  LimitedStream* stream_ = nullptr;
  const RequestHead* head_ = nullptr;
  bool is_whole_ = false;
  bool asked_ = false;  ///< the handler has asked for the body
};

}  // namespace

std::function<bool(Connection&)> make_conversation(Answer answer,
                                                   std::function<void(int)> answered) {
  const auto engine = std::make_shared<Engine>(std::move(answer), std::move(answered));
  return [engine](Connection& connection) { return engine->converse(connection); };
}

}  // namespace parray::http
