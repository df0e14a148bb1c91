#include "coordinator/loop/descriptors.h"

#include <sys/resource.h>

#include <filesystem>
#include <iterator>
#include <system_error>

namespace parray::coordinator {

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
