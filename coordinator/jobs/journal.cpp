#include "coordinator/jobs/journal.h"

#include <algorithm>

#include "common/base/bytes.h"
#include "common/base/error.h"

namespace parray::coordinator {
namespace {

constexpr std::size_t longest_name = 1000;

void put(ByteWriter& out, const CellRange& range) {
  out.put(range.begin);
  out.put(range.end);
}
void put(ByteWriter& out, const JournalWorker& e) {
  const std::string_view name = std::string_view(e.name).substr(0, longest_name);
  out.put(e.tracer);
  out.put(e.threads);
  out.put(static_cast<std::uint32_t>(name.size()));
  out.put_bytes(name);
}
void put(ByteWriter& out, const JournalPass& e) {
  out.put(e.pass);
  out.put(e.cells);
  out.put(e.at);
  out.put(e.grain.row_cells);
  out.put(e.grain.piece_cells);
  out.put(e.grain.cell_samples);
}
void put(ByteWriter& out, const JournalMerge& e) {
  out.put(e.pass);
  out.put(e.tracer);
  out.put(e.epoch);
  put(out, e.range);
  out.put(e.samples);
  out.put(e.granted);
  out.put(e.arrived);
  out.put(e.seconds);
  out.put(e.digest);
}
void put(ByteWriter& out, const JournalRetraction& e) {
  out.put(e.pass);
  out.put(e.at);
  out.put(std::uint64_t{e.cells.size()});
  for (const CellRange& range : e.cells) put(out, range);
}

void put(ByteWriter& out, const JournalGrid& e) {
  const GridShape& shape = e.shape;
  for (const std::uint32_t number :
       {e.pass, shape.width, shape.height, static_cast<std::uint32_t>(shape.row_order),
        shape.band_rows, shape.cell_pixels, shape.layer_samples, shape.piece_cells,
        static_cast<std::uint32_t>(shape.stages.size())}) {
    out.put(number);
  }
  for (const Stage& stage : shape.stages) {
    for (const std::uint32_t number :
         {stage.begin, stage.end, stage.lattice.x, stage.lattice.y, stage.lattice.step}) {
      out.put(number);
    }
  }
}

CellRange get_range(ByteReader& in) {
  CellRange range;
  range.begin = in.get<std::uint64_t>();
  range.end = in.get<std::uint64_t>();
  if (range.begin >= range.end) throw DecodeError("journal: an empty range of cells");
  return range;
}
void get(ByteReader& in, JournalWorker& e) {
  e.tracer = in.get<TracerKey>();
  e.threads = in.get<std::uint32_t>();
  const auto size = in.get<std::uint32_t>();
  if (size > longest_name) throw DecodeError("journal: a name is too long");
  e.name = in.get_bytes(size);
}
void get(ByteReader& in, JournalPass& e) {
  e.pass = in.get<std::uint32_t>();
  e.cells = in.get<std::uint64_t>();
  e.at = in.get<double>();
  e.grain.cells = e.cells;
  e.grain.row_cells = in.get<std::uint64_t>();
  e.grain.piece_cells = in.get<std::uint32_t>();
  e.grain.cell_samples = in.get<double>();
  if (e.cells == 0 || e.grain.row_cells == 0 || e.grain.piece_cells == 0 ||
      !(e.grain.cell_samples > 0)) {
    throw DecodeError("journal: a pass without cells");
  }
}
void get(ByteReader& in, JournalMerge& e) {
  e.pass = in.get<std::uint32_t>();
  e.tracer = in.get<TracerKey>();
  e.epoch = in.get<std::uint64_t>();
  e.range = get_range(in);
  e.samples = in.get<std::uint64_t>();
  e.granted = in.get<double>();
  e.arrived = in.get<double>();
  e.seconds = in.get<double>();
  e.digest = in.get<std::uint64_t>();
}
void get(ByteReader& in, JournalRetraction& e) {
  e.pass = in.get<std::uint32_t>();
  e.at = in.get<double>();
  const auto count = in.get<std::uint64_t>();
  if (count > in.left() / (2 * sizeof(std::uint64_t))) throw DecodeError("journal: data end early");
  e.cells.resize(count);
  std::generate(e.cells.begin(), e.cells.end(), [&] { return get_range(in); });
}

void get(ByteReader& in, JournalGrid& e) {
  const auto number = [&in] { return in.get<std::uint32_t>(); };
  GridShape& shape = e.shape;
  e.pass = number();
  shape.width = number();
  shape.height = number();
  const std::uint32_t row_order = number();
  if (row_order > static_cast<std::uint32_t>(RowOrder::interleaved)) {
    throw DecodeError("journal: an unknown order of rows");
  }
  shape.row_order = static_cast<RowOrder>(row_order);
  shape.band_rows = number();
  shape.cell_pixels = number();
  shape.layer_samples = number();
  shape.piece_cells = number();
  const std::uint32_t stages = number();
  if (stages > in.left() / (5 * sizeof(std::uint32_t))) {
    throw DecodeError("journal: data end early");
  }
  shape.stages.clear();
  for (std::uint32_t i = 0; i < stages; ++i) {
    const std::uint32_t begin = number();
    const std::uint32_t end = number();
    const std::uint32_t x = number();
    const std::uint32_t y = number();
    shape.stages.emplace_back(begin, end, Lattice{x, y, number()});
  }
  try {
    const CellGrid checked(shape);
  } catch (const InputError& error) {
    throw DecodeError(std::string("journal: ") + error.what());
  }
}

template <typename Entry>
JournalEntry get_as(ByteReader& in) {
  Entry entry;
  get(in, entry);
  return entry;
}

/// Decodes one entry: its kind, then its fields.
JournalEntry get_entry(ByteReader& in) {
  switch (in.get<std::uint32_t>()) {
    case 0: return get_as<JournalWorker>(in);
    case 1: return get_as<JournalPass>(in);
    case 2: return get_as<JournalMerge>(in);
    case 3: return get_as<JournalRetraction>(in);
    case 4: return get_as<JournalGrid>(in);
    default: throw DecodeError("journal: an entry of an unknown kind");
  }
}

}  // namespace

std::string Journal::add(const JournalEntry& entry) {
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(entry.index()));
  std::visit([&](const auto& e) { put(out, e); }, entry);
  std::string bytes = out.take();
  note(entry);
  bytes_ += bytes;
  return bytes;
}

void Journal::replay(std::string_view entry) {
  ByteReader in(entry);
  const JournalEntry read = get_entry(in);
  in.expect_end();
  note(read);
  bytes_ += entry;
}

void Journal::note(const JournalEntry& entry) {
  if (const auto* worker = std::get_if<JournalWorker>(&entry)) {
    workers_.insert(worker->tracer);
  } else if (const auto* pass = std::get_if<JournalPass>(&entry)) {
    passes_.insert(pass->pass);
  }
}

std::vector<JournalEntry> read_journal(std::string_view bytes) {
  std::vector<JournalEntry> entries;
  for (ByteReader in(bytes); in.left() > 0;) entries.push_back(get_entry(in));
  return entries;
}

}  // namespace parray::coordinator
