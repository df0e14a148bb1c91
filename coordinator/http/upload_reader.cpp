#include "coordinator/http/upload_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <utility>

#include "common/base/ascii.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/scene/settings_fields.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

enum class OptionType : std::uint8_t { whole, real, text, boolean, flag, list };

template <typename Rule>
constexpr OptionType type_of(const Rule& /*rule*/) {
  if constexpr (std::is_same_v<Rule, IntegerRange>) return OptionType::whole;
  if constexpr (std::is_same_v<Rule, NumberRange>) return OptionType::real;
  if constexpr (std::is_same_v<Rule, Words>) return OptionType::text;
  if constexpr (std::is_same_v<Rule, OnOff>) return OptionType::boolean;
  return OptionType::list;
}

/// Returns the types of the options that this process knows. Their names have underscores instead
/// of hyphens.
const std::map<std::string, OptionType>& option_types() {
  static const std::map<std::string, OptionType> known = [] {
    std::map<std::string, OptionType> types = {
        {"name", OptionType::text},          {"priority", OptionType::whole},
        {"max_failures", OptionType::whole}, {"webhook", OptionType::text},
        {"preview_of", OptionType::whole},   {"denoise", OptionType::boolean},
        {"progressive", OptionType::flag}};
    settings_fields([&types](const Setting& setting, const auto& rule) {
      if (setting.help != nullptr) types.emplace(keyword_of(setting), type_of(rule));
    });
    return types;
  }();
  return known;
}

[[noreturn]] void fail_option(const std::string& name, const std::string& problem) {
  throw Problem(422, "options: /" + printable(name) + ": " + problem, 2);
}

/// Returns the option of the command line. Throws Problem if the name could mean anything else.
std::string option_named(const std::string& name) {
  constexpr std::array<std::string_view, 3> of_programs{"help", "version", "describe"};
  constexpr std::size_t longest = 40;
  const bool plain = !name.empty() && name.size() <= longest && name.front() != '_' &&
                     std::ranges::all_of(name, [](char c) {
                       return ascii::is_lower(c) || ascii::is_digit(c) || c == '_';
                     });
  if (!plain || std::ranges::count(of_programs, name) > 0) fail_option(name, "unknown option");
  if (name == "like") {
    fail_option(name,
                "not possible by HTTP: give the settings of the picture as options, or use parray "
                "render --like");
  }
  std::string words = "--" + name;
  std::ranges::replace(words, '_', '-');
  return words;
}

/// Returns the value as it stands on the command line.
std::string text_of_value(const std::string& name, const json& value) {
  if (value.is_string()) {
    auto given = value.get<std::string>();
    if (given.empty()) fail_option(name, "use a string that is not empty");
    return given;
  }
  if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
  if (value.is_number()) return whole_in(value) ? std::to_string(*whole_in(value)) : value.dump();
  if (!value.is_array() || value.empty()) {
    fail_option(name, "use a string, a number, true or false, or a list of them");
  }
  std::string text;
  for (const json& item : value) {
    if (item.is_structured()) fail_option(name, "use strings or numbers in the list");
    text += (text.empty() ? "" : name == "range" ? ":" : ",") + text_of_value(name, item);
  }
  return text;
}

/// Appends the words of the option `show`: a selection, or a map with `select` and the options of
/// its look, or a list of them. They must follow all other options.
void add_representations(const json& value, std::vector<std::string>& words) {
  for (const json& one : value.is_array() ? value : json::array({value})) {
    const json select = one.is_object() ? one.value("select", json()) : one;
    if (!select.is_string()) {
      fail_option("show", "use a selection, or a map with `select`, or a list of these");
    }
    words.push_back("--show=" + text_of_value("show", select));
    if (!one.is_object()) continue;
    for (const auto& [name, look] : one.items()) {
      if (name != "select") words.push_back(option_named(name) + "=" + text_of_value(name, look));
    }
  }
}

/// Throws Problem if a value has not the type of its option.
void check_type(const std::string& name, OptionType type, const json& value) {
  const auto require = [&](bool fits, const char* advice) {
    if (!fits) fail_option(name, advice);
  };
  const auto whole = [](const json& item) { return whole_in(item).has_value(); };
  switch (type) {
    case OptionType::whole: require(value.is_number(), "use a whole number"); break;
    case OptionType::real: require(value.is_number(), "use a number"); break;
    case OptionType::text: require(value.is_string(), "use a string that is not empty"); break;
    case OptionType::boolean:
    case OptionType::flag: require(value.is_boolean(), "write true or false"); break;
    case OptionType::list:
      require(value.is_array() && !value.empty(), "use a list of whole numbers");
      require(std::all_of(value.begin(), value.end(), whole), "use whole numbers");
  }
}

