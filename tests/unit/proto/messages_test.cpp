#include "proto/messages.h"

#include <doctest/doctest.h>
#include <xxhash.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/image/picture_bytes.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "proto/control_frame.h"
#include "proto/zmq_link.h"
#include "tests/support/protocol_table.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_messages.h"

namespace parray {
namespace {

using nlohmann::json;
using test::protocol;
using test::sample_messages;
using test::TypeRow;

json map_of(const Frames& frames) { return json::from_msgpack(frames[0].view()); }

/// Returns a message's frames after a change of its control map.
Frames with(Frames frames, const std::function<void(json&)>& change) {
  json map = map_of(frames);
  change(map);
  std::string bytes;
  json::to_msgpack(map, bytes);
  frames[0] = std::move(bytes);
  return frames;
}

/// Encodes a decoded message again. A decoded result lacks the grid of its cells.
Frames encoded_again(Message message) {
  if (auto* result = std::get_if<msg::Result>(&message)) result->grid = test::sample_batch().grid;
  return encode(message);
}

/// Returns "" if the frames are a valid message, otherwise the text of the error.
std::string problem_of(const Frames& frames) {
  try {
    decode(frames);
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "";
}

Frames frames_of(const std::string& type) {
  for (const Message& message : sample_messages()) {
    Frames frames = encode(message);
    if (map_of(frames)["type"] == type) return frames;
  }
  FAIL("no sample of ", type);
  return {};
}

std::string problem_with(const std::string& type, const std::string& key, const json& value) {
  return problem_of(with(frames_of(type), [&](json& map) { map[key] = value; }));
}

}  // namespace

TEST_CASE("a client accepts the frame of the largest picture with its statistics and halves") {
  CHECK(max_answer_bytes >
        image::picture_size(1, limits::max_pixels, image::PictureDetail::replicates) + 1000);
}

TEST_CASE("every message has the type, keys, values and frames that PROTOCOL.md lists") {
  const auto messages = sample_messages();
  REQUIRE(messages.size() == std::variant_size_v<Message>);
  REQUIRE(messages.size() == protocol().size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const TypeRow& row = protocol()[i];
    CAPTURE(row.type);
    REQUIRE(messages[i].index() == i);
    const Frames frames = encode(messages[i]);
    json expected = row.keys;
    expected["v"] = protocol_version;
    expected["type"] = row.type;
    json map = map_of(frames);
    if (row.bulk) {
      REQUIRE(frames.size() == 2);
      CHECK(map["bulk_xxh3"] == XXH3_64bits(frames[1].view().data(), frames[1].size()));
      map.erase("bulk_xxh3");
    }
    CHECK(map.dump() == expected.dump());
    CHECK(frames.size() == (row.bulk ? 2 : 1));
  }
}

TEST_CASE("every message is equal after encoding and decoding") {
  for (const Message& message : sample_messages()) {
    CAPTURE(message.index());
    const Frames frames = encode(message);
    const Message back = decode(frames);
    CHECK(back.index() == message.index());
    CHECK(encoded_again(back) == frames);
  }
}

/// Optional keys, which older programs do not send.
static bool may_be_missing(const std::string& type, const std::string& key) {
  if (type == "hello") return key == "release" || key == "processors" || key == "memory_bytes";
  return ((type == "list_jobs" || type == "list_workers" || type == "show_farm") &&
          key != "request") ||
         (type == "heartbeat" && key == "load") || (type == "jobs" && key == "total") ||
         (type == "submit" && key == "preview_of") || key == "denoise" || key == "drawing";
}

TEST_CASE("every key of a message is required, except later ones, and has its type") {
  for (const TypeRow& row : protocol()) {
    for (auto field = row.keys.begin(); field != row.keys.end(); ++field) {
      const std::string& key = field.key();
      CAPTURE(row.type);
      CAPTURE(key);
      const std::string missing =
          problem_of(with(frames_of(row.type), [&](json& map) { map.erase(key); }));
      if (may_be_missing(row.type, key)) {
        CHECK(missing.empty());
      } else {
        CHECK(missing.find(row.type) == 0);
        CHECK(missing.find("missing") != std::string::npos);
        CHECK(missing.find("'" + key + "'") != std::string::npos);
      }
      CHECK(problem_with(row.type, key, nullptr) != "");
      CHECK(problem_with(row.type, key, json::array({nullptr})).empty() ==
            ((key == "jobs" && std::string(row.type) == "jobs") || key == "workers" ||
             key == "results"));
      CHECK(problem_with(row.type, key, "text").empty() ==
            (field->is_string() && key != "scene" && key != "verdict" && key != "action" &&
             key != "sort" && key != "order"));
    }
  }
}

TEST_CASE("a change of many jobs names 1 to 500") {
  const auto problem = [](std::size_t jobs) {
    return problem_with("steer_jobs", "jobs", std::vector<std::uint64_t>(jobs, 7));
  };
  CHECK(problem(1) == "");
  CHECK(problem(500) == "");
  CHECK(problem(0) != "");
  CHECK(problem(501) != "");
  CHECK(problem_with("steer_jobs", "jobs", json::array({-1})) != "");
}

TEST_CASE("unknown keys are ignored, at any level") {
  for (const Message& message : sample_messages()) {
    const Frames frames = encode(message);
    const Frames more = with(frames, [](json& map) {
      map["colour"] = {{"deep", {1, 2, {3}}}};
      if (map.contains("settings")) map["settings"]["mood"] = "blue";
    });
    CHECK(encoded_again(decode(more)) == frames);
  }
}

TEST_CASE("a number out of its range is refused, and the bounds are accepted") {
  struct Range {
    const char* type;
    const char* key;
    std::uint64_t low;
    std::uint64_t high;
  };
  for (const Range& range : {Range{"hello", "threads", 1, 4096},
                             Range{"hello", "capacity", 1, 16},
                             Range{"hello", "share_port", 0, 65535},
                             Range{"hello", "processors", 0, 65536},
                             Range{"hello", "memory_bytes", 0, std::uint64_t{1} << 50},
                             Range{"need_scene", "failed", 0, 1000},
                             Range{"scene_source", "bytes", 1, std::uint64_t{1} << 33},
                             Range{"scene_source", "chunk_bytes", 256, 1 << 20},
                             Range{"need_chunk", "chunk", 0, UINT32_MAX},
                             Range{"hello", "trace_version", 0, UINT32_MAX},
                             Range{"welcome", "heartbeat_ms", 1, 60'000},
                             Range{"welcome", "silence_ms", 1, 600'000},
                             Range{"submit", "priority", 0, 100},
                             Range{"error", "status", 1, 2},
                             Range{"grant", "job", 0, UINT64_MAX},
                             Range{"result", "accelerator_bytes", 0, UINT64_MAX},
                             Range{"submit", "duplicates_removed", 0, UINT64_MAX},
                             Range{"submit", "max_failures", 0, 1000},
                             Range{"submit", "frame", 0, 999'999'999},
                             Range{"submit", "frames", 0, 10'000},
                             Range{"show_job", "from_frame", 0, 999'999'999},
                             Range{"list_jobs", "offset", 0, UINT32_MAX},
                             Range{"submit", "preview_of", 0, UINT64_MAX},
                             Range{"steer_job", "priority", 0, 100},
                             Range{"steer_jobs", "priority", 0, 100}}) {
    CAPTURE(range.type);
    CAPTURE(range.key);
    CHECK(problem_with(range.type, range.key, range.low) == "");
    CHECK(problem_with(range.type, range.key, range.high) == "");
    if (range.low > 0) CHECK(problem_with(range.type, range.key, range.low - 1) != "");
    if (range.high < UINT64_MAX) {
      CHECK(problem_with(range.type, range.key, range.high + 1) != "");
      CHECK(problem_with(range.type, range.key, UINT64_MAX) != "");
    }
    CHECK(problem_with(range.type, range.key, -1) != "");
    CHECK(problem_with(range.type, range.key, 1.0) != "");
    CHECK(problem_with(range.type, range.key, true) != "");
  }
}

TEST_CASE("a scene has a bounded number of chunks") {
  const auto problem = [](std::uint64_t chunk_bytes) {
    msg::SceneSource source{std::string(64, 'a'), {std::uint64_t{1} << 30}};
    source.cut.chunk_bytes = static_cast<std::uint32_t>(chunk_bytes);
    return problem_of(encode(source));
  };
  CHECK(problem(1024) == "");
  CHECK(problem(1023).find("too many chunks") != std::string::npos);
}

TEST_CASE("a real number must be finite and may be an integer") {
  for (const double bad :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(problem_with("result", "seconds", bad) != "");
    CHECK(problem_with("submit", "load_seconds", bad) != "");
  }
  CHECK(problem_with("result", "seconds", 3) == "");
  CHECK(problem_with("result", "seconds", "3") != "");
}

TEST_CASE("times lie between 0 and ten years, so that no speed is below 0 or infinite") {
  for (const auto& place : {std::pair("result", "seconds"), std::pair("result", "build_seconds"),
                            std::pair("submit", "load_seconds"), std::pair("grant", "longest")}) {
    const char* const type = place.first;
    const char* const key = place.second;
    CAPTURE(key);
    CHECK(problem_with(type, key, 0.0) == "");
    CHECK(problem_with(type, key, 5e-324) == "");  // see WorkerRegistry::measure()
    CHECK(problem_with(type, key, 3.2e8) == "");
    CHECK(problem_with(type, key, 3.3e8) != "");
    CHECK(problem_with(type, key, -1e-9) != "");
    CHECK(problem_with(type, key, -1.0) != "");
  }
}

TEST_CASE("a load lies between 0 and a million; a worker that does not know it sends none") {
  for (const double good : {0.0, 0.25, 1e6}) CHECK(problem_with("heartbeat", "load", good) == "");
  for (const double bad : {-0.5, 1.1e6, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(problem_with("heartbeat", "load", bad) != "");
  }
  CHECK_FALSE(map_of(encode(msg::Heartbeat{})).contains("load"));
}

TEST_CASE("a log has at most 100 printable lines of at most 500 bytes") {
  using Lines = std::vector<std::string>;
  CHECK(problem_with("log", "lines", Lines(100, std::string(500, 'x'))) == "");
  CHECK(problem_with("log", "lines", Lines{""}) == "");
  CHECK(problem_with("log", "lines", Lines(101, "x")) != "");
  CHECK(problem_with("log", "lines", Lines{std::string(501, 'x')}) != "");
  CHECK(problem_with("log", "lines", Lines{"\x1b[2J"}) != "");
  CHECK(problem_with("log", "lines", json::array({7})) != "");
  CHECK(problem_with("log", "lines", {{"0", "x"}}) != "");

  Lines many(150, "old");
  many.back() = "\x1b[2J" + std::string(600, 'x');
  const auto arrived = std::get<msg::Log>(decode(encode(msg::Log{1, many}))).lines;
  REQUIRE(arrived.size() == 100);
  CHECK(arrived.back().substr(0, 5) == "\\x1b[");
  CHECK(arrived.back().size() <= 500);
}

TEST_CASE("texts must be printable, and names neither empty nor long") {
  for (const char* key : {"name", "instance"}) {
    CHECK(problem_with("hello", key, "") != "");
    CHECK(problem_with("hello", key, std::string(128, 'n')) == "");
    CHECK(problem_with("hello", key, std::string(129, 'n')) != "");
  }
  CHECK(problem_with("submit", "token", "") != "");
  CHECK(problem_with("submit", "token", std::string(64, 't')) == "");
  CHECK(problem_with("submit", "token", std::string(65, 't')) != "");
  CHECK(problem_with("submit", "name", "") != "");
  CHECK(problem_with("hello", "name", "Mühle \xe6\xb0\xb4") == "");
  const std::string reversed = std::string("\xe2\x80") + '\xae';  // U+202E
  for (const std::string& bad :
       {std::string("line\nline"), std::string("\x1b[2J"), std::string("\x7f"), std::string("\xff"),
        std::string("cut \xc3"), reversed}) {
    CAPTURE(bad);
    CHECK(problem_with("hello", "name", bad) != "");
    CHECK(problem_with("bye", "reason", bad) != "");
    CHECK(problem_with("submit", "precision_reason", bad) != "");
  }
}

TEST_CASE("a text that is unprintable or too long arrives escaped or cut") {
  const auto arrives = [](const std::string& reason) {
    return std::get<msg::Bye>(decode(encode(msg::Bye{reason}))).reason;
  };
  CHECK(arrives("two\nlines") == "two\\x0alines");
  CHECK(arrives("\xff") == "\\xff");
  std::string umlauts;
  for (int i = 0; i < 1200; ++i) umlauts += "\xc3\xa4";
  const std::string cut = arrives(umlauts);
  CHECK(cut.size() <= max_line);
  CHECK(cut.substr(cut.size() - 3) == "...");
  CHECK(arrives(std::string(max_line, 'x')) == std::string(max_line, 'x'));
}

TEST_CASE("a digest is 64 lower-case hexadecimal digits") {
  for (const std::string& bad : {std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'A'),
                                 std::string(64, 'g'), std::string()}) {
    CHECK(problem_with("need_scene", "scene", bad) != "");
    CHECK(problem_with("grant", "scene", bad) != "");
  }
}

TEST_CASE("a lease has cells of a valid grid of its own picture") {
  const auto problem = [](const std::string& key, const json& value) {
    return problem_of(with(frames_of("grant"), [&](json& map) { map["cells"][key] = value; }));
  };
  CHECK(problem("range", {0, 150}).find("do not fit") != std::string::npos);  // as for one cell
  for (const json& bad : {json{5, 5}, json{6, 5}, json{0, 151}, json{5}, json{5, 6, 7}, json{-5, 6},
                          json{5, "6"}, json(7)}) {
    CAPTURE(bad.dump());
    CHECK(problem("range", bad) != "");
  }
  for (const json& bad : {json{0, 30}, json{20, 0}, json{20, 31}, json{19, 30}, json{65537, 30},
                          json{20}, json{20, -30}}) {
    CAPTURE(bad.dump());
    CHECK(problem("size", bad) != "");
  }
  for (const json& bad : {json{0, 20, 8, 2}, json{65537, 20, 8, 2}, json{4, 0, 8, 2},
                          json{4, 21, 8, 2}, json{4, 20, 0, 2}, json{4, 20, 8, 0},
                          json{4, 20, 8, 65537}, json{4, 20, 8}, json{4, 20, 8, 2, 1}}) {
    CAPTURE(bad.dump());
    CHECK(problem("cut", bad) != "");
  }
  const auto stages = [&](std::vector<std::vector<std::uint64_t>> list) {
    return problem("stages", list);
  };
  CHECK(stages({{2, 10}, {10, 40}}) == "");
  CHECK(stages({{2, 10}, {11, 41}}) != "");  // the picture has 40 samples per pixel
  CHECK(stages({}) != "");
  CHECK(stages({{2, 2}}) != "");
  CHECK(stages({{10, 2}}) != "");
  CHECK(stages({{2, 10}, {9, 40}}) != "");
  CHECK(stages({{11, 40}, {2, 10}}) != "");
  CHECK(stages({{2, 10}, {11}}) != "");
  CHECK(stages(std::vector<std::vector<std::uint64_t>>(65, {2, 10})) != "");
  CHECK(stages({{2, 10, 2, 0, 2}}) != "");  // a lattice begins before its step
  CHECK(stages({{2, 10, 0, 0, 0}}) != "");
  CHECK(stages({{2, 10, 0, 0, 1 << 20}}) != "");
  CHECK(stages({{2, 10, 1, 0}}) != "");
  CHECK(stages({{2, 41, 0, 0, 2}, {2, 10, 1, 1, 2}}) != "");
  CHECK(problem("row_order", "quantum") != "");
  CHECK(problem("row_order", 7) != "");
  for (const char* key : {"range", "size", "row_order", "cut", "stages"}) {
    CHECK(problem_of(with(frames_of("grant"), [&](json& map) { map["cells"].erase(key); })) != "");
  }
}

TEST_CASE("a grid with too many cells is refused before it is built") {
  json cells = {{"range", {0, 1}},
                {"size", {8192, 8192}},
                {"row_order", "sequential"},
                {"cut", {1, 1, 1, 1}},
                {"stages", json::array({json::array({0, 40})})}};
  const auto problem = [&] {
    return problem_of(with(frames_of("grant"), [&](json& map) {
      map["settings"]["width"] = map["settings"]["height"] = 8192;
      map["settings"]["samples_per_pixel"] = 1 << 24;
      map["cells"] = cells;
    }));
  };
  CHECK(problem().find("do not fit") != std::string::npos);
  cells["stages"] = json::array({json::array({0, 1 << 20})});
  CHECK(problem().find("too many cells") != std::string::npos);
}

TEST_CASE("a heartbeat lists at most 64 leases, in pairs") {
  json epochs = json::array();
  for (int i = 0; i < 64; ++i) epochs.push_back({1, i});
  CHECK(problem_with("heartbeat", "epochs", epochs) == "");
  CHECK(problem_with("heartbeat", "epochs", json::array()) == "");
  epochs.push_back({1, 64});
  CHECK(problem_with("heartbeat", "epochs", epochs) != "");
  for (const json& bad : {json::array({1}), json::array({json::array({1, 2, 3})}),
                          json::array({json::array({1, -2})}), json(7)}) {
    CHECK(problem_with("heartbeat", "epochs", bad) != "");
  }
}

TEST_CASE("settings are complete, in range and leave nothing automatic") {
  const auto problem = [](const std::string& key, const json& value) {
    return problem_of(with(frames_of("grant"), [&](json& map) { map["settings"][key] = value; }));
  };
  for (const char* key : {"width", "height", "samples_per_pixel", "max_depth", "seed", "precision",
                          "accelerator", "schedule", "row_order"}) {
    CAPTURE(key);
    CHECK(problem_of(with(frames_of("grant"), [&](json& map) { map["settings"].erase(key); })) !=
          "");
    CHECK(problem(key, nullptr) != "");
    CHECK(problem(key, -1) != "");
  }
  for (const char* key : {"precision", "accelerator", "row_order"}) {
    CHECK(problem(key, "auto") != "");
    CHECK(problem(key, "quantum") != "");
  }
  CHECK(problem("width", 0) != "");
  CHECK(problem("width", limits::max_image_side + 1) != "");
  CHECK(problem("width", limits::max_image_side) != "");  // the cells are of another picture
  CHECK(problem("max_depth", limits::max_depth + 1) != "");
  CHECK(problem("samples_per_pixel", (std::uint64_t{1} << 32) + 40) != "");
  CHECK(problem("seed", UINT64_MAX) == "");
  CHECK(problem("sampler", "quantum") != "");
  CHECK(problem("sampler", 1) != "");
}

TEST_CASE("the passes of settings are a list of unsigned integers") {
  const auto problem = [](const json& value) {
    return problem_of(
        with(frames_of("grant"), [&](json& map) { map["settings"]["passes"] = value; }));
  };
  CHECK(problem(json::array({40, 80})).empty());
  CHECK(problem(json::array()).empty());
  for (const json& odd : {json(5), json{{"a", 5}}, json("5"), json::array({-5}),
                          json::array({1e300}), json::array({1.5})}) {
    CAPTURE(odd.dump());
    CHECK(problem(odd).find("'passes' is not a list of unsigned integers") != std::string::npos);
  }
}

TEST_CASE("settings without a sampler mean independent samples") {
  const auto sampler_of = [](auto change) {
    return std::get<msg::Grant>(decode(with(frames_of("grant"), change))).settings->sampler;
  };
  CHECK(sampler_of([](json&) {}) == Sampler::sobol);
  CHECK(sampler_of([](json& map) { map["settings"].erase("sampler"); }) == Sampler::independent);
}

TEST_CASE("every verdict is equal after encoding and decoding, and other words are refused") {
  using enum msg::Verdict;
  for (const msg::Verdict verdict : {accepted, duplicate, stale, mismatch}) {
    const auto back = decode(encode(msg::ResultVerdict{1, 2, verdict}));
    CHECK(std::get<msg::ResultVerdict>(back).verdict == verdict);
  }
  CHECK(problem_with("verdict", "verdict", "maybe") != "");
  CHECK(problem_with("verdict", "verdict", "") != "");
}

}  // namespace parray
