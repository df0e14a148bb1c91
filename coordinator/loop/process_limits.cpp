#include "coordinator/loop/process_limits.h"

#include <malloc.h>
#include <sys/resource.h>

#include <string>

#include "common/base/error.h"

namespace parray::coordinator {

void keep_freed_blocks() {
  constexpr int largest_block = 1 << 26;
  // NOLINTBEGIN(concurrency-mt-unsafe): runs before the first thread starts
  mallopt(M_MMAP_THRESHOLD, largest_block);
  mallopt(M_TRIM_THRESHOLD, 2 * largest_block);
  // NOLINTEND(concurrency-mt-unsafe)
}

void allow_connections(std::size_t workers, std::size_t http) {
  constexpr std::size_t others = 256;  // clients, files, and those of ZeroMQ
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < workers + http + others) {
    throw InputError("--max-workers " + std::to_string(workers) + ": this process may open " +
                     std::to_string(limit.rlim_cur) + " files and needs " +
                     std::to_string(workers + http + others) +
                     ": raise ulimit -n, or lower --max-workers" +
                     (http > 0 ? " or --http-connections" : ""));
  }
}

}  // namespace parray::coordinator
