// How soon a coordinator answers reads and acknowledges submits while clients load it.
// tests/bench/answers starts the coordinator and runs this program beside it.
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <list>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "proto/clock.h"
#include "tests/bench/peer.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using nlohmann::json;

struct Arguments {
  std::string coordinator;
  std::string http;   ///< HOST:PORT; empty: no reads by HTTP
  std::string token;  ///< for HTTP; empty: none
  std::string keys;   ///< of a farm, directory; empty: none
  int fill = 0;
  int submits = 0;
  int handshakes = 0;
  int rounds = 3;
  double seconds = 5;
  bool distinct = false;
};

/// Median, 99 % and largest, in milliseconds.
json figures_of(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(seconds.size()));
    return seconds.empty() ? 0 : 1000 * seconds[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
  };
  return {{"count", seconds.size()}, {"median", at(0.5)}, {"p99", at(0.99)}, {"max", at(1)}};
}

/// One request over ZeroMQ at a time.
class MessageReader {
 public:
  MessageReader(const Arguments& a, Message request)
      : peer_(context_, a.coordinator, key_of(a.keys, "admin")), request_(std::move(request)) {}

  void read() {
    peer_.send(request_);
    zmq::pollitem_t item{peer_.handle(), 0, ZMQ_POLLIN, 0};
    do {
      zmq::poll(&item, 1, seconds(30));
    } while (!peer_.receive());
  }

 private:
  zmq::context_t context_;
  Peer peer_;
  Message request_;
};

/// One request over HTTP at a time, by one connection.
class HttpReader {
 public:
  HttpReader(const Arguments& a, const std::string& path)
      : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)),
        request_("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" +
                 (a.token.empty() ? "" : "Authorization: Bearer " + a.token + "\r\n") + "\r\n") {
    const std::size_t colon = a.http.rfind(':');
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoul(a.http.substr(colon + 1))));
    inet_pton(AF_INET, a.http.substr(0, colon).c_str(), &to.sin_addr);
    const int one = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      throw RunError("cannot connect to " + a.http);
    }
  }
  ~HttpReader() { close(socket_); }
  HttpReader& operator=(HttpReader&&) = delete;

  void read() {
    if (send(socket_, request_.data(), request_.size(), MSG_NOSIGNAL) < 0) {
      throw RunError("the HTTP connection was closed");
    }
    std::string answer;
    std::size_t body = std::string::npos;
    std::size_t length = 0;
    while (body == std::string::npos || answer.size() < body + length) {
      std::array<char, 65536> buffer{};
      const ssize_t got = recv(socket_, buffer.data(), buffer.size(), 0);
      if (got <= 0) throw RunError("the HTTP connection was closed");
      answer.append(buffer.data(), static_cast<std::size_t>(got));
      if (body == std::string::npos && answer.find("\r\n\r\n") != std::string::npos) {
        body = answer.find("\r\n\r\n") + 4;
        length = length_in(answer.substr(0, body));
      }
    }
  }

 private:
  static std::size_t length_in(const std::string& head) {
    constexpr std::string_view name = "Content-Length: ";
    const std::size_t found = head.find(name);
    if (!head.starts_with("HTTP/1.1 200") || found == std::string::npos) {
      throw RunError("HTTP: " + head.substr(0, head.find('\r')));
    }
    std::size_t length = 0;
    std::from_chars(head.data() + found + name.size(), head.data() + head.size(), length);
    return length;
  }

  const int socket_;
  const std::string request_;
};

/// Reads of several kinds, each kind in a thread of its own, until the end of its life. A read
/// counts if a part of it lies within a span that note_span() names.
class Readers {
 public:
  explicit Readers(const Arguments& a) {
    add("show", [&a] { return MessageReader(a, msg::ShowJob{1, 1}); });
    add("list 50", [&a] { return MessageReader(a, msg::ListJobs{1, 0, 50}); });
    add(
        "list 1000", [&a] { return MessageReader(a, msg::ListJobs{1}); }, milliseconds(100));
    add(
        "farm", [&a] { return MessageReader(a, msg::ShowFarm{1}); }, milliseconds(20));
    add("workers", [&a] { return MessageReader(a, msg::ListWorkers{1}); });
    if (!a.http.empty()) {
      for (const char* path : {"/healthz", "/readyz", "/api/v1/jobs/1", "/api/v1/jobs?limit=50"}) {
        add(path, [&a, path] { return HttpReader(a, path); });
      }
      add(
          "/metrics", [&a] { return HttpReader(a, "/metrics"); }, milliseconds(100));
    }
  }
  ~Readers() { stop_ = true; }
  Readers& operator=(Readers&&) = delete;

