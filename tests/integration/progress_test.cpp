#include "cli/output/progress.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "cli/output/text.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

JobStatus job_at(double progress, double seconds_left = 12) {
  JobStatus job;
  job.name = "a.json";
  job.state = "running";
  job.progress = progress;
  job.samples_per_second = 3.14e6;
  job.seconds_left = seconds_left;
  return job;
}

/// Records the output of a Progress of one style.
class Recorder {
 public:
  explicit Recorder(ProgressStyle style)
      : progress_(std::make_unique<Progress>(style, out_, [this] { return columns; })) {}

  std::size_t columns = 60;

  void show(Time now, const JobStatus& job) { progress_->show(now, job); }
  std::string end() {
    progress_.reset();
    return out_.str();
  }

 private:
  std::ostringstream out_;
  std::unique_ptr<Progress> progress_;
};

}  // namespace

TEST_CASE("numbers have three digits, a prefix and a unit") {
  CHECK(with_unit(0, "B") == "0.00 B");
  CHECK(with_unit(9.994, "B") == "9.99 B");
  CHECK(with_unit(9.996, "B") == "10.0 B");
  CHECK(with_unit(999.4, "B") == "999 B");
  CHECK(with_unit(999.6, "B") == "1.00 k B");
  CHECK(with_unit(3.14159e6, "samples/s") == "3.14 M samples/s");
  CHECK(with_unit(1e21, "B") == "1000 E B");
  CHECK(with_unit(-1, "B") == "? B");
  CHECK(with_unit(std::nan(""), "B") == "? B");
  CHECK(bytes_text(1) == "1 byte");
  CHECK(bytes_text(1023) == "1023 bytes");
  CHECK(bytes_text(1536) == "1.50 KiB");
  CHECK(bytes_text(std::uint64_t{3} << 30U) == "3.00 GiB");
}

TEST_CASE("times are printed in the two largest units") {
  CHECK(mean_text(43.94) == "43.9");
  CHECK(mean_text(999.6) == "1000");
  CHECK(mean_text(1316.2) == "1316");
  CHECK(duration_text(0.25) == "0.25 s");
  CHECK(duration_text(9.96) == "10 s");
  CHECK(duration_text(59.6) == "1 min 00 s");
  CHECK(duration_text(200) == "3 min 20 s");
  CHECK(duration_text(7500) == "2 h 05 min");
  CHECK(duration_text(100 * 3600) == "4 d 4 h");
  CHECK(duration_text(-1) == "?");
  CHECK(duration_text(std::nan("")) == "?");
  CHECK(duration_text(std::numeric_limits<double>::infinity()) == "?");
}

TEST_CASE("columns of a table line up, and UTF-8 counts as characters") {
  CHECK(table_text({"A", "B"}, {{"long", "1"}, {"\xC3\xA9", "2"}}) ==
        "A     B\nlong  1\n\xC3\xA9     2\n");
  CHECK(table_text({"A", "B"}, {}) == "A  B\n");
}

TEST_CASE("a bar fits its terminal, whatever its width") {
  CHECK(bar_text(job_at(0.5), 80) ==
        "[###############               ]  50.0 %  3.14 M samples/s  12 s left");
  for (std::size_t columns = 0; columns < 100; ++columns) {
    for (const double progress : {-1.0, 0.0, 0.123, 1.0, 2.0}) {
      CHECK(bar_text(job_at(progress), columns).size() <= columns);
    }
  }
  CHECK(bar_text(job_at(0.99999), 80).find("100") == std::string::npos);
}

TEST_CASE("a finished frame shows, even if the progress counted it before") {
  Recorder recorder(ProgressStyle::lines);
  JobStatus film = job_at(1);
  film.state = "done";
  film.frames = 1;
  recorder.show(seconds(1000), film);
  film.frames_done = 1;
  recorder.show(seconds(1001), film);
  CHECK(recorder.end() ==
        "a.json: 100.0 %  0/1 frames  done\n"
        "a.json: 100.0 %  1/1 frames  done\n");
}

TEST_CASE("a log gets a line every ten seconds and the last") {
  Recorder recorder(ProgressStyle::lines);
  for (int second = 0; second <= 25; ++second) {
    recorder.show(seconds(1000 + second), job_at(second / 25.0));
  }
  JobStatus done = job_at(1);
  done.state = "done";
  recorder.show(seconds(1026), done);
  CHECK(recorder.end() ==
        "a.json:  40.0 %  3.14 M samples/s  12 s left\n"
        "a.json:  80.0 %  3.14 M samples/s  12 s left\n"
        "a.json: 100.0 %  done\n");
}

TEST_CASE("a bar is redrawn in place, covers a longer text, and ends its line") {
  Recorder recorder(ProgressStyle::bar);
  recorder.show(seconds(1), job_at(0.1, 100000));
  recorder.show(seconds(1) + milliseconds(50), job_at(0.2));  // too early to be drawn
  recorder.show(seconds(2), job_at(0.3));
  const std::string text = recorder.end();
  CHECK(std::count(text.begin(), text.end(), '\r') == 2);
  CHECK(text.find("20.0 %") == std::string::npos);
  CHECK(text.back() == '\n');
  const std::size_t second = text.rfind('\r');
  CHECK(text.size() - 1 - second >= second);  // covers the first
}

