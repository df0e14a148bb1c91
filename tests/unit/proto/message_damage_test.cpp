#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "proto/control_frame.h"
#include "proto/messages.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_messages.h"

namespace parray {
namespace {

using nlohmann::json;
using test::Dice;
using test::sample_messages;

/// Returns the message, or nothing if it is malformed. Other exceptions end the test.
std::optional<Message> decoded(const Frames& frames) {
  try {
    return decode(frames);
  } catch (const ProtocolError&) {
    return {};
  }
}

bool refused(const Frames& frames) { return !decoded(frames); }

std::string pack(const json& map) {
  std::string bytes;
  json::to_msgpack(map, bytes);
  return bytes;
}

/// Numbers and texts that are invalid for most fields.
json odd_value(Dice& dice, int depth = 0) {
  switch (dice.below(depth < 3 ? 12 : 9)) {
    case 0: return nullptr;
    case 1: return dice.one_in(2);
    case 2: return dice.bits();
    case 3: return static_cast<std::int64_t>(dice.bits());
    case 4: return dice.below(70);
    case 5: return dice.ten_to(-320, 308);
    case 6: return std::string(dice.below(200), static_cast<char>(dice.below(256)));
    case 7: return std::string(64, 'b');
    case 8: return -static_cast<std::int64_t>(dice.below(1000));
    case 9: return {{"a", odd_value(dice, depth + 1)}, {"width", odd_value(dice, depth + 1)}};
    default: {
      json list = json::array();
      for (std::uint64_t i = dice.below(6); i > 0; --i) list.push_back(odd_value(dice, depth + 1));
      return list;
    }
  }
}

/// Cuts, flips, repeats or inserts bytes.
void damage(Dice& dice, std::string& bytes) {
  for (std::uint64_t i = 1 + dice.below(4); i > 0 && !bytes.empty(); --i) {
    const std::size_t at = dice.below(bytes.size());
    switch (dice.below(5)) {
      case 0: bytes[at] = static_cast<char>(dice.below(256)); break;
      case 1: bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8))); break;
      case 2: bytes.erase(at, 1 + dice.below(8)); break;
      case 3: bytes.insert(at, bytes.substr(at / 2, 1 + dice.below(12))); break;
      default: bytes.insert(at, 1, static_cast<char>(dice.below(256))); break;
    }
  }
}

void set(Frame& frame, std::string bytes) { frame = std::move(bytes); }

/// Returns bulk data with a correct checksum.
void set_bulk(Frames& frames, std::string data) {
  json map = json::from_msgpack(frames[0].view());
  map["bulk_xxh3"] = Bulk::of(data).checksum;
  set(frames[0], pack(map));
  set(frames[1], std::move(data));
}

void damage(Dice& dice, Frame& frame) {
  std::string bytes(frame.view());
  damage(dice, bytes);
  frame = std::move(bytes);
}

/// Returns whether opening the bulk data of a message detects a change.
bool bulk_noticed(const Message& message) {
  try {
    if (const auto* chunk = std::get_if<msg::Chunk>(&message)) {
      (void)chunk->content.verified();
    } else if (const auto* submit = std::get_if<msg::Submit>(&message)) {
      (void)submit->scene.bytes();
    } else if (const auto* result = std::get_if<msg::Result>(&message)) {
      (void)result->cells.packed(*test::sample_batch().grid);
    } else if (const auto* image = std::get_if<msg::ImageData>(&message)) {
      (void)image->picture.bytes(PictureDetail::image);
    } else if (const auto* journal = std::get_if<msg::JournalData>(&message)) {
      (void)journal->journal.verified();
    } else if (const auto* scene = std::get_if<msg::SceneData>(&message)) {
      (void)scene->scene.bytes();
    }
  } catch (const ChecksumError&) {
    return true;
  }
  return false;
}

bool refused_or_noticed(const Frames& frames) {
  const auto message = decoded(frames);
  return !message || bulk_noticed(*message);
}

}  // namespace