  void note_span(Time begin, Time end) { spans_.emplace_back(begin, end); }

  json figures() {
    stop_ = true;
    for (Kind& kind : kinds_) kind.thread.join();
    json result;
    std::vector<double> all;
    for (const Kind& kind : kinds_) {
      if (!kind.failure.empty()) throw RunError(kind.name + ": " + kind.failure);
      std::vector<double> counted;
      for (const auto& [begin, end] : kind.reads) {
        if (std::ranges::any_of(spans_, [&, from = begin, to = end](const auto& span) {
              return from < span.second && to > span.first;
            })) {
          counted.push_back(to_seconds(end - begin));
        }
      }
      all.insert(all.end(), counted.begin(), counted.end());
      result[kind.name] = figures_of(std::move(counted));
    }
    result["all reads"] = figures_of(std::move(all));
    return result;
  }

 private:
  struct Kind {
    std::string name;
    std::vector<std::pair<Time, Time>> reads{};
    std::string failure{};
    std::jthread thread{};  // last: it uses the others
  };

  template <typename Make>
  void add(const std::string& name, Make make, Time pause = milliseconds(5)) {
    Kind& kind = kinds_.emplace_back(Kind{name});
    kind.thread = std::jthread([this, &kind, make, pause] {
      try {
        auto reader = make();
        while (!stop_) {
          const Time begin = clock_.now();
          reader.read();
          kind.reads.emplace_back(begin, clock_.now());
          std::this_thread::sleep_for(pause);
        }
      } catch (const std::exception& error) {
        kind.failure = error.what();
      }
    });
  }

  const SteadyClock clock_;
  std::atomic<bool> stop_ = false;
  std::vector<std::pair<Time, Time>> spans_;
  std::list<Kind> kinds_;  // last: their threads use the others
};

/// Many clients, each with a connection of its own, in one thread that leaves the processor to the
/// readers.
class Crowd {
 public:
  explicit Crowd(const Arguments& a) : arguments_(a), key_(key_of(a.keys, "admin")) {
    context_.set(zmq::ctxopt::max_sockets, 20000);
    scene_.camera.tan_half_vfov = 0.25;
    scene_.materials = {{MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1}};
    scene_.spheres = {{{0, 0, 0}, 1, 0}};
    RenderSettings asked;
    asked.width = 60;
    asked.height = 40;
    asked.samples_per_pixel = 4;
    settings_ = resolve_settings(requirements_of(scene_), asked).settings;
  }

  /// Connects so many clients at once; each asks for one worker. Returns the seconds until each has
  /// its answer.
  std::vector<double> shake_hands(int clients) {
    std::list<Peer> peers;
    for (int i = 0; i < clients; ++i) peers.emplace_back(context_, arguments_.coordinator, key_);
    return exchange<msg::Workers>(peers, [](int) { return msg::ListWorkers{1, 0, 1}; });
  }

  /// The clients are connected before they submit a job each, all at once.
  std::vector<double> submit(int clients, const std::function<void()>& begin) {
    std::list<Peer> peers;
    for (int i = 0; i < clients; ++i) peers.emplace_back(context_, arguments_.coordinator, key_);
    exchange<msg::Workers>(peers, [](int) { return msg::ListWorkers{1, 0, 1}; });
    begin();
    return exchange<msg::Submitted>(peers, [this](int) { return next_job(); });
  }

 private:
  msg::Submit next_job() {
    msg::Submit submit;
    submit.request = 1;
    submit.token = "answers-" + std::to_string(getpid()) + "-" + std::to_string(++jobs_);
    submit.name = "answers";
    submit.settings = settings_;
    if (arguments_.distinct) scene_.spheres.front().radius = 1 + 1e-4 * jobs_;
    submit.scene = ScenePayload(std::make_shared<const Scene>(scene_));
    return submit;
  }

