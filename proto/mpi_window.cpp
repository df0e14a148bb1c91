#include "proto/mpi_window.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <string>
#include <string_view>

#include "common/base/error.h"

namespace parray {
namespace {

/// Counts are int in MPI 3: longer transfers go in parts.
constexpr std::size_t most_bytes = std::size_t{1} << 30;

constexpr MPI_Aint displacement(std::size_t bytes) { return static_cast<MPI_Aint>(bytes); }

}  // namespace

void check_mpi(int code, const char* what) {
  if (code == MPI_SUCCESS) {
    return;
  }
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  throw RunError(std::string(what) + ": " +
                 std::string(text.data(), static_cast<std::size_t>(length)));
}

MpiWindow::MpiWindow(MPI_Comm comm, std::size_t bytes, std::size_t zeroed) : comm_(comm) {
  MPI_Comm_rank(comm, &rank_);
  void* base = nullptr;
  const std::size_t own_bytes = rank_ == 0 ? bytes : 0;
  check_mpi(MPI_Win_allocate(displacement(own_bytes), 1, MPI_INFO_NULL, comm, &base, &window_),
            "allocating an MPI window");
  MPI_Win_set_errhandler(window_, MPI_ERRORS_RETURN);
  memory_ = {static_cast<std::byte*>(base), own_bytes};
  std::fill_n(memory_.begin(), std::min(own_bytes, zeroed), std::byte{0});
  check_mpi(MPI_Barrier(comm), "starting together");  // nobody writes before it is zero
  check_mpi(MPI_Win_lock_all(MPI_MODE_NOCHECK, window_), "opening an MPI window");
}

void MpiWindow::clear(std::size_t zeroed) {
  std::fill_n(memory_.begin(), std::min(memory_.size(), zeroed), std::byte{0});
  MPI_Win_sync(window_);
}

MpiWindow::~MpiWindow() {
  MPI_Win_unlock_all(window_);
  MPI_Win_free(&window_);
}

std::uint64_t MpiWindow::fetch_and(MPI_Op op, std::size_t word, std::uint64_t operand) {
  std::uint64_t before = 0;
  check_mpi(MPI_Fetch_and_op(&operand, &before, MPI_UINT64_T, 0,
                             displacement(word * sizeof(std::uint64_t)), op, window_),
            "an atomic operation on the coordinator's window");
  check_mpi(MPI_Win_flush(0, window_), "completing an operation on the coordinator's window");
  return before;
}

std::uint64_t MpiWindow::fetch_add(std::size_t word, std::uint64_t delta) {
  return fetch_and(MPI_SUM, word, delta);
}

std::uint64_t MpiWindow::load(std::size_t word) { return fetch_and(MPI_NO_OP, word, 0); }

void MpiWindow::store(std::size_t word, std::uint64_t value) {
  fetch_and(MPI_REPLACE, word, value);
}

void MpiWindow::put(std::size_t offset, std::span<const std::byte> bytes) {
  if (rank_ == 0) {
    std::memcpy(memory_.data() + offset, bytes.data(), bytes.size());
    MPI_Win_sync(window_);
    return;
  }
  for (std::size_t done = 0; done < bytes.size(); done += most_bytes) {
    const int count = static_cast<int>(std::min(bytes.size() - done, most_bytes));
    check_mpi(MPI_Put(bytes.data() + done, count, MPI_BYTE, 0, displacement(offset + done), count,
                      MPI_BYTE, window_),
              "putting rows into the coordinator's window");
  }
  check_mpi(MPI_Win_flush(0, window_), "completing a put into the coordinator's window");
}

bool MpiWindow::works() {
  int ranks = 0;
  MPI_Comm_size(comm_, &ranks);
  const auto all = static_cast<std::uint64_t>(ranks);
  const auto own = static_cast<std::uint64_t>(rank_) + 1;
  bool good = fetch_add(0, own) <= all * (all + 1) / 2;
  const std::array value = {own};
  put(own * sizeof own, std::as_bytes(std::span(value)));
  MPI_Barrier(comm_);
  progress();
  good = load(0) == all * (all + 1) / 2 && load(own % all + 1) == own % all + 1 && good;
  MPI_Barrier(comm_);
  store(own, 0);
  if (rank_ == 0) {
    store(0, 0);
  }
  int everywhere = good ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &everywhere, 1, MPI_INT, MPI_MIN, comm_);
  return everywhere != 0;
}

void MpiWindow::progress() {
  // The first look lets things in, the second acts on them: half the latency of one a turn.
  for (int look = 0; look < 2; ++look) {
    int arrived = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm_, &arrived, MPI_STATUS_IGNORE);
    MPI_Win_sync(window_);
  }
}

}  // namespace parray
