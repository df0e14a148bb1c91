#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/keys.h"

/// Requests and replies, as handlers see them. Handlers do not depend on the HTTP library.
namespace parray::http {

/// Header fields: name and value. HTTP ignores the case of names.
using Fields = std::vector<std::pair<std::string, std::string>>;

/// Why a request was refused or failed: an HTTP status and a message (RFC 9457). `what()` is one
/// line. If the command line has a message for the problem, it is that message, with the JSON
/// pointer "options: /target_error" in place of the option --target-error.
class Problem : public std::runtime_error {
 public:
  /// `exit_status`: exit status of the command line for this problem; 0: the command line has no
  /// such problem. `headers`: additional header fields of the reply.
  Problem(int status, const std::string& detail, int exit_status = 0, Fields headers = {})
      : std::runtime_error(detail),
        status_(status),
        exit_status_(exit_status),
        headers_(std::move(headers)) {}

  [[nodiscard]] int status() const { return status_; }
  [[nodiscard]] int exit_status() const { return exit_status_; }
  [[nodiscard]] const Fields& headers() const { return headers_; }

 private:
  int status_;
  int exit_status_;
  Fields headers_;
};

/// Bodies up to this size, in bytes, are complete before a handler gets the request, unless the
/// client stops sending. Every handler that reads a body accepts this size.
inline constexpr std::size_t small_body = 4096;

/// Receives a body piece by piece. An exception from a member ends the reading.
class BodySink {
 public:
  virtual ~BodySink() = default;
  /// Called with the Content-Length, which includes the framing of parts, before anything is read;
  /// with 0 if the body is chunked. Throws Problem 413 if it is too large.
  virtual void expect(std::uint64_t bytes) = 0;
  /// Called for each part of a form. The bytes that follow belong to the part `name`.
  virtual void begin_part(const std::string& name, const std::string& file_name) = 0;
  /// Receives the next bytes.
  virtual void take(std::string_view bytes) = 0;
};

/// A request, as handlers see it.
struct Request {
  std::string method;                    ///< upper case
  std::string path;                      ///< decoded, without the query
  std::vector<std::string> arguments{};  ///< parts of the path that stand for {...} in the route
  std::multimap<std::string, std::string> query;
  std::string remote;  ///< IP address of the client
  /// Returns the value of a header field, "" if it is missing. `name` is in lower case.
  std::function<std::string(const char*)> field;
  bool is_whole = true;  ///< the whole body has arrived, so that read_body() does not wait
  /// Reads the body; callable once. `form`: parses it as multipart/form-data. Throws Problem.
  std::function<void(BodySink&, bool form)> read_body;
  Sender sender{};  ///< set after the guard has admitted the request
};

/// A body that is made while it is sent. The client reads its pieces as one body.
class BodyStream {
 public:
  virtual ~BodyStream() = default;
  /// Waits for the next piece and returns it. Returns nothing when the body has ended. An exception
  /// cuts the connection, so that the client notices that the body is incomplete.
  virtual std::optional<std::string> next() = 0;
};

class FileBody;

/// An answer. Its content is `body`, `stream` or `file`.
struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
  Fields headers{};
  std::shared_ptr<BodyStream> stream{};    ///< replaces `body` if set
  std::shared_ptr<const FileBody> file{};  ///< replaces `body` if set
};

/// Answers a request.
using Answer = std::function<Reply(const Request&)>;

/// Returns the result of `act()`. If that throws a Problem with the status `from`, throws a Problem
/// with the same message and exit status, the status `to`, and no header fields.
auto with_status(int from, int to, const auto& act) {
  try {
    return act();
  } catch (const Problem& problem) {
    if (problem.status() != from) throw;
    throw Problem(to, problem.what(), problem.exit_status());
  }
}

/// Returns the reason phrase of a status, such as "Not Found" for 404; "Error" if it is unknown.
std::string_view reason_of(int status);

/// Returns the header fields of the reply, except Content-Type and Content-Length. Adds those that
/// every reply has, such as Cache-Control.
Fields fields_of(const Reply& reply);

/// Return a reply with the given content. problem_reply() returns a document of RFC 9457.
Reply json_reply(const nlohmann::json& content, int status = 200);
Reply text_reply(std::string text, const std::string& type = "text/plain; charset=utf-8");
Reply problem_reply(const Problem& problem);

/// Returns the name under which the request waits for its turn: "user NAME", or "address ..." with
/// owner_of_address() if there are no keys.
std::string owner_of(const Request& request);

/// Returns the media type of the body in lower case, without parameters.
std::string media_type(const Request& request);

/// The header of JSON bodies, for messages. curl sends another one unless it is told.
inline constexpr const char* json_header = "'Content-Type: application/json'";
/// Returns the beginning of a message that refuses the media type of the body.
std::string wrong_media_type(const Request& request);

/// Reads a small JSON body; a discarded value if it is not JSON. Throws Problem 413 if it has more
/// than `most` bytes, 415 with the example `form` if its media type is not JSON.
nlohmann::json json_body(const Request& request, std::size_t most, const std::string& form);

}  // namespace parray::http