TEST_CASE("a bar in a terminal that becomes narrower remains one line") {
  Recorder recorder(ProgressStyle::bar);
  recorder.show(seconds(1), job_at(0.1));
  recorder.columns = 24;
  recorder.show(seconds(2), job_at(0.2));
  recorder.show(seconds(3), job_at(0.3));
  std::istringstream draws(recorder.end());
  std::vector<std::size_t> lengths;
  for (std::string drawn; std::getline(draws, drawn, '\r');) lengths.push_back(drawn.size());
  REQUIRE(lengths.size() == 4);  // before the first is nothing
  CHECK(lengths[1] > 24);
  CHECK(lengths[2] < 24);
  CHECK(lengths[3] <= 24);  // with the line's end
}

TEST_CASE("between two steps of progress the speed remains and the time left decreases") {
  Recorder recorder(ProgressStyle::bar);
  recorder.show(seconds(1), job_at(0.5, 12));
  JobStatus later = job_at(0.5, 20);
  later.samples_per_second = 1e6;
  recorder.show(seconds(5), later);
  recorder.show(seconds(50), later);
  const std::string text = recorder.end();
  CHECK(text.find("3.14 M samples/s  8 s left") != std::string::npos);
  CHECK(text.find("0 s left") != std::string::npos);
  CHECK(text.find("1.00 M") == std::string::npos);
}

TEST_CASE("a waiting job always says for what, and prints no unknown time") {
  Recorder recorder(ProgressStyle::bar);
  JobStatus job = job_at(0);
  job.state = "queued";
  job.waits_for = "a worker (none is connected)";
  recorder.show(seconds(1), job);
  job = job_at(0.5, 12);
  recorder.show(seconds(2), job);
  job.waits_for = "the disk is full";  // progress and state are as before
  recorder.show(seconds(3), job);
  job.waits_for.clear();
  recorder.show(seconds(4), job);
  const std::string text = recorder.end();
  CHECK(text.find("0.0 %  waits for: a worker (none is connected)") != std::string::npos);
  CHECK(text.find("50.0 %  waits for: the disk is full") != std::string::npos);
  CHECK(text.rfind("12 s left") > text.find("the disk is full"));
}

TEST_CASE("a job that is paused or being finished says so") {
  JobStatus job = job_at(0.5, 12);
  for (const char* state : {"paused", "finishing"}) {
    job.state = state;
    CHECK(bar_text(job, 80).find(std::string("50.0 %  ") + state) != std::string::npos);
  }
}

TEST_CASE("the bar of a job with a target prints the error and the target") {
  JobStatus job = job_at(0.5, 12);
  job.target_error = 0.01;
  CHECK(bar_text(job, 80).find("error") == std::string::npos);  // nothing is known yet
  job.error = {0.0205, 0.02, 0.021, 0.03, 0.0612};
  CHECK(bar_text(job, 80).find("3.14 M samples/s  error 0.021 of 0.01  12 s left") !=
        std::string::npos);
  job.target_half_width = 0.05;
  CHECK(target_text(job) == "error 0.021 of 0.01, half-width 0.0612 of 0.05");
  job.target_error = 0;
  CHECK(target_text(job) == "half-width 0.0612 of 0.05");
  job.target_half_width = 0;
  CHECK(target_text(job).empty());
}

TEST_CASE("a report's error is printed with its interval, or as not known") {
  const nlohmann::json error = {{"rmse", 0.00944}, {"low", 0.0092}, {"high", 0.00961}};
  CHECK(error_text({{"error", error}}) == "error 0.00944 (0.0092 to 0.00961)");
  const nlohmann::json none = {{"rmse", nullptr}, {"low", nullptr}, {"high", nullptr}};
  for (const nlohmann::json& report :
       {nlohmann::json{{"error", none}}, nlohmann::json{{"error", nullptr}},
        nlohmann::json{{"error", 5}}, nlohmann::json::object()}) {
    CHECK(error_text(report) == "error not known");
  }
}

TEST_CASE("--progress json prints lines of JSON, the last one at the end") {
  Recorder recorder(ProgressStyle::json);
  JobStatus job = job_at(0.25);
  job.error = {0.02, 0.019, 0.021, 0.03, 0.06};
  recorder.show(seconds(1), job);
  recorder.show(seconds(1) + milliseconds(50), job_at(0.5));  // too soon
  job.state = "failed";
  job.waits_for = "a disk \xFF";  // no UTF-8
  job.frames = 3;
  recorder.show(seconds(1) + milliseconds(60), job);
  std::istringstream lines(recorder.end());
  std::string line;
  REQUIRE(std::getline(lines, line));
  const auto first = nlohmann::json::parse(line);
  CHECK(first.at("progress") == 0.25);
  CHECK(first.at("state") == "running");
  CHECK(first.at("seconds_left") == 12);
  CHECK(first.at("error").at("high") == 0.021);
  CHECK(!first.contains("frames"));
  REQUIRE(std::getline(lines, line));
  CHECK(nlohmann::json::parse(line).at("state") == "failed");
  CHECK(nlohmann::json::parse(line).at("frames_done") == 0);
  CHECK(!std::getline(lines, line));
}

TEST_CASE("a given style applies on any terminal, and --quiet overrides it") {
  CHECK(progress_style(false, "json") == ProgressStyle::json);
  CHECK(progress_style(false, "bar") == ProgressStyle::bar);
  CHECK(progress_style(false, "lines") == ProgressStyle::lines);
  CHECK(progress_style(true, "json") == ProgressStyle::none);
}

TEST_CASE("--quiet prints nothing") {
  Recorder recorder(ProgressStyle::none);
  recorder.show(seconds(1), job_at(0.5));
  recorder.show(seconds(100), job_at(0.6));
  CHECK(recorder.end().empty());
}

}  // namespace parray
