#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/rooms.h"

namespace parray::test {

/// PROTOCOL.md in examples: type and keys of every message, with the values of sample_messages(),
/// and whether a bulk frame follows.
struct TypeRow {
  std::string type;
  nlohmann::json keys;
  bool bulk = false;
};

inline const std::vector<TypeRow>& protocol() {
  using nlohmann::json;
  static const std::string digest(64, 'a');
  static const json settings = {{"width", 20},
                                {"height", 30},
                                {"samples_per_pixel", 40},
                                {"max_depth", 50},
                                {"precision", "f64"},
                                {"seed", 0xFEDCBA9876543210},
                                {"sampler", "sobol"},
                                {"accelerator", "bvh"},
                                {"isa", "auto"},
                                {"schedule", "factoring"},
                                {"row_order", "sequential"}};
  static const json cells = {
      {"range", {5, 6}},
      {"size", {20, 30}},
      {"row_order", "sequential"},
      {"cut", {4, 20, 8, 2}},
      {"stages", json::array({json::array({2, 10}), json::array({11, 40})})}};
  static const json job = {{"id", 7}, {"name", "glass"}, {"progress", 0.5}};
  static const json none = json::object();
  static const std::vector<TypeRow> table = {
      {"hello",
       {{"name", "node 1"},
        {"instance", "12345"},
        {"threads", 16},
        {"capacity", 3},
        {"trace_version", 9},
        {"fingerprint", "abc"},
        {"host", "node"},
        {"share_port", 7401},
        {"share_key", "key"}}},
      {"welcome", {{"heartbeat_ms", 250}, {"silence_ms", 4000}}},
      {"refuse", {{"reason", "another build"}}},
      {"heartbeat",
       {{"traced", UINT64_MAX},
        {"preparing", true},
        {"epochs", json::array({json::array({1, 2}), json::array({3, UINT64_MAX})})}}},
      {"pulse", none},
      {"who", none},
      {"grant",
       {{"job", 5},
        {"pass", 1},
        {"epoch", 6},
        {"cells", cells},
        {"scene", digest},
        {"settings", settings},
        {"longest", 1.5}},
       true},
      {"need_scene", {{"scene", digest}, {"failed", 2}}},
      {"scene_source",
       {{"scene", digest},
        {"bytes", 1000},
        {"chunk_bytes", 1U << 18},
        {"address", "tcp://10.0.0.1:7401"},
        {"key", "key"}}},
      {"need_chunk", {{"scene", digest}, {"chunk", 3}}},
      {"chunk", {{"scene", digest}, {"chunk", 3}, {"packed", true}}, true},
      {"chunk_later", {{"scene", digest}, {"chunk", 3}}},
      {"no_scene", {{"scene", digest}}},
      {"result",
       {{"job", 5},
        {"epoch", 6},
        {"seconds", 1.25},
        {"build_seconds", 0.1},
        {"accelerator_bytes", 1000},
        {"isa", "avx2"},
        {"count", 1}},
       true},
      {"failed", {{"job", 5}, {"epoch", 6}, {"reason", "not enough memory"}}},
      {"verdict", {{"job", 5}, {"epoch", 6}, {"verdict", "mismatch"}}},
      {"revoke", {{"job", 5}, {"epoch", 6}}},
      {"bye", {{"reason", "stopped"}}},
      {"submit",
       {{"request", 8},
        {"token", "token-1"},
        {"name", "glass"},
        {"priority", 99},
        {"settings", settings},
        {"precision_reason", "asked for"},
        {"duplicates_removed", 3},
        {"load_seconds", 0.25},
        {"reserved_seconds", 0.5},
        {"user", "ann"},
        {"max_failures", 4},
        {"series", "dance"},
        {"frame", 7},
        {"frames", 9},
        {"denoise", true},
        {"drawing", "{}"}},
       true},
      {"submitted", {{"request", 8}, {"job", 5}}},
      {"list_jobs", {{"request", 8}, {"before", 70}, {"limit", 10}, {"states", "done,failed"}}},
      {"jobs", {{"request", 8}, {"jobs", json::array({job, job})}}},
      {"show_job", {{"request", 8}, {"job", 5}, {"from_frame", 3}}},
      {"job", {{"request", 8}, {"job", job}}},
      {"steer_job", {{"request", 8}, {"job", 5}, {"action", "prioritise"}, {"priority", 70}}},
      {"fetch",
       {{"request", 8},
        {"job", 5},
        {"partial", false},
        {"statistics", true},
        {"replicates", false}}},
      {"image",
       {{"request", 8},
        {"report", {{"image_sha256", digest}}},
        {"width", 2},
        {"height", 3},
        {"statistics", false},
        {"replicates", false}},
       true},
      {"fetch_journal", {{"request", 8}, {"job", 5}}},
      {"journal", {{"request", 8}, {"job", job}, {"report", {{"image_sha256", digest}}}}, true},
      {"list_workers", {{"request", 8}, {"offset", 1000}, {"limit", 500}}},
      {"steer_workers", {{"request", 8}, {"action", "readmit"}, {"host", true}, {"name", "node"}}},
      {"workers",
       {{"request", 8}, {"workers", json::array({{{"name", "node 1"}}})}, {"total", 1500}}},
      {"show_farm", {{"request", 8}}},
      {"farm", {{"request", 8}, {"farm", {{"threads", 16}}}}},
      {"error", {{"request", 8}, {"status", 2}, {"message", "no room"}, {"later", true}}},
      {"fetch_scene", {{"request", 8}, {"job", 5}}},
      {"scene", {{"request", 8}, {"settings", settings}, {"drawing", "{}"}}, true}};
  return table;
}

}  // namespace parray::test
