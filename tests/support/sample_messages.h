#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "proto/messages.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns a batch of one cell of a picture of 20 x 30 pixels: samples 2 to 9 of row 5.
inline CellBatch sample_batch() {
  const GridShape shape{20, 30, RowOrder::sequential, 4, 20, 8, 2, {{2, 10}, {11, 40}}};
  const auto grid = std::make_shared<const CellGrid>(shape);
  return {grid, {5, 6}, std::vector<SampleRange>(20, {3, 9})};
}

/// Returns a traced cell of this batch.
inline TracedCells sample_cells() {
  TracedCells cells;
  cells.range = {5, 6};
  cells.samples = 120;
  cells.records.resize(record_bytes(20));
  cells.records[0] = std::byte{200};                     // rays
  cells.records[8] = std::byte{1};                       // not finite
  cells.records[sizeof(CellHeader) + 2] = std::byte{7};  // part of a sum
  cells.excluded = {{5, 1, 8, 1}};
  return cells;
}

/// Returns one message of every type, in the order of the variant. No value is its default.
inline std::vector<Message> sample_messages() {
  const std::string digest(64, 'a');
  RenderSettings settings;
  settings.width = 20;
  settings.height = 30;
  settings.samples_per_pixel = 40;
  settings.max_depth = 50;
  settings.seed = 0xFEDCBA9876543210;
  settings.sampler = Sampler::sobol;
  settings.precision = Precision::f64;
  settings.accelerator = AcceleratorKind::bvh;
  settings.schedule = SchedulePolicy::factoring;
  settings.row_order = RowOrder::sequential;
  const CellBatch batch = sample_batch();
  const nlohmann::json job = {{"id", 7}, {"name", "glass"}, {"progress", 0.5}};
  std::string pixels(72, '\x3f');  // 2 x 3 pixels
  return {msg::Hello{protocol_version, "node 1", "12345", 16, 3, 9, "abc", "node", 7401, "key",
                     "1.2.3", 64, std::uint64_t{1} << 36},
          msg::Welcome{250, 4000},
          msg::Refuse{"another build"},
          msg::Heartbeat{UINT64_MAX, true, {{1, 2}, {3, UINT64_MAX}}, 1.5},
          msg::HeartbeatAck{},
          msg::Identify{},
          msg::Grant{5, 1, 6, batch, digest, settings, 1.5},
          msg::NeedScene{digest, 2},
          msg::SceneSource{digest, {1000, 1U << 18}, "tcp://10.0.0.1:7401", "key"},
          msg::NeedChunk{digest, 3},
          msg::Chunk{digest, 3, true, Bulk::of(std::string("a\0b\xff", 4))},
          msg::ChunkLater{digest, 3},
          msg::NoScene{digest},
          msg::Result{5, 6, 1.25, 0.1, 1000, "avx2",
                      CellsPayload(std::make_shared<const TracedCells>(sample_cells())),
                      batch.range.count(), batch.grid},
          msg::Failed{5, 6, "not enough memory"},
          msg::ResultVerdict{5, 6, msg::Verdict::mismatch},
          msg::Revoke{5, 6},
          msg::Bye{"stopped"},
          msg::Submit{
              {"glass", 99, settings, "asked for", 0.25, 0.5, 3, 4, "dance", 7, 9, 12, true, "{}"},
              8,
              "token-1",
              ScenePayload(Bulk::of("scene")),
              "ann"},
          msg::Submitted{8, 5},
          msg::ListJobs{8, 70, 10, "done,failed", "ann", "water", msg::JobSort::taken,
                        msg::JobOrder::ascending, 30},
          msg::Jobs{8, nlohmann::json::array({job, job}), 9},
          msg::ShowJob{8, 5, 3},
          msg::Job{8, job},
          msg::SteerJob{8, 5, msg::JobAction::prioritise, 70},
          msg::SteerJobs{8, {5, UINT64_MAX}, msg::JobAction::forget, 70},
          msg::Steered{8, nlohmann::json::array({{{"id", 5}, {"job", job}}})},
          msg::Fetch{8, 5, false, true},
          msg::ImageData{
              8, {{"image_sha256", digest}}, 2, 3, false, false, PicturePayload(Bulk::of(pixels))},
          msg::FetchJournal{8, 5},
          msg::JournalData{8, job, {{"image_sha256", digest}}, Bulk::of("merged")},
          msg::ListWorkers{8, 1000, 500},
          msg::SteerWorkers{8, msg::WorkerAction::readmit, true, "node"},
          msg::Workers{8, nlohmann::json::array({{{"name", "node 1"}}}), 1500},
          msg::ShowFarm{8, true},
          msg::Farm{8, {{"threads", 16}}},
          msg::ShowWorker{8, "node 1"},
          msg::Worker{8, {{"name", "node 1"}}},
          msg::ShowLog{8, "node 1"},
          msg::Log{8, {"serving", "a scene has come"}},
          msg::Error{8, 2, "no room", true},
          msg::FetchScene{8, 5},
          msg::SceneData{8, settings, ScenePayload(Bulk::of("scene")), "{}"}};
}

}  // namespace parray::test
