#include "cli/mpi/mpi_job.h"

#include <unistd.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "proto/settings_json.h"

namespace parray {

using nlohmann::json;

std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job) {
  std::string header;
  if (job != nullptr) {
    header = json{{"settings", settings_to_json(job->settings)},
                  {"mode", static_cast<int>(job->mode)},
                  {"tile", job->tile},
                  {"fingerprint", job->fingerprint}}
                 .dump();
  }
  header = world.broadcast(std::move(header));
  if (header.empty()) {
    return {};
  }
  const json map = json::parse(header);
  MpiJob received;
  received.settings = settings_from_json(map.at("settings"));
  received.mode = static_cast<MpiMode>(map.at("mode").get<int>());
  received.tile = map.at("tile");
  received.fingerprint = map.at("fingerprint");
  if (!received.alone()) {
    received.scene_bytes = world.broadcast(job != nullptr ? job->scene_bytes : std::string());
  } else if (job != nullptr) {
    received.scene_bytes = job->scene_bytes;
  }
  return received;
}

namespace {

/// Elements without padding, as they lie in memory: all ranks run the same build.
template <typename Element>
std::vector<Element> broadcast_list(const MpiWorld& world, const std::vector<Element>& list) {
  const std::string bytes =
      world.broadcast({reinterpret_cast<const char*>(list.data()), list.size() * sizeof(Element)});
  std::vector<Element> received(bytes.size() / sizeof(Element));
  std::memcpy(received.data(), bytes.data(), bytes.size());
  return received;
}

}  // namespace

std::optional<MpiPass> broadcast_pass(const MpiWorld& world, const MpiPass* pass) {
  if (world.broadcast(pass != nullptr ? "pass" : "").empty()) {
    return {};
  }
  const MpiPass own = pass != nullptr ? *pass : MpiPass{};
  return MpiPass{broadcast_list(world, own.pending), broadcast_list(world, own.samples)};
}

std::vector<RankFacts> gather_facts(const MpiWorld& world, std::uint32_t own_threads,
                                    std::uint32_t participants) {
  constexpr std::size_t name_size = 64;
  struct Packed {
    std::array<char, name_size> host{};
    std::uint32_t threads = 0;
  };
  Packed own;
  own.threads = own_threads;
  gethostname(own.host.data(), name_size - 1);
  std::vector<Packed> all(world.ranks());
  all[0] = own;
  if (participants > 1) {
    check_mpi(
        MPI_Gather(&own, sizeof own, MPI_BYTE, all.data(), sizeof own, MPI_BYTE, 0, world.comm()),
        "asking all ranks for their threads");
  }
  std::vector<RankFacts> facts;
  facts.reserve(all.size());
  for (const Packed& rank : all) {
    facts.push_back({rank.host.data(), rank.threads});
  }
  return facts;
}

Transport::Transport(const MpiWorld& world, MpiMode mode, const WindowLayout& layout) {
  const bool alone = layout.ranks() == 1;
  by_messages_ = !alone && mode == MpiMode::messages;
  if (!alone && !by_messages_) {
    try {
      mpi_window_ =
          std::make_unique<MpiWindow>(world.comm(), layout.bytes(), layout.zeroed_bytes());
    } catch (const RunError& error) {
      fallback_reason_ = error.what();
    }
    const bool everywhere = world.all_of(mpi_window_ != nullptr);
    if (!everywhere || !mpi_window_->works()) {
      if (fallback_reason_.empty()) {
        fallback_reason_ = "its trial failed";
      }
      static_cast<void>(mpi_window_.release());  // closing a window that does not work may hang
      by_messages_ = true;
    }
  }
  if (world.first() && !mpi_window_) {
    local_memory_.resize((layout.bytes() + 7) / 8);
    local_window_ = std::make_unique<LocalWindow>(memory());
  }
}

const char* Transport::name() const {
  return mpi_window_ ? "window" : by_messages_ ? "messages" : "memory";
}

Window* Transport::window() {
  return mpi_window_ ? static_cast<Window*>(mpi_window_.get()) : local_window_.get();
}

std::span<std::byte> Transport::memory() {
  return mpi_window_ ? mpi_window_->memory() : std::as_writable_bytes(std::span(local_memory_));
}

void Transport::progress() {
  if (mpi_window_) {
    mpi_window_->progress();
  }
}

}  // namespace parray
