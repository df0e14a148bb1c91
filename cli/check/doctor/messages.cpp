#include "cli/check/doctor/messages.h"

#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "cli/check/doctor/tracing.h"
#include "cli/child_process/child_process.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "proto/keys.h"
#include "proto/zmq_link.h"

namespace parray::doctor {
namespace {

namespace fs = std::filesystem;

constexpr const char* loopback = "tcp://127.0.0.1:*";
constexpr const char* loopback_remedy = "check whether a firewall or a sandbox blocks 127.0.0.1";
constexpr std::size_t most_bytes = 1 << 20;

/// Waits for a message of `link`, and returns it. Returns nothing if none comes before `end`.
std::optional<Delivery> next_message(Link& link, const Clock& clock, Time end) {
  for (;;) {
    if (auto delivery = link.receive()) return delivery;
    const Time left = end - clock.now();
    if (left <= Time(0)) return {};
    check_interrupted();
    link.wait(std::min(left, Time(milliseconds(50))));
  }
}

/// Returns the lines of `log` without lines of dashes and empty lines, which frame Open MPI's
/// messages.
std::string words_of(const fs::path& log) {
  std::ifstream file(log);
  std::string text;
  for (std::string line; std::getline(file, line) && text.size() < 300;) {
    if (line.find_first_not_of("- \t") != std::string::npos) {
      text += (text.empty() ? "" : " ") + line;
    }
  }
  return text.empty() ? "it printed nothing" : printable(text, 300);
}

std::vector<std::string> variables_for_root() {
  // mpirun refuses to run as root without these. Two ranks on loopback are harmless.
  if (geteuid() != 0) return {};
  return {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"};
}

CheckResult judge_report(const fs::path& file, const std::string& expected) {
  std::ifstream text(file);
  const nlohmann::json report = nlohmann::json::parse(text);
  const std::string found = report.at("image_sha256");
  const std::string transport = report.at("mpi").at("transport");
  const std::size_t ranks = report.at("mpi").at("ranks").size();
  if (found != expected) {
    return failed("two ranks make a different picture than this process: SHA-256 " +
                      found.substr(0, 16) + " instead of " + expected.substr(0, 16),
                  "install parray and parray-mpi from the same build");
  }
  if (ranks != 2) {
    return failed("mpirun -n 2 started " + counted(ranks, "rank") + " instead of 2",
                  "use the mpirun of the MPI that ParRay was built with (Debian: openmpi-bin)");
  }
  if (transport != "window") {
    return warned("the same picture from 2 ranks, but by " + transport +
                      ": windows (one-sided communication) do not work",
                  "check the variable OMPI_MCA_osc and the free space in /dev/shm");
  }
  return passed("the same picture from 2 ranks, over a window: SHA-256 " + expected.substr(0, 16));
}

}  // namespace

CheckResult check_messages(Time patience) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const Time end = begin + patience;
  ZmqServer server(loopback, most_bytes);
  const auto worker = zmq_connect(server.endpoint(), most_bytes, Time(0));
  const Frames question{std::string("a control frame"), std::string(100'000, 'b')};
  worker->send({}, question);
  const auto arrived = next_message(server.link(), clock, end);
  if (!arrived || arrived->content.frames() != question) {
    return failed("no message arrived over " + server.endpoint(), loopback_remedy);
  }
  const Frames reply{std::string("an answer")};
  server.link().send(arrived->peer, reply);
  const auto answer = next_message(*worker, clock, end);
  if (!answer || answer->content.frames() != reply) {
    return failed("no answer arrived over " + server.endpoint(), loopback_remedy);
  }
  return passed("a message and its answer over " + server.endpoint() + " took " +
                duration_text(to_seconds(clock.now() - begin)));
}

CheckResult check_keys(Time patience, const fs::path& directory, KeyTrial trial) {
  if (zmq_has("curve") == 0) {
    return failed("this ZeroMQ was built without CURVE, so it cannot encrypt",
                  "install a libzmq with libsodium (Debian: libzmq5)");
  }
  const fs::path keys = directory / "keys";
  make_farm_keys(keys);
  const MemberKey known = read_member_key(keys, "admin");
  MemberKey unknown{known.coordinator, make_key_pair()};
  if (trial == KeyTrial::accepts_anybody) {
    add_member_key(keys, Role::client, "stranger");
    unknown = read_member_key(keys, "stranger");
  } else if (trial == KeyTrial::refuses_everybody) {
    remove_member_key(keys, "admin");
  }
  ZmqServer server(loopback, most_bytes, keys);
  const auto guest = zmq_connect(server.endpoint(), most_bytes, Time(0), known);
  const auto stranger = zmq_connect(server.endpoint(), most_bytes, Time(0), unknown);
  const Frames greeting{std::string("from the guest")};
  guest->send({}, greeting);
  stranger->send({}, Frames{std::string("from the stranger")});

  const SteadyClock clock;
  bool heard = false;
  bool invaded = false;
  Time end = clock.now() + patience;
  while (const auto message = next_message(server.link(), clock, end)) {
    const bool own = message->content.frames() == greeting;
    if (own && !heard) {
      // No other message may come in this time.
      end = std::min(end, clock.now() + milliseconds(300));
    }
    heard = heard || own;
    invaded = invaded || !own;
  }
  const char* const remedy = "reinstall libzmq (Debian: libzmq5) and libsodium";
  if (invaded) return failed("the server accepts a client with an unknown key", remedy);
  if (!heard) return failed("the server refuses a client with a known key", remedy);
  return passed("CURVE: the server accepts a known key, encrypted, and refuses an unknown one");
}

CheckResult check_mpi_trial(const MpiTrial& trial) {
  if (!trial.mpirun) {
    return skipped("no mpirun in PATH", "to use parray-mpi, install openmpi-bin (Debian)");
  }
  if (!executable(trial.parray_mpi)) {
    return skipped("no parray-mpi in " + printable(trial.parray_mpi.parent_path().string(), 200),
                   "install or build parray-mpi beside parray");
  }
  const fs::path& directory = trial.directory;
  write_text_file(directory / "scene.json", std::string(doctor_scene_text));
  const ChildEnd end =
      run_child({trial.mpirun->string(), "-n", "2", "--oversubscribe", trial.parray_mpi.string(),
                 (directory / "scene.json").string(), "-o", (directory / "mpi.exr").string(),
                 "--report", (directory / "mpi.json").string(), "--quiet", "--threads", "1"},
                variables_for_root(), directory / "mpi.log", trial.limit);
  const char* const remedy = "check whether mpirun -n 2 hostname works; see man parray-mpi";
  if (end.timed_out) {
    return failed("mpirun -n 2 parray-mpi did not end within " +
                      duration_text(to_seconds(trial.limit)) + ": " +
                      words_of(directory / "mpi.log"),
                  remedy);
  }
  if (end.status != 0) {
    return failed("mpirun -n 2 parray-mpi ended with status " + std::to_string(end.status) + ": " +
                      words_of(directory / "mpi.log"),
                  remedy);
  }
  return judge_report(directory / "mpi.json", trial.image_sha256);
}

}  // namespace parray::doctor
