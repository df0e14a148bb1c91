#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "coordinator/http/api.h"
#include "coordinator/http/frames_zip.h"

/// Handlers for scripts that fetch many pictures.
namespace parray::http {
namespace {

using nlohmann::json;

/// Returns the jobs of the done frames of a series, by the numbers of the frames. Throws Problem
/// 404 if there is no such job, 409 if it is no series.
std::map<std::uint32_t, JobId> done_frames(LoopClient& loop, const Sender& sender, JobId series) {
  std::map<std::uint32_t, JobId> done;
  for (std::uint32_t from = 0;;) {
    const json shown = with_status(409, 404, [&] {
      return loop.ask<msg::Job>(sender, msg::ShowJob{0, series, from}).job;
    });
    if (!shown.contains("frame_list")) {
      throw Problem(409, fmt::format("job {} is not a series: its picture is image.png", series));
    }
    const json& frames = shown.at("frame_list");
    for (const json& frame : frames) {
      if (frame.at("state") == "done") done.emplace(frame.at("frame"), frame.at("job"));
    }
    if (frames.empty()) return done;
    from = frames.back().at("frame").get<std::uint32_t>() + 1;
  }
}

Reply frames_zip(Api& api, const Request& request) {
  const JobId series = job_in(request);
  const auto held = std::make_shared<const Places::Entry>(api.archives, owner_of(request));
  const auto frames = done_frames(api.loop, request.sender, series);
  if (frames.empty()) {
    throw Problem(
        409,
        fmt::format("no frame of series {} is done: /api/v1/jobs/{} lists the states of its frames",
                    series, series));
  }
  std::vector<ZipStream::Member> members;
  members.reserve(frames.size());
  for (const auto& [frame, frame_job] : frames) {
    members.push_back({fmt::format("frame-{:04}.png", frame),
                       [&api, job = frame_job, sender = request.sender, owner = owner_of(request)] {
                         return api.pictures.get(sender, owner, job, PictureCache::Kind::png).file;
                       }});
  }
  Reply reply{.type = "application/zip",
              .headers = {{"Content-Disposition",
                           fmt::format("attachment; filename=\"frames-{}.zip\"", series)}}};
  if (request.method != "HEAD") {
    reply.stream = std::make_shared<ZipStream>(std::move(members), held);
  }
  return reply;
}

}  // namespace

void add_frames_zip(Api& api) { api.add("GET", "/api/v1/jobs/{id}/frames.zip", frames_zip); }

}  // namespace parray::http
