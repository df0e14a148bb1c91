#include "coordinator/http/metrics.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "coordinator/loop/process_limits.h"

namespace parray::http {
namespace {

using nlohmann::json;

class Text {
 public:
  /// Begins a metric. Those whose name ends with _total are counters.
  void family(std::string_view name, std::string_view help, std::string_view type = "gauge") {
    if (name.ends_with("_total")) type = "counter";
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  /// `labels`: empty, or in braces. See label_value().
  void sample(std::string_view name, std::string_view labels, const json& value) {
    text_ += fmt::format("{}{} {}\n", name, labels, value.get<double>());
  }
  void single(std::string_view name, std::string_view help, const json& value) {
    family(name, help);
    sample(name, "", value);
  }
  /// Writes one sample per key of a map of numbers.
  void by(std::string_view label, std::string_view name, std::string_view help,
          const json& numbers) {
    family(name, help);
    for (const auto& [key, value] : numbers.items()) {
      sample(name, fmt::format("{{{}=\"{}\"}}", label, key), value);
    }
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

/// Returns the start time of this process in seconds since 1970. Field 22 of /proc/self/stat
/// (proc(5)) counts from the boot.
double started() {
  constexpr int fields_behind_name = 20;
  std::ifstream process("/proc/self/stat");
  process.ignore(std::numeric_limits<std::streamsize>::max(), ')');
  std::string field;
  for (int i = 0; i < fields_behind_name; ++i) process >> field;
  const double ticks = std::strtod(field.c_str(), nullptr);
  std::ifstream system("/proc/stat");
  double booted = 0;
  while (system >> field && field != "btime") {
  }
  system >> booted;
  return booted + ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0;
  double resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void add_process(Text& text) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  text.single("process_cpu_seconds_total", "Processor time of the coordinator",
              seconds(used.ru_utime) + seconds(used.ru_stime));
  text.single("process_resident_memory_bytes", "Memory of the coordinator", resident_bytes());
  text.single("process_open_fds", "Open files of the coordinator, including connections",
              static_cast<double>(descriptor_use().open));
  text.single("process_start_time_seconds", "Start time of the coordinator in seconds since 1970",
              started());
}

/// Returns the value of a label with the escapes of the format.
std::string label_value(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

void add_users(Text& text, const json& users) {
  text.family("parray_user_jobs", "Jobs by user and state; open: not ended");
  for (const json& user : users) {
    const std::string name = label_value(user.at("user").get<std::string>());
    for (const char* state : {"open", "done", "failed", "cancelled"}) {
      text.sample("parray_user_jobs", fmt::format("{{user=\"{}\",state=\"{}\"}}", name, state),
                  user.at(std::string(state) + "_jobs"));
    }
  }
  text.family("parray_user_thread_seconds_total",
              "Tracing time of accepted results by user, times the threads of their workers");
  for (const json& user : users) {
    const std::string name = label_value(user.at("user").get<std::string>());
    text.sample("parray_user_thread_seconds_total", fmt::format("{{user=\"{}\"}}", name),
                user.at("thread_seconds"));
  }
}

void add_queue(Text& text, const json& farm) {
  const json& since_start = farm.at("since_start");
  text.family("parray_queue_seconds", "Time that jobs waited in the queue for their first lease",
              "summary");
  text.sample("parray_queue_seconds_sum", "", since_start.at("queue_seconds"));
  text.sample("parray_queue_seconds_count", "", since_start.at("jobs_begun"));
  text.single(
      "parray_oldest_queued_job_seconds",
      "Longest time that a job has waited so far for its first lease since it was queued; 0: "
      "no job waits for it",
      farm.at("oldest_queued_seconds"));
  text.by("state", "parray_jobs_ended_total", "Jobs that ended, by state",
          since_start.at("jobs_ended"));
  text.single("parray_workers_lost_total",
              "Workers that did not report their end: crashed, killed, unreachable or restarted",
              since_start.at("workers_lost"));
}

void add_results(Text& text, const json& since_start) {
  json results;
  for (const char* verdict : {"accepted", "duplicate", "stale", "mismatch", "failed"}) {
    results[verdict] = since_start.at(verdict);
  }
  text.by("verdict", "parray_results_total",
          "Results of workers: accepted, equal duplicates, stale, copies with other bits, failed",
          results);
  text.single("parray_samples_total", "Samples in accepted results", since_start.at("samples"));
  text.single("parray_leases_granted_total", "Leases granted", since_start.at("granted"));
  text.single("parray_malformed_messages_total",
              "Messages that were refused because they are malformed or not permitted",
              since_start.at("malformed"));
}

}  // namespace

std::string metrics_text(const json& farm) {
  Text text;
  text.family("parray_build_info", "Always 1; the label is the version");
  text.sample("parray_build_info", "{version=\"" PARRAY_VERSION "\"}", 1);
  text.by("state", "parray_jobs", "Jobs by state", farm.at("jobs"));
  text.by("state", "parray_workers", "Connected workers by state", farm.at("workers"));
  text.single("parray_worker_threads", "Threads of workers that may get leases",
              farm.at("threads"));
  text.single("parray_leases", "Leases that workers hold", farm.at("leases"));
  text.single("parray_samples_per_second",
              "Sum of the measured speeds of the workers that hold leases",
              farm.at("samples_per_second"));
  text.single("parray_work_left_thread_seconds",
              "Estimated seconds that one thread needs for all unfinished jobs: divide by "
              "parray_worker_threads for the time left, or scale the number of workers by it",
              farm.at("thread_seconds_left"));
  add_queue(text, farm);
  add_users(text, farm.at("users"));
  add_results(text, farm.at("since_start"));
  for (const auto& [key, what] :
       {std::pair("memory", "Memory of unfinished pictures and scenes in bytes"),
        std::pair("disk", "Disk space of --state in bytes")}) {
    text.single(fmt::format("parray_{}_bytes", key), what, farm.at(key).at("used"));
    text.single(fmt::format("parray_{}_limit_bytes", key), "Limit in bytes",
                farm.at(key).at("most"));
  }
  text.single("parray_storage_blocked",
              "1 while jobs cannot be stored, because the disk is full or the standby is missing",
              farm.at("storage").get<std::string>().empty() ? 0 : 1);
  add_process(text);
  return text.take();
}

void RequestCounts::add(int status) {
  const auto place = static_cast<std::size_t>(status - least);
  if (status >= least && place < counts_.size()) ++counts_.at(place);
}

std::string RequestCounts::metrics() const {
  constexpr const char* name = "parray_http_requests_total";
  Text text;
  text.family(name, "HTTP requests that were answered, by status");
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const std::uint64_t count = counts_.at(i);
    if (count > 0) text.sample(name, fmt::format("{{status=\"{}\"}}", i + least), count);
  }
  return text.take();
}

}  // namespace parray::http
