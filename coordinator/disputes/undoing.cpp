#include "coordinator/disputes/undoing.h"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

namespace parray::coordinator {

using nlohmann::json;

FaultFindings kept_findings(Store& store) {
  const std::string text = store.note("workers");
  if (text.empty()) {
    return {};
  }
  try {
    return FaultFindings::from_json(json::parse(text).value("convictions", json::array()));
  } catch (const json::exception& error) {
    throw RunError(std::string("the state's note of workers is damaged: ") + error.what());
  }
}

/// What a job says of a machine that returned wrong bits.
static std::string flag_of(const JobPicture::Retraction& retraction, const std::string& name) {
  if (retraction.restarted) {
    return fmt::format("worker '{}' returned wrong bits: the picture was begun again", name);
  }
  std::uint64_t cells = 0;
  for (const CellRange& range : retraction.cells) {
    cells += range.count();
  }
  return fmt::format("worker '{}' returned wrong bits: {} cells were traced again", name, cells);
}

std::optional<JobPicture::Retraction> undo(JobPicture& picture, Store* store, JobRecord& record,
                                           const FaultFinding& finding, double at) {
  std::optional<JobPicture::Retraction> undone;
  record.passes = picture.passes().begun();
  record.fault_findings = finding.number;
  if (picture.relies_on(finding.machine)) {
    undone = picture.retract(finding.machine);
    record.flag = flag_of(*undone, finding.worker);
    std::vector<JournalEntry> entries{
        JournalRetraction{picture.passes().pass(), at, undone->cells}};
    if (undone->restarted) {
      record.passes = {};  // another life must not repeat what lies have decided
      entries = begun_entries(picture, at);
    }
    if (store != nullptr) {
      undone->restarted ? store->drop_rows(record.id)
                        : store->append_rows(record.id, picture.retraction_entry(undone->cells));
    }
    keep_journal(picture, store, record.id, entries);
  }
  if (store != nullptr) {
    store->put_job(record);
  }
  return undone;
}

}  // namespace parray::coordinator
