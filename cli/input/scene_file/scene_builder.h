#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/scene_file/json_stream.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/material_table.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/style.h"

namespace parray::input {

/// Builds a scene from the pieces of its JSON, in whichever of the two formats they come.
///
/// The format shows in the pieces: an item {"sphere": ...} is the seed's, everything else but the
/// key "spheres" is version 1's; both in one file are an error. Every member function throws
/// InputError that names the place and the line.
class SceneBuilder final : public JsonSink {
 public:
  /// `file` names the input in messages and must outlive this.
  explicit SceneBuilder(const std::string& file) : file_(file), root_(file_) {}

  JsonDelivery on_key(const std::string& key, std::uint64_t line) override;
  void on_member(const JsonMember& member) override;
  void on_child(const JsonMember& child) override;
  std::size_t take_items(ByteSource& source) override;

  /// Once, after the last piece. `start_line` is where the document starts.
  SceneFile finish(std::uint64_t start_line);

 private:
  enum class Format : std::uint8_t { unknown, version_1, seed };

  bool has_key(std::string_view key) const;
  void add_sphere(const JsonValue& value);
  void add_seed_sphere(const JsonValue& value, const JsonPlace& place);
  void add_named_sphere(const JsonValue& value, const JsonPlace& place);
  void add_material(const JsonMember& member);
  void add_particles(const JsonValue& value);
  void finish_version_1(std::uint64_t start_line);
  void resolve_materials();
  std::uint32_t resolve_material(std::uint32_t name);

  const std::string& file_;
  JsonPlace root_;
  std::vector<std::string> keys_;  // the top-level keys so far; the last is being read
  Format format_ = Format::unknown;
  SceneFile out_;
  std::optional<Style> style_;
  FinishSection finish_;
  MaterialNames names_;  // version 1; a sphere's material is a number of these until finish()
  MaterialTable table_;
};

}  // namespace parray::input
