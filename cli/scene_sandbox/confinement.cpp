#include "cli/scene_sandbox/confinement.h"

#include <fcntl.h>
#include <link.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <optional>
#include <set>
#include <utility>

#include "common/base/error.h"
#include "common/base/files.h"

namespace parray::scene_sandbox {
namespace {

namespace fs = std::filesystem;

// Rights that the header of Debian 12 lacks. Comments name the version of Landlock that added them.
constexpr std::uint64_t right_truncate = std::uint64_t{1} << 14;  // 3
constexpr std::uint64_t right_ioctl = std::uint64_t{1} << 15;     // 5
constexpr std::uint64_t net_bind_connect = 3;                     // 4
constexpr std::uint64_t scope_all = 3;                            // 6: abstract sockets, signals

constexpr std::uint64_t reading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t writing = reading | LANDLOCK_ACCESS_FS_WRITE_FILE |
                                  LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG;
constexpr std::uint64_t of_files = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                                   LANDLOCK_ACCESS_FS_EXECUTE | right_truncate | right_ioctl;

struct Ruleset {
  std::uint64_t files = 0;
  std::uint64_t network = 0;
  std::uint64_t scopes = 0;
};

Ruleset all_rights(long version) {
  Ruleset all{(std::uint64_t{1} << 13) - 1};
  if (version >= 2) all.files |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) all.files |= right_truncate;
  if (version >= 4) all.network = net_bind_connect;
  if (version >= 5) all.files |= right_ioctl;
  if (version >= 6) all.scopes = scope_all;
  return all;
}

void allow(int ruleset, std::uint64_t handled, const fs::path& path, std::uint64_t rights) {
  const int at = open(path.c_str(), O_PATH | O_CLOEXEC);
  if (at < 0) return;
  struct stat found {};
  const bool is_file = fstat(at, &found) == 0 && !S_ISDIR(found.st_mode);
  landlock_path_beneath_attr rule{};
  rule.allowed_access = rights & handled & (is_file ? of_files : ~std::uint64_t{0});
  rule.parent_fd = at;
  syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
  close(at);
}

/// Returns the directories of the program and of the loaded libraries. They also contain the
/// libraries that the program loads later.
std::set<fs::path> library_directories() {
  std::set<fs::path> found;
  const auto note = [](dl_phdr_info* info, std::size_t /*size*/, void* paths) {
    std::error_code error;
    const fs::path library = fs::canonical(info->dlpi_name, error);
    if (!error) static_cast<std::set<fs::path>*>(paths)->insert(library.parent_path());
    return 0;
  };
  dl_iterate_phdr(note, &found);
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error) found.insert(self.parent_path());  // modules are beside the program
  return found;
}

/// Restricts access to files by Landlock. Does nothing if the kernel lacks it.
void restrict_files(const fs::path& directory) {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return;
  const Ruleset all = all_rights(version);
  const std::size_t size = version >= 6   ? sizeof all
                           : version >= 4 ? offsetof(Ruleset, scopes)
                                          : offsetof(Ruleset, network);
  const auto ruleset = static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0));
  if (ruleset < 0) return;
  for (const fs::path& libraries : library_directories()) {
    allow(ruleset, all.files, libraries, reading);
  }
  // None of these may contain the keys of a farm.
  for (const char* path :
       {"/usr/lib", "/usr/share", "/usr/local/lib", "/lib", "/lib64", "/etc/ld.so.cache",
        "/etc/fonts", "/etc/localtime", "/etc/ssl/openssl.cnf", "/proc/cpuinfo", "/proc/meminfo",
        "/proc/self", "/sys/devices/system/cpu", "/sys/fs/cgroup", "/dev/urandom", "/dev/null"}) {
    allow(ruleset, all.files, path, reading);
  }
  allow(ruleset, all.files, directory, writing | right_truncate);
  syscall(SYS_landlock_restrict_self, ruleset, 0);
  close(ruleset);
}

#if defined(__x86_64__)
constexpr std::uint32_t this_architecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t this_architecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t this_architecture = 0;
#endif

