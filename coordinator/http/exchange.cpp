#include "coordinator/http/exchange.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/ascii.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "coordinator/http/seats.h"

namespace parray::http {
namespace {

class TextSink final : public BodySink {
 public:
  explicit TextSink(std::size_t most) : most_(most) {}

  void expect(std::uint64_t bytes) override {
    if (bytes <= most_) return;
    throw Problem(413, "the body is larger than " + std::to_string(most_) +
                           " bytes, the limit for this request");
  }
  void begin_part(const std::string& /*name*/, const std::string& /*file_name*/) override {}
  void take(std::string_view bytes) override {
    expect(text.size() + bytes.size());
    text += bytes;
  }

  std::string text;

 private:
  std::size_t most_;
};

}  // namespace

std::string_view reason_of(int status) {
  static const std::map<int, std::string_view> reasons = {{200, "OK"},
                                                          {204, "No Content"},
                                                          {400, "Bad Request"},
                                                          {401, "Unauthorized"},
                                                          {403, "Forbidden"},
                                                          {404, "Not Found"},
                                                          {405, "Method Not Allowed"},
                                                          {408, "Request Timeout"},
                                                          {409, "Conflict"},
                                                          {413, "Content Too Large"},
                                                          {414, "URI Too Long"},
                                                          {415, "Unsupported Media Type"},
                                                          {421, "Misdirected Request"},
                                                          {422, "Unprocessable Content"},
                                                          {429, "Too Many Requests"},
                                                          {431, "Request Header Fields Too Large"},
                                                          {500, "Internal Server Error"},
                                                          {501, "Not Implemented"},
                                                          {502, "Bad Gateway"},
                                                          {503, "Service Unavailable"},
                                                          {504, "Gateway Timeout"},
                                                          {505, "HTTP Version Not Supported"}};
  const auto found = reasons.find(status);
  return found == reasons.end() ? "Error" : found->second;
}

Fields fields_of(const Reply& reply) {
  Fields fields = reply.headers;
  const auto named = [](const auto& field) { return field.first == "Cache-Control"; };
  if (std::ranges::none_of(fields, named)) fields.emplace_back("Cache-Control", "no-store");
  fields.emplace_back("X-Content-Type-Options", "nosniff");
  fields.emplace_back("Referrer-Policy", "no-referrer");
  return fields;
}

Reply json_reply(const nlohmann::json& content, int status) {
  return {.status = status, .body = std::make_shared<const std::string>(json_text(content) + "\n")};
}

Reply text_reply(std::string text, const std::string& type) {
  return {.type = type, .body = std::make_shared<const std::string>(std::move(text))};
}

Reply problem_reply(const Problem& problem) {
  nlohmann::json map = {{"type", "about:blank"},
                        {"title", reason_of(problem.status())},
                        {"status", problem.status()},
                        {"detail", printable(problem.what(), 2000)}};
  if (problem.exit_status() != 0) map["exit_status"] = problem.exit_status();
  Reply reply = json_reply(map, problem.status());
  reply.type = "application/problem+json";
  reply.headers = problem.headers();
  return reply;
}

std::string owner_of(const Request& request) {
  const std::string& user = request.sender.name;
  return user.empty() ? "address " + owner_of_address(request.remote) : "user " + user;
}

std::string media_type(const Request& request) {
  std::string type = lower_case(request.field("content-type"));
  type.resize(std::min(type.find(';'), type.size()));
  std::erase_if(type, ascii::is_blank);
  return type;
}

std::string wrong_media_type(const Request& request) {
  const std::string type = media_type(request);
  return type.empty() ? "the request has no Content-Type"
                      : "the Content-Type '" + printable(type) + "' is not supported";
}

nlohmann::json json_body(const Request& request, std::size_t most, const std::string& form) {
  if (media_type(request) != "application/json") {
    throw Problem(415,
                  wrong_media_type(request) + ": send " + form + " with the header " + json_header);
  }
  TextSink sink(most);
  request.read_body(sink, false);
  return nlohmann::json::parse(sink.text, nullptr, false);
}

}  // namespace parray::http
