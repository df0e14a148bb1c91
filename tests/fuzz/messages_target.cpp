#include <nlohmann/json.hpp>

#include "common/base/bytes.h"
#include "proto/messages.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_messages.h"

namespace parray::fuzz {
namespace {

using nlohmann::json;

// Forms of an input, by its first letter.
constexpr char raw = 'r';        // a control frame
constexpr char raw_bulk = 'R';   // its size (u16), a control frame, a bulk frame
constexpr char text = 't';       // a control frame as JSON text
constexpr char text_bulk = 'T';  // the same, a zero byte, a bulk frame; the checksum is put right

std::string packed(const json& map) {
  std::string bytes;
  json::to_msgpack(map, bytes);
  return bytes;
}

/// Empty: no control frame.
std::string from_text(std::string_view input, const std::optional<std::string>& bulk) {
  json map = json::parse(input, nullptr, false);
  if (map.is_discarded()) return {};
  if (map.contains("v")) map["v"] = protocol_version;  // old finds stay messages
  if (bulk && map.is_object()) map["bulk_xxh3"] = Bulk::of(*bulk).checksum;
  return packed(map);
}

Frames frames_of(std::string_view input) {
  const char form = take_letter(input);
  if (form == text_bulk) {
    const std::size_t end = std::min(input.find('\0'), input.size());
    std::string bulk(input.substr(std::min(end + 1, input.size())));
    std::string control = from_text(input.substr(0, end), bulk);
    return {std::move(control), std::move(bulk)};
  }
  if (form == text) return {from_text(input, {})};
  if (form == raw_bulk && input.size() >= sizeof(std::uint16_t)) {
    ByteReader in(input);
    const std::size_t announced = in.get<std::uint16_t>();
    const std::size_t size = std::min(announced, in.left());
    std::string control(in.get_bytes(size));
    return {std::move(control), std::string(in.get_bytes(in.left()))};
  }
  return {std::string(input)};
}

/// Texts of maps that are handed on as they are.
void promise_printable_as_json(const Message& message) {
  const auto dumps = [](const json& value) { static_cast<void>(value.dump()); };
  if (const auto* m = std::get_if<msg::Jobs>(&message)) dumps(m->jobs);
  if (const auto* m = std::get_if<msg::Job>(&message)) dumps(m->job);
  if (const auto* m = std::get_if<msg::Workers>(&message)) dumps(m->workers);
  if (const auto* m = std::get_if<msg::Worker>(&message)) dumps(m->worker);
  if (const auto* m = std::get_if<msg::Farm>(&message)) dumps(m->farm);
  if (const auto* m = std::get_if<msg::ImageData>(&message)) dumps(m->report);
}

bool run(std::string_view input) {
  Message message;
  try {
    message = decode(frames_of(input));
  } catch (const ProtocolError& error) {
    promise_one_line(error.what());
    return false;
  }
  promise_printable_as_json(message);
  if (const auto* submit = std::get_if<msg::Submit>(&message)) promise_startable(submit->settings);
  if (auto* result = std::get_if<msg::Result>(&message)) {
    result->grid = test::sample_batch().grid;  // it does not travel
  }
  Frames frames;
  try {
    frames = encode(message);
  } catch (const ChecksumError&) {
    return false;  // seen by whoever opens the bulk frame, and no earlier
  }
  Message again = decode(frames);
  if (auto* result = std::get_if<msg::Result>(&again)) result->grid = test::sample_batch().grid;
  promise(again.index() == message.index() && encode(again) == frames, "a message as encoded");
  return true;
}

std::vector<std::string> seeds() {
  std::vector<std::string> inputs;
  for (const Message& message : test::sample_messages()) {
    const Frames frames = encode(message);
    const std::string control(frames[0].view());
    const std::string as_text = json::from_msgpack(control).dump();
    if (frames.size() == 1) {
      inputs.push_back(raw + control);
      inputs.push_back(text + as_text);
      continue;
    }
    ByteWriter size;
    size.put(static_cast<std::uint16_t>(control.size()));
    const std::string bulk(frames[1].view());
    inputs.push_back(raw_bulk + size.take() + control + bulk);
    inputs.push_back(text_bulk + as_text + '\0' + bulk);
  }
  return inputs;
}

}  // namespace

const Target messages_target{"messages", run, seeds};

}  // namespace parray::fuzz
