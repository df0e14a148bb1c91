#include "cli/farm/client.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <utility>
#include <variant>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "coordinator/jobs/report.h"

namespace parray::farm {
namespace {

/// Longest time between two calls of the poll function.
constexpr Time nap = milliseconds(50);

/// Calls `read`. If it throws because a message is unreadable, stores why, and the remedy.
void note_unreadable(std::string& unreadable, const auto& read) {
  const auto store = [&unreadable](const std::string& why, const char* remedy) {
    unreadable = "(" + why + "): " + remedy;
  };
  try {
    read();
  } catch (const ProtocolError& error) {
    store(error.what(), "use parray and parray-coordinator of the same release");
  } catch (const ChecksumError& error) {
    store(error.what(), "check the network and the memory of both machines");
  }
}

RunError damaged_answer(const nlohmann::json::exception& error) {
  return RunError(std::string("the coordinator's answer is damaged (") + error.what() +
                  "): use parray and parray-coordinator of the same release");
}

/// Returns a name for a job that has no number yet. It is random, so that no other job has it.
std::string random_token() {
  constexpr std::string_view digits = "0123456789abcdef";
  std::random_device device;
  std::string token;
  for (int i = 0; i < 32; ++i) token += digits[device() % digits.size()];
  return token;
}

/// Returns the name of the user of this process. Empty: the user has no name.
std::string login_name() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread asks for users
  const passwd* const entry = getpwuid(getuid());
  return entry == nullptr ? "" : std::string(entry->pw_name).substr(0, 64);
}

/// Returns the time of a transfer over a slow line (10 MB/s).
Time transfer_time(std::uint64_t bytes) {
  constexpr std::uint64_t most = std::uint64_t{1} << 40;  // in case the other side lies
  return Time(std::min(bytes, most) * 100);
}

/// Returns the exception for the coordinator's answer.
std::exception_ptr refusal_of(const msg::Error& error) {
  const std::string message = printable(error.message, 2000);
  if (error.later) return std::make_exception_ptr(NoRoom(message));
  if (error.status == 2) return std::make_exception_ptr(InputError(message));
  return std::make_exception_ptr(RunError(message));
}

}  // namespace

bool JobStatus::ended() const {
  return state == name_of(JobState::done) || state == name_of(JobState::failed) ||
         state == name_of(JobState::cancelled);
}

JobStatus job_status(const nlohmann::json& map) {
  JobStatus job;
  try {
    map.at("id").get_to(job.id);
    map.at("name").get_to(job.name);
    job.user = map.value("user", std::string());
    map.at("state").get_to(job.state);
    map.at("priority").get_to(job.priority);
    map.at("progress").get_to(job.progress);
    map.at("samples_per_second").get_to(job.samples_per_second);
    map.at("seconds_left").get_to(job.seconds_left);
    map.at("reason").get_to(job.reason);
    map.at("width").get_to(job.width);
    map.at("height").get_to(job.height);
    const nlohmann::json& limit = map.at("samples_per_pixel");
    job.samples_per_pixel = limit.is_null() ? 0 : limit.get<std::uint64_t>();
    job.samples_taken = map.value("samples_taken", 0.0);
    job.whole = map.value("whole", false);
    job.waits_for = map.value("waits_for", std::string());
    job.warning = map.value("warning", std::string());
    const auto get_if_known = [&map](const char* key, auto& target) {
      const nlohmann::json found = map.value(key, nlohmann::json());
      if (!found.is_null()) found.get_to(target);
    };
    get_if_known("queue_place", job.queue_place);
    get_if_known("starts_in", job.starts_in);
    job.flag = map.value("flag", std::string());
    map.at("sampler").get_to(job.sampler);
    job.frames = map.value("frames", std::uint64_t{0});
    job.frames_done = map.value("frames_done", std::uint64_t{0});
    job.error = error_from_json(map.value("error", nlohmann::json()));
    job.target_error = map.value("target_error", 0.0);
    job.target_half_width = map.value("target_half_width", 0.0);
    job.denoise = map.value("denoise", false);
    job.drawn = map.value("drawn", false);
  } catch (const nlohmann::json::exception& error) {
    throw damaged_answer(error);
  }
  return job;
}

std::function<int()> reading_answers(std::function<int()> work) {
  return [work = std::move(work)] {
    try {
      return work();
    } catch (const nlohmann::json::exception& error) {
      throw damaged_answer(error);
    }
  };
}

Client::Client(Link& link, const Clock& clock, Options options)
    : link_(link), clock_(clock), options_(std::move(options)) {}

msg::Submit submit_message(Submission submission) {
  msg::Submit message;
  message.scene = ScenePayload(std::move(submission.scene));
  static_cast<JobHead&>(message) = std::move(submission);
  return message;
}

/// Returns the request with a token, which makes repeating it safe, and with the user.
static msg::Submit submit_request(Submission submission) {
  msg::Submit request = submit_message(std::move(submission));
  request.token = request.series.empty() ? random_token()
                                         : request.series + "-" + std::to_string(request.frame);
  request.user = login_name();
  return request;
}

