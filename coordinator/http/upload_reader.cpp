#include "coordinator/http/upload_reader.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <type_traits>

#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/base/suggest.h"
#include "common/scene/settings_fields.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

enum class OptionType : std::uint8_t { whole, real, text, boolean, flag, list };

struct KnownOption {
  std::string name;  ///< name of the option, with underscores instead of hyphens
  OptionType kind;
};

template <typename Rule>
constexpr OptionType type_of(const Rule& /*rule*/) {
  if constexpr (std::is_same_v<Rule, IntegerRange>) return OptionType::whole;
  if constexpr (std::is_same_v<Rule, NumberRange>) return OptionType::real;
  if constexpr (std::is_same_v<Rule, Words>) return OptionType::text;
  if constexpr (std::is_same_v<Rule, OnOff>) return OptionType::boolean;
  return OptionType::list;
}

const std::vector<KnownOption>& known_options() {
  static const std::vector<KnownOption> known = [] {
    std::vector<KnownOption> options = {
        {"name", OptionType::text},          {"priority", OptionType::whole},
        {"max_failures", OptionType::whole}, {"webhook", OptionType::text},
        {"preview_of", OptionType::whole},   {"progressive", OptionType::flag}};
    settings_fields([&options](const Setting& setting, const auto& rule) {
      if (setting.help != nullptr) options.push_back({keyword_of(setting), type_of(rule)});
    });
    return options;
  }();
  return known;
}

[[noreturn]] void fail_option(const std::string& name, const std::string& problem) {
  throw Problem(422, "options: /" + printable(name) + ": " + problem, 2);
}

OptionType kind_of(const std::string& name) {
  const auto found = std::ranges::find(known_options(), name, &KnownOption::name);
  if (found != known_options().end()) return found->kind;
  std::vector<std::string_view> names;
  for (const KnownOption& option : known_options()) names.emplace_back(option.name);
  fail_option(name, "unknown option: " + remedy_for_name(name, names));
}

std::string list_text(const std::string& name, const json& value) {
  std::string text;
  for (const json& item : value) {
    const auto number = whole_in(item);
    if (!number) fail_option(name, "use whole numbers");
    text += (text.empty() ? "" : ",") + std::to_string(*number);
  }
  return text;
}

/// Returns the argument of the command line; "" for a flag that is false.
std::string word_of(const std::string& name, const json& value) {
  const std::string option = "--" + [&] {
    std::string words = name;
    std::ranges::replace(words, '_', '-');
    return words;
  }();
  switch (kind_of(name)) {
    case OptionType::whole:
      if (!value.is_number()) fail_option(name, "use a whole number");
      return option + "=" + (whole_in(value) ? std::to_string(*whole_in(value)) : value.dump());
    case OptionType::real:
      if (!value.is_number()) fail_option(name, "use a number");
      return option + "=" + value.dump();
    case OptionType::text:
      if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
        fail_option(name, "use a string that is not empty");
      }
      return option + "=" + value.get<std::string>();
    case OptionType::boolean:
      if (!value.is_boolean()) fail_option(name, "write true or false");
      return option + (value.get<bool>() ? "=on" : "=off");
    case OptionType::flag:
      if (!value.is_boolean()) fail_option(name, "write true or false");
      return value.get<bool>() ? option : "";
    case OptionType::list:
      if (!value.is_array() || value.empty()) fail_option(name, "use a list of whole numbers");
      return option + "=" + list_text(name, value);
  }
  return "";
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
      throw Problem(413, "the form has more than " + std::to_string(limits_.parts) +
                             " parts, the limit of this server (--http-parts)");
    }
    add_to_digest(std::to_string(name.size()) + " " + name + std::to_string(file_name.size()) +
                  " " + file_name);
    to_options_ = name == "options";
    if (to_options_) return;
    const bool nameless_scene = name == "scene" && file_name.empty();
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
    if (!out_) throw Problem(503, "storing the upload failed: the server's disk may be full");
  }

  /// Returns the file name of the scene. Throws Problem 422 if the scene is missing or ambiguous.
  std::string scene() {
    out_.close();
    if (!scene_.empty()) return scene_;
    if (names_.size() == 1) return names_.front();
    throw Problem(422, names_.empty()
                           ? "there is no scene: send it as application/json, or as part 'scene'"
                           : "several files and no part 'scene': send the scene as part 'scene'");
  }
  [[nodiscard]] const std::string& options() const { return options_; }
  /// Returns the digest of all parts. No part can be added after it.
  std::string digest() { return digest_.hex(); }

 private:
  [[noreturn]] void refuse_length() const {
    throw Problem(413, "the request body is larger than " + std::to_string(limits_.body_bytes) +
                           " bytes, the limit of this server (--http-body)");
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
      throw Problem(422, "'" + printable(file_name) +
                             "' is not a valid file name: use up to 200 characters and no path");
    }
    if (std::ranges::find(names_, file_name) != names_.end()) {
      throw Problem(422, "two parts have the file name '" + file_name + "': rename one of them");
    }
    names_.push_back(file_name);
    out_ = std::ofstream(directory_ / file_name, std::ios::binary);
  }

  const fs::path directory_;
  const UploadLimits& limits_;
  std::vector<std::string> names_;
  std::string scene_;
  std::string options_;
  bool to_options_ = false;
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

