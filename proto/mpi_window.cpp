#include "proto/mpi_window.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "common/base/error.h"

namespace parray::proto {
namespace {

/// Largest transfer in bytes: MPI 3 counts with int, so longer transfers are cut into parts.
constexpr std::size_t most_bytes = std::size_t{1} << 30;

enum Tag : int { request_tag = 1, bytes_tag, reply_tag };

/// Calls `part(offset, count)` for every part of a transfer.
void in_parts(std::size_t bytes, auto part) {
  for (std::size_t done = 0; done < bytes; done += most_bytes) {
    part(done, static_cast<int>(std::min(bytes - done, most_bytes)));
  }
}

constexpr MPI_Aint displacement(std::size_t bytes) { return static_cast<MPI_Aint>(bytes); }

}  // namespace

void check_mpi(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  throw RunError(std::string(what) + ": " +
                 std::string(text.data(), static_cast<std::size_t>(length)));
}

MpiWindow::MpiWindow(MPI_Comm comm, std::size_t bytes, std::size_t zeroed) : comm_(comm) {
  int rank = 0;
  int ranks = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  rank_ = static_cast<std::uint32_t>(rank);
  ranks_ = static_cast<std::uint32_t>(ranks);
  void* base = nullptr;
  check_mpi(MPI_Win_allocate(displacement(bytes), 1, MPI_INFO_NULL, comm, &base, &window_),
            "allocating an MPI window");
  MPI_Win_set_errhandler(window_, MPI_ERRORS_RETURN);
  memory_ = {static_cast<std::byte*>(base), bytes};
  std::fill_n(memory_.begin(), std::min(bytes, zeroed), std::byte{0});
  for (int target = 0; target < ranks; ++target) {
    targets_.emplace_back(window_, target, target == rank ? memory_ : std::span<std::byte>());
  }
  check_mpi(MPI_Barrier(comm), "waiting for all ranks");  // no rank writes before memory is 0
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

std::uint64_t MpiTarget::fetch_and(MPI_Op op, std::size_t word, std::uint64_t operand) {
  std::uint64_t before = 0;
  check_mpi(MPI_Fetch_and_op(&operand, &before, MPI_UINT64_T, rank_,
                             displacement(word * sizeof(std::uint64_t)), op, window_),
            "an atomic operation on a rank's window");
  check_mpi(MPI_Win_flush(rank_, window_), "completing an operation on a rank's window");
  return before;
}

void MpiTarget::put(std::size_t offset, std::span<const std::byte> bytes) {
  if (!own_.empty()) {
    std::memcpy(own_.data() + offset, bytes.data(), bytes.size());
    MPI_Win_sync(window_);
    return;
  }
  in_parts(bytes.size(), [&](std::size_t done, int count) {
    check_mpi(MPI_Put(bytes.data() + done, count, MPI_BYTE, rank_, displacement(offset + done),
                      count, MPI_BYTE, window_),
              "putting results into a rank's window");
  });
  check_mpi(MPI_Win_flush(rank_, window_), "completing a put into a rank's window");
}

bool MpiWindow::works() {
  const auto all = static_cast<std::uint64_t>(ranks_);
  const auto own = static_cast<std::uint64_t>(rank_) + 1;
  Window& first = targets_.front();
  bool good = first.fetch_add(0, own) <= all * (all + 1) / 2;
  const std::array value = {own};
  first.put(own * sizeof own, std::as_bytes(std::span(value)));
  Window& next = targets_[own % all];
  if (own < all) next.store(0, own);
  MPI_Barrier(comm_);
  progress();
  good = first.load(0) == all * (all + 1) / 2 && first.load(own % all + 1) == own % all + 1 && good;
  if (own < all) good = next.fetch_add(0, 0 - own) == own && next.load(0) == 0 && good;
  MPI_Barrier(comm_);
  first.store(own, 0);
  if (rank_ == 0) first.store(0, 0);
  int everywhere = good ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &everywhere, 1, MPI_INT, MPI_MIN, comm_);
  return everywhere != 0;
}

RequestWindow::Ask ask_first_rank(MPI_Comm comm) {
  return [comm](WindowRequest request, std::span<const std::byte> bytes) {
    check_mpi(MPI_Send(&request, sizeof request, MPI_BYTE, 0, request_tag, comm),
              "sending a request to rank 0");
    in_parts(bytes.size(), [&](std::size_t offset, int count) {
      check_mpi(MPI_Send(bytes.data() + offset, count, MPI_BYTE, 0, bytes_tag, comm),
                "sending a result to rank 0");
    });
    std::uint64_t reply = 0;
    check_mpi(MPI_Recv(&reply, 1, MPI_UINT64_T, 0, reply_tag, comm, MPI_STATUS_IGNORE),
              "receiving a reply from rank 0");
    return reply;
  };
}

void answer_requests(MPI_Comm comm, std::span<std::byte> memory) {
  // The first probe may only make progress on a message that the second one finds.
  for (int misses = 0; misses < 2;) {
    int arrived = 0;
    MPI_Status status;
    check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, request_tag, comm, &arrived, &status),
              "probing for requests");
    if (arrived == 0) {
      ++misses;
      continue;
    }
    const int rank = status.MPI_SOURCE;
    WindowRequest request;
    check_mpi(
        MPI_Recv(&request, sizeof request, MPI_BYTE, rank, request_tag, comm, MPI_STATUS_IGNORE),
        "receiving a request");
    const std::uint64_t reply = perform(request, memory, [&](std::span<std::byte> bytes) {
      in_parts(bytes.size(), [&](std::size_t offset, int count) {
        check_mpi(MPI_Recv(bytes.data() + offset, count, MPI_BYTE, rank, bytes_tag, comm,
                           MPI_STATUS_IGNORE),
                  "receiving a result");
      });
    });
    check_mpi(MPI_Send(&reply, 1, MPI_UINT64_T, rank, reply_tag, comm), "sending a reply");
  }
}

void MpiWindow::progress() {
  // The first probe receives operations, the second performs them. This halves the latency.
  for (int look = 0; look < 2; ++look) {
    int arrived = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm_, &arrived, MPI_STATUS_IGNORE);
    MPI_Win_sync(window_);
  }
}

}  // namespace parray::proto
