#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/keys.h"

/// Requests and replies as this program sees them: the library that speaks HTTP stays behind
/// server.cpp.
namespace parray::http {

/// Names without regard to upper and lower case are the library's affair: ours are lower case.
using Fields = std::vector<std::pair<std::string, std::string>>;

/// What a request is refused or has failed with (RFC 9457). `what()` is one line, the command
/// line's where it has one.
class Problem : public std::runtime_error {
 public:
  /// `exit_status`: that the command line would exit with; 0: it knows no such problem.
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

/// Bytes of a body that no handler waits for: it has come before the request is handed over. Every
/// handler that reads a body takes as many.
inline constexpr std::size_t small_body = 4096;

/// Takes a body as it comes. What its members throw ends the reading.
class BodySink {
 public:
  virtual ~BodySink() = default;
  /// Called with the Content-Length of a body, framing of parts included, before anything is read.
  /// Throws Problem 413 if that is too long.
  virtual void expect(std::uint64_t bytes) = 0;
  /// Of a form: what follows belongs to the part `name`.
  virtual void begin_part(const std::string& name, const std::string& file_name) = 0;
  virtual void take(std::string_view bytes) = 0;
};

struct Request {
  std::string method;  ///< upper case
  std::string path;    ///< decoded, without the query
  std::multimap<std::string, std::string> query;
  std::string remote;  ///< address of the other side
  /// Value of a field of the head, "" where there is none.
  std::function<std::string(const char*)> field;
  bool is_whole = true;  ///< all of its body is in memory
  /// Reads the body; at most once. Throws Problem. `form`: as multipart/form-data.
  std::function<void(BodySink&, bool form)> read_body;
  Sender sender{};  ///< once the guard has let it in
};

/// Events for one listener, as they travel.
class EventStream {
 public:
  virtual ~EventStream() = default;
  /// The next ones, or, after a while without any, a comment that keeps the connection alive.
  /// None: there will be no more.
  virtual std::optional<std::string> next() = 0;
};

class FileBody;

struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
  Fields headers{};
  std::shared_ptr<EventStream> events{};   ///< instead of a body
  std::shared_ptr<const FileBody> file{};  ///< likewise
};

/// "Not Found" of 404.
std::string_view reason_of(int status);

/// The fields that a reply is sent with, beside those of its body.
Fields fields_of(const Reply& reply);

Reply json_reply(const std::string& text, int status = 200);
Reply text_reply(std::string text, const std::string& type = "text/plain; charset=utf-8");
Reply problem_reply(const Problem& problem);

/// In whose turn the request is served: its user's, or, where there are no keys, its address's.
std::string owner_of(const Request& request);

/// Reads at most `most` bytes; throws Problem 413 beyond. For small bodies.
std::string read_text(const Request& request, std::size_t most);

/// The media type of the body, lower case and without parameters.
std::string media_type(const Request& request);

}  // namespace parray::http