TEST_CASE("a message cut short at any length is refused") {
  for (const Message& message : sample_messages()) {
    const Frames frames = encode(message);
    for (std::size_t frame = 0; frame < frames.size(); ++frame) {
      CAPTURE(message.index());
      CAPTURE(frame);
      for (std::size_t size = 0; size < frames[frame].size(); ++size) {
        Frames cut = frames;
        set(cut[frame], std::string(frames[frame].view().substr(0, size)));
        CHECK_UNARY(refused_or_noticed(cut));
      }
      Frames longer = frames;
      set(longer[frame], std::string(frames[frame].view()) + '\0');
      CHECK(refused_or_noticed(longer));
    }
  }
}

TEST_CASE("a message with too few or too many frames is refused") {
  CHECK(refused({}));
  CHECK(refused({std::string()}));
  CHECK(refused({std::string(), std::string()}));
  for (const Message& message : sample_messages()) {
    CAPTURE(message.index());
    Frames frames = encode(message);
    frames.push_back(std::string("more"));
    CHECK(refused(frames));
    frames.pop_back();
    frames.pop_back();
    CHECK(refused(frames));
  }
}

TEST_CASE("a control frame without a map, type or version is refused") {
  for (const json& odd :
       {json(nullptr), json(7), json("hello"), json::array({1, 2}), json::object(),
        json{{"type", "pulse"}}, json{{"v", protocol_version}},
        json{{"v", protocol_version}, {"type", 3}}, json{{"v", "1"}, {"type", "pulse"}},
        json{{"v", -1}, {"type", "pulse"}}, json{{"v", 1.0}, {"type", "pulse"}},
        json{{"v", std::uint64_t{1} << 32}, {"type", "pulse"}},
        json{{"v", protocol_version}, {"type", ""}},
        json{{"v", protocol_version}, {"type", "Pulse"}},
        json{{"v", protocol_version}, {"type", "pulse\n"}},
        json{{"v", protocol_version}, {"type", std::string(1000, 'x')}}}) {
    CAPTURE(odd.dump());
    CHECK(refused({pack(odd)}));
  }
  CHECK_FALSE(refused({pack({{"v", protocol_version}, {"type", "pulse"}})}));
}

TEST_CASE(
    "hello of any version can be read, so that it gets an answer; other messages are refused") {
  for (const std::uint64_t version : {0U, 1U, 0xFFFFFFFFU}) {
    for (const json& hello : {json{{"v", version}, {"type", "hello"}},
                              json{{"v", version}, {"type", "hello"}, {"name", 3}, {"x", {1}}}}) {
      const auto message = decoded({pack(hello)});
      REQUIRE(message);
      CHECK(std::get<msg::Hello>(*message).version == version);
    }
    CHECK(refused({pack({{"v", version}, {"type", "pulse"}})}));
  }
}

