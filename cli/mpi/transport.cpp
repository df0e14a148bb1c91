#include "cli/mpi/transport.h"

#include <algorithm>

#include "common/base/error.h"

namespace parray::mpi {

static constexpr std::size_t ledger_bytes = WindowLayout::shared_words * sizeof(std::uint64_t);

void Transport::begin_pass(const WindowLayout& layout) {
  if (layout.bytes() <= bytes_) return clear(layout.zeroed_bytes());
  // Records become a little longer with each pass.
  bytes_ = bytes_ == 0 ? layout.bytes() : layout.bytes() / 4 * 5;
  if (!alone_ && !by_messages_) open_window(layout);
  if (mpi_window_) return;
  if (world_.first()) {
    local_memory_ = {};  // first, because old and new memory may not both fit
    local_memory_.resize((bytes_ + 7) / 8);
    own_window_ = std::make_unique<LocalWindow>(memory());
  } else {
    own_window_ = std::make_unique<RequestWindow>(ask_first_rank(world_.comm()));
  }
}

void Transport::open_window(const WindowLayout& layout) {
  close();
  try {
    mpi_window_ = std::make_unique<MpiWindow>(world_.comm(), world_.first() ? bytes_ : ledger_bytes,
                                              layout.zeroed_bytes());
  } catch (const RunError& error) {
    fallback_reason_ = error.what();
  }
  const bool everywhere = world_.all_of(mpi_window_ != nullptr);
  if (!everywhere || !mpi_window_->works()) {
    if (fallback_reason_.empty()) fallback_reason_ = "its trial failed";
    static_cast<void>(mpi_window_.release());  // closing a window that does not work may hang
    by_messages_ = true;
  }
}

void Transport::clear(std::size_t zeroed) {
  if (mpi_window_) {
    mpi_window_->clear(zeroed);
    world_.barrier(std::chrono::hours(24 * 365));  // no rank may write before the memory is zero
  } else if (world_.first()) {
    std::fill_n(memory().begin(), zeroed, std::byte{0});
  }
}

const char* Transport::name() const {
  return mpi_window_ ? "window" : by_messages_ ? "messages" : "memory";
}

Window& Transport::window() { return mpi_window_ ? mpi_window_->of(0) : *own_window_; }

LedgerWindows Transport::ledgers() {
  if (!mpi_window_) return {Ledgers(world_.ranks(), world_.ranks()), {&window()}};
  LedgerWindows reached{Ledgers(world_.ranks(), ledger_ranks_), {}};
  for (std::uint32_t ledger = 0; ledger < reached.ledgers.count(); ++ledger) {
    reached.windows.push_back(&mpi_window_->of(reached.ledgers.keeper(ledger)));
  }
  return reached;
}

std::span<std::byte> Transport::memory() {
  return mpi_window_ ? mpi_window_->memory() : std::as_writable_bytes(std::span(local_memory_));
}

void Transport::progress() {
  if (mpi_window_) {
    mpi_window_->progress();
  } else if (by_messages_ && world_.first()) {
    answer_requests(world_.comm(), memory());
  }
}

}  // namespace parray::mpi