/// System calls that reading and writing files do not need.
constexpr std::array refused_calls = {
    // Sockets.
    SYS_socket, SYS_socketpair, SYS_connect, SYS_bind, SYS_listen, SYS_accept, SYS_accept4,
    // Programs and other processes.
    SYS_execve, SYS_execveat, SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev, SYS_kill,
    SYS_tkill, SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo, SYS_setpriority, SYS_ioprio_set,
    SYS_kcmp, SYS_migrate_pages, SYS_move_pages, SYS_process_madvise, SYS_shmget, SYS_shmat,
    SYS_shmctl, SYS_msgget, SYS_msgctl, SYS_semget, SYS_semctl, SYS_mq_open, SYS_mq_unlink,
    SYS_pidfd_open, SYS_pidfd_getfd, SYS_pidfd_send_signal,
#ifdef SYS_vfork  // newer architectures lack these calls
    SYS_fork, SYS_vfork,
#endif
    // Ways around the other restrictions.
    SYS_io_uring_setup, SYS_io_uring_enter, SYS_io_uring_register, SYS_bpf, SYS_perf_event_open,
    SYS_userfaultfd, SYS_keyctl, SYS_add_key, SYS_request_key, SYS_unshare, SYS_setns, SYS_mount,
    SYS_umount2, SYS_pivot_root, SYS_chroot, SYS_open_by_handle_at, SYS_name_to_handle_at,
    SYS_personality, SYS_memfd_create};

/// System calls that a process needs for itself. Their first argument names the process; 0: itself.
constexpr std::array calls_for_itself = {
    SYS_tgkill,         SYS_prlimit64,    SYS_sched_setaffinity, SYS_sched_setscheduler,
    SYS_sched_setparam, SYS_sched_setattr};

constexpr sock_filter statement(std::uint32_t code, std::uint32_t value) {
  return {static_cast<std::uint16_t>(code), 0, 0, value};
}
constexpr sock_filter jump(std::uint32_t code, std::uint32_t value, std::uint8_t if_true,
                           std::uint8_t if_false) {
  return {static_cast<std::uint16_t>(code), if_true, if_false, value};
}

