// Workers that take no time: what a coordinator can take in, and how soon it answers meanwhile.
// tests/bench/coordinator runs it beside a coordinator and its jobs.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/clock.h"
#include "proto/messages.h"

namespace {

using namespace parray;

struct Arguments {
  std::string coordinator;
  int workers = 4;
  double lease_seconds = 1;
  double seconds = 600;
};

/// Results that tracing could have given: samples of random radiance, as noisy as a picture's.
class Forger {
 public:
  msg::Result result_of(const msg::Grant& grant, double seconds) {
    msg::Result result;
    result.job = grant.job;
    result.epoch = grant.epoch;
    result.seconds = seconds;
    result.isa = "none";
    const CellGrid& grid = *grant.cells.grid;
    // Packed cells stand one after the other: each kind of cell is packed once.
    std::string packed;
    for (std::uint64_t i = grant.cells.range.begin; i < grant.cells.range.end; ++i) {
      packed += cell_of(grant.cells, grid.cell(i));
    }
    result.cells = CellsParcel(Bulk::of(std::move(packed)));
    return result;
  }

 private:
  const std::string& cell_of(const CellBatch& batch, const Cell& cell) {
    std::string& packed = packed_[{cell.pixels(), cell.samples.count()}];
    if (packed.empty()) {
      GridShape shape = batch.grid->shape();
      shape.width = cell.pixels();
      shape.height = 1;
      shape.cell_pixels = cell.pixels();
      packed = pack_cells(traced(shape, cell.samples), CellGrid(shape));
    }
    return packed;
  }

  TracedCells traced(const GridShape& shape, const SampleRange& samples) {
    TracedCells traced;
    traced.range = {0, 1};
    traced.records.resize(record_bytes(shape.cell_pixels));
    const CellHeader header{std::uint64_t{samples.count()} * shape.cell_pixels, 0, 0, 0};
    std::memcpy(traced.records.data(), &header, sizeof header);
    std::uniform_real_distribution<double> radiance(0.3, 0.7);
    for (std::uint32_t x = 0; x < shape.cell_pixels; ++x) {
      PixelSums sums;
      for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
        std::array<std::uint64_t, 3> fixed{};
        for (std::uint64_t& channel : fixed) {
          channel = static_cast<std::uint64_t>(radiance(random_) * 0x1p32);
        }
        sums.add(fixed, s);
      }
      std::memcpy(traced.records.data() + sizeof header + x * sizeof sums, &sums, sizeof sums);
    }
    return traced;
  }

  std::mt19937_64 random_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> packed_;
};

class Peer {
 public:
  Peer(zmq::context_t& context, const std::string& address)
      : socket_(context, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.connect(address);
  }
  void send(const Message& message) {
    std::vector<zmq::message_t> parts;
    for (const Frame& frame : encode(message)) {
      parts.emplace_back(frame.view().data(), frame.size());
    }
    zmq::send_multipart(socket_, parts);
  }
  std::optional<Message> receive() {
    std::vector<zmq::message_t> parts;
    if (!zmq::recv_multipart(socket_, std::back_inserter(parts), zmq::recv_flags::dontwait)) {
      return {};
    }
    Frames frames;
    for (const zmq::message_t& part : parts) {
      frames.emplace_back(part.to_string());
    }
    return decode(frames);
  }
  void* handle() { return socket_.handle(); }

 private:
  zmq::socket_t socket_;
};

struct FloodWorker {
  explicit FloodWorker(Peer link) : peer(std::move(link)) {}
  Peer peer;
  std::set<std::pair<std::uint64_t, std::uint64_t>> held;  ///< job, epoch
};

/// All of it, in one thread.
class Flood {
 public:
  explicit Flood(const Arguments& a) : arguments_(a), client_(context(a), a.coordinator) {
    msg::Hello hello;
    hello.fingerprint = trace_fingerprint();
    for (int i = 0; i < a.workers; ++i) {
      hello.name = "flood-" + std::to_string(i);
      hello.instance = hello.name + "-" + std::to_string(getpid());
      workers_.emplace_back(Peer(context_, a.coordinator));
      workers_.back().peer.send(hello);
    }
  }

