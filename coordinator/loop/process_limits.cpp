#include "coordinator/loop/process_limits.h"

#include <malloc.h>
#include <sys/resource.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>

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

DescriptorUse descriptor_use() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  std::error_code ignored;
  const std::filesystem::directory_iterator files("/proc/self/fd", ignored);
  return {static_cast<std::size_t>(std::distance(begin(files), end(files))), limit.rlim_cur};
}

void DescriptorWatch::look(Time now) {
  constexpr Time rest = seconds(5);
  if (now >= look_at_) {
    look_at_ = now + rest;
    check(descriptor_use());
  }
}

void DescriptorWatch::check(const DescriptorUse& use) {
  if (!warned_ && use.open > use.most / 10 * 9) {
    warned_ = true;
    log_.warn(
        "{} of {} open files are in use, most of them by connections: new workers and clients may "
        "not be able to connect: find out who connects, or raise ulimit -n",
        use.open, use.most);
  } else if (warned_ && use.open < use.most / 10 * 8) {
    warned_ = false;
    log_.info("{} of {} open files are in use: new connections work again", use.open, use.most);
  }
}

}  // namespace parray::coordinator