/// Returns the argument of the command line; "" for a flag that is false.
std::string word_of(const std::string& name, const json& value) {
  const std::string option = option_named(name);
  const auto known = option_types().find(name);
  if (known == option_types().end()) return option + "=" + text_of_value(name, value);
  const OptionType type = known->second;
  check_type(name, type, value);
  if (type == OptionType::flag) return value.get<bool>() ? option : "";
  return option + "=" + (type == OptionType::real ? value.dump() : text_of_value(name, value));
}

[[noreturn]] void fail_storing() {
  throw Problem(503, "storing the upload failed: the server's disk may be full", 1);
}

constexpr std::size_t most_option_bytes = std::size_t{1} << 16;
constexpr const char* plain_scene = "scene.json";

/// Writes the parts of a form into a directory. Each file has the name that the client gave it.
class Parts final : public BodySink {
 public:
  Parts(fs::path directory, const UploadLimits& limits)
      : directory_(std::move(directory)), limits_(limits) {}

  void expect(std::uint64_t bytes) override {
    constexpr std::uint64_t head_of_part = 1000;
    if (bytes > limits_.body_bytes + head_of_part * (limits_.parts + 1)) refuse_length();
  }
  void begin_part(const std::string& name, const std::string& file_name) override {
    if (++parts_ > limits_.parts) {
      throw Problem(413, fmt::format("the form has more than {} parts, the limit of this server: "
                                     "send fewer, or raise --http-parts of parray-coordinator",
                                     limits_.parts));
    }
    add_to_digest(std::to_string(name.size()) + " " + name + std::to_string(file_name.size()) +
                  " " + file_name);
    to_options_ = name == "options";
    if (to_options_ && std::exchange(has_options_, true)) {
      throw Problem(422, "two parts are named 'options': send one");
    }
    if (to_options_) return;
    const bool nameless_scene = name == "scene" && file_name.empty();
    if (name == "scene" && !scene_.empty()) {
      throw Problem(422, "two parts are named 'scene': send one request for each scene");
    }
    open(nameless_scene ? plain_scene : file_name, name);
    if (name == "scene") scene_ = names_.back();
  }

  void take(std::string_view bytes) override {
    bytes_ += bytes.size();
    add_to_digest(bytes);
    if (bytes_ > limits_.body_bytes) refuse_length();
    if (to_options_) {
      options_ += bytes;
      if (options_.size() > most_option_bytes) throw Problem(413, "the options exceed 65536 bytes");
      return;
    }
    if (names_.empty()) open(plain_scene, "scene");
    out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out_) fail_storing();
  }

  /// Returns the file name of the scene. Throws Problem 422 if the scene is missing or ambiguous.
  std::string scene() {
    close();
    if (!scene_.empty()) return scene_;
    if (names_.size() == 1) return names_.front();
    throw Problem(422, names_.empty()
                           ? "there is no scene: send it as application/json, or as part 'scene'"
                           : "several files and no part 'scene': send the scene as part 'scene', "
                             "or one request for each file");
  }
  [[nodiscard]] const std::string& options() const { return options_; }
  /// Returns the digest of all parts. No part can be added after it.
  std::string digest() { return digest_.hex(); }

 private:
  [[noreturn]] void refuse_length() const {
    throw Problem(413, fmt::format("the request body is larger than {:g} MiB, the limit of this "
                                   "server: send less, or raise --http-body of parray-coordinator",
                                   static_cast<double>(limits_.body_bytes) * 0x1p-20));
  }
  /// Writes the rest of the current file, which the stream may still hold.
  void close() {
    if (out_.is_open()) out_.close();
    if (!out_) fail_storing();
  }
  void add_to_digest(std::string_view bytes) { digest_.add(std::as_bytes(std::span(bytes))); }

  void open(const std::string& file_name, const std::string& part) {
    if (file_name.empty()) {
      throw Problem(422, "part '" + printable(part) +
                             "' has no file name: only the parts 'scene' and 'options' "
                             "need none");
    }
    const bool plain = file_name.size() <= 200 && file_name.find('/') == std::string::npos &&
                       file_name.front() != '.' && file_name.front() != '-' &&
                       printable(file_name, 1000) == file_name;
    if (!plain) {
      throw Problem(
          422,
          "'" + printable(file_name) +
              "' is not a valid file name: use up to 200 printable bytes, without '/', that do "
              "not begin with '.' or '-'");
    }
    if (std::ranges::find(names_, file_name) != names_.end()) {
      throw Problem(422, "two parts have the file name '" + file_name + "': rename one of them");
    }
    close();
    names_.push_back(file_name);
    out_ = std::ofstream(directory_ / file_name, std::ios::binary);
  }

  const fs::path directory_;
  const UploadLimits& limits_;
  std::vector<std::string> names_;
  std::string scene_;
  std::string options_;
  bool to_options_ = false;
  bool has_options_ = false;
  std::size_t parts_ = 0;
  std::uint64_t bytes_ = 0;
  std::ofstream out_;
  Sha256 digest_;
};

}  // namespace