TEST_CASE("a ProtocolError contains the request that its error answers") {
  const auto request_of = [](const json& map) -> std::optional<std::uint64_t> {
    try {
      decode({pack(map)});
    } catch (const ProtocolError& error) {
      return error.request();
    }
    FAIL("not refused");
    return {};
  };
  CHECK(request_of({{"v", protocol_version}, {"type", "teapot"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", protocol_version}, {"type", "show_job"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", 7}, {"type", "show_job"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", protocol_version}, {"type", "show_job"}, {"request", "9"}}) ==
        std::nullopt);
  CHECK(request_of({{"v", protocol_version}, {"type", "show_job"}}) == std::nullopt);
}

TEST_CASE("a control frame nested 100 000 deep is refused without recursion") {
  for (const char opening : {'\x91', '\x81'}) {
    std::string bytes;
    for (int i = 0; i < 100'000; ++i) {
      bytes += opening;
      if (opening == '\x81') bytes += "\xa1k";
    }
    CHECK(refused({bytes}));
    CHECK(refused({bytes + '\xc0'}));
  }
  // A value of an otherwise valid message with the largest allowed depth, and one more.
  for (const int depth : {7, 8}) {
    std::string bytes =
        "\x83\xa1v\x06\xa4type\xa5pulse\xa4"
        "deep";
    bytes += std::string(static_cast<std::size_t>(depth), '\x91') + '\xc0';
    CHECK(refused({bytes}) == (depth > 7));
  }
}

TEST_CASE("a control frame over 1 MiB is refused") {
  const auto padded = [](std::size_t bytes) {
    json map = {{"v", protocol_version}, {"type", "pulse"}, {"pad", std::string(bytes, 'x')}};
    return Frames{pack(map)};
  };
  CHECK_FALSE(refused(padded(1'000'000)));
  CHECK(refused(padded(1 << 20)));
}

TEST_CASE("wrong lengths do not allocate memory") {
  const std::uint64_t before = test::peak_address_space();
  // array32, map32, str32, bin32, ext32 of 4 Gi elements with nothing behind them.
  for (const char kind : {'\xdd', '\xdf', '\xdb', '\xc6', '\xc9'}) {
    const std::string lie = std::string(1, kind) + "\xff\xff\xff\xff";
    CHECK(refused({lie}));
    CHECK(refused({"\x81\xa4type" + lie}));
    CHECK(refused({lie + "\xa4type\xa5pulse"}));
  }
  CHECK(test::peak_address_space() - before < std::uint64_t{64} << 20);
}

TEST_CASE("binary values and extensions are refused") {
  json map = {{"v", protocol_version}, {"type", "pulse"}, {"blob", json::binary({1, 2, 3})}};
  CHECK(refused({pack(map)}));
  map["blob"] = json::binary({1, 2, 3}, 42);
  CHECK(refused({pack(map)}));
}

TEST_CASE("a map or list that is passed on unchanged has no text that JSON cannot hold") {
  for (const Message& message : sample_messages()) {
    json map = json::from_msgpack(encode(message)[0].view());
    for (const char* key : {"job", "jobs", "workers", "report"}) {
      if (!map.contains(key) || !map[key].is_structured()) continue;
      for (const json& odd : {json{{"a", {{"b", "\xff"}}}}, json{{"\xc3", 1}}}) {
        CAPTURE(key);
        json damaged = map;
        damaged[key] = map[key].is_array() ? json::array({odd}) : odd;
        Frames frames = encode(message);
        set(frames[0], pack(damaged));
        CHECK(refused(frames));
      }
    }
  }
}

TEST_CASE("any flipped bit of bulk data or its checksum is detected, at the latest by the reader") {
  for (const Message& message : sample_messages()) {
    const Frames frames = encode(message);
    if (frames.size() == 1) continue;
    CAPTURE(message.index());
    for (std::size_t at = 0; at < frames[1].size(); ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        std::string data(frames[1].view());
        data[at] = static_cast<char>(data[at] ^ (1 << bit));
        Frames flipped = frames;
        set(flipped[1], data);
        CHECK_UNARY(refused_or_noticed(flipped));
      }
    }
    json map = json::from_msgpack(frames[0].view());
    for (int bit = 0; bit < 64; ++bit) {
      json flipped = map;
      flipped["bulk_xxh3"] = map["bulk_xxh3"].get<std::uint64_t>() ^ (std::uint64_t{1} << bit);
      CHECK_UNARY(refused_or_noticed({pack(flipped), frames[1]}));
    }
  }
}

TEST_CASE("bulk data arrive unchanged, even empty ones, and are not copied") {
  for (const std::string& data : {std::string(), std::string("x"), std::string(1000, '\0')}) {
    CHECK(Bulk::of(data).verified() == data);
  }
  CHECK_THROWS_AS((void)Bulk{}.verified(), ChecksumError);
  const Frames frames = encode(sample_messages()[10]);
  const auto chunk = std::get<msg::Chunk>(decode(frames));
  CHECK(chunk.content.data.view().data() == frames[1].view().data());
  CHECK(encode(chunk)[1].view().data() == frames[1].view().data());
}

TEST_CASE("a grant's sample ranges must fit its rectangle") {
  msg::Grant grant;
  grant.scene = std::string(64, 'a');
  grant.settings = std::get<msg::Grant>(sample_messages()[6]).settings;
  grant.cells.grid = test::sample_batch().grid;  // cells 31, 32: rows 1 and 2, samples 11 to 18
  grant.cells.range = {31, 33};
  const auto with_ranges = [&](std::size_t count, const SampleRange& odd_one) {
    grant.cells.samples.assign(count, {11, 19});
    grant.cells.samples.back() = odd_one;
    return encode(grant);
  };
  CHECK_FALSE(refused(with_ranges(40, {12, 12})));
  CHECK_FALSE(refused(with_ranges(40, {0, 0})));  // no samples
  CHECK(refused(with_ranges(39, {12, 18})));
  CHECK(refused(with_ranges(41, {12, 18})));
  CHECK(refused(with_ranges(40, {10, 18})));
  CHECK(refused(with_ranges(40, {12, 20})));
  CHECK(refused(with_ranges(40, {18, 12})));
}

TEST_CASE("a grant has no samples for pixels beyond the end of a row") {
  msg::Grant grant = std::get<msg::Grant>(sample_messages()[6]);
  GridShape shape = grant.cells.grid->shape();
  shape.cell_pixels = 15;  // the second cell of a row has five
  grant.cells.grid = std::make_shared<const CellGrid>(shape);
  grant.cells.range = {4, 5};  // the second of row 0: four rows are cut across together
  REQUIRE(grant.cells.grid->cell(4).pixels() == 5);
  grant.cells.samples.assign(15, {0, 0});
  grant.cells.samples[4] = {2, 10};
  CHECK_FALSE(refused(encode(grant)));
  grant.cells.samples[5] = {2, 3};
  CHECK(refused(encode(grant)));
}

TEST_CASE("the data of a picture must fit its size") {
  msg::ImageData image{.request = 1,
                       .report = json::object(),
                       .width = 2,
                       .height = 3,
                       .picture = PicturePayload(Bulk::of(std::string(72, '\0')))};
  CHECK_FALSE(refused(encode(image)));
  image.width = 3;
  CHECK(refused(encode(image)));
  image.width = image.height = 65536;
  CHECK(refused(encode(image)));
}

TEST_CASE("20 000 random mutations give a message or a protocol error, nothing else") {
  Dice dice(1);
  const auto samples = sample_messages();
  int accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    CAPTURE(round);
    Frames frames = encode(samples[dice.below(samples.size())]);
    switch (dice.below(4)) {
      case 0: damage(dice, frames[dice.below(frames.size())]); break;
      case 1:  // past the checksum
        if (frames.size() > 1) {
          std::string data(frames[1].view());
          damage(dice, data);
          set_bulk(frames, std::move(data));
        } else {
          damage(dice, frames[0]);
        }
        break;
      default: {  // past MessagePack
        json map = json::from_msgpack(frames[0].view());
        auto field = map.begin();
        std::advance(field, static_cast<std::ptrdiff_t>(dice.below(map.size())));
        json& target =
            field->is_object() && !field->empty() && dice.one_in(2)
                ? *std::next(field->begin(), static_cast<std::ptrdiff_t>(dice.below(field->size())))
                : *field;
        target = odd_value(dice);
        set(frames[0], pack(map));
        break;
      }
    }
    auto message = decoded(frames);
    if (message) {
      ++accepted;
      const bool sound = !bulk_noticed(*message);
      if (auto* result = std::get_if<msg::Result>(&*message)) {
        result->grid = test::sample_batch().grid;
      }
      if (sound) {  // an accepted message can be encoded again
        CHECK_UNARY(decoded(encode(*message)).has_value());
      }
    }
  }
  CHECK(accepted > 1000);
  CHECK(accepted < 15'000);
}

}  // namespace parray
