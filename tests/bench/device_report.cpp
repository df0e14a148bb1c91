#include "tests/bench/device_report.h"

#include <fstream>
#include <iomanip>
#include <set>
#include <sstream>
#include <vector>

#include "common/base/error.h"
#include "tests/bench/device_speed.h"

namespace parray::bench {
namespace {

std::string number(const Json& value, int digits = 1) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value.get<double>();
  return text.str();
}

std::string text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void add_row(std::ostream& out, const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) out << "| " << cell << " ";
  out << "|\n";
}

void begin_table(std::ostream& out, const std::vector<std::string>& heads) {
  out << "\n";
  add_row(out, heads);
  add_row(out, std::vector<std::string>(heads.size(), "---"));
}

void write_device(std::ostream& out, const Json& device) {
  out << "# Device code on " << text(device["name"]) << "\n\n"
      << "Compute capability " << text(device["compute_capability"]) << ", "
      << device["multiprocessors"] << " multiprocessors, "
      << number(device["memory_bytes"].get<double>() / 0x1p30) << " GiB of memory"
      << (device["ecc"].get<bool>() ? " with ECC" : "") << " ("
      << number(device["memory_gb_per_s"], 0) << " GB/s), "
      << number(device["l2_bytes"].get<double>() / 0x1p20) << " MiB of L2, "
      << number(device["clock_mhz"], 0) << " MHz, driver for CUDA " << text(device["driver"])
      << ".\n";
}

void write_checks(std::ostream& out, const Json& report) {
  begin_table(out, {"check", "compared", "different"});
  if (report.contains("fingerprint")) {
    const Json& print = report["fingerprint"];
    const bool equal = print["device"] == print["cpu"] &&
                       (text(print["pinned"]).empty() || print["device"] == print["pinned"]);
    add_row(out, {"fingerprint of a device", text(print["pictures"]) + " pictures",
                  equal ? "0" : "**another fingerprint**"});
  }
  if (report.contains("pictures")) {
    const Json& pictures = report["pictures"];
    add_row(out, {"pictures of " + text(pictures["scenes"]) + " scenes (" +
                      text(pictures["items_handed_back"]) + " items handed back)",
                  text(pictures["pictures"]), text(pictures["different"])});
  }
  if (report.contains("operations")) {
    for (const Json& operation : report["operations"]) {
      add_row(out, {"`" + text(operation["operation"]) + "`", text(operation["count"]),
                    text(operation["wrong"])});
    }
  }
  for (const Json& wrong : report["wrong"]) out << "\n**Wrong:** " << text(wrong) << "\n";
}

void write_best(std::ostream& out, const Json& speed) {
  out << "\n## Speed\n\nM samples/s of the device with the best limit of registers and the best "
         "size of blocks, and of one core of the CPU ("
      << text(speed["cpu"]) << ").\n";
  begin_table(out, {"spheres", "precision", "search", "device", "registers", "block", "M rays/s",
                    "one core", "device / core"});
  for (const Json& row : speed["rows"]) {
    if (!row.contains("best")) continue;
    const Json& best = row["best"];
    add_row(out, {text(row["spheres"]), text(row["precision"]), text(row["search"]),
                  number(best["million_samples_per_s"]), text(best["most_registers"]),
                  text(best["block"]), number(best["million_rays_per_s"], 0),
                  number(row["cpu_million_samples_per_s"], 2) + " (" + text(row["cpu_search"]) +
                      ", " + text(row["cpu_isa"]) + ")",
                  number(row["ratio"])});
  }
}

/// Returns the columns of the table of all cells.
std::set<std::pair<int, std::string>> columns_of(const Json& rows) {
  std::set<std::pair<int, std::string>> columns;
  for (const Json& row : rows) {
    if (!row.contains("cells")) continue;
    for (const Json& cell : row["cells"]) {
      const auto cap = text(cell["most_registers"]);
      columns.emplace(cap == "none" ? 0 : std::stoi(cap), cap);
    }
  }
  return columns;
}

