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
  void family(std::string_view name, std::string_view type, std::string_view help) {
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  /// `labels`: empty, or in braces. See label_value().
  void sample(std::string_view name, std::string_view labels, double value) {
    text_ += fmt::format("{}{} {}\n", name, labels, value);
  }
  void single(std::string_view name, std::string_view type, std::string_view help, double value) {
    family(name, type, help);
    sample(name, "", value);
  }
  /// Writes one sample per key of a map of numbers.
  void by(std::string_view label, std::string_view name, std::string_view type,
          std::string_view help, const json& numbers) {
    family(name, type, help);
    for (const auto& [key, value] : numbers.items()) {
      sample(name, fmt::format("{{{}=\"{}\"}}", label, key), value.get<double>());
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
  text.single("process_cpu_seconds_total", "counter", "Processor time of the coordinator",
              seconds(used.ru_utime) + seconds(used.ru_stime));
  text.single("process_resident_memory_bytes", "gauge", "Memory of the coordinator",
              resident_bytes());
  text.single("process_open_fds", "gauge", "Open files of the coordinator, including connections",
              static_cast<double>(descriptor_use().open));
  text.single("process_start_time_seconds", "gauge",
              "Start time of the coordinator in seconds since 1970", started());
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
  text.family("parray_user_jobs", "gauge", "Jobs by user and state; open: not ended");
  for (const json& user : users) {
    const std::string name = label_value(user.at("user").get<std::string>());
    for (const char* state : {"open", "done", "failed", "cancelled"}) {
      text.sample("parray_user_jobs", fmt::format("{{user=\"{}\",state=\"{}\"}}", name, state),
                  user.at(std::string(state) + "_jobs").get<double>());
    }
  }
  text.family("parray_user_thread_seconds_total", "counter",
              "Tracing time of accepted results by user, times the threads of their workers");
  for (const json& user : users) {
    const std::string name = label_value(user.at("user").get<std::string>());
    text.sample("parray_user_thread_seconds_total", fmt::format("{{user=\"{}\"}}", name),
                user.at("thread_seconds").get<double>());
  }
}

void add_queue(Text& text, const json& farm) {
  const json& since_start = farm.at("since_start");
  text.family("parray_queue_seconds", "summary",
              "Time that jobs waited in the queue for their first lease");
  text.sample("parray_queue_seconds_sum", "", since_start.at("queue_seconds").get<double>());
  text.sample("parray_queue_seconds_count", "", since_start.at("jobs_begun").get<double>());
  text.single(
      "parray_oldest_queued_job_seconds", "gauge",
      "Longest time that a job has waited so far for its first lease since it was queued; 0: "
      "no job waits for it",
      farm.at("oldest_queued_seconds").get<double>());
  text.by("state", "parray_jobs_ended_total", "counter", "Jobs that ended, by state",
          since_start.at("jobs_ended"));
  text.single("parray_workers_lost_total", "counter",
              "Workers that did not report their end: crashed, killed, unreachable or restarted",
              since_start.at("workers_lost").get<double>());
}

void add_results(Text& text, const json& since_start) {
  json results;
  for (const char* verdict : {"accepted", "duplicate", "stale", "mismatch", "failed"}) {
    results[verdict] = since_start.at(verdict);
  }
  text.by("verdict", "parray_results_total", "counter",
          "Results of workers: accepted, equal duplicates, stale, copies with other bits, failed",
          results);
  const auto number = [&](const char* key) { return since_start.at(key).get<double>(); };
  text.single("parray_samples_total", "counter", "Samples in accepted results", number("samples"));
  text.single("parray_leases_granted_total", "counter", "Leases granted", number("granted"));
  text.single("parray_malformed_messages_total", "counter",
              "Messages that were refused because they are malformed or not permitted",
              number("malformed"));
}

}  // namespace

std::string metrics_text(const json& farm) {
  Text text;
  text.family("parray_build_info", "gauge", "Always 1; the label is the version");
  text.sample("parray_build_info", "{version=\"" PARRAY_VERSION "\"}", 1);
  text.by("state", "parray_jobs", "gauge", "Jobs by state", farm.at("jobs"));
  text.by("state", "parray_workers", "gauge", "Connected workers by state", farm.at("workers"));
  const auto number = [&](const char* key) { return farm.at(key).get<double>(); };
  text.single("parray_worker_threads", "gauge", "Threads of workers that may get leases",
              number("threads"));
  text.single("parray_leases", "gauge", "Leases that workers hold", number("leases"));
  text.single("parray_samples_per_second", "gauge",
              "Sum of the measured speeds of the workers that hold leases",
              number("samples_per_second"));
  text.single("parray_work_left_thread_seconds", "gauge",
              "Estimated seconds that one thread needs for all unfinished jobs: divide by "
              "parray_worker_threads for the time left, or scale the number of workers by it",
              number("thread_seconds_left"));
  add_queue(text, farm);
  add_users(text, farm.at("users"));
  add_results(text, farm.at("since_start"));
  for (const auto& [key, what] :
       {std::pair("memory", "Memory of unfinished pictures and scenes in bytes"),
        std::pair("disk", "Disk space of --state in bytes")}) {
    text.single(fmt::format("parray_{}_bytes", key), "gauge", what,
                farm.at(key).at("used").get<double>());
    text.single(fmt::format("parray_{}_limit_bytes", key), "gauge", "Limit in bytes",
                farm.at(key).at("most").get<double>());
  }
  text.single("parray_storage_blocked", "gauge",
              "1 while jobs cannot be stored, because the disk is full or the standby is missing",
              farm.at("storage").get<std::string>().empty() ? 0 : 1);
  add_process(text);
  return text.take();
}

}  // namespace parray::http
