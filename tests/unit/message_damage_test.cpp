#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "proto/control_frame.h"
#include "proto/messages.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/sample_messages.h"

namespace parray {
namespace {

using nlohmann::json;
using test::Dice;
using test::sample_messages;

/// The message, or nothing if it is malformed; any other exception ends the test.
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

/// Numbers and texts that a field is not made for.
json odd_value(Dice& dice, int depth = 0) {
  switch (dice.below(depth < 3 ? 12 : 9)) {
    case 0:
      return nullptr;
    case 1:
      return dice.one_in(2);
    case 2:
      return dice.bits();
    case 3:
      return static_cast<std::int64_t>(dice.bits());
    case 4:
      return dice.below(70);
    case 5:
      return dice.ten_to(-320, 308);
    case 6:
      return std::string(dice.below(200), static_cast<char>(dice.below(256)));
    case 7:
      return std::string(64, 'b');
    case 8:
      return -static_cast<std::int64_t>(dice.below(1000));
    case 9:
      return {{"a", odd_value(dice, depth + 1)}, {"width", odd_value(dice, depth + 1)}};
    default: {
      json list = json::array();
      for (std::uint64_t i = dice.below(6); i > 0; --i) {
        list.push_back(odd_value(dice, depth + 1));
      }
      return list;
    }
  }
}

/// Cuts, flips, repeats or inserts bytes.
void damage(Dice& dice, std::string& bytes) {
  for (std::uint64_t i = 1 + dice.below(4); i > 0 && !bytes.empty(); --i) {
    const std::size_t at = dice.below(bytes.size());
    switch (dice.below(5)) {
      case 0:
        bytes[at] = static_cast<char>(dice.below(256));
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
        break;
      case 2:
        bytes.erase(at, 1 + dice.below(8));
        break;
      case 3:
        bytes.insert(at, bytes.substr(at / 2, 1 + dice.below(12)));
        break;
      default:
        bytes.insert(at, 1, static_cast<char>(dice.below(256)));
        break;
    }
  }
}

RowBlock small_block() {
  return {{3, 5, 7, 10}, 2, {12, 34, 1}, std::vector<PixelSums>(4), {{4, 1, 8, 1}}};
}

bool block_refused(const std::string& bytes) {
  try {
    row_block_from_bytes(bytes);
  } catch (const DecodeError&) {
    return true;
  }
  return false;
}

template <typename T>
std::string with(std::string bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  return bytes;
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
        cut[frame].resize(size);
        CHECK_UNARY(refused(cut));
      }
      Frames longer = frames;
      longer[frame] += '\0';
      CHECK(refused(longer));
    }
  }
}

TEST_CASE("a message with frames too few or too many is refused") {
  CHECK(refused({}));
  CHECK(refused({""}));
  CHECK(refused({"", ""}));
  for (const Message& message : sample_messages()) {
    CAPTURE(message.index());
    Frames frames = encode(message);
    frames.push_back(seal_bulk("more"));
    CHECK(refused(frames));
    frames.pop_back();
    frames.pop_back();
    CHECK(refused(frames));
  }
}

TEST_CASE("a control frame that is no map, or says no type or version, is refused") {
  for (const json& odd :
       {json(nullptr), json(7), json("hello"), json::array({1, 2}), json::object(),
        json{{"type", "pulse"}}, json{{"v", 1}}, json{{"v", 1}, {"type", 3}},
        json{{"v", "1"}, {"type", "pulse"}}, json{{"v", -1}, {"type", "pulse"}},
        json{{"v", 1.0}, {"type", "pulse"}}, json{{"v", std::uint64_t{1} << 32}, {"type", "pulse"}},
        json{{"v", 1}, {"type", ""}}, json{{"v", 1}, {"type", "Pulse"}},
        json{{"v", 1}, {"type", "pulse\n"}}, json{{"v", 1}, {"type", std::string(1000, 'x')}}}) {
    CAPTURE(odd.dump());
    CHECK(refused({pack(odd)}));
  }
  CHECK_FALSE(refused({pack({{"v", 1}, {"type", "pulse"}})}));
}

