#include "cli/mpi/mpi_world.h"

#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>
#include <vector>

#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/text.h"
#include "proto/mpi_window.h"

namespace parray::mpi {
namespace {

constexpr int end_tag = 100;  // differs from all tags in proto/mpi_window.cpp

/// Returns whether the user requested a binding. mpirun passes its options in the environment. The
/// option "none" means no binding, like the default of ParRay.
bool binding_requested() {
  // NOLINTBEGIN(concurrency-mt-unsafe): nothing changes the environment meanwhile
  const char* binding = std::getenv("OMPI_MCA_hwloc_base_binding_policy");
  const char* mapping = std::getenv("OMPI_MCA_rmaps_base_mapping_policy");
  // NOLINTEND(concurrency-mt-unsafe)
  return (binding != nullptr && std::string_view(binding) != "none") ||
         (mapping != nullptr && std::string_view(mapping).find("PE=") != std::string_view::npos);
}

void allow_all_processors() {
  cpu_set_t all;
  CPU_ZERO(&all);
  for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) CPU_SET(cpu, &all);
  sched_setaffinity(0, sizeof all, &all);  // the kernel leaves out processors that are not allowed
}

}  // namespace

MpiWorld::MpiWorld() {
  // Debian's configuration disables osc/pt2pt, the only component for windows across machines
  // without special networks. A value that the user has set stays.
  setenv("OMPI_MCA_osc", "^ucx", 0);  // NOLINT(concurrency-mt-unsafe): no other thread runs yet
  int provided = MPI_THREAD_SINGLE;
  check_mpi(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "starting MPI");
  if (provided < MPI_THREAD_FUNNELED) {
    throw RunError("this MPI library does not support threads: use one with MPI_THREAD_FUNNELED");
  }
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  rank_ = static_cast<std::uint32_t>(rank);
  ranks_ = static_cast<std::uint32_t>(ranks);
  if (!binding_requested()) allow_all_processors();
  inspect_machine();
  if (!first()) {
    check_mpi(MPI_Irecv(nullptr, 0, MPI_BYTE, 0, end_tag, comm(), &end_), "waiting for the end");
  }
}

/// Finds the ranks of this machine, and divides processors among ranks with the same set.
void MpiWorld::inspect_machine() {
  MPI_Comm here = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here),
            "finding the ranks of this machine");
  int ranks_here = 1;
  MPI_Comm_size(here, &ranks_here);
  one_machine_ = static_cast<std::uint32_t>(ranks_here) == ranks_;
  cpu_set_t own;
  CPU_ZERO(&own);
  sched_getaffinity(0, sizeof own, &own);
  std::vector<cpu_set_t> sets(static_cast<std::size_t>(ranks_here));
  check_mpi(MPI_Allgather(&own, sizeof own, MPI_BYTE, sets.data(), sizeof own, MPI_BYTE, here),
            "comparing processors with the ranks of this machine");
  MPI_Comm_free(&here);
  const auto alike = std::ranges::count_if(
      sets, [&own](const cpu_set_t& set) { return std::memcmp(&set, &own, sizeof own) == 0; });
  const auto sharing = std::max<std::ptrdiff_t>(alike, 1);
  threads_ = static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(usable_cpus() / sharing, 1));
}

MpiWorld::~MpiWorld() {
  if (end_ != MPI_REQUEST_NULL) {
    MPI_Cancel(&end_);
    MPI_Request_free(&end_);
  }
  MPI_Finalize();
}

std::string MpiWorld::broadcast(std::string text) const {
  std::uint64_t size = text.size();
  check_mpi(MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm()), "sending the job to all ranks");
  text.resize(size);
  constexpr std::size_t most = std::size_t{1} << 30;  // counts are int
  for (std::size_t done = 0; done < size; done += most) {
    const int count = static_cast<int>(std::min<std::size_t>(size - done, most));
    check_mpi(MPI_Bcast(text.data() + done, count, MPI_BYTE, 0, comm()),
              "sending the job to all ranks");
  }
  return text;
}

std::uint64_t MpiWorld::sum(std::uint64_t value) const {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_SUM, comm()),
            "adding up over all ranks");
  return value;
}

bool MpiWorld::all_of(bool value) const { return sum(value ? 1 : 0) == ranks_; }

bool MpiWorld::barrier(Time patience, const std::function<void()>& meanwhile) const {
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ibarrier(comm(), &request), "waiting for all ranks");
  const SteadyClock clock;
  const Time end = clock.now() + patience;
  for (;;) {
    int done = 0;
    check_mpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "waiting for all ranks");
    if (done != 0 || clock.now() >= end) return done != 0;
    meanwhile();
    std::this_thread::sleep_for(milliseconds(1));
  }
}

void MpiWorld::announce_end() const {
  // NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker): nothing waits for the request
  for (std::uint32_t rank = 1; rank < ranks_; ++rank) {
    MPI_Request request = MPI_REQUEST_NULL;
    check_mpi(MPI_Isend(nullptr, 0, MPI_BYTE, static_cast<int>(rank), end_tag, comm(), &request),
              "announcing the end");
    MPI_Request_free(&request);
  }
}

bool MpiWorld::end_announced() {
  int done = 0;
  check_mpi(MPI_Test(&end_, &done, MPI_STATUS_IGNORE), "waiting for the end");
  return done != 0;
}

std::uint32_t rank_in_environment() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before there is any other thread
  const char* const text = std::getenv("PMIX_RANK");
  return text == nullptr ? 0 : parsed<std::uint32_t>(text).value_or(0);
}

}  // namespace parray::mpi