/// Notices a missing coordinator before a request that may be answered late.
void Client::find_coordinator() {
  if (!answered_) ask<msg::Workers>(msg::ListWorkers{0, 0, 1});
}

JobId Client::submit(Submission submission) {
  find_coordinator();
  msg::Submit request = submit_request(std::move(submission));
  const std::uint64_t bulk = request.scene.size();
  return ask<msg::Submitted>(std::move(request), bulk).job;
}

void Client::start_submit(Submission submission) {
  if (in_flight_.empty()) submit_silence_ = {clock_.now()};
  SentSubmission sent;
  sent.submission = submission;
  msg::Submit request = submit_request(std::move(submission));
  request.request = ++request_;
  sent.bytes = request.scene.size();
  sent.message = link_.seal(Message(std::move(request)));
  link_.send({}, sent.message);
  sent.repeat_at = clock_.now() + options_.repeat + transfer_time(sent.bytes);
  bytes_in_flight_ += sent.bytes;
  in_flight_.emplace(request_, std::move(sent));
}

std::optional<Client::Outcome> Client::take_outcome(Time most) {
  const Time end = clock_.now() + most;
  receive_outcomes();
  while (outcomes_.empty() && !in_flight_.empty() && clock_.now() < end) {
    repeat_submits(clock_.now());
    wait_a_little(end - clock_.now());
    receive_outcomes();
    note_silence(submit_silence_, options_.timeout + 10 * transfer_time(bytes_in_flight_));
  }
  if (outcomes_.empty()) return {};
  Outcome outcome = std::move(outcomes_.front());
  outcomes_.pop_front();
  return outcome;
}

void Client::repeat_submits(Time now) {
  for (auto& [number, sent] : in_flight_) {
    if (now >= sent.repeat_at) {
      link_.send({}, sent.message);
      sent.repeat_at = now + options_.repeat + transfer_time(bytes_in_flight_);
    }
  }
}

/// Handles all messages that have arrived. Ignores late answers; notes why a message is unreadable.
void Client::receive_outcomes() {
  while (auto delivery = link_.receive()) {
    note_unreadable(unreadable_, [&] { note_outcome(delivery->content.open()); });
  }
}

/// Notes the outcome if the message answers a submission in flight. Returns whether it does.
bool Client::note_outcome(const Message& message) {
  const auto* const submitted = std::get_if<msg::Submitted>(&message);
  const auto* const error = std::get_if<msg::Error>(&message);
  if (submitted == nullptr && error == nullptr) return false;
  const auto sent = in_flight_.find(submitted != nullptr ? submitted->request : error->request);
  if (sent == in_flight_.end()) return false;
  outcomes_.push_back({std::move(sent->second.submission),
                       submitted != nullptr ? submitted->job : 0,
                       error != nullptr ? refusal_of(*error) : nullptr});
  bytes_in_flight_ -= sent->second.bytes;
  in_flight_.erase(sent);
  submit_silence_ = {clock_.now()};
  return true;
}

nlohmann::json Client::show(JobId job) { return ask<msg::Job>(msg::ShowJob{0, job}).job; }

nlohmann::json Client::show_series(JobId series, std::uint32_t from_frame) {
  return ask<msg::Job>(msg::ShowJob{0, series, from_frame}).job;
}

nlohmann::json Client::steer(JobId job, msg::JobAction action, std::uint32_t priority) {
  find_coordinator();
  return ask<msg::Job>(msg::SteerJob{0, job, action, priority}).job;
}

nlohmann::json Client::steer(const std::vector<JobId>& jobs, msg::JobAction action,
                             std::uint32_t priority) {
  find_coordinator();
  return ask<msg::Steered>(msg::SteerJobs{0, jobs, action, priority}).results;
}

msg::Jobs Client::list(msg::ListJobs wanted) { return ask<msg::Jobs>(std::move(wanted)); }

nlohmann::json Client::jobs() { return list({}).jobs; }

nlohmann::json Client::workers() { return ask<msg::Workers>(msg::ListWorkers{}).workers; }

nlohmann::json Client::worker(const std::string& name) {
  return ask<msg::Worker>(msg::ShowWorker{0, name}).worker;
}

std::vector<std::string> Client::worker_log(const std::string& name) {
  return ask<msg::Log>(msg::ShowLog{0, name}).lines;
}

nlohmann::json Client::steer_workers(msg::WorkerAction action, const std::string& name, bool host) {
  find_coordinator();
  return ask<msg::Workers>(msg::SteerWorkers{0, action, host, name}).workers;
}

/// Returns the result of `decode`. Throws RunError if that throws DecodeError.
static auto decoded(const auto& decode) {
  try {
    return decode();
  } catch (const DecodeError& error) {
    throw RunError(std::string("the coordinator's answer is damaged: ") + error.what());
  }
}

static Picture picture_of(msg::ImageData answer) {
  const auto parts = decoded([&] { return answer.picture.picture(answer.width, answer.height); });
  return {parts->image, parts->statistics, std::move(answer.report)};
}