  /// Until no job is left that is not done.
  nlohmann::json run() {
    const Time end = clock_.now() + std::chrono::duration_cast<Time>(
                                        std::chrono::duration<double>(arguments_.seconds));
    while (clock_.now() < end && !done_) {
      serve();
      ask();
      beat();
    }
    std::sort(answers_.begin(), answers_.end());
    const auto at = [&](double share) {
      return answers_.empty()
                 ? nlohmann::json()
                 : nlohmann::json(answers_[static_cast<std::size_t>(
                                      share * static_cast<double>(answers_.size() - 1))] *
                                  1000);
    };
    return {{"done", done_},
            {"workers", workers_.size()},
            {"leases", accepted_},
            {"answers", answers_.size()},
            {"answer_ms", {{"median", at(0.5)}, {"p99", at(0.99)}, {"worst", at(1)}}}};
  }

 private:
  zmq::context_t& context(const Arguments& a) {
    context_.set(zmq::ctxopt::max_sockets, a.workers + 16);
    return context_;
  }

  void serve() {
    std::vector<zmq::pollitem_t> items;
    items.push_back({client_.handle(), 0, ZMQ_POLLIN, 0});
    for (FloodWorker& worker : workers_) {
      items.push_back({worker.peer.handle(), 0, ZMQ_POLLIN, 0});
    }
    zmq::poll(items, milliseconds(5));
    if (items[0].revents != 0) {
      take_answers();
    }
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      if (items[i + 1].revents != 0) {
        work(workers_[i]);
        if (workers_.size() > 100) {
          take_answers();
        }
      }
    }
  }

  void work(FloodWorker& worker) {
    while (const auto message = worker.peer.receive()) {
      if (const auto* grant = std::get_if<msg::Grant>(&*message)) {
        worker.held.insert({grant->job, grant->epoch});
        worker.peer.send(forger_.result_of(*grant, arguments_.lease_seconds));
      } else if (const auto* verdict = std::get_if<msg::ResultVerdict>(&*message)) {
        worker.held.erase({verdict->job, verdict->epoch});
        accepted_ += verdict->verdict == msg::Verdict::accepted ? 1 : 0;
      } else if (const auto* refusal = std::get_if<msg::Refuse>(&*message)) {
        throw RunError("refused: " + refusal->reason);
      }
    }
  }

  void ask() {
    const Time now = clock_.now();
    if (asked_at_ == never && now >= next_question_) {
      asked_at_ = now;
      client_.send(msg::ListJobs{++request_});
    }
  }

  void take_answers() {
    while (const auto message = client_.receive()) {
      const auto* jobs = std::get_if<msg::Jobs>(&*message);
      if (jobs == nullptr || jobs->request != request_) {
        continue;
      }
      const Time now = clock_.now();
      answers_.push_back(to_seconds(now - asked_at_));
      asked_at_ = never;
      next_question_ = now + milliseconds(10);
      done_ = !jobs->jobs.empty() &&
              std::all_of(jobs->jobs.begin(), jobs->jobs.end(), [](const nlohmann::json& job) {
                return job.value("state", "") == "done" || job.value("state", "") == "failed";
              });
    }
  }

  void beat() {
    const Time now = clock_.now();
    if (now < next_beat_) {
      return;
    }
    next_beat_ = now + seconds(1);
    for (FloodWorker& worker : workers_) {
      msg::Heartbeat heartbeat;
      heartbeat.epochs.assign(worker.held.begin(), worker.held.end());
      worker.peer.send(heartbeat);
    }
  }

  const Arguments& arguments_;
  const SteadyClock clock_;
  zmq::context_t context_;
  Peer client_;
  std::vector<FloodWorker> workers_;
  Forger forger_;
  std::vector<double> answers_;
  std::uint64_t accepted_ = 0;
  std::uint64_t request_ = 0;
  Time asked_at_ = never;
  Time next_question_{};
  Time next_beat_{};
  bool done_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  const Program program = {
      "bench_flood",
      "Workers that make up their results, until all jobs of a coordinator are done.",
      PARRAY_VERSION};
  return run_main(program, argc, argv, [&](CommandLine& line) {
    line.option("--coordinator", arguments.coordinator, "Its address");
    line.number("--workers", arguments.workers, 1, 1 << 16, "Workers").show_default();
    line.number("--lease-seconds", arguments.lease_seconds, 0, 3600,
                "How long each says that a lease took: long makes leases small")
        .show_default();
    line.number("--seconds", arguments.seconds, 0, 1e6, "The longest it goes on").show_default();
    return [&] {
      std::printf("%s\n", Flood(arguments).run().dump().c_str());
      return 0;
    };
  });
}
