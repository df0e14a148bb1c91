#include "common/base/cgroup_limits.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <string>

#include "common/base/cpu_count.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

constexpr double no_cpus = std::numeric_limits<double>::infinity();
constexpr std::uint64_t no_memory = std::numeric_limits<std::uint64_t>::max();

/// A directory that looks like the root of a system.
class FakeSystem {
 public:
  FakeSystem() {
    std::string name = (fs::temp_directory_path() / "parray-cgroups-XXXXXX").string();
    root_ = mkdtemp(name.data());
  }
  FakeSystem& operator=(FakeSystem&&) = delete;
  ~FakeSystem() { fs::remove_all(root_); }

  void write(const std::string& file, const std::string& text) const {
    const fs::path path = root_ / file;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text << '\n';
  }
  /// Mounts of version 2, and the group that the process is in.
  void version_2(const std::string& group, const std::string& mounted = "/") const {
    write("proc/self/cgroup", "0::" + group);
    write("proc/self/mountinfo",
          "22 1 0:20 / /proc rw,nosuid - proc proc rw\n30 23 0:26 " + mounted +
              " /sys/fs/cgroup rw,nosuid shared:9 master:2 - cgroup2 cgroup2 rw,nsdelegate");
  }
  /// The same of version 1, whose hierarchies have one controller or two.
  void version_1(const std::string& group, const std::string& mounted = "/") const {
    write("proc/self/cgroup",
          "7:name=systemd:/init\n5:memory:" + group + "\n4:cpu,cpuacct:" + group);
    write("proc/self/mountinfo",
          "31 23 0:28 " + mounted +
              " /sys/fs/cgroup/cpu,cpuacct rw - cgroup cgroup rw,cpuacct,cpu\n" + "32 23 0:29 " +
              mounted + " /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory");
  }
  CgroupLimits limits() const { return cgroup_limits(root_); }

 private:
  fs::path root_;
};

TEST_CASE("a system without control groups limits nothing") {
  const FakeSystem system;
  CHECK(system.limits().cpus == no_cpus);
  CHECK(system.limits().memory == no_memory);
}

TEST_CASE("cgroups of version 2 limit CPUs and memory") {
  const FakeSystem system;
  system.version_2("/job");
  system.write("sys/fs/cgroup/job/cpu.max", "150000 100000");
  system.write("sys/fs/cgroup/job/memory.max", "1073741824");
  CHECK(system.limits().cpus == 1.5);
  CHECK(system.limits().memory == 1073741824);
}

TEST_CASE("cgroups of version 2 that say max limit nothing") {
  const FakeSystem system;
  system.version_2("/job");
  system.write("sys/fs/cgroup/job/cpu.max", "max 100000");
  system.write("sys/fs/cgroup/job/memory.max", "max");
  CHECK(system.limits().cpus == no_cpus);
  CHECK(system.limits().memory == no_memory);
}

TEST_CASE("cgroups of version 1 limit CPUs and memory, each in its own hierarchy") {
  const FakeSystem system;
  system.version_1("/job");
  system.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "250000");
  system.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "100000");
  system.write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "536870912");
  CHECK(system.limits().cpus == 2.5);
  CHECK(system.limits().memory == 536870912);
}

TEST_CASE("cgroups of version 1 without a quota limit no CPUs") {
  const FakeSystem system;
  system.version_1("/job");
  system.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "-1");
  system.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "100000");
  CHECK(system.limits().cpus == no_cpus);
}

TEST_CASE("the least limit of all groups above counts") {
  const FakeSystem system;
  system.version_2("/slice/job/step");
  system.write("sys/fs/cgroup/slice/cpu.max", "800000 100000");
  system.write("sys/fs/cgroup/slice/job/cpu.max", "200000 100000");
  system.write("sys/fs/cgroup/slice/job/step/cpu.max", "max 100000");
  system.write("sys/fs/cgroup/slice/memory.max", "4096");
  system.write("sys/fs/cgroup/slice/job/step/memory.max", "8192");
  CHECK(system.limits().cpus == 2);
  CHECK(system.limits().memory == 4096);
}

TEST_CASE("a container that sees its own group under the host's path finds its limits") {
  for (const auto& row :
       {std::pair("/docker/f00", "/docker/f00"), std::pair("/", "/"),
        std::pair("/docker/f00", "/docker"), std::pair("/", "/../.."), std::pair("/../../pod", "/"),
        std::pair("/kubepods/f00", "/docker/f00")}) {
    const auto& [group, mounted] = row;  // which Clang 14 does not capture
    CAPTURE(row.first);
    CAPTURE(row.second);
    const std::string below = std::string(mounted) == "/docker" ? "/f00" : "";
    const FakeSystem two;
    two.version_2(group, mounted);
    two.write("sys/fs/cgroup" + below + "/cpu.max", "300000 100000");
    CHECK(two.limits().cpus == 3);
    const FakeSystem one;
    one.version_1(group, mounted);
    one.write("sys/fs/cgroup/memory" + below + "/memory.limit_in_bytes", "12345");
    CHECK(one.limits().memory == 12345);
  }
}

TEST_CASE("a group of another name does not count") {
  const FakeSystem system;
  system.version_2("/job", "/jo");
  system.write("sys/fs/cgroup/b/cpu.max", "100000 100000");
  system.write("sys/fs/cgroup/job/cpu.max", "100000 100000");
  CHECK(system.limits().cpus == no_cpus);
}

TEST_CASE("files that are not understood limit nothing") {
  const FakeSystem system;
  system.version_2("/job");
  system.write("sys/fs/cgroup/job/cpu.max", "many");
  system.write("sys/fs/cgroup/job/memory.max", "-");
  CHECK(system.limits().cpus == no_cpus);
  CHECK(system.limits().memory == no_memory);
  system.write("sys/fs/cgroup/job/cpu.max", "100000 0");
  CHECK(system.limits().cpus == no_cpus);
  system.write("proc/self/cgroup", "nonsense\n::\n0");
  system.write("proc/self/mountinfo", "nonsense\n- cgroup2\n");
  CHECK(system.limits().cpus == no_cpus);
}

TEST_CASE("there is always a CPU and some memory") {
  CHECK(usable_cpus() >= 1);
  CHECK(usable_cpus() <= sysconf(_SC_NPROCESSORS_CONF));
  CHECK(usable_memory() > 0);
}

}  // namespace
}  // namespace parray
