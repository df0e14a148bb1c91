#include "proto/messages.h"

#include <array>
#include <cstring>

#include "common/base/bytes.h"
#include "common/image/picture_bytes.h"
#include "common/scene/limits.h"
#include "proto/control_frame.h"

namespace parray {
namespace {

constexpr std::size_t pixel_bytes = 9 * sizeof(std::uint64_t);
static_assert(sizeof(PixelSums) == pixel_bytes, "sums are copied to the wire as they lie");

// One description of each message's fields, for both directions: `f` is a ControlWriter or a
// ControlReader. PROTOCOL.md is the reference for keys and ranges.

template <typename F>
void fields(F& f, msg::Hello& m) {
  f.version(m.version);
  f.text("name", m.name, max_name, 1);
  f.text("instance", m.instance, max_name, 1);
  f.number("threads", m.threads, 1U, 4096U);
  f.number("capacity", m.capacity, 1U, 16U);
  f.number("trace_version", m.trace);
  f.text("fingerprint", m.fingerprint, max_name);
}
template <typename F>
void fields(F& f, msg::Welcome& m) {
  f.number("heartbeat_ms", m.heartbeat_ms, 1U, 60000U);
  f.number("silence_ms", m.silence_ms, 1U, 600000U);
}
template <typename F>
void fields(F& f, msg::Refuse& m) {
  f.text("reason", m.reason, max_line);
}
template <typename F>
void fields(F& f, msg::Heartbeat& m) {
  f.number("traced", m.traced);
  f.flag("preparing", m.preparing);
  f.epochs("epochs", m.epochs);
}
template <typename F>
void fields(F& /*f*/, msg::Pulse& /*m*/) {}
template <typename F>
void fields(F& /*f*/, msg::Who& /*m*/) {}
template <typename F>
void fields(F& f, msg::Grant& m) {
  f.number("job", m.job);
  f.number("epoch", m.epoch);
  f.rect("rect", m.rect);
  f.digest("scene", m.scene);
  f.settings("settings", m.settings);
}
template <typename F>
void fields(F& f, msg::NeedScene& m) {
  f.digest("scene", m.scene);
}
template <typename F>
void fields(F& f, msg::SceneData& m) {
  f.digest("scene", m.scene);
}
template <typename F>
void fields(F& f, msg::Result& m) {
  f.number("job", m.job);
  f.number("epoch", m.epoch);
  f.real("seconds", m.seconds);
  f.real("build_seconds", m.build_seconds);
  f.number("accelerator_bytes", m.accelerator_bytes);
  f.text("isa", m.isa, max_name);
}
template <typename F>
void fields(F& f, msg::VerdictOf& m) {
  f.number("job", m.job);
  f.number("epoch", m.epoch);
  f.verdict("verdict", m.verdict);
}
template <typename F>
void fields(F& f, msg::Revoke& m) {
  f.number("job", m.job);
  f.number("epoch", m.epoch);
}
template <typename F>
void fields(F& f, msg::Bye& m) {
  f.text("reason", m.reason, max_line);
}
template <typename F>
void fields(F& f, msg::Submit& m) {
  f.number("request", m.request);
  f.text("token", m.token, 64, 1);
  f.text("name", m.name, max_name, 1);
  f.number("priority", m.priority, 0U, 100U);
  f.settings("settings", m.settings);
  f.text("precision_reason", m.precision_reason, max_line);
  f.number("duplicates_removed", m.duplicates_removed);
  f.real("load_seconds", m.load_seconds);
}
template <typename F>
void fields(F& f, msg::Submitted& m) {
  f.number("request", m.request);
  f.number("job", m.job);
}
template <typename F>
void fields(F& f, msg::ListJobs& m) {
  f.number("request", m.request);
}
template <typename F>
void fields(F& f, msg::Jobs& m) {
  f.number("request", m.request);
  f.list("jobs", m.jobs);
}
template <typename F>
void fields(F& f, msg::ShowJob& m) {
  f.number("request", m.request);
  f.number("job", m.job);
}
template <typename F>
void fields(F& f, msg::Job& m) {
  f.number("request", m.request);
  f.object("job", m.job);
}
template <typename F>
void fields(F& f, msg::Cancel& m) {
  f.number("request", m.request);
  f.number("job", m.job);
}
template <typename F>
void fields(F& f, msg::Fetch& m) {
  f.number("request", m.request);
  f.number("job", m.job);
  f.flag("partial", m.partial);
  f.flag("statistics", m.statistics);
}
template <typename F>
void fields(F& f, msg::ImageData& m) {
  f.number("request", m.request);
  f.object("report", m.report);
  f.number("width", m.width, 1U, limits::max_image_side);
  f.number("height", m.height, 1U, limits::max_image_side);
  f.flag("statistics", m.statistics);
}
template <typename F>
void fields(F& f, msg::ListWorkers& m) {
  f.number("request", m.request);
}
template <typename F>
void fields(F& f, msg::Workers& m) {
  f.number("request", m.request);
  f.list("workers", m.workers);
}
template <typename F>
void fields(F& f, msg::Error& m) {
  f.number("request", m.request);
  f.number("status", m.status, 1U, 2U);
  f.text("message", m.message, max_line);
}

/// Type names, in the order of the variant's alternatives.
constexpr std::array<std::string_view, std::variant_size_v<Message>> type_names = {
    "hello",      "welcome",      "refuse",  "heartbeat", "pulse",  "who",    "grant",
    "need_scene", "scene",        "result",  "verdict",   "revoke", "bye",    "submit",
    "submitted",  "list_jobs",    "jobs",    "show_job",  "job",    "cancel", "fetch",
    "image",      "list_workers", "workers", "error"};

// The bulk frame of the messages that have one.

template <typename M>
constexpr bool has_bulk = std::is_same_v<M, msg::Grant> || std::is_same_v<M, msg::SceneData> ||
                          std::is_same_v<M, msg::Result> || std::is_same_v<M, msg::Submit> ||
                          std::is_same_v<M, msg::ImageData>;

std::string bulk_of(const msg::Grant& m) {
  return seal_bulk(
      {reinterpret_cast<const char*>(m.samples.data()), m.samples.size() * sizeof(SampleRange)});
}
std::string bulk_of(const msg::SceneData& m) { return seal_bulk(m.bytes); }
std::string bulk_of(const msg::Result& m) { return seal_bulk(row_block_to_bytes(m.block)); }
std::string bulk_of(const msg::Submit& m) { return seal_bulk(m.scene_bytes); }
std::string bulk_of(const msg::ImageData& m) { return seal_bulk(m.pixels); }

void set_bulk(msg::Grant& m, std::string_view data) {
  if (data.empty()) {
    return;
  }
  static_assert(sizeof(SampleRange) == 8, "ranges are copied from the wire as they lie");
  if (data.size() != std::uint64_t{m.rect.rows()} * m.settings.width * sizeof(SampleRange)) {
    throw ProtocolError("sample ranges do not fit the rectangle");
  }
  m.samples.resize(data.size() / sizeof(SampleRange));
  std::memcpy(m.samples.data(), data.data(), data.size());
  for (const SampleRange& range : m.samples) {
    if (range.begin > range.end || (range.count() > 0 && (range.begin < m.rect.sample_begin ||
                                                          range.end > m.rect.sample_end))) {
      throw ProtocolError("sample range reaches beyond the rectangle");
    }
  }
}
void set_bulk(msg::SceneData& m, std::string_view data) { m.bytes = data; }
void set_bulk(msg::Result& m, std::string_view data) {
  try {
    m.block = row_block_from_bytes(data);
  } catch (const DecodeError& error) {
    throw ProtocolError(error.what());
  }
}
void set_bulk(msg::Submit& m, std::string_view data) { m.scene_bytes = data; }
void set_bulk(msg::ImageData& m, std::string_view data) {
  if (data.size() != picture_size(m.width, m.height, m.statistics)) {
    throw ProtocolError("image data do not fit the image");
  }
  m.pixels = data;
}

/// What several fields of a message have to agree on.
template <typename M>
void check(const M& /*m*/) {}
void check(const msg::Grant& m) {
  // In passes, samples_per_pixel bounds the mean alone.
  const std::uint32_t most =
      m.settings.in_passes() ? limits::max_samples_per_pixel : m.settings.samples_per_pixel;
  if (m.rect.row_end > m.settings.height || m.rect.sample_end > most) {
    throw ProtocolError("'rect' reaches beyond the picture");
  }
}

template <std::size_t I>
Message decode_as(ControlReader& reader, const Frames& frames) {
  std::variant_alternative_t<I, Message> message;
  fields(reader, message);
  check(message);
  constexpr bool bulk = has_bulk<decltype(message)>;
  if (frames.size() != (bulk ? 2 : 1)) {
    throw ProtocolError("wrong number of frames", reader.request());
  }
  if constexpr (bulk) {
    set_bulk(message, open_bulk(frames[1]));
  }
  return message;
}

template <std::size_t... I>
Message decode_type(ControlReader& reader, const Frames& frames,
                    std::index_sequence<I...> /*all*/) {
  std::optional<Message> result;
  (void)((reader.type() == type_names[I] ? (result = decode_as<I>(reader, frames), true) : false) ||
         ...);
  if (!result) {
    throw ProtocolError("unknown message type '" + reader.type() + "'", reader.request());
  }
  return std::move(*result);
}

}  // namespace

Frames encode(const Message& message) {
  return std::visit(
      [&](auto copy) {  // by value: a description binds to mutable fields
        ControlWriter writer(type_names[message.index()]);
        fields(writer, copy);
        Frames frames{writer.frame()};
        if constexpr (has_bulk<decltype(copy)>) {
          frames.push_back(bulk_of(copy));
        }
        return frames;
      },
      message);
}

Message decode(const Frames& frames) {
  if (frames.empty()) {
    throw ProtocolError("message has no frames");
  }
  ControlReader reader(frames[0]);
  if (reader.protocol() != protocol_version) {
    if (reader.type() == "hello") {  // its other keys may differ; this one is enough to refuse it
      msg::Hello hello;
      hello.version = reader.protocol();
      return hello;
    }
    throw ProtocolError("protocol version " + std::to_string(reader.protocol()) + ", not " +
                            std::to_string(protocol_version),
                        reader.request());
  }
  try {
    return decode_type(reader, frames, std::make_index_sequence<std::variant_size_v<Message>>{});
  } catch (const ProtocolError& error) {
    throw ProtocolError(reader.type() + ": " + error.what(), reader.request());
  }
}

std::string row_block_to_bytes(const RowBlock& block) {
  ByteWriter out;
  out.reserve(52 + block.pixels.size() * pixel_bytes);
  out.put(block.rect.row_begin);
  out.put(block.rect.row_end);
  out.put(block.rect.sample_begin);
  out.put(block.rect.sample_end);
  out.put(block.width);
  out.put(block.counts.samples);
  out.put(block.counts.rays);
  out.put(block.counts.nonfinite);
  out.put(block.counts.lost);
  out.put_bytes(
      {reinterpret_cast<const char*>(block.pixels.data()), block.pixels.size() * pixel_bytes});
  for (const ExcludedSamples& some : block.excluded) {
    out.put(some.position);
    out.put(some.x);
    out.put(some.first);
    out.put(some.count);
  }
  return out.take();
}

namespace {

/// What is left of a row block's bytes. They account for every sample that is missing.
std::vector<ExcludedSamples> excluded_from_bytes(ByteReader& in, const RowBlock& block) {
  std::vector<ExcludedSamples> excluded;
  std::uint64_t missing = 0;
  while (in.left() > 0) {
    ExcludedSamples some;
    some.position = in.get<std::uint32_t>();
    some.x = in.get<std::uint32_t>();
    some.first = in.get<std::uint32_t>();
    some.count = in.get<std::uint32_t>();
    const WorkRect& rect = block.rect;
    if (some.position < rect.row_begin || some.position >= rect.row_end || some.x >= block.width ||
        some.first < rect.sample_begin || some.first >= rect.sample_end || some.count == 0 ||
        some.count > rect.sample_end - some.first) {
      throw DecodeError("row block lacks samples that it never had");
    }
    missing += some.count;
    excluded.push_back(some);
  }
  if (missing != block.counts.nonfinite) {
    throw DecodeError("row block does not say which samples were not finite");
  }
  return excluded;
}

}  // namespace

RowBlock row_block_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  RowBlock block;
  block.rect.row_begin = in.get<std::uint32_t>();
  block.rect.row_end = in.get<std::uint32_t>();
  block.rect.sample_begin = in.get<std::uint32_t>();
  block.rect.sample_end = in.get<std::uint32_t>();
  block.width = in.get<std::uint32_t>();
  block.counts.samples = in.get<std::uint64_t>();
  block.counts.rays = in.get<std::uint64_t>();
  block.counts.nonfinite = in.get<std::uint64_t>();
  block.counts.lost = in.get<std::uint64_t>();
  if (block.rect.row_begin > block.rect.row_end ||
      block.rect.sample_begin > block.rect.sample_end) {
    throw DecodeError("row block has a negative size");
  }
  const std::uint64_t pixels = std::uint64_t{block.rect.rows()} * block.width;
  if (pixels > in.left() / pixel_bytes) {
    throw DecodeError("row block does not hold its pixels");
  }
  if (block.counts.samples > pixels * block.rect.samples() ||
      block.counts.nonfinite > block.counts.samples) {
    throw DecodeError("row block has false counts");
  }
  block.pixels.resize(pixels);
  if (pixels > 0) {  // memcpy may not be given null, not even for nothing
    const std::size_t size = pixels * pixel_bytes;
    std::memcpy(block.pixels.data(), in.get_bytes(size).data(), size);
  }
  block.excluded = excluded_from_bytes(in, block);
  return block;
}

std::string_view name_of(msg::Verdict verdict) {
  constexpr std::array<std::string_view, 4> names = {"accepted", "duplicate", "stale", "mismatch"};
  return names[static_cast<std::size_t>(verdict)];
}

}  // namespace parray