TEST_CASE("a hello of any version can be read, so that it can be answered; others are refused") {
  for (const std::uint64_t version : {0U, 2U, 0xFFFFFFFFU}) {
    for (const json& hello : {json{{"v", version}, {"type", "hello"}},
                              json{{"v", version}, {"type", "hello"}, {"name", 3}, {"x", {1}}}}) {
      const auto message = decoded({pack(hello)});
      REQUIRE(message);
      CHECK(std::get<msg::Hello>(*message).version == version);
    }
    CHECK(refused({pack({{"v", version}, {"type", "pulse"}})}));
  }
}

TEST_CASE("an error knows the request that it can be told to") {
  const auto request_of = [](const json& map) -> std::optional<std::uint64_t> {
    try {
      decode({pack(map)});
    } catch (const ProtocolError& error) {
      return error.request();
    }
    FAIL("not refused");
    return {};
  };
  CHECK(request_of({{"v", 1}, {"type", "teapot"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", 1}, {"type", "show_job"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", 7}, {"type", "show_job"}, {"request", 9}}) == 9);
  CHECK(request_of({{"v", 1}, {"type", "show_job"}, {"request", "9"}}) == std::nullopt);
  CHECK(request_of({{"v", 1}, {"type", "show_job"}}) == std::nullopt);
}

TEST_CASE("a control frame nested 100 000 deep is refused, not recursed into") {
  for (const char opening : {'\x91', '\x81'}) {
    std::string bytes;
    for (int i = 0; i < 100'000; ++i) {
      bytes += opening;
      if (opening == '\x81') {
        bytes += "\xa1k";
      }
    }
    CHECK(refused({bytes}));
    CHECK(refused({bytes + '\xc0'}));
  }
  // As a value of an otherwise good message: the deepest that is allowed, and one more.
  for (const int depth : {7, 8}) {
    std::string bytes =
        "\x83\xa1v\x01\xa4type\xa5pulse\xa4"
        "deep";
    bytes += std::string(static_cast<std::size_t>(depth), '\x91') + '\xc0';
    CHECK(refused({bytes}) == (depth > 7));
  }
}

TEST_CASE("a control frame over 1 MiB is refused") {
  const auto padded = [](std::size_t bytes) {
    json map = {{"v", 1}, {"type", "pulse"}, {"pad", std::string(bytes, 'x')}};
    return Frames{pack(map)};
  };
  CHECK_FALSE(refused(padded(1'000'000)));
  CHECK(refused(padded(1 << 20)));
}

TEST_CASE("lengths that lie do not allocate") {
  const std::uint64_t before = test::peak_address_space();
  // array32, map32, str32, bin32, ext32 of 4 Gi elements with nothing behind them.
  for (const char kind : {'\xdd', '\xdf', '\xdb', '\xc6', '\xc9'}) {
    const std::string lie = std::string(1, kind) + "\xff\xff\xff\xff";
    CHECK(refused({lie}));
    CHECK(refused({"\x81\xa4type" + lie}));
    CHECK(refused({lie + "\xa4type\xa5pulse"}));
  }
  // A block of 4 Gi rows, and of 4 Gi pixels a row.
  const std::string bytes = row_block_to_bytes(small_block());
  CHECK(block_refused(with(bytes, 4, UINT32_MAX)));
  CHECK(block_refused(with(bytes, 16, UINT32_MAX)));
  CHECK(test::peak_address_space() - before < std::uint64_t{64} << 20);
}

TEST_CASE("binary values and extensions are refused, they are in no message") {
  json map = {{"v", 1}, {"type", "pulse"}, {"blob", json::binary({1, 2, 3})}};
  CHECK(refused({pack(map)}));
  map["blob"] = json::binary({1, 2, 3}, 42);
  CHECK(refused({pack(map)}));
}

TEST_CASE("any flipped bit of bulk data or of its checksum is noticed") {
  for (const Message& message : sample_messages()) {
    const Frames frames = encode(message);
    if (frames.size() == 1) {
      continue;
    }
    for (std::size_t at = 0; at < frames[1].size(); ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        Frames flipped = frames;
        flipped[1][at] = static_cast<char>(flipped[1][at] ^ (1 << bit));
        CHECK_UNARY(refused(flipped));
      }
    }
  }
}

TEST_CASE("bulk data come out as they were sealed, empty ones too") {
  for (const std::string& data : {std::string(), std::string("x"), std::string(1000, '\0')}) {
    CHECK(open_bulk(seal_bulk(data)) == data);
  }
  CHECK_THROWS_AS(open_bulk(""), ProtocolError);
  CHECK_THROWS_AS(open_bulk("1234567"), ProtocolError);
}

