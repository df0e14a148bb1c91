#include "proto/messages.h"

#include <cstring>

#include "common/base/bytes.h"
#include "common/image/picture_bytes.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "proto/control_frame.h"
#include "proto/link.h"

namespace parray::proto {
namespace {

// Each message's fields are described once for both directions: `f` is a ControlWriter or a
// ControlReader. control_fields() describes the fields that mean the same in all messages.
// PROTOCOL.md is the reference for keys and ranges.

void fields(auto& /*f*/, auto& /*m*/) {}  // messages without other fields
void fields(auto& f, msg::Hello& m) {
  f.version(m.version);
  f.text("name", m.name, max_name, 1);
  f.text("instance", m.instance, max_name, 1);
  f.number("threads", m.threads, 1U, 4096U);
  f.number("capacity", m.capacity, 1U, 16U);
  f.number("trace_version", m.trace);
  f.text("fingerprint", m.fingerprint, max_name);
  f.text("host", m.host, max_name);
  f.number("share_port", m.share_port, 0U, 65535U);
  f.text("share_key", m.share_key, max_name);
  f.text_if_there("release", m.release, max_name);
  f.number_if_there("processors", m.processors, 0U, msg::most_processors);
  f.number_if_there("memory_bytes", m.memory_bytes, std::uint64_t{0}, msg::most_memory_bytes);
}
void fields(auto& f, msg::Welcome& m) {
  f.number("heartbeat_ms", m.heartbeat_ms, 1U, 60000U);
  f.number("silence_ms", m.silence_ms, 1U, 600000U);
}
void fields(auto& f, msg::Heartbeat& m) {
  f.number("traced", m.traced);
  f.flag("preparing", m.preparing);
  f.epochs("epochs", m.epochs);
  f.real_if_there("load", m.load, 1e6);
}
void fields(auto& f, msg::Grant& m) {
  f.number("pass", m.pass);
  f.batch("cells", m.cells);
  f.settings("settings", m.settings);
  f.duration("longest", m.longest);
}
void fields(auto& f, msg::NeedScene& m) { f.number("failed", m.failed, 0U, msg::every_source); }
void fields(auto& f, msg::SceneSource& m) {
  f.number("bytes", m.cut.bytes, std::uint64_t{1}, max_scene_bytes);
  f.number("chunk_bytes", m.cut.chunk_bytes, least_chunk_bytes, most_chunk_bytes);
  f.text("address", m.address, max_name);
  f.text("key", m.key, max_name);
}
void fields(auto& f, msg::Chunk& m) { f.flag("packed", m.packed); }
void fields(auto& f, msg::Result& m) {
  f.duration("seconds", m.seconds);
  f.duration("build_seconds", m.build_seconds);
  f.number("accelerator_bytes", m.accelerator_bytes);
  f.text("isa", m.isa, max_name);
  f.number("count", m.count);
}
void fields(auto& f, msg::ResultVerdict& m) { f.word("verdict", m.verdict, verdict_names); }
void fields(auto& f, msg::Submit& m) {
  f.text("token", m.token, 64, 1);
  f.text("user", m.user, 64);
  head_fields(f, m);
}
void fields(auto& f, msg::ListJobs& m) {
  f.number_if_there("before", m.before);
  f.number_if_there("limit", m.limit, 1U, msg::most_listed);
  f.text_if_there("states", m.states, max_name);
  f.text_if_there("user", m.user, max_name);
  f.text_if_there("name", m.name, max_name);
  f.word_if_there("sort", m.sort, job_sort_names);
  f.word_if_there("order", m.order, job_order_names);
  f.number_if_there("offset", m.offset);
}
void fields(auto& f, msg::Jobs& m) {
  f.list("jobs", m.jobs);
  f.number_if_there("total", m.total);
}
void fields(auto& f, msg::ShowJob& m) {
  f.number("from_frame", m.from_frame, 0U, limits::max_frame);
}
void fields(auto& f, msg::Job& m) { f.object("job", m.job); }
void fields(auto& f, msg::SteerJob& m) {
  f.word("action", m.action, job_action_names);
  f.number("priority", m.priority, 0U, 100U);
}
void fields(auto& f, msg::SteerJobs& m) {
  f.numbers("jobs", m.jobs, msg::most_steered);
  f.word("action", m.action, job_action_names);
  f.number("priority", m.priority, 0U, 100U);
}
void fields(auto& f, msg::Steered& m) { f.list("results", m.results); }
void fields(auto& f, msg::Fetch& m) {
  f.flag("partial", m.partial);
  f.flag("statistics", m.statistics);
  f.flag("replicates", m.replicates);
}
void fields(auto& f, msg::ImageData& m) {
  f.object("report", m.report);
  f.number("width", m.width, 1U, limits::max_image_side);
  f.number("height", m.height, 1U, limits::max_image_side);
  f.flag("statistics", m.statistics);
  f.flag("replicates", m.replicates);
}
void fields(auto& f, msg::JournalData& m) {
  f.object("job", m.job);
  f.object("report", m.report);
}
void fields(auto& f, msg::SceneData& m) {
  f.settings("settings", m.settings);
  f.text_if_there("drawing", m.drawing, max_drawing);
}
void fields(auto& f, msg::ListWorkers& m) {
  f.number_if_there("offset", m.offset);
  f.number_if_there("limit", m.limit, 1U, msg::most_listed);
}
void fields(auto& f, msg::SteerWorkers& m) {
  f.word("action", m.action, worker_action_names);
  f.flag("host", m.host);
  f.text("name", m.name, max_name, 1);
}
void fields(auto& f, msg::Workers& m) {
  f.list("workers", m.workers);
  f.number("total", m.total);
}
void fields(auto& f, msg::ShowFarm& m) { f.flag_if_there("history", m.history); }
void fields(auto& f, msg::Farm& m) { f.object("farm", m.farm); }
void fields(auto& f, msg::ShowWorker& m) { f.text("name", m.name, max_name, 1); }
void fields(auto& f, msg::Worker& m) { f.object("worker", m.worker); }
void fields(auto& f, msg::ShowLog& m) { f.text("name", m.name, max_name, 1); }
void fields(auto& f, msg::Log& m) {
  f.lines("lines", m.lines, msg::most_log_lines, msg::most_log_line);
}
void fields(auto& f, msg::Error& m) {
  f.number("status", m.status, 1U, 2U);
  f.text("message", m.message, max_line);
  f.flag("later", m.later);
}

/// Type names, in the order of the variant's alternatives.
constexpr std::array<std::string_view, std::variant_size_v<Message>> type_names = {
    "hello",       "welcome",      "refuse",        "heartbeat",  "pulse",     "who",
    "grant",       "need_scene",   "scene_source",  "need_chunk", "chunk",     "chunk_later",
    "no_scene",    "result",       "failed",        "verdict",    "revoke",    "bye",
    "submit",      "submitted",    "list_jobs",     "jobs",       "show_job",  "job",
    "steer_job",   "steer_jobs",   "steered",       "fetch",      "image",     "fetch_journal",
    "journal",     "list_workers", "steer_workers", "workers",    "show_farm", "farm",
    "show_worker", "worker",       "show_log",      "log",        "error",     "fetch_scene",
    "scene"};

// The bulk frame of the messages that have one.

Bulk bulk_of(const msg::Grant& m) {
  const std::vector<SampleRange>& samples = m.cells.samples;
  return Bulk::of(std::string(reinterpret_cast<const char*>(samples.data()),
                              samples.size() * sizeof(SampleRange)));
}
Bulk bulk_of(const msg::Chunk& m) { return m.content; }
Bulk bulk_of(const msg::Result& m) { return m.cells.packed(*m.grid); }
Bulk bulk_of(const msg::Submit& m) { return m.scene.bytes(); }
Bulk bulk_of(const msg::SceneData& m) { return m.scene.bytes(); }
Bulk bulk_of(const msg::JournalData& m) { return m.journal; }
Bulk bulk_of(const msg::ImageData& m) { return m.picture.bytes(detail_of(m)); }

void set_bulk(msg::Grant& m, const Bulk& bulk) {
  static_assert(sizeof(SampleRange) == 8, "ranges are copied from the wire as they lie");
  const std::string_view data = bulk.verified();
  if (data.empty()) return;
  CellBatch& batch = m.cells;
  const std::uint64_t pixels = batch.range.count() * batch.grid->shape().cell_pixels;
  if (data.size() / sizeof(SampleRange) != pixels || data.size() % sizeof(SampleRange) != 0) {
    throw ProtocolError("sample ranges do not fit the cells");
  }
  batch.samples.resize(pixels);
  std::memcpy(batch.samples.data(), data.data(), data.size());
  auto pixel = batch.samples.begin();
  for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
    const Cell cell = batch.grid->cell(index);
    for (std::uint32_t i = 0; i < batch.grid->shape().cell_pixels; ++i, ++pixel) {
      if (pixel->begin > pixel->end ||
          (pixel->count() > 0 && (i >= cell.pixels() || pixel->begin < cell.samples.begin ||
                                  pixel->end > cell.samples.end))) {
        throw ProtocolError("sample range reaches beyond its cell");
      }
    }
  }
}
void set_bulk(msg::Chunk& m, Bulk bulk) { m.content = std::move(bulk); }
void set_bulk(msg::Result& m, Bulk bulk) { m.cells = CellsPayload(std::move(bulk)); }
void set_bulk(msg::Submit& m, Bulk bulk) { m.scene = ScenePayload(std::move(bulk)); }
void set_bulk(msg::SceneData& m, Bulk bulk) { m.scene = ScenePayload(std::move(bulk)); }
void set_bulk(msg::JournalData& m, Bulk bulk) { m.journal = std::move(bulk); }
void set_bulk(msg::ImageData& m, Bulk bulk) {
  if (bulk.data.size() != picture_size(m.width, m.height, detail_of(m))) {
    throw ProtocolError("the data do not fit the size of the picture");
  }
  m.picture = PicturePayload(std::move(bulk));
}
template <typename M>
concept HasBulk = requires(const M& message) {
  bulk_of(message);
};

/// Reads or writes all fields but the bulk frame and its checksum.
template <typename M>
void control_fields(auto& f, M& message) {
  if constexpr (requires { message.request; }) f.number("request", message.request);
  if constexpr (requires { requires std::is_integral_v<decltype(message.job)>; }) {
    f.number("job", message.job);
  }
  if constexpr (requires { message.epoch; }) f.number("epoch", message.epoch);
  if constexpr (requires { requires std::is_same_v<decltype(message.scene), std::string>; }) {
    f.digest("scene", message.scene);
  }
  if constexpr (requires { message.chunk; }) f.number("chunk", message.chunk);
  if constexpr (requires { message.reason; }) f.text("reason", message.reason, max_line);
  fields(f, message);
}

/// Checks the relations between fields of a message.
void check(const auto& /*m*/) {}
void check(const msg::Grant& m) {
  const GridShape& shape = m.cells.grid->shape();
  // In passes, samples_per_pixel bounds only the mean over all pixels.
  const std::uint32_t most =
      m.settings->in_passes() ? limits::max_samples_per_pixel : m.settings->samples_per_pixel;
  const bool beyond =
      std::ranges::any_of(shape.stages, [most](const Stage& stage) { return stage.end > most; });
  if (shape.width != m.settings->width || shape.height != m.settings->height || beyond) {
    throw ProtocolError("'cells' do not fit the picture");
  }
}

void check(const msg::SceneSource& m) {
  constexpr std::uint32_t most_chunks = 1U << 20;
  if (m.cut.count() > most_chunks) {
    throw ProtocolError("'chunk_bytes' is too small: the scene has too many chunks, more than " +
                        std::to_string(most_chunks));
  }
}

template <std::size_t I>
Message decode_as(ControlReader& reader, const Frames& frames) {
  std::variant_alternative_t<I, Message> message;
  control_fields(reader, message);
  check(message);
  constexpr bool bulk = HasBulk<decltype(message)>;
  if (frames.size() != (bulk ? 2 : 1)) {
    throw ProtocolError("wrong number of frames", reader.request());
  }
  if constexpr (bulk) {
    Bulk content{frames[1], 0};
    reader.number("bulk_xxh3", content.checksum);
    set_bulk(message, std::move(content));
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

PictureDetail msg::detail_of(const ImageData& message) {
  return message.replicates   ? PictureDetail::replicates
         : message.statistics ? PictureDetail::statistics
                              : PictureDetail::image;
}

Frames encode(const Message& message) {
  return std::visit(
      [&](auto copy) {  // by value, because fields() takes a mutable message; payloads are shared
        ControlWriter writer(type_names[message.index()]);
        control_fields(writer, copy);
        if constexpr (HasBulk<decltype(copy)>) {
          Bulk bulk = bulk_of(copy);
          writer.number("bulk_xxh3", bulk.checksum);
          return Frames{writer.frame(), std::move(bulk.data)};
        }
        return Frames{writer.frame()};
      },
      message);
}

Message decode(const Frames& frames) {
  if (frames.empty()) throw ProtocolError("message has no frames");
  ControlReader reader(frames[0].view());
  if (reader.protocol() != protocol_version) {
    if (reader.type() == "hello") {  // its other keys may differ; this one is enough to refuse it
      msg::Hello hello;
      hello.version = reader.protocol();
      return hello;
    }
    throw ProtocolError("protocol version " + std::to_string(reader.protocol()) + " instead of " +
                            std::to_string(protocol_version) +
                            ": use the same release of ParRay everywhere",
                        reader.request());
  }
  try {
    return decode_type(reader, frames, std::make_index_sequence<std::variant_size_v<Message>>{});
  } catch (const ProtocolError& error) {
    throw ProtocolError(reader.type() + ": " + error.what(), reader.request());
  } catch (const DecodeError& error) {
    throw ProtocolError(reader.type() + ": " + error.what(), reader.request());
  }
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): other links store the message
Envelope Link::seal(Message message) const { return encode(message); }

Message Envelope::open() const {
  if (const auto* frames = std::get_if<Frames>(&content_)) return decode(*frames);
  return std::get<Message>(content_);
}

Frames Envelope::frames() const {
  if (const auto* message = std::get_if<Message>(&content_)) return encode(*message);
  return std::get<Frames>(content_);
}

}  // namespace parray::proto