  /// Sends one request by each connection and waits for all answers.
  template <typename Answer, typename Make>
  std::vector<double> exchange(std::list<Peer>& peers, const Make& make) {
    std::vector<Message> requests;
    for (int i = 0; i < static_cast<int>(peers.size()); ++i) requests.push_back(make(i));
    std::vector<zmq::pollitem_t> items;
    std::vector<Peer*> waiting;
    const Time begin = clock_.now();
    for (Peer& peer : peers) {
      peer.send(requests[waiting.size()]);
      items.push_back({peer.handle(), 0, ZMQ_POLLIN, 0});
      waiting.push_back(&peer);
    }
    std::vector<double> taken;
    while (!waiting.empty()) {
      if (zmq::poll(items, seconds(30)) == 0) {
        throw RunError("a client has waited 30 s for its answer");
      }
      for (std::size_t i = waiting.size(); i-- > 0;) {
        const auto answer = items[i].revents == 0 ? std::nullopt : waiting[i]->receive();
        if (!answer) continue;
        if (const auto* error = std::get_if<msg::Error>(&*answer)) throw RunError(error->message);
        if (std::holds_alternative<Answer>(*answer)) {
          taken.push_back(to_seconds(clock_.now() - begin));
          waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(i));
          items.erase(items.begin() + static_cast<std::ptrdiff_t>(i));
        }
      }
    }
    return taken;
  }

  const Arguments& arguments_;
  const std::optional<MemberKey> key_;
  const SteadyClock clock_;
  zmq::context_t context_;
  Scene scene_;
  RenderSettings settings_;
  int jobs_ = 0;
};

void append(std::vector<double>& to, const std::vector<double>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

json measure(const Arguments& a) {
  const SteadyClock clock;
  Readers readers(a);
  // The load that follows has the lowest priority, so that it takes no time from the readers.
  setpriority(PRIO_PROCESS, 0, 19);
  std::this_thread::sleep_for(seconds(1));
  if (a.submits == 0 && a.handshakes == 0) {
    const Time begin = clock.now();
    std::this_thread::sleep_for(std::chrono::duration<double>(a.seconds));
    readers.note_span(begin, clock.now());
    return {{"reads_ms", readers.figures()}};
  }
  std::vector<double> acknowledged;
  std::vector<double> greeted;
  Crowd submitters(a);
  for (int round = 0; round < a.rounds; ++round) {
    Time begin = clock.now();
    std::jthread strangers;
    const auto shake_hands = [&] {
      begin = clock.now();
      strangers = std::jthread([&] {
        Crowd crowd(a);
        append(greeted, crowd.shake_hands(a.handshakes));
      });
    };
    if (a.submits > 0) {
      append(acknowledged, submitters.submit(a.submits, shake_hands));
    } else {
      shake_hands();
    }
    strangers.join();
    readers.note_span(begin, clock.now());
    std::this_thread::sleep_for(seconds(1));
  }
  json result = {{"reads_ms", readers.figures()}};
  if (a.submits > 0) result["submits_ms"] = figures_of(acknowledged);
  if (a.handshakes > 0) result["handshakes_ms"] = figures_of(greeted);
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  const Program program = {"bench_answers", "How soon a coordinator answers, as JSON",
                           PARRAY_VERSION};
  return run_main(program, argc, argv, [&](CommandLine& line) {
    line.option("--coordinator", a.coordinator, "Its address");
    line.option("--http", a.http, "HOST:PORT of its HTTP interface");
    line.option("--token", a.token, "Token for HTTP");
    line.option("--keys", a.keys, "Directory of the farm's keys");
    line.number("--fill", a.fill, 0, 1000000, "Submit so many jobs, and do nothing else");
    line.number("--submits", a.submits, 0, 10000, "Clients that submit a job each at once");
    line.number("--handshakes", a.handshakes, 0, 10000, "Clients that connect at once");
    line.number("--rounds", a.rounds, 1, 1000, "How often they do").show_default();
    line.number("--seconds", a.seconds, 0, 1e6, "How long to read where there is no load")
        .show_default();
    line.flag("--distinct", a.distinct, "Each submit has a scene of its own");
    return [&] {
      if (a.fill > 0) {
        Crowd crowd(a);
        constexpr int at_once = 250;
        for (int left = a.fill; left > 0; left -= at_once) {
          crowd.submit(std::min(left, at_once), [] {});
        }
        return 0;
      }
      std::printf("%s\n", measure(a).dump().c_str());
      return 0;
    };
  });
}
