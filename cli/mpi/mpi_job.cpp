#include "cli/mpi/mpi_job.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

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

/// As it lies in memory: all ranks run the same build.
template <typename Element>
void append(std::string& bytes, const std::vector<Element>& list) {
  bytes.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(Element));
}

template <typename Element>
std::vector<Element> list_from(std::string_view bytes) {
  std::vector<Element> list(bytes.size() / sizeof(Element));
  std::memcpy(list.data(), bytes.data(), list.size() * sizeof(Element));
  return list;
}

}  // namespace

std::optional<MpiPass> broadcast_pass(const MpiWorld& world, const MpiPass* pass) {
  std::string bytes;
  if (pass != nullptr) {
    append(bytes, std::vector<std::uint64_t>{pass->pending.size()});
    append(bytes, pass->pending);
    append(bytes, pass->samples);
  }
  bytes = world.broadcast(std::move(bytes));
  if (bytes.empty()) {
    return {};
  }
  const std::string_view lists = std::string_view(bytes).substr(sizeof(std::uint64_t));
  const std::size_t rects =
      list_from<std::uint64_t>(bytes.substr(0, sizeof(std::uint64_t))).front() * sizeof(WorkRect);
  return MpiPass{list_from<WorkRect>(lists.substr(0, rects)),
                 list_from<SampleRange>(lists.substr(rects))};
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

Transport::Transport(const MpiWorld& world, const MpiJob& job)
    : world_(world),
      alone_(job.alone() || world.ranks() == 1),
      by_messages_(!alone_ && job.mode == MpiMode::messages) {}

void Transport::begin_pass(const WindowLayout& layout) {
  if (layout.bytes() <= bytes_) {
    clear(layout.zeroed_bytes());
    return;
  }
  // Records of later passes are a little longer, pass by pass.
  bytes_ = bytes_ == 0 ? layout.bytes() : layout.bytes() / 4 * 5;
  if (!alone_ && !by_messages_) {
    open_window(layout);
  }
  if (world_.first() && !mpi_window_) {
    local_memory_ = {};  // before there is more: two may not fit
    local_memory_.resize((bytes_ + 7) / 8);
    local_window_ = std::make_unique<LocalWindow>(memory());
  }
}

void Transport::open_window(const WindowLayout& layout) {
  close();
  try {
    mpi_window_ = std::make_unique<MpiWindow>(world_.comm(), bytes_, layout.zeroed_bytes());
  } catch (const RunError& error) {
    fallback_reason_ = error.what();
  }
  const bool everywhere = world_.all_of(mpi_window_ != nullptr);
  if (!everywhere || !mpi_window_->works()) {
    if (fallback_reason_.empty()) {
      fallback_reason_ = "its trial failed";
    }
    static_cast<void>(mpi_window_.release());  // closing a window that does not work may hang
    by_messages_ = true;
  }
}

void Transport::clear(std::size_t zeroed) {
  if (mpi_window_) {
    mpi_window_->clear(zeroed);
    world_.meet(std::chrono::hours(24 * 365));  // nobody writes before it is zero
  } else if (world_.first()) {
    std::fill_n(memory().begin(), zeroed, std::byte{0});
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
