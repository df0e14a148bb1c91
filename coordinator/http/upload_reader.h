#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/http/budget.h"
#include "coordinator/http/child.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/places.h"
#include "proto/messages.h"

namespace parray::http {

/// Limit of large bodies that are received at the same time.
inline constexpr std::size_t most_uploads = 24;

/// Limits of one upload.
struct UploadLimits {
  std::uint64_t body_bytes = std::uint64_t{256} << 20;  ///< bytes of all parts together
  std::size_t parts = 100;                              ///< parts of a form
  ChildLimits child{};                                  ///< of the child that reads the scene
};

/// A job of an upload: its only one, or a frame of a series.
struct Upload {
  msg::Submit submit;     ///< `frames` 0: the only job
  std::size_t place = 0;  ///< place of the frame, from 0
  std::string webhook;    ///< address of the webhook; empty: none
  Budget::Hold memory;    ///< holds the memory of `submit`
  std::string digest;     ///< SHA-256 of names and contents of all parts
};

/// Returns the value if it is a whole number >= 0. JSON does not distinguish 20 from 20.0.
std::optional<std::uint64_t> whole_in(const nlohmann::json& value);

/// The `options` of a request.
struct RequestOptions {
  std::vector<std::string> words;  ///< the others, as arguments of the command line
  std::string webhook;             ///< address of the webhook; empty: none
  std::uint64_t preview_of = 0;    ///< the job of which this one is the quick look; 0: none
};
/// Reads options from a JSON map. Checks the types of settings; parray-http-child checks everything
/// else. Throws Problem 422 with the option in its message.
RequestOptions read_options(const std::string& text);

/// Translates a message of parray-http-child for the client. `words`: those of RequestOptions. If
/// the message begins with an option of `words`, or with a file's name and then such an option, a
/// JSON pointer replaces the option: "--spp: ..." becomes "options: /spp: ...". Also removes the
/// advice to see the help of parray.
std::string message_about_options(const std::string& message,
                                  const std::vector<std::string>& words);

/// Returns the message about a child that reached a limit of time: which one, and what to do.
std::string time_limit_message(const ChildEnd& end, const ChildLimits& limits);

/// Reads uploaded scenes. It writes the parts to a directory of the request. A child process with
/// limits on memory and time reads them and writes `submit` messages. This process parses only
/// these messages and the options. Callable from any thread.
class UploadReader {
 public:
  /// `memory`: limits scenes on their way to the loop. `directory`: for directories of requests.
  /// All references must outlive this object.
  UploadReader(const ChildRunner& runner, Budget& memory, std::filesystem::path directory,
               UploadLimits limits)
      : runner_(runner), memory_(memory), directory_(std::move(directory)), limits_(limits) {}

  /// Makes all requests fail that wait for a child process.
  void stop() { places_.stop(); }

  /// Receives and reads the request's scene and options. Calls `take` with each of its jobs, in the
  /// order of their frames, as soon as it is read. Throws Problem, RunError, and what `take`
  /// throws.
  void receive(const Request& request, const std::function<void(Upload&)>& take);

  /// Receives a request and forecasts its job on a farm with `threads` threads. Returns the map of
  /// parray-http-child (cli/scene_sandbox/upload_jobs.h). Throws Problem, RunError.
  nlohmann::json forecast(const Request& request, std::size_t threads);

 private:
  struct Received;
  using Work = std::function<void(const Received&, const Places::Entry&)>;
  void with_parts(const Request& request, const Work& work);
  void run(const Received& received, std::vector<std::string> before, const char* command,
           std::size_t more_seconds) const;
  Upload read_job(const std::filesystem::path& made, std::size_t number) const;

  const ChildRunner& runner_;
  Places uploads_{"uploads", {.inside = most_uploads, .one_inside = 16}};
  /// For children.
  Places places_{"scenes", {.places = 3, .of_one = 2, .inside = 24, .one_inside = 16}};
  Budget& memory_;
  const std::filesystem::path directory_;
  const UploadLimits limits_;
};

}  // namespace parray::http
