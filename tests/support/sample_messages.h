#pragma once

#include <string>
#include <vector>

#include "proto/messages.h"

namespace parray::test {

/// One message of every type, in the order of the variant, with no value left at its default.
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
  RowBlock block{{3, 5, 7, 10}, 2, {12, 34, 1}, std::vector<PixelSums>(4), {{4, 1, 8, 1}}};
  block.pixels[1].sum = {1, 2, 3};
  block.pixels[3].sum_of_squares = {UINT64_MAX, 0, 4};
  const nlohmann::json job = {{"id", 7}, {"name", "glass"}, {"progress", 0.5}};
  std::string pixels(72, '\x3f');  // 2 x 3 pixels
  return {msg::Hello{protocol_version, "node 1", "12345", 16, 3, 9, "abc"},
          msg::Welcome{250, 4000},
          msg::Refuse{"another build"},
          msg::Heartbeat{UINT64_MAX, true, {{1, 2}, {3, UINT64_MAX}}},
          msg::Pulse{},
          msg::Who{},
          msg::Grant{5, 6, {1, 30, 2, 40}, digest, settings},
          msg::NeedScene{digest},
          msg::SceneData{digest, std::string("a\0b\xff", 4)},
          msg::Result{5, 6, 1.25, 0.1, 1000, "avx2", block},
          msg::VerdictOf{5, 6, msg::Verdict::mismatch},
          msg::Revoke{5, 6},
          msg::Bye{"stopped"},
          msg::Submit{8, "token-1", "glass", 99, settings, "asked for", 0.25, "scene", 3},
          msg::Submitted{8, 5},
          msg::ListJobs{8},
          msg::Jobs{8, nlohmann::json::array({job, job})},
          msg::ShowJob{8, 5},
          msg::Job{8, job},
          msg::Cancel{8, 5},
          msg::Fetch{8, 5, false, true},
          msg::ImageData{8, {{"image_sha256", digest}}, 2, 3, false, pixels},
          msg::ListWorkers{8},
          msg::Workers{8, nlohmann::json::array({{{"name", "node 1"}}})},
          msg::Error{8, 2, "no such job"}};
}

}  // namespace parray::test
