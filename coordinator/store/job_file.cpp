#include "coordinator/store/job_file.h"

#include <spdlog/fmt/fmt.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/base/checksum.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"

namespace parray::store {
namespace {

using nlohmann::json;

constexpr std::string_view before_checksum = "{\"checksum\": \"";
constexpr std::string_view before_content = "\",\n\"content\": ";
constexpr std::string_view after_content = "}\n";
constexpr std::size_t digits = 16;

std::string checksum_text(std::string_view bytes) {
  return fmt::format("{:016x}", checksum_of(bytes));
}

std::string with_checksum(const std::string& content) {
  return std::string(before_checksum) + checksum_text(content) + std::string(before_content) +
         content + std::string(after_content);
}

std::string_view checked_content(std::string_view text) {
  constexpr std::size_t head = before_checksum.size() + digits + before_content.size();
  if (text.size() < head + after_content.size() || !text.starts_with(before_checksum) ||
      !text.ends_with(after_content) ||
      text.substr(before_checksum.size() + digits, before_content.size()) != before_content) {
    throw RunError("it is incomplete");
  }
  const std::string_view content = text.substr(head, text.size() - head - after_content.size());
  if (text.substr(before_checksum.size(), digits) != checksum_text(content)) {
    throw RunError("it fails its checksum");
  }
  return content;
}

auto read_content(std::string_view text, const auto& read) {
  const std::string_view content = checked_content(text);
  try {
    return read(json::parse(content));
  } catch (const json::exception& error) {
    throw RunError("it has wrong content: " + printable(error.what(), 400));
  }
}

}  // namespace

/// Inserts the record as text without parsing it into a tree, because a commit may have 1000 jobs.
std::string job_file_to_text(JobId id, const JobFile& file) {
  if (!json::accept(file.record)) {
    throw RunError("the state's record of job " + std::to_string(id) +
                   " is damaged: it is not JSON");
  }
  std::string content =
      fmt::format(R"({{"batch":{},"job":{},"record":{})", file.batch, id, file.record);
  if (file.rows) {
    content +=
        fmt::format(R"(,"rows":{{"number":{},"bytes":{}}})", file.rows->number, file.rows->bytes);
  }
  if (file.picture) {
    content +=
        fmt::format(R"(,"picture":{{"number":{},"bytes":{},"checksum":{}}})", file.picture->number,
                    file.picture->file.bytes, file.picture->file.checksum);
  }
  return with_checksum(content + "}");
}

JobFile job_file_from_text(JobId id, std::string_view text) {
  return read_content(text, [id](const json& content) {
    if (content.at("job") != id) throw RunError("it belongs to job " + content.at("job").dump());
    JobFile file{content.at("batch"), content.at("record").dump()};
    if (content.contains("rows")) {
      const json& rows = content.at("rows");
      file.rows = {rows.at("number"), rows.at("bytes")};
    }
    if (content.contains("picture")) {
      const json& picture = content.at("picture");
      file.picture = {picture.at("number"), {picture.at("bytes"), picture.at("checksum")}};
    }
    return file;
  });
}

std::string notes_file_to_text(const NotesFile& file) {
  const json content = {{"batch", file.batch}, {"notes", file.notes}};
  return with_checksum(json_text(content));
}

NotesFile notes_file_from_text(std::string_view text) {
  return read_content(text, [](const json& content) {
    return NotesFile{content.at("batch"), content.at("notes")};
  });
}

std::string commit_count_to_text(std::uint64_t commits) {
  constexpr std::size_t width = 20;  // digits of the largest number
  const std::string number = std::to_string(commits);
  const std::string padded = std::string(width - number.size(), '0') + number;
  return padded + " " + checksum_text(padded) + "\n";
}

std::optional<std::uint64_t> commit_count_from_text(std::string_view text) {
  std::uint64_t commits = 0;
  std::from_chars(text.data(), text.data() + text.size(), commits);
  return commit_count_to_text(commits) == text ? std::optional(commits) : std::nullopt;
}

}  // namespace parray::store
