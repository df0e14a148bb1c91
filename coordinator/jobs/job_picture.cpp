#include "coordinator/jobs/job_picture.h"

#include <xxhash.h>

#include "common/base/bytes.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"

namespace parray::coordinator {
namespace {

enum class EntryKind : std::uint32_t {
  cells = 1,
  retraction = 2,
  journal = 3,
  check = 4,
  wanted = 5
};

std::string entry_of(EntryKind kind, std::uint32_t pass, TracerKey tracer, const CellRange& range,
                     std::string_view packed = {}) {
  ByteWriter out;
  out.reserve(32 + packed.size());
  out.numbers(kind, pass, tracer, range.begin, range.end);
  out.put_bytes(packed);
  return out.take();
}

}  // namespace

SceneFacts::SceneFacts(const Scene& scene)
    : requirements(requirements_of(scene)), largest_radiance(scene::largest_radiance(scene)) {}

JobPicture::JobPicture(const RenderSettings& settings, const SceneFacts& scene,
                       std::vector<std::uint64_t> begun, std::uint32_t tile, bool large_pages,
                       PictureJudge judge)
    : settings_(settings),
      scene_(scene),
      tile_(tile),
      judge_(std::move(judge)),
      framebuffer_(settings.width, settings.height, large_pages),
      passes_(std::make_unique<PassController>(settings, scene.largest_radiance, std::move(begun),
                                               judge_)) {}

bool JobPicture::begin_pass(const PassTimes& times) {
  auto pass = passes_->next(framebuffer_, times);
  if (!pass) return false;
  if (collector_) {
    earlier_tracers_.insert(collector_->tracers().begin(), collector_->tracers().end());
    earlier_cells_ += collector_->done_cells();
    earlier_checked_ += collector_->checked_cells();
  }
  collector_ = std::make_unique<ResultCollector>(
      std::make_shared<const WorkPlan>(settings_, std::move(*pass), tile_), framebuffer_);
  return true;
}

JobPicture::Retraction JobPicture::retract(TracerKey tracer) {
  const bool decided_passes = earlier_tracers_.contains(tracer) || collector_->has_cells_of(tracer);
  if (!settings_->has_passes() || !decided_passes) {
    auto retraction = collector_->retract(tracer);
    return {std::move(retraction.cells), false, std::move(retraction.unchecked)};
  }
  collector_.reset();
  journal_.clear();
  earlier_tracers_.clear();
  earlier_cells_ = earlier_checked_ = 0;
  framebuffer_ = Framebuffer(settings_->width, settings_->height);
  passes_ = std::make_unique<PassController>(settings_, scene_.largest_radiance,
                                             std::vector<std::uint64_t>{}, judge_);
  begin_pass();
  return {{{0, plan()->cells()}}, true, {}};
}

double JobPicture::checked_share() const {
  const std::uint64_t cells = earlier_cells_ + collector_->done_cells();
  const std::uint64_t checked = earlier_checked_ + collector_->checked_cells();
  return cells == 0 ? 0 : static_cast<double>(checked) / static_cast<double>(cells);
}

bool JobPicture::relies_on(TracerKey tracer) const {
  return earlier_tracers_.contains(tracer) || (collector_ && collector_->relies_on(tracer));
}

ErrorEstimate JobPicture::error() const {
  const ErrorEstimate& found = passes_->final_error();
  return found.half_width.empty() ? estimate_error(view()) : found;
}

std::string JobPicture::cells_entry(std::uint32_t pass, TracerKey tracer, const CellRange& range,
                                    std::string_view packed) {
  return entry_of(EntryKind::cells, pass, tracer, range, packed);
}

std::string JobPicture::check_entry(TracerKey tracer, const CellRange& range) const {
  return entry_of(EntryKind::check, passes_->pass(), tracer, range);
}

std::string JobPicture::wanted_entry(const CellRange& range) const {
  return entry_of(EntryKind::wanted, passes_->pass(), 0, range);
}

std::string JobPicture::retraction_entry(const std::vector<CellRange>& cells) const {
  ByteWriter out;
  out.numbers(EntryKind::retraction, passes_->pass());
  for (const CellRange& range : cells) out.numbers(range.begin, range.end);
  return out.take();
}

std::string JobPicture::journal_entry(const JournalEntry& entry) {
  ByteWriter out;
  out.put(EntryKind::journal);
  out.put_bytes(journal_.add(entry));
  return out.take();
}

void JobPicture::replay(std::string_view entry) {
  ByteReader in(entry);
  const auto kind = in.get<EntryKind>();
  if (kind == EntryKind::journal) {
    journal_.replay(in.get_bytes(in.left()));
    return;
  }
  const auto pass = in.get<std::uint32_t>();
  if (!collector_ || (collector_->done() && passes_->pass() + 1 == pass)) begin_pass();
  if (!collector_ || passes_->pass() != pass) {
    throw DecodeError("cells of a pass that has not begun");
  }
  const auto take_range = [&] {
    CellRange range;
    in.numbers(range.begin, range.end);
    if (range.begin >= range.end || range.end > plan()->cells()) {
      throw DecodeError("cells outside the work plan");
    }
    return range;
  };
  if (kind == EntryKind::cells) {
    const auto tracer = in.get<TracerKey>();
    const CellRange range = take_range();
    const CellBatch batch = plan()->batch(range);
    collector_->take(tracer, unpack_cells(in.get_bytes(in.left()), batch, settings_->max_depth));
    return;
  }
  if (kind == EntryKind::check || kind == EntryKind::wanted) {
    const auto tracer = in.get<TracerKey>();
    const CellRange range = take_range();
    kind == EntryKind::check ? collector_->note_check(tracer, range)
                             : collector_->note_wanted(range);
    return;
  }
  if (kind != EntryKind::retraction) throw DecodeError("an entry of an unknown kind");
  std::vector<CellRange> cells;
  while (in.left() > 0) cells.push_back(take_range());
  collector_->retract(cells);
}

std::uint64_t JobPicture::memory(const RenderSettings& settings) {
  // Bytes per pixel: framebuffer 76; at the end image 12, counts and half-widths 16, noise model
  // about 60.
  constexpr std::uint64_t even = 170;
  constexpr std::uint64_t in_passes = 60;  // samples per pixel and their allocation
  constexpr std::uint64_t replicates = 40;
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  return pixels * (even + (settings.in_passes() ? in_passes : 0) +
                   (settings.replicates ? replicates : 0)) +
         (std::uint64_t{1} << 20);
}

TracerKey tracer_key(std::string_view name, std::string_view instance) {
  return XXH3_64bits_withSeed(instance.data(), instance.size(),
                              XXH3_64bits(name.data(), name.size()));
}

}  // namespace parray::coordinator
