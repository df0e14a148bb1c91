#include "cli/mpi/mpi_job.h"

#include <unistd.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/scene/settings.h"
#include "proto/mpi_window.h"
#include "proto/settings_json.h"

namespace parray::mpi {
namespace {

using nlohmann::json;

/// Appends the length of a list and its bytes in memory. All ranks run the same build.
template <typename Element>
void append(std::string& bytes, const std::vector<Element>& list) {
  const std::uint64_t count = list.size();
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  bytes.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(Element));
}

template <typename Element>
std::vector<Element> take_list(std::string_view& bytes) {
  std::uint64_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  bytes.remove_prefix(sizeof count);
  std::vector<Element> list(count);
  if (count > 0) {  // data() of an empty list may be null, which memcpy does not allow
    std::memcpy(list.data(), bytes.data(), count * sizeof(Element));
  }
  bytes.remove_prefix(count * sizeof(Element));
  return list;
}

/// Returns the facts of all ranks. The result is meaningful in rank 0 only.
std::vector<RankFacts> gather_facts(const MpiWorld& world, std::uint32_t threads, bool alone) {
  constexpr std::size_t name_size = 64;
  struct Packed {
    std::array<char, name_size> host{};
    std::uint32_t threads = 0;
  };
  Packed own;
  own.threads = threads;
  gethostname(own.host.data(), name_size - 1);
  std::vector<Packed> all(world.ranks());
  all[0] = own;
  if (!alone) {
    check_mpi(
        MPI_Gather(&own, sizeof own, MPI_BYTE, all.data(), sizeof own, MPI_BYTE, 0, world.comm()),
        "asking all ranks for their threads");
  }
  std::vector<RankFacts> facts;
  facts.reserve(all.size());
  for (const Packed& rank : all) facts.push_back({rank.host.data(), rank.threads});
  return facts;
}

}  // namespace

std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job,
                                    const std::string& scene_bytes) {
  std::string header;
  if (job != nullptr) {
    header = json{{"settings", settings_to_json(job->settings)},
                  {"mode", static_cast<int>(job->mode)},
                  {"tile", job->tile},
                  {"fingerprint", job->fingerprint}}
                 .dump();
  }
  header = world.broadcast(std::move(header));
  if (header.empty()) return {};
  const json map = json::parse(header);
  MpiJob received;
  received.settings = settings_from_json(map.at("settings"));
  received.mode = static_cast<MpiMode>(map.at("mode").get<int>());
  received.tile = map.at("tile");
  received.fingerprint = map.at("fingerprint");
  if (!received.alone()) received.scene_bytes = world.broadcast(scene_bytes);
  return received;
}

std::optional<RankPass> broadcast_pass(const MpiWorld& world, const MpiJob& job,
                                       const RankPass* pass) {
  std::string bytes;
  if (pass != nullptr) {
    append(bytes, pass->plan->grid()->shape().stages);
    append(bytes, pass->plan->pixel_samples());
    append(bytes, pass->missing.ranges());
  }
  bytes = world.broadcast(std::move(bytes));
  if (bytes.empty() || pass != nullptr) return {};
  std::string_view rest = bytes;
  RankPass received;
  Pass cut;
  cut.stages = take_list<Stage>(rest);
  cut.samples = take_list<SampleRange>(rest);
  received.plan = std::make_shared<const WorkPlan>(job.settings, std::move(cut), job.tile);
  received.missing = CellList(take_list<CellRange>(rest));
  return received;
}

Ranks find_ranks(const MpiWorld& world, const MpiJob& job, std::uint32_t threads) {
  Ranks ranks;
  ranks.count = job.alone() ? 1 : world.ranks();
  ranks.facts = gather_facts(world, threads, job.alone());
  ranks.own.policy = job.settings->schedule;
  ranks.own.rank = world.rank();
  ranks.own.threads = threads;
  ranks.own.all_threads = job.alone() ? threads : static_cast<std::uint32_t>(world.sum(threads));
  return ranks;
}

}  // namespace parray::mpi