/// Adds the check of a call of `calls_for_itself`.
void allow_for_itself(std::vector<sock_filter>& filter, long call) {
  constexpr std::uint32_t equal = BPF_JMP | BPF_JEQ | BPF_K;
  filter.insert(filter.end(),
                {jump(equal, static_cast<std::uint32_t>(call), 0, 5),
                 statement(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
                 jump(equal, 0, 2, 0), jump(equal, static_cast<std::uint32_t>(getpid()), 1, 0),
                 statement(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
                 statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)});
}

/// Restricts system calls by seccomp. Does nothing if the kernel lacks it.
void restrict_calls() {
  if (this_architecture == 0) return;
  constexpr std::uint32_t load = BPF_LD | BPF_W | BPF_ABS;
  constexpr std::uint32_t equal = BPF_JMP | BPF_JEQ | BPF_K;
  constexpr std::uint32_t at_least = BPF_JMP | BPF_JGE | BPF_K;
  constexpr std::uint32_t other_table = 0x40000000;  // x32: other numbers for the same calls
  const sock_filter refuse = statement(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
  std::vector<sock_filter> filter = {
      statement(load, offsetof(seccomp_data, arch)), jump(equal, this_architecture, 1, 0),
      statement(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      statement(load, offsetof(seccomp_data, nr)), jump(at_least, other_table, 0, 1), refuse,
      // glibc then uses clone, whose flags a filter can check.
      jump(equal, SYS_clone3, 0, 1), statement(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS)};
  for (const long call : refused_calls) {
    filter.push_back(jump(equal, static_cast<std::uint32_t>(call), 0, 1));
    filter.push_back(refuse);
  }
  for (const long call : calls_for_itself) allow_for_itself(filter, call);
  // Allows threads, but no processes.
  filter.push_back(jump(equal, SYS_clone, 0, 3));
  filter.push_back(statement(load, offsetof(seccomp_data, args)));
  filter.push_back(jump(BPF_JMP | BPF_JSET | BPF_K, CLONE_THREAD, 1, 0));
  filter.push_back(refuse);
  filter.push_back(statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

bool writes_a_large_file(const Enclosure& enclosure) {
  const fs::path file = enclosure.directory / "too-large";
  const int out = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (out < 0) return false;
  const auto last = static_cast<off_t>(enclosure.file_bytes);
  const bool written = pwrite(out, "x", 1, last) == 1;
  close(out);
  unlink(file.c_str());
  return written;
}

/// `option` is the option of the coordinator that gives the limit. `beyond`: the distance from the
/// soft limit `value` to the hard limit.
void limit(decltype(RLIMIT_AS) what, rlim_t value, const std::string& option, rlim_t beyond = 0) {
  const rlimit wanted{value, value + beyond};
  if (setrlimit(what, &wanted) != 0) {
    throw RunError("the coordinator's own limits (ulimit -H -a) are below " + option +
                   ": start it with higher limits, or lower the option");
  }
}

}  // namespace

void enclose_process(const Enclosure& enclosure) {
  const rlimit size{enclosure.file_bytes, enclosure.file_bytes};
  // NOLINTNEXTLINE(concurrency-mt-unsafe): there is one thread
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));  // write() then fails with an error
  if (setrlimit(RLIMIT_FSIZE, &size) != 0) {
    throw RunError(
        "the coordinator cannot confine the process that reads scenes: the coordinator's limit of "
        "file sizes is too low: start it with ulimit -H -f unlimited");
  }
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
    throw RunError(
        "the coordinator cannot confine the process that reads scenes: run the coordinator on "
        "Linux 3.5 or later");
  }
  restrict_files(enclosure.directory);
  restrict_calls();
}

std::vector<std::string> ways_out(const Enclosure& enclosure, const fs::path& file) {
  std::vector<std::string> ways;
  const int read = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (read >= 0) {
    ways.push_back("reads " + file.string());
    close(read);
  }
  const fs::path beside = file.parent_path() / ".parray-written";
  const int written = open(beside.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (written >= 0) {
    ways.push_back("writes beside " + file.string());
    close(written);
    unlink(beside.c_str());
  }
  for (const int family : {AF_INET, AF_UNIX}) {
    const int made = socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (made < 0) continue;
    ways.emplace_back(family == AF_INET ? "makes sockets" : "makes local sockets");
    close(made);
  }
  const pid_t parent = getppid();
  if (kill(parent, 0) == 0 || syscall(SYS_tgkill, parent, parent, 0) == 0) {
    ways.emplace_back("sends signals");
  }
  rlimit limit{};
  if (prlimit(parent, RLIMIT_CPU, nullptr, &limit) == 0) {
    ways.emplace_back("has access to the limits of other processes");
  }
  if (writes_a_large_file(enclosure)) ways.emplace_back("writes large files");
  return ways;
}

Enclosure enclosure_of(std::uint64_t file_bytes) {
  return {std::filesystem::current_path().parent_path(), file_bytes};
}

void confine(const ChildResources& resources, std::uint64_t file_bytes) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_DUMPABLE, 0);
  limit(RLIMIT_CORE, 0, "0 for core files");
  // At the soft limit the kernel sends SIGXCPU, which names the reason. The hard limit kills.
  limit(RLIMIT_CPU, resources.seconds, "--http-scene-seconds", 1);
#ifndef PARRAY_SANITIZED  // the shadow memory of sanitizers needs a huge address space
  limit(RLIMIT_AS, resources.memory, "--http-scene-memory");
  enclose_process(enclosure_of(file_bytes));
#else
  static_cast<void>(file_bytes);
#endif
}

void keep_bytes(const std::filesystem::path& file, std::string_view bytes) {
  if (!write_file(file, bytes)) {
    throw RunError("the coordinator cannot write the temporary file " + file.filename().string() +
                   ", perhaps because the disk is full: make room on the disk of --state or, "
                   "without --state, of TMPDIR");
  }
}

std::string kept_bytes(const std::filesystem::path& file) {
  std::optional<std::string> bytes = read_file(file);
  if (!bytes) throw RunError("reading " + file.string() + " failed");
  return *std::move(bytes);
}

}  // namespace parray::scene_sandbox
