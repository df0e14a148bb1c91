#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "proto/messages.h"

namespace parray::proto {

/// The names of the values of an enumeration, in its order.
using Names = std::span<const std::string_view>;

/// Writes a message's fields into the map of a control frame. ControlWriter and ControlReader have
/// the same members, so that one description of a message serves both directions.
class ControlWriter {
 public:
  explicit ControlWriter(std::string_view type);

  void number(const char* key, auto& value, auto... /*range*/) { map_[key] = value; }
  /// Functions named ..._if_there() serve keys that a received message may lack: ControlReader then
  /// leaves `value` as it is. ControlWriter always writes these keys, except in real_if_there().
  void number_if_there(const char* key, auto& value, auto... /*range*/) { map_[key] = value; }
  void text_if_there(const char* key, std::string& value, std::size_t longest) {
    text(key, value, longest);
  }
  void word_if_there(const char* key, auto& value, Names names) { word(key, value, names); }
  /// Writes a list of numbers; ControlReader accepts 1 to `most` of them.
  void numbers(const char* key, std::vector<std::uint64_t>& value, std::size_t /*most*/) {
    map_[key] = value;
  }
  void flag_if_there(const char* key, bool& value) { map_[key] = value; }
  /// Writes a real number unless it is negative, which means that it is not known.
  void real_if_there(const char* key, double& value, double /*highest*/) {
    if (value >= 0) map_[key] = value;
  }
  void duration(const char* key, double& value) { map_[key] = value; }
  void flag(const char* key, bool& value) { map_[key] = value; }
  /// Writes a text. Escapes characters that are not printable, and cuts a text of more than
  /// `longest` bytes after a whole character. ControlReader refuses one below `shortest` bytes.
  void text(const char* key, std::string& value, std::size_t longest, std::size_t shortest = 0);
  /// Writes a list of texts of at most `longest` bytes each. If there are more than `most`, writes
  /// only the last `most` of them.
  void lines(const char* key, std::vector<std::string>& value, std::size_t most,
             std::size_t longest);
  void digest(const char* key, std::string& value) { map_[key] = value; }
  void version(std::uint32_t& value) { map_["v"] = value; }
  void batch(const char* key, CellBatch& value);
  void epochs(const char* key, std::vector<std::pair<std::uint64_t, std::uint64_t>>& value);
  void settings(const char* key, Boxed<RenderSettings>& value);
  void object(const char* key, nlohmann::json& value) { map_[key] = value; }
  void list(const char* key, nlohmann::json& value) { map_[key] = value; }
  /// Writes one of `names`, which has a name for each value of the enumeration.
  void word(const char* key, auto& value, Names names) {
    map_[key] = names[static_cast<std::size_t>(value)];
  }

  /// Returns the control frame.
  [[nodiscard]] std::string frame() const;

 private:
  nlohmann::json map_;
};

/// Reads and checks a message's fields. Members that read a key throw ProtocolError that names it.
class ControlReader {
 public:
  /// Checks the size first, and the nesting during parsing. Throws ProtocolError.
  explicit ControlReader(std::string_view frame);

  [[nodiscard]] const std::string& type() const { return type_; }
  /// Returns the sender's protocol version, the key `v`.
  [[nodiscard]] std::uint32_t protocol() const { return protocol_; }
  /// Returns the key `request`; nothing: it is missing or no unsigned integer.
  [[nodiscard]] std::optional<std::uint64_t> request() const;

  template <typename T>
  void number(const char* key, T& value, T lowest = 0, T highest = std::numeric_limits<T>::max()) {
    value = static_cast<T>(integer(key, lowest, highest));
  }
  void number_if_there(const char* key, auto& value, auto... range) {
    if (map_.contains(key)) number(key, value, range...);
  }
  void text_if_there(const char* key, std::string& value, std::size_t longest) const {
    if (map_.contains(key)) text(key, value, longest);
  }
  void word_if_there(const char* key, auto& value, Names names) const {
    if (map_.contains(key)) word(key, value, names);
  }
  void numbers(const char* key, std::vector<std::uint64_t>& value, std::size_t most) const;
  void flag_if_there(const char* key, bool& value) const {
    if (map_.contains(key)) flag(key, value);
  }
  /// Reads a real number from 0 to `highest`, if the key is there.
  void real_if_there(const char* key, double& value, double highest) const {
    if (map_.contains(key)) real(key, value, highest);
  }
  /// Reads seconds: 0 to 3.2e8, about ten years.
  void duration(const char* key, double& value) const { real(key, value, 3.2e8); }
  void flag(const char* key, bool& value) const;
  void text(const char* key, std::string& value, std::size_t longest,
            std::size_t shortest = 0) const;
  void lines(const char* key, std::vector<std::string>& value, std::size_t most,
             std::size_t longest) const;
  void digest(const char* key, std::string& value) const;
  void version(std::uint32_t& value) const { value = protocol_; }
  void batch(const char* key, CellBatch& value) const;
  void epochs(const char* key, std::vector<std::pair<std::uint64_t, std::uint64_t>>& value) const;
  void settings(const char* key, Boxed<RenderSettings>& value) const;
  void object(const char* key, nlohmann::json& value) const;
  void list(const char* key, nlohmann::json& value) const;
  template <typename Enum>
  void word(const char* key, Enum& value, Names names) const {
    value = static_cast<Enum>(index_of(key, names));
  }

 private:
  [[nodiscard]] const nlohmann::json& at(const char* key) const;
  [[nodiscard]] std::uint64_t integer(const char* key, std::uint64_t lowest,
                                      std::uint64_t highest) const;
  /// Reads a real number from 0 to `highest`.
  void real(const char* key, double& value, double highest) const;
  /// Returns the index in `names` of the text of `key`.
  [[nodiscard]] std::size_t index_of(const char* key, Names names) const;

  nlohmann::json map_;
  std::string type_;
  std::uint32_t protocol_ = 0;
};

}  // namespace parray::proto