TEST_CASE("a row block comes back as it was, an empty one too") {
  CHECK(row_block_from_bytes(row_block_to_bytes(small_block())) == small_block());
  CHECK(row_block_to_bytes(small_block()).size() == 52 + 72 * 4 + 16);
  CHECK(row_block_from_bytes(row_block_to_bytes({})) == RowBlock{});
}

TEST_CASE("a row block that contradicts itself is refused") {
  const std::string bytes = row_block_to_bytes(small_block());
  CHECK_FALSE(block_refused(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    CHECK_UNARY(block_refused(bytes.substr(0, size)));
  }
  CHECK(block_refused(bytes + '\0'));
  CHECK(block_refused(bytes + std::string(48, '\0')));
  for (const std::uint32_t value : {0U, 1U, 4U, 6U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    for (const std::size_t at : {0U, 4U, 16U}) {  // the rows and the width
      CAPTURE(at);
      CAPTURE(value);
      CHECK(block_refused(with(bytes, at, value)));
    }
  }
  // A rectangle may hold more samples than its pixels have, but not fewer.
  for (const std::uint32_t begin : {8U, 10U, 11U, 0xFFFFFFFFU}) {
    CHECK(block_refused(with(bytes, 8, begin)));
  }
  for (const std::uint32_t end : {0U, 6U, 7U, 9U}) {
    CHECK(block_refused(with(bytes, 12, end)));
  }
  CHECK(block_refused(with(bytes, 20, std::uint64_t{13})));  // samples
  CHECK(block_refused(with(bytes, 20, UINT64_MAX)));
  CHECK(block_refused(with(bytes, 36, std::uint64_t{13})));  // more non-finite than samples
  CHECK(block_refused(with(bytes, 36, std::uint64_t{12})));  // more than it accounts for
}

TEST_CASE("a grant's sample ranges must fit its rectangle") {
  msg::Grant grant;
  grant.scene = std::string(64, 'a');
  grant.settings = std::get<msg::Grant>(sample_messages()[6]).settings;
  grant.settings.adaptive = true;
  grant.rect = {0, 2, 10, 30};
  const auto with_ranges = [&](std::size_t count, const SampleRange& odd_one) {
    grant.samples.assign(count, {10, 30});
    grant.samples.back() = odd_one;
    return encode(grant);
  };
  const std::size_t pixels = std::size_t{2} * grant.settings.width;
  CHECK_FALSE(refused(with_ranges(pixels, {12, 12})));
  CHECK_FALSE(refused(with_ranges(pixels, {0, 0})));  // nothing, wherever
  CHECK(refused(with_ranges(pixels - 1, {12, 20})));
  CHECK(refused(with_ranges(pixels + 1, {12, 20})));
  CHECK(refused(with_ranges(pixels, {9, 20})));
  CHECK(refused(with_ranges(pixels, {12, 31})));
  CHECK(refused(with_ranges(pixels, {20, 12})));
}

TEST_CASE("an image's data must fit its size") {
  msg::ImageData image{1, json::object(), 2, 3, false, std::string(72, '\0')};
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
      case 0:
        damage(dice, frames[dice.below(frames.size())]);
        break;
      case 1:  // past the checksum
        if (frames.size() > 1) {
          std::string data(open_bulk(frames[1]));
          damage(dice, data);
          frames[1] = seal_bulk(data);
        } else {
          damage(dice, frames[0]);
        }
        break;
      default: {  // past MessagePack
        json map = json::from_msgpack(frames[0]);
        auto field = map.begin();
        std::advance(field, static_cast<std::ptrdiff_t>(dice.below(map.size())));
        json& target =
            field->is_object() && !field->empty() && dice.one_in(2)
                ? *std::next(field->begin(), static_cast<std::ptrdiff_t>(dice.below(field->size())))
                : *field;
        target = odd_value(dice);
        frames[0] = pack(map);
        break;
      }
    }
    const auto message = decoded(frames);
    if (message) {  // what is let in can be sent on
      ++accepted;
      CHECK_UNARY(decoded(encode(*message)).has_value());
    }
  }
  CHECK(accepted > 1000);
  CHECK(accepted < 15'000);
}

}  // namespace parray