std::uint64_t preview_in_options(const std::string& options) {
  const json map = json::parse(options, nullptr, false);
  if (!map.is_object() || !map.contains("preview_of")) return 0;
  const auto job = whole_in(map.at("preview_of"));
  if (!job || *job == 0) fail_option("preview_of", "use the number of a job");
  return *job;
}

std::vector<std::string> words_of_options(const std::string& options, std::string& webhook) {
  if (options.empty()) return {};
  const json map = json::parse(options, nullptr, false);
  if (!map.is_object()) throw Problem(422, "options: not a JSON map: send {\"spp\": 100}", 2);
  std::vector<std::string> words;
  for (const auto& [name, value] : map.items()) {
    const std::string word = word_of(name, value);
    if (name == "webhook") {
      webhook = value.get<std::string>();
    } else if (!word.empty() && name != "preview_of") {
      words.push_back(word);
    }
  }
  return words;
}

Upload UploadReader::receive(const Request& request) {
  const std::string type = media_type(request);
  const bool form = type == "multipart/form-data";
  if (!form && type != "application/json") {
    throw Problem(415, wrong_media_type(request) + ": send a scene with the header " + json_header +
                           " (curl -H), or files as multipart/form-data (curl -F scene=@FILE)");
  }
  std::optional<Places::Entry> receiving;
  if (!request.is_whole) receiving.emplace(uploads_, owner_of(request));
  const WorkDirectory directory(directory_);
  const fs::path files = directory.path() / "parts";
  fs::create_directory(files);
  Parts parts(files, limits_);
  request.read_body(parts, form);
  receiving.reset();
  const Places::Entry entry(places_, owner_of(request));
  const std::string scene = parts.scene();
  const Places::Place place(entry);
  Upload upload = read_scene(files, scene, parts.options());
  upload.digest = parts.digest();
  return upload;
}

Upload UploadReader::read_scene(const fs::path& directory, const std::string& scene,
                                const std::string& options) const {
  Upload upload;
  std::vector<std::string> words = words_of_options(options, upload.webhook);
  const std::uint64_t preview = preview_in_options(options);
  words.insert(words.begin(), {"submit", scene});
  const ChildEnd end = runner_.run(words, directory, limits_.child);
  if (end.status != 0) fail(end);
  try {
    const fs::path made = directory.parent_path();
    constexpr Time patience = seconds(20);
    const std::uint64_t bytes = fs::file_size(made / "control") + fs::file_size(made / "bulk");
    upload.memory.emplace(memory_.hold(2 * bytes, patience, "another scene"));
    Message message = decode({Frame(read_file(made / "control").value_or("")),
                              Frame(read_file(made / "bulk").value_or(""))});
    upload.submit = std::move(std::get<msg::Submit>(message));
    upload.submit.preview_of = preview;
  } catch (const Problem&) {
    throw;
  } catch (const std::exception& error) {
    throw RunError(std::string("the output of the scene reader cannot be read: ") + error.what());
  }
  return upload;
}

void UploadReader::fail(const ChildEnd& end) const {
  const ChildLimits& limits = limits_.child;
  if (end.timed_out) {
    throw Problem(422,
                  "reading the scene took more than " + std::to_string(limits.seconds) +
                      " seconds, the limit of this server (--http-scene-seconds)",
                  2);
  }
  if (end.status == 2) throw Problem(422, end.message, 2);
  if (end.status == 1 && end.message != "out of memory" && !end.message.empty() &&
      !end.message.starts_with("libgomp")) {
    throw Problem(500, end.message, 1);
  }
  throw Problem(422,
                "reading the scene took more than " + std::to_string(limits.memory >> 20) +
                    " MiB of memory, the limit of this server (--http-scene-memory)",
                2);
}

}  // namespace parray::http
