#include "cli/mpi/mpi_options.h"

#include <array>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::mpi {
namespace {

constexpr std::array<std::string_view, 5> mode_names = {"window", "messages", "static", "openmp",
                                                        "sequential"};
constexpr const char* safety_group = "When something goes wrong";

}  // namespace

std::string_view name_of(MpiMode mode) { return mode_names[static_cast<std::size_t>(mode)]; }

void MpiOptions::add_to(Command& command) {
  add_scene(command, scene);
  render.add_to(command);
  render.add_quality_to(command);
  render.add_like_to(command);
  add_whole_number(
      command, "--threads", 1, most_threads, threads,
      "Number of threads of each rank (default: the processors of its machine, divided among the "
      "ranks there)")
      .group(work_group);
  command
      .option(
          "--mode",
          [this](const std::string& text) {
            const auto place = place_in(mode_names, text);
            if (!place) {
              throw InputError("'" + printable(text) + "' is unknown: use one of " +
                               joined(mode_names, ", "));
            }
            mode = static_cast<MpiMode>(*place);
          },
          "How ranks share the work. window: each rank takes leases from rank 0's memory; "
          "messages: each rank requests leases from rank 0; static: each rank gets 1/P of the "
          "rows, without regard to --schedule; openmp and sequential: rank 0 alone, with all its "
          "threads or with one")
      .words({mode_names.begin(), mode_names.end()})
      .group(work_group);
  add_whole_number(command, "--tile", 0, 4096, tile,
                   "Let threads trace square tiles of N x N pixels. 0: runs of pixels along a row")
      .group(work_group);
  add_whole_number(
      command, "--ledger-ranks", 1, 1U << 20, ledger_ranks,
      "Largest number of ranks that take their leases from the memory of one rank. More ranks "
      "use the memory of several ranks (default: 256)")
      .group(work_group);
  output.add_to(command, true);
  output.add_aov_to(command);
  output.add_denoise_to(command);
  output.add_labels_to(command, render);
  command
      .option("--state", state,
              "Save finished rows in DIR, and continue with the rows there. A coordinator with "
              "--state DIR can also continue (default: IMAGE.state, until the picture is written)")
      .type_name("DIR")
      .completes(Completes::directories)
      .group(safety_group);
  command
      .number("--checkpoint", checkpoint, 0.1, 86400.0,
              "Save finished rows every N seconds (default: 10)")
      .group(safety_group);
  add_whole_number(command, "--patience", 1, 86400, patience,
                   "Give up if no rank has made progress for N seconds (default: 60)")
      .group(safety_group);
  command
      .flag("--row-seconds", row_seconds, "Add the time of each row to the report, for simulations")
      .group(output_group);
  add_following(command, following);
  command.example("mpirun -n 4 parray-mpi scenes/glass.json -o glass.png",
                  "uses four ranks (as root add --allow-run-as-root; for more ranks than cores add "
                  "--oversubscribe)");
  command.example("mpirun -n 64 parray-mpi scenes/glass.json -o glass.exr --threads 4 --state rows",
                  "saves finished rows; after a crash the same command continues");
}

}  // namespace parray::mpi