/// Writes a line for each row and size of blocks. `show` makes the text of a cell.
template <typename Show>
void write_cells(std::ostream& out, const Json& rows, const Show& show) {
  const auto columns = columns_of(rows);
  std::vector<std::string> heads{"spheres", "precision", "search", "block"};
  for (const auto& [cap, name] : columns) heads.push_back(name);
  begin_table(out, heads);
  for (const Json& row : rows) {
    if (!row.contains("cells")) continue;
    std::set<int> blocks;
    for (const Json& cell : row["cells"]) blocks.insert(cell["block"].get<int>());
    for (const int block : blocks) {
      std::vector<std::string> line{text(row["spheres"]), text(row["precision"]),
                                    text(row["search"]), std::to_string(block)};
      for (const Json& cell : row["cells"]) {
        if (cell["block"] == block) line.push_back(show(cell));
      }
      add_row(out, line);
    }
  }
}

void write_launches(std::ostream& out, const Json& launches) {
  out << "\n## Launches\n\nAt " << goal_spheres << " spheres in f32, limit of registers "
      << text(launches["most_registers"]) << ", blocks of " << launches["block"]
      << " threads. An empty launch with its wait takes " << number(launches["empty_launch_us"])
      << " us. Copies of pageable memory: " << number(launches["gb_per_s_to_device"])
      << " GB/s to the device, " << number(launches["gb_per_s_from_device"]) << " GB/s from it.\n";
  begin_table(out, {"order of items", "samples of an item", "items", "M samples/s"});
  for (const Json& row : launches["divisions"]) {
    add_row(out, {text(row["order"]), text(row["samples_of_an_item"]), text(row["items"]),
                  number(row["million_samples_per_s"])});
  }
}

std::string markdown(const Json& report) {
  std::ostringstream out;
  write_device(out, report["device"]);
  write_checks(out, report);
  if (report.contains("speed")) {
    const Json& speed = report["speed"];
    write_best(out, speed);
    const std::string goal = goal_line(report);
    if (!goal.empty()) out << "\n" << goal << "\n";
    for (const Json& row : speed["left_out"]) {
      out << "\nLeft out, because the time was over: " << text(row) << "\n";
    }
    out << "\nM samples/s with each limit of registers (columns). The driver compiled the kernels "
           "in "
        << speed["compile_seconds"].dump() << " seconds.\n";
    write_cells(out, speed["rows"],
                [](const Json& cell) { return number(cell["million_samples_per_s"]); });
    out << "\nRegisters of a thread, bytes of local memory of a thread, warps of a multiprocessor "
           "at once.\n";
    write_cells(out, speed["rows"], [](const Json& cell) {
      return text(cell["registers"]) + " / " + text(cell["local_bytes"]) + " / " +
             text(cell["warps_at_once"]);
    });
  }
  if (report.contains("launches")) write_launches(out, report["launches"]);
  out << "\nTotal: " << number(report["seconds"]) << " s.\n";
  return out.str();
}

void write_file(const std::filesystem::path& path, const std::string& content) {
  std::ofstream file(path);
  file << content << std::flush;
  if (!file) throw RunError("writing " + path.string() + " failed");
}

}  // namespace

Json facts_of(const test::CudaDevice& device) {
  const test::DeviceFacts& facts = device.facts();
  return {{"name", facts.name},
          {"compute_capability",
           std::to_string(facts.capability_major) + "." + std::to_string(facts.capability_minor)},
          {"multiprocessors", facts.multiprocessors},
          {"memory_bytes", facts.memory},
          {"memory_gb_per_s", facts.memory_gb_per_s},
          {"l2_bytes", facts.l2},
          {"clock_mhz", facts.clock_mhz},
          {"ecc", facts.ecc},
          {"driver", facts.driver}};
}

Json goal_row(const Json& report) {
  if (!report.contains("speed")) return nullptr;
  for (const Json& row : report["speed"]["rows"]) {
    if (row["spheres"] == goal_spheres && row["precision"] == "f32" && row.contains("best")) {
      return row;
    }
  }
  return nullptr;
}

std::string goal_line(const Json& report) {
  const Json row = goal_row(report);
  if (row.is_null()) return "";
  const double rate = row["best"]["million_samples_per_s"].get<double>() * 1e6;
  return "Goal: " + number(goal / 1e9, 2) + " G samples/s in f32 at " +
         std::to_string(goal_spheres) + " spheres. Measured: " + number(rate / 1e9, 3) +
         " G samples/s. " + (rate >= goal ? "Reached." : "Not reached.");
}

void write_report(const Json& report, const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) {
    throw RunError("making the folder " + folder.string() + " failed: " + failed.message());
  }
  write_file(folder / "device.json", report.dump(2) + "\n");
  write_file(folder / "device.md", markdown(report));
}

}  // namespace parray::bench
