#include "common/base/cgroup_limits.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/cpu_count.h"
#include "common/base/text.h"

namespace parray::base {
namespace {

namespace fs = std::filesystem;

/// A line of /proc/self/cgroup: "4:cpu,cpuacct:/job", or "0::/job" in version 2.
struct Membership {
  std::string controllers;
  std::string path;
};

/// A line of /proc/self/mountinfo, of a cgroup file system.
struct Mount {
  std::string root;  ///< the mounted group
  std::string point;
  std::string controllers;  ///< empty: version 2
};

std::vector<Membership> read_memberships(const fs::path& root) {
  std::ifstream file(root / "proc/self/cgroup");
  std::vector<Membership> found;
  Membership next;
  for (std::string number; std::getline(file, number, ':') &&
                           std::getline(file, next.controllers, ':') &&
                           std::getline(file, next.path);) {
    found.push_back(next);
  }
  return found;
}

std::vector<Mount> read_mounts(const fs::path& root) {
  std::ifstream file(root / "proc/self/mountinfo");
  std::vector<Mount> found;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    std::string skipped;
    Mount mount;
    fields >> skipped >> skipped >> skipped >> mount.root >> mount.point;
    while (fields >> skipped && skipped != "-") {
    }
    std::string type;
    std::string options;
    fields >> type >> skipped >> options;
    if (type == "cgroup2" || type == "cgroup") {
      mount.controllers = type == "cgroup" ? options : "";
      found.push_back(mount);
    }
  }
  return found;
}

/// Returns the place of the group `path` below a mount of `root`. A container may see a mount of
/// its own group under a path that only its host knows. Then the mount is the group.
fs::path inside(const std::string& path, const std::string& root) {
  const std::string prefix = root == "/" ? root : root + "/";
  if (!path.starts_with(prefix) || path.starts_with("/..")) return {};
  return fs::path(path.substr(prefix.size()));
}

template <class Value>
Value read_value(const fs::path& file, Value otherwise) {
  std::ifstream stream(file);
  Value value{};
  return stream >> value ? value : otherwise;
}

void lower_cpus(CgroupLimits& limits, double quota, double period) {
  if (quota > 0 && period > 0) limits.cpus = std::min(limits.cpus, quota / period);
}

void lower(CgroupLimits& limits, const fs::path& group) {
  double quota = 0;
  double period = 0;
  if (std::ifstream(group / "cpu.max") >> quota >> period) lower_cpus(limits, quota, period);
  lower_cpus(limits, read_value<double>(group / "cpu.cfs_quota_us", 0),
             read_value<double>(group / "cpu.cfs_period_us", 0));
  for (const char* file : {"memory.max", "memory.limit_in_bytes"}) {
    limits.memory = std::min(limits.memory, read_value(group / file, limits.memory));
  }
}

/// Returns the number of CPUs in the process's affinity mask, which cpusets and batch systems set.
int allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(CPU_COUNT(&set), 1) : 1;
}

}  // namespace

CgroupLimits cgroup_limits(const fs::path& root) {
  CgroupLimits limits;
  const std::vector<Membership> memberships = read_memberships(root);
  for (const Mount& mount : read_mounts(root)) {
    for (const Membership& member : memberships) {
      const bool same = mount.controllers.empty() || member.controllers.empty()
                            ? mount.controllers == member.controllers
                            : place_in(split_at(',', mount.controllers),
                                       split_at(',', member.controllers).front())
                                  .has_value();
      if (!same) continue;
      const fs::path top = root / fs::path(mount.point).relative_path();
      lower(limits, top);
      fs::path group = top;
      for (const fs::path& part : inside(member.path, mount.root)) {
        group /= part;
        lower(limits, group);
      }
    }
  }
  return limits;
}

int usable_cpus() {
  const int allowed = allowed_cpus();
  // With one and a half CPUs, two threads use all of the quota and one thread does not.
  const double granted = std::ceil(cgroup_limits().cpus);
  return granted < allowed ? std::max(static_cast<int>(granted), 1) : allowed;
}

std::uint64_t usable_memory() {
  const auto pages = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES));
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return std::min(pages * page, cgroup_limits().memory);
}

}  // namespace parray::base
