#pragma once

#include <cstdint>
#include <filesystem>
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

/// Bodies that are read at once while their bytes are coming.
inline constexpr std::size_t most_uploads = 24;

struct UploadLimits {
  std::uint64_t body_bytes = std::uint64_t{256} << 20;
  std::size_t parts = 100;
  ChildLimits child{};
};

/// A scene that was sent, read.
struct Taken {
  msg::Submit submit;
  std::string webhook;                 ///< empty: none
  std::optional<Budget::Hold> memory;  ///< that of `submit`
  std::string digest;                  ///< SHA-256 of the names and contents of all parts
};

/// The whole number, from 0 on, that `value` is: 20 and 20.0 are the same in JSON.
std::optional<std::uint64_t> whole_in(const nlohmann::json& value);

/// The command line that stands for a request's `options`, a JSON map; without `webhook`, which
/// goes to the other. Throws Problem 422 that names the option.
std::vector<std::string> words_of_options(const std::string& options, std::string& webhook);

/// Reads what strangers send. Its files go to a directory of the request's own; a child, bounded in
/// memory and time, makes a `submit` of them there. This process parses nothing but that. Any
/// thread.
class UploadReader {
 public:
  /// `directory`: for those of requests. `runner`, `places`, where scenes are read, and
  /// `memory`, which scenes take on their way to the loop, must outlive this.
  UploadReader(const ChildRunner& runner, Places& places, Budget& memory,
               std::filesystem::path directory, UploadLimits limits)
      : runner_(runner),
        places_(places),
        memory_(memory),
        directory_(std::move(directory)),
        limits_(limits) {}

  /// Throws Problem, RunError.
  Taken take(const Request& request);

 private:
  Taken read(const std::filesystem::path& directory, const std::string& scene,
             const std::string& options) const;
  [[noreturn]] void fail(const ChildEnd& end) const;

  const ChildRunner& runner_;
  Places uploads_{"uploads", {.inside = most_uploads, .one_inside = 16}};
  Places& places_;
  Budget& memory_;
  const std::filesystem::path directory_;
  const UploadLimits limits_;
};

}  // namespace parray::http
