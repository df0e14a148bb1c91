#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/farm.h"
#include "cli/commands/options.h"
#include "cli/commands/rendering.h"
#include "cli/output/picture/image_file.h"

namespace parray::commands {
namespace {

struct WatchCommand {
  std::uint64_t job = 0;
  FarmOptions farm;
  ProgressOptions following;
};

int watch(const WatchCommand& command) {
  if (!command.following.preview.empty()) check_image_path(command.following.preview);
  check_display(command.following.display);
  FarmClient client(command.farm);
  wait_until_done(*client, command.job, command.following);
  return 0;
}

}  // namespace

void add_watch(CommandLine& line, Action& chosen) {
  Command command = line.command(
      "watch", "Show a job's progress; returns when it ends: 0 if it is done, 1 if not");
  const auto options = std::make_shared<WatchCommand>();
  add_job(command, options->job);
  add_following(command, options->following);
  options->farm.add_to(command);
  command.example("parray watch 7", "shows progress until the job has ended");
  command.example("parray watch 7 --quiet --preview live.png",
                  "keeps live.png updated with the unfinished picture");
  command.on_chosen([options, &chosen] { chosen = [options] { return watch(*options); }; });
}

}  // namespace parray::commands