std::optional<std::uint64_t> whole_in(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  constexpr double exact = 0x1p53;
  if (!value.is_number_float()) return {};
  const auto number = value.get<double>();
  const bool whole = number >= 0 && number <= exact && std::floor(number) == number;
  return whole ? std::optional(static_cast<std::uint64_t>(number)) : std::nullopt;
}

RequestOptions read_options(const std::string& text) {
  RequestOptions options;
  if (text.empty()) return options;
  const json map = json::parse(text, nullptr, false);
  if (!map.is_object()) throw Problem(422, "options: not a JSON map: send {\"spp\": 100}", 2);
  for (const auto& [name, value] : map.items()) {
    if (name == "show") continue;
    const std::string word = word_of(name, value);
    if (name == "webhook") {
      options.webhook = value.get<std::string>();
    } else if (!word.empty() && name != "preview_of") {
      options.words.push_back(word);
    }
  }
  if (map.contains("show")) add_representations(map.at("show"), options.words);
  if (map.contains("preview_of")) {
    options.preview_of = whole_in(map.at("preview_of")).value_or(0);
    if (options.preview_of == 0) fail_option("preview_of", "use the number of a job");
  }
  return options;
}

std::string message_about_options(const std::string& message,
                                  const std::vector<std::string>& words) {
  std::string text = message.substr(0, message.find("; see `parray"));
  text = text.substr(0, text.find(" See `parray"));
  constexpr std::string_view unknown = "unknown option --";
  const bool is_unknown = text.starts_with(unknown);
  // Messages begin with the option, or with the file: "a.xyz: --color-by: ...".
  const std::size_t after_file = text.find(": --");
  const std::size_t start = text.starts_with("--")            ? 0
                            : after_file != std::string::npos ? after_file + 2
                                                              : std::string::npos;
  if (!is_unknown && start == std::string::npos) return text;
  const std::size_t begin = is_unknown ? unknown.size() : start + 2;
  const std::size_t end =
      std::min(text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-", begin), text.size());
  std::string name = text.substr(begin, end - begin);
  const bool given = std::ranges::any_of(
      words, [&](const std::string& word) { return word.substr(2, word.find('=') - 2) == name; });
  if (!given) return text;
  const auto as_key = [](std::string option) {
    std::ranges::replace(option, '-', '_');
    return option;
  };
  std::string problem = text.substr(end);
  if (is_unknown) {
    constexpr std::string_view nearest = ": did you mean --";
    problem =
        problem.starts_with(nearest)
            ? ": did you mean '" +
                  as_key(problem.substr(nearest.size(), problem.size() - nearest.size() - 1)) + "'?"
            : "";
    return "options: /" + as_key(name) + ": unknown option" + problem;
  }
  return "options: /" + as_key(name) + ": " +
         (problem.starts_with(": ") ? text.substr(0, start) + problem.substr(2) : text);
}

std::string time_limit_message(const ChildEnd& end, const ChildLimits& limits) {
  const bool computed = end.signal == SIGXCPU;
  return fmt::format(
      "reading the scene took more than {} seconds{}, the limit of this server: send a smaller "
      "scene, or raise --http-scene-seconds of parray-coordinator",
      computed ? limits.seconds : elapsed_seconds(limits), computed ? " of processor time" : "");
}

/// A request whose parts lie in a directory.
struct UploadReader::Received {
  fs::path files;     ///< directory of the parts; its parent is for results
  std::string scene;  ///< file name
  RequestOptions options;
  std::string digest;
};

/// Receives the request and calls `work`, whose entry may wait for places of child processes.
void UploadReader::with_parts(const Request& request, const Work& work) {
  const std::string type = media_type(request);
  const bool form = type == "multipart/form-data";
  if (!form && type != "application/json") {
    throw Problem(415, wrong_media_type(request) + ": send a scene with the header " + json_header +
                           " (curl -H), or files as multipart/form-data (curl -F scene=@FILE)");
  }
  std::optional<Places::Entry> receiving;
  if (!request.is_whole) receiving.emplace(uploads_, owner_of(request));
  const OwnedPath directory = work_directory(directory_);
  const fs::path files = directory.path() / "parts";
  fs::create_directory(files);
  Parts parts(files, limits_);
  request.read_body(parts, form);
  receiving.reset();
  const Places::Entry entry(places_, owner_of(request));
  work({files, parts.scene(), read_options(parts.options()), parts.digest()}, entry);
}

void UploadReader::receive(const Request& request, const std::function<void(Upload&)>& take) {
  with_parts(request, [&](const Received& received, const Places::Entry& entry) {
    const fs::path made = received.files.parent_path();
    std::size_t place = 0;
    std::size_t frames = 1;
    while (place < frames) {
      {
        const Places::Place one(entry);
        run(received, {"--first=" + std::to_string(place)}, "submit", 0);
      }
      const json batch = json::parse(read_file(made / "batch").value_or(""), nullptr, false);
      const std::size_t jobs = batch.is_object() ? batch.value("jobs", std::size_t{0}) : 0;
      if (jobs == 0) throw RunError("the scene reader has made no job");
      frames = std::max(batch.value("frames", std::size_t{0}), std::size_t{1});
      for (std::size_t i = 0; i < jobs && place < frames; ++i, ++place) {
        Upload upload = read_job(made, i);
        upload.place = place;
        upload.submit.preview_of = received.options.preview_of;
        upload.webhook = received.options.webhook;
        upload.digest = received.digest;
        take(upload);
      }
    }
  });
}

json UploadReader::forecast(const Request& request, std::size_t threads) {
  constexpr std::size_t pilot_seconds = 10;
  json answer;
  with_parts(request, [&](const Received& received, const Places::Entry& entry) {
    const Places::Place place(entry);
    run(received, {"--threads=" + std::to_string(threads)}, "plan", pilot_seconds);
    answer = json::parse(read_file(received.files.parent_path() / "forecast").value_or(""), nullptr,
                         false);
  });
  if (!answer.is_object()) throw RunError("the scene reader has made no forecast");
  return answer;
}

/// Runs a command of parray-http-child. `before`: its arguments before the command.
/// `more_seconds`: processor time beside reading the scene.
void UploadReader::run(const Received& received, std::vector<std::string> before,
                       const char* command, std::size_t more_seconds) const {
  std::vector<std::string> words = std::move(before);
  words.insert(words.end(), {command, received.scene});
  const std::vector<std::string>& options = received.options.words;
  words.insert(words.end(), options.begin(), options.end());
  ChildLimits limits = limits_.child;
  limits.seconds += more_seconds;
  const ChildEnd end = runner_.run(words, received.files, limits);
  if (end.status == 0) return;
  std::error_code ignored;
  constexpr std::uintmax_t too_little = 1 << 16;  // for its message
  if (end.message.empty() && fs::space(directory_, ignored).available < too_little) fail_storing();
  if (end.timed_out) throw Problem(422, time_limit_message(end, limits), 2);
  if (end.status == 2) throw Problem(422, message_about_options(end.message, options), 2);
  const bool says_so = end.message == "out of memory" || end.message.starts_with("libgomp");
  if (end.status == 1 && !says_so && !end.message.empty()) throw Problem(500, end.message, 1);
  throw Problem(422,
                fmt::format("{} {:g} GiB of memory, the limit of this server: send a smaller "
                            "scene, or raise --http-scene-memory of parray-coordinator",
                            says_so ? "reading the scene took more than"
                                    : "reading the scene ended abruptly. It may need more than",
                            static_cast<double>(limits.memory) * 0x1p-30),
                2);
}

/// Reads the message `submit` with that number of the present batch.
Upload UploadReader::read_job(const fs::path& made, std::size_t number) const {
  Upload upload;
  try {
    const fs::path control = made / ("control-" + std::to_string(number));
    const fs::path bulk = made / ("bulk-" + std::to_string(number));
    constexpr Time patience = seconds(20);
    const std::uint64_t bytes = fs::file_size(control) + fs::file_size(bulk);
    upload.memory = memory_.hold(2 * bytes, patience, "another scene");
    Message message =
        decode({Frame(read_file(control).value_or("")), Frame(read_file(bulk).value_or(""))});
    upload.submit = std::move(std::get<msg::Submit>(message));
    fs::remove(bulk);
  } catch (const Problem&) {
    throw;
  } catch (const std::exception& error) {
    throw RunError(std::string("the output of the scene reader cannot be read: ") + error.what());
  }
  return upload;
}

}  // namespace parray::http