Picture Client::fetch_partial(JobId job) {
  const JobStatus status = job_status(show(job));
  return picture_of(
      ask<msg::ImageData>(msg::Fetch{0, job, true, false},
                          picture_size(status.width, status.height, PictureDetail::image)));
}

Picture Client::fetch(JobId job, PictureDetail detail) {
  const JobStatus status = job_status(show(job));
  Picture picture =
      picture_of(ask<msg::ImageData>(msg::Fetch{0, job, false, detail != PictureDetail::image,
                                                detail == PictureDetail::replicates},
                                     picture_size(status.width, status.height, detail)));
  const auto stated = picture.report.find("image_sha256");
  if (stated == picture.report.end() || *stated != image_sha256(picture.image)) {
    throw RunError("the picture of job " + std::to_string(job) +
                   " differs from the SHA-256 in its report: fetch it again");
  }
  return picture;
}

Client::JobScene Client::scene(JobId job) {
  const auto answer = ask<msg::SceneData>(msg::FetchScene{0, job});
  return {answer.settings, decoded([&] { return answer.scene.scene(); }), answer.drawing};
}

Client::JobJournal Client::journal(JobId job) {
  auto answer = ask<msg::JournalData>(msg::FetchJournal{0, job});
  return {std::move(answer.job), std::move(answer.report),
          decoded([&] { return std::string(answer.journal.verified()); })};
}

void Client::rest(Time duration) {
  const Time end = clock_.now() + duration;
  for (Time now = clock_.now(); now < end; now = clock_.now()) {
    wait_a_little(end - now);
    receive_outcomes();  // also removes late answers, which would end every wait at once
  }
}

void Client::wait_a_little(Time most) {
  options_.poll();
  link_.wait(std::clamp(most, Time(0), nap));
  options_.poll();
}

/// Reports once that the coordinator does not answer. Throws RunError if it never answered.
void Client::note_silence(Silence& silence, Time timeout) {
  // If a step took much longer than the nap, the process was stopped (Ctrl-Z, a sleeping laptop).
  const Time now = clock_.now();
  silence.waited += std::min(now - silence.last, 20 * nap);
  silence.last = now;
  if (silence.waited >= timeout && !std::exchange(silence.reported, true)) {
    if (!answered_) throw RunError(silence_text());
    options_.on_silence(silence_text());
  }
}

/// Sends the request repeatedly until its answer comes.
template <typename Answer, typename Request>
Answer Client::ask(Request request, std::uint64_t bulk_bytes) {
  request.request = ++request_;
  const Envelope message = link_.seal(Message(std::move(request)));
  const Time bulk_time = transfer_time(bulk_bytes);
  const Time repeat = options_.repeat + bulk_time;
  const Time timeout = options_.timeout + 10 * bulk_time;
  unreadable_.clear();
  Time send_at{};
  for (Silence silence{clock_.now()};;) {
    if (silence.waited >= send_at) {
      link_.send({}, message);
      send_at = silence.waited + repeat;
    }
    wait_a_little((silence.reported ? send_at : std::min(send_at, timeout)) - silence.waited);
    if (auto answer = take_answer<Answer>()) {
      answered_ = true;
      return *std::move(answer);
    }
    note_silence(silence, timeout);
  }
}

/// Throws ChecksumError if the bulk data is damaged, so that the answer counts as lost.
template <typename Answer>
static void check_bulk(const Answer& answer) {
  if constexpr (std::is_same_v<Answer, msg::ImageData>) {
    answer.picture.verify();
  } else if constexpr (std::is_same_v<Answer, msg::JournalData>) {
    (void)answer.journal.verified();
  } else if constexpr (std::is_same_v<Answer, msg::SceneData>) {
    if (answer.scene.held_bytes() != nullptr) (void)answer.scene.held_bytes()->verified();
  }
}

/// Handles messages that have arrived, until one of them is the answer to the latest request.
/// Returns nothing if there is none. Other messages are late answers, or unreadable.
template <typename Answer>
std::optional<Answer> Client::take_answer() {
  std::optional<Answer> answer;
  while (auto delivery = link_.receive()) {
    note_unreadable(unreadable_, [&] {
      Message message = delivery->content.open();
      if (note_outcome(message)) return;
      if (const auto* error = std::get_if<msg::Error>(&message);
          error != nullptr && error->request == request_) {
        std::rethrow_exception(refusal_of(*error));
      }
      if (auto* found = std::get_if<Answer>(&message);
          found != nullptr && found->request == request_) {
        check_bulk(*found);
        answer = std::move(*found);
      }
    });
    if (answer) break;
  }
  return answer;
}

std::string Client::silence_text() const {
  if (!unreadable_.empty()) {
    return "cannot read the answers of the coordinator at " + options_.address + " " + unreadable_;
  }
  return "no answer from the coordinator at " + options_.address +
         ": is parray-coordinator running there?" + (answered_ ? "" : options_.silence_hint);
}

}  // namespace parray::farm
