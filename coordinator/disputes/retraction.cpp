#include "coordinator/disputes/retraction.h"

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

/// Returns a job's flag after a machine returned wrong bits.
static std::string flag_of(const JobPicture::Retraction& retraction, const std::string& name) {
  if (retraction.restarted) {
    return fmt::format("worker '{}' returned wrong bits: the picture was started again", name);
  }
  std::uint64_t cells = 0;
  for (const CellRange& range : retraction.cells) {
    cells += range.count();
  }
  return fmt::format("worker '{}' returned wrong bits: {} cells were traced again", name, cells);
}

std::optional<JobPicture::Retraction> retract_results(JobPicture& picture, Store* store,
                                                      JobRecord& record,
                                                      const FaultFinding& finding, double at) {
  std::optional<JobPicture::Retraction> retraction;
  record.passes = picture.passes().begun();
  record.fault_findings = finding.number;
  if (picture.relies_on(finding.machine)) {
    retraction = picture.retract(finding.machine);
    record.flag = flag_of(*retraction, finding.worker);
    std::vector<JournalEntry> entries{
        JournalRetraction{picture.passes().pass(), at, retraction->cells}};
    if (retraction->restarted) {
      record.passes = {};  // wrong bits influenced the earlier passes
      entries = begun_entries(picture, at);
    }
    if (store != nullptr) {
      retraction->restarted
          ? store->drop_rows(record.id)
          : store->append_rows(record.id, picture.retraction_entry(retraction->cells));
    }
    keep_journal(picture, store, record.id, entries);
  }
  if (store != nullptr) {
    store->put_job(record);
  }
  return retraction;
}

}  // namespace parray::coordinator
