#include "coordinator/jobs/journal.h"

#include "common/base/bytes.h"
#include "common/base/error.h"

namespace parray::coordinator {
namespace {

constexpr std::size_t longest_name = 1000;

// Each entry's fields are described once for both directions: `f` is a ByteWriter or a ByteReader.
// check() throws DecodeError for values that no journal has.

/// Writes the number of elements. Reads it, and makes no more elements than the data can hold.
template <typename Count>
void count(ByteWriter& out, const auto& list, std::size_t /*element_bytes*/) {
  out.put(static_cast<Count>(list.size()));
}
template <typename Count>
void count(ByteReader& in, auto& list, std::size_t element_bytes) {
  const auto elements = in.get<Count>();
  if (elements > in.left() / element_bytes) throw DecodeError("data ends early");
  list.resize(elements);
}

void short_name(ByteWriter& out, const std::string& name) {
  const std::string_view start = std::string_view(name).substr(0, longest_name);
  out.put(static_cast<std::uint32_t>(start.size()));
  out.put_bytes(start);
}
void short_name(ByteReader& in, std::string& name) {
  const auto size = in.get<std::uint32_t>();
  if (size > longest_name) throw DecodeError("the name of a worker is too long");
  name = in.get_bytes(size);
}

void fields(auto& f, JournalWorker& e) {
  f.numbers(e.tracer, e.threads);
  short_name(f, e.name);
}
void fields(auto& f, JournalPass& e) {
  f.numbers(e.pass, e.cells, e.at, e.grain.row_cells, e.grain.piece_cells, e.grain.cell_samples);
  e.grain.cells = e.cells;
}
void fields(auto& f, JournalMerge& e) {
  f.numbers(e.pass, e.tracer, e.epoch, e.range.begin, e.range.end, e.samples, e.granted, e.arrived,
            e.seconds, e.digest);
}
void fields(auto& f, JournalRetraction& e) {
  f.numbers(e.pass, e.at);
  count<std::uint64_t>(f, e.cells, 2 * sizeof(std::uint64_t));
  for (CellRange& range : e.cells) f.numbers(range.begin, range.end);
}
void fields(auto& f, JournalGrid& e) {
  GridShape& s = e.shape;
  auto row_order = static_cast<std::uint32_t>(s.row_order);
  f.numbers(e.pass, s.width, s.height, row_order, s.band_rows, s.cell_pixels, s.layer_samples,
            s.piece_cells);
  if (row_order > static_cast<std::uint32_t>(RowOrder::interleaved)) {
    throw DecodeError("an unknown order of rows");
  }
  s.row_order = static_cast<RowOrder>(row_order);
  count<std::uint32_t>(f, s.stages, 5 * sizeof(std::uint32_t));
  for (Stage& stage : s.stages) {
    f.numbers(stage.begin, stage.end, stage.lattice.x, stage.lattice.y, stage.lattice.step);
  }
}

void check(const JournalWorker& /*e*/) {}
void check(const JournalPass& e) {
  if (e.cells == 0 || e.grain.row_cells == 0 || e.grain.piece_cells == 0 ||
      !(e.grain.cell_samples > 0)) {
    throw DecodeError("a pass without cells");
  }
}
void check(const CellRange& range) {
  if (range.begin >= range.end) throw DecodeError("an empty range of cells");
}
void check(const JournalMerge& e) { check(e.range); }
void check(const JournalRetraction& e) {
  for (const CellRange& range : e.cells) check(range);
}
void check(const JournalGrid& e) {
  try {
    const CellGrid checked(e.shape);
  } catch (const InputError& error) {
    throw DecodeError(error.what());
  }
}

template <typename Entry>
JournalEntry get_as(ByteReader& in) {
  Entry entry;
  fields(in, entry);
  check(entry);
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
    default: throw DecodeError("an entry of an unknown kind");
  }
}

}  // namespace

std::string Journal::add(const JournalEntry& entry) {
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(entry.index()));
  std::visit([&](auto copy) { fields(out, copy); }, entry);  // fields() takes a mutable entry
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

std::string damaged_journal(std::uint64_t job, const std::string& damage) {
  return "the journal of job " + std::to_string(job) + " is damaged (" + damage +
         "): submit the scene again for a new journal";
}

}  // namespace parray::coordinator
