#include <fstream>

#include "common/adaptive/error_estimate.h"
#include "common/base/bytes.h"
#include "common/image/image.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/row_log.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/window_rig.h"

namespace parray::fuzz {
namespace {

// Kinds of state, by an input's first letter.
constexpr char rows = 'r';       // a rows file
constexpr char record = 'j';     // a job's record
constexpr char one_pass = 'l';   // a log of a picture: of each entry its size (u16), then the entry
constexpr char in_passes = 'L';  // the same, of an adaptive picture

/// The entries of a rows file; throws RunError as each_entry_in() does.
std::vector<std::string> entries_in(const std::filesystem::path& file, std::uint64_t bytes) {
  std::vector<std::string> entries;
  each_entry_in(file, bytes, [&](std::string_view entry) { entries.emplace_back(entry); });
  return entries;
}

std::string bytes_of(const std::vector<std::string>& entries) {
  PendingRows fresh;
  for (const std::string& entry : entries) fresh.append(entry);
  std::string bytes;
  for (const std::string_view piece : fresh.pieces()) bytes += piece;
  return bytes;
}

bool run_rows(std::string_view input) {
  static const test::TemporaryDirectory directory;
  const std::filesystem::path file = directory.path() / "rows";
  std::ofstream(file, std::ios::binary) << input;
  promise(bytes_of(entries_in(file, input.size())) == input, "rows as they were written");
  return true;
}

bool run_record(std::string_view text) {
  const JobRecord job = record_from_json(7, text);
  const std::string kept = record_to_json(job);
  const JobRecord again = record_from_json(7, kept);
  promise(record_to_json(again) == kept, "a record as it was kept");
  promise_startable(job.settings, job.passes, job.tile);
  return true;
}

RenderSettings settings_for(char kind) {
  RenderSettings settings = test::made_settings(20, 12, kind == in_passes ? 300 : 50);
  settings.adaptive = kind == in_passes;
  return settings;
}

/// What is in of a picture adds up, and can be shown.
void promise_consistent(const JobPicture& picture) {
  const Framebuffer& framebuffer = picture.framebuffer();
  std::uint64_t samples = 0;
  for (const std::uint32_t count : framebuffer.samples()) samples += count;
  promise(samples == framebuffer.counts().samples, "samples of pixels and of cells alike");
  promise(framebuffer.counts().nonfinite <= samples, "samples that are not finite are samples");
  for (const auto& [at, excluded] : framebuffer.excluded()) {
    const std::uint32_t all = framebuffer.samples()[at.first * framebuffer.width() + at.second];
    promise(excluded.count <= all, "no more samples left out than there are");
  }
  for (const float value : resolve_image(framebuffer, picture.scene().largest_radiance).rgb) {
    promise(value >= 0 && value <= picture.scene().largest_radiance, "a pixel's bound");
  }
  static_cast<void>(estimate_error(picture.view()));
}

/// Throws DecodeError as JobPicture::replay() does.
void replay(JobPicture& picture, std::string_view log) {
  for (ByteReader in(log); in.left() > 0;) {
    const auto size = in.get<std::uint16_t>();
    picture.replay(in.get_bytes(std::min<std::size_t>(size, in.left())));
  }
  picture.end_replay();
}

bool run_log(std::string_view log, char kind) {
  const SceneFacts scene(test::small_scene());
  JobPicture picture(settings_for(kind), scene);
  bool taken = true;
  try {
    replay(picture, log);
  } catch (const DecodeError& error) {
    promise_one_line(error.what());
    taken = false;
  }
  promise_consistent(picture);  // whatever has come before the damage
  if (taken && (!picture.has_begun() || picture.collector().done())) picture.begin_pass();
  return taken;
}

bool run(std::string_view input) {
  const char kind = take_letter(input);
  try {
    if (kind == rows) return run_rows(input);
    if (kind == record) return run_record(input);
    return run_log(input, kind);
  } catch (const RunError& error) {
    promise_one_line(error.what());
    return false;
  }
}

void append(std::string& log, const std::string& entry) {
  ByteWriter size;
  size.put(static_cast<std::uint16_t>(entry.size()));
  log += size.take() + entry;
}

/// All of the first passes, in pieces; something of it set back and traced again.
std::string whole_log(char kind) {
  JobPicture picture(settings_for(kind), SceneFacts(test::small_scene()));
  std::string log;
  const auto take = [&](TracerKey tracer, const CellRange& range) {
    const TracedCells cells = test::made_cells(picture.plan()->batch(range));
    picture.collector().take(tracer, cells);
    append(log, picture.cells_entry(tracer, range, pack_cells(cells, *picture.plan()->grid())));
  };
  for (int pass = 0; pass < 2 && picture.begin_pass(); ++pass) {
    const std::uint64_t cells = picture.plan()->cells();
    for (std::uint64_t at = 0; at < cells; at += 5) take(at % 3, {at, std::min(at + 5, cells)});
    if (kind == in_passes) continue;
    const auto retraction = picture.retract(1);
    append(log, picture.retraction_entry(retraction.cells));
    for (const CellRange& range : retraction.cells) take(4, range);
  }
  return log;
}

JobRecord sample_record() {
  JobRecord job;
  job.token = "token";
  job.name = "glass";
  job.user = "ann";
  job.settings = test::made_settings(20, 30, 40);
  job.settings->precision = Precision::f64;
  job.settings->accelerator = AcceleratorKind::bvh;
  job.settings->adaptive = true;
  job.settings->passes = {1000, 2000};
  job.scene = std::string(64, 'a');
  job.passes = {1000};
  job.report = "{}";
  return job;
}

std::vector<std::string> seeds() {
  const std::string json = record_to_json(sample_record());
  return {rows + bytes_of({"first", "", std::string(300, '\0')}), record + json,
          one_pass + whole_log(one_pass), in_passes + whole_log(in_passes),
          std::string(1, one_pass)};
}

}  // namespace

const Target state_target{"state", run, seeds};

}  // namespace parray::fuzz
