#include "worker/scene_exchange.h"

#include <algorithm>
#include <exception>
#include <span>

#include "common/base/bytes.h"
#include "common/scene/scene_bytes.h"

namespace parray::worker {
namespace {

/// Most chunks in flight: enough that a connection is never idle while one travels.
constexpr std::size_t most_in_flight = 16;
/// Most requests of other workers that wait for a chunk. Further ones are answered with NoScene.
constexpr std::size_t most_waiting = 1024;
/// Number of scenes with stored chunks.
constexpr std::size_t holdings_kept = 2;

constexpr Time ask_again = seconds(1);
/// A worker that is silent for this long is given up as a source.
constexpr Time patience = seconds(3);
/// A worker that answers but sends no chunk for this long is given up, too.
constexpr Time longest_stall = seconds(30);
/// Time before a chunk is requested again: this long if the source is silent, ten times as long if
/// other chunks arrive.
constexpr Time first_resend_interval = seconds(1);
constexpr Time longest_resend_interval = seconds(30);
/// Unused chunks are dropped after this time: the scene itself is in memory.
constexpr Time longest_unused = seconds(60);

std::string bytes_of(const ScenePieces& packed) {
  std::string bytes(packed.cut.bytes, '\0');
  for (std::uint32_t i = 0; i < packed.cut.count(); ++i) {
    const std::span<char> chunk = std::span(bytes).subspan(packed.cut.begin(i), packed.cut.size(i));
    const std::string_view piece = packed.pieces[i].content.data.view();
    if (packed.pieces[i].packed) {
      unpack_chunk(piece, chunk);
    } else {
      std::copy(piece.begin(), piece.end(), chunk.begin());
    }
  }
  return bytes;
}

/// Never throws.
OpenedScene open_scene(const ScenePieces& packed) {
  OpenedScene opened{packed.id, nullptr};
  bool genuine = false;
  try {
    const std::string bytes = bytes_of(packed);
    genuine = scene_identity(bytes) == packed.id;
    if (genuine) opened.scene = std::make_shared<const Scene>(scene_from_bytes(bytes));
  } catch (const DecodeError& error) {
    // Another source would not help if this program cannot read the right bytes.
    if (genuine) opened.failure = error.what();
  } catch (const std::bad_alloc&) {
    opened.failure = "not enough memory for the scene";
  } catch (const std::exception& error) {
    opened.failure = std::string("opening the scene: ") + error.what();
  }
  return opened;
}

}  // namespace

SceneOpener::SceneOpener(const std::function<void()>& wake) {
  if (wake) {
    thread_ = std::make_unique<TaskThread<ScenePieces, OpenedScene>>(
        [](const ScenePieces& packed, const std::atomic<bool>& /*stop*/) {
          return open_scene(packed);
        },
        wake);
  }
}

void SceneOpener::start(ScenePieces packed) {
  if (thread_) {
    thread_->start(std::move(packed));
  } else {
    opened_ = open_scene(packed);
  }
}

std::optional<OpenedScene> SceneOpener::take() {
  return thread_ ? thread_->take() : std::exchange(opened_, std::nullopt);
}

void SceneExchange::want(const std::string& scene) {
  if (fetch_ && (fetch_->scene == scene || fetch_->opening)) return;
  fetch_.reset();
  if (!scene.empty()) fetch_.emplace(Fetch{scene, 0, never, {}});
}

std::optional<OpenedScene> SceneExchange::take_opened() {
  if (opened_.empty()) return {};
  OpenedScene opened = std::move(opened_.front());
  opened_.pop_front();
  return opened;
}

bool SceneExchange::is_source(const PeerId& from, const std::string& scene) const {
  return fetch_ && !fetch_->opening && fetch_->scene == scene && fetch_->source == from;
}

SceneExchange::Holding* SceneExchange::holding_of(const std::string& scene) {
  const auto found =
      std::ranges::find_if(holdings_, [&](const Holding& h) { return h.content.id == scene; });
  return found == holdings_.end() ? nullptr : &*found;
}

/// Returns the stored chunks of the scene if they have this cut, otherwise an empty holding.
SceneExchange::Holding& SceneExchange::hold(Time now, const std::string& scene,
                                            const ChunkCut& cut) {
  if (Holding* known = holding_of(scene); known != nullptr && known->content.cut == cut) {
    return *known;
  }
  drop(scene);
  if (holdings_.size() >= holdings_kept) {
    drop(std::ranges::min_element(holdings_, [](const auto& a, const auto& b) {
           return a.used < b.used;
         })->content.id);
  }
  ScenePieces content{scene, cut, std::vector<ScenePiece>(cut.count())};
  return holdings_.emplace_back(Holding{std::move(content), 0, now});
}

/// Drops the chunks of a scene. The argument is a copy, because it may be the holding's own name.
void SceneExchange::drop(std::string scene) {  // NOLINT(performance-unnecessary-value-param)
  std::erase_if(holdings_, [&](const Holding& h) { return h.content.id == scene; });
}

void SceneExchange::drop_unused(Time now) {
  std::erase_if(holdings_, [&](const Holding& h) {
    return h.used + longest_unused <= now && !(fetch_ && fetch_->scene == h.content.id);
  });
}

// NOLINTNEXTLINE(readability-convert-member-functions-to-static): the lambda calls members
bool SceneExchange::receive(Time now, const PeerId& from, Message& message) {
  const auto take = [&](auto* m) {
    if (m != nullptr) on(now, from, *m);
    return m != nullptr;
  };
  return take(std::get_if<msg::SceneSource>(&message)) || take(std::get_if<msg::Chunk>(&message)) ||
         take(std::get_if<msg::ChunkLater>(&message)) ||
         take(std::get_if<msg::NoScene>(&message)) || take(std::get_if<msg::NeedChunk>(&message));
}

void SceneExchange::on(Time now, const PeerId& from, msg::SceneSource& m) {
  if (!from.empty() || !fetch_ || fetch_->opening || fetch_->source || fetch_->scene != m.scene) {
    return;
  }
  if (m.here) {
    opened_.push_back({m.scene, std::move(m.here)});
    fetch_.reset();
    return;
  }
  hold(now, m.scene, m.cut);
  fetch_->source = m.address.empty() ? PeerId() : peer_at(m.address, m.key);
  fetch_->heard = now;
  fetch_->progressed = now;
  fetch_->resend_after = first_resend_interval;
  fetch_->in_flight.clear();
  pull(now);
}

void SceneExchange::on(Time now, const PeerId& from, msg::Chunk& m) {
  Holding* const holding = is_source(from, m.scene) ? holding_of(m.scene) : nullptr;
  if (holding == nullptr || m.chunk >= holding->content.cut.count()) return;
  fetch_->heard = now;
  const std::size_t size = holding->content.cut.size(m.chunk);
  const std::size_t came = m.content.data.size();
  try {
    (void)m.content.verified();
  } catch (const ChecksumError&) {
    return;  // treated as lost
  }
  ScenePiece& piece = holding->content.pieces[m.chunk];
  if (piece.arrived() || came == 0 || (m.packed ? came >= size : came != size)) return;
  piece = {m.packed, std::move(m.content)};
  ++holding->received;
  holding->used = now;
  (from.empty() ? tally_.from_coordinator : tally_.from_workers) += came;
  fetch_->progressed = now;
  fetch_->in_flight.erase(m.chunk);
  pull(now);
  for (const Waiting& waiting : waiting_) {
    if (waiting.chunk == m.chunk && waiting.scene == m.scene) {
      pass_on(now, waiting.peer, *holding, m.chunk);
    }
  }
  std::erase_if(waiting_,
                [&](const Waiting& w) { return w.chunk == m.chunk && w.scene == m.scene; });
  open_if_complete(now);
}

void SceneExchange::on(Time now, const PeerId& from, msg::ChunkLater& m) {
  if (is_source(from, m.scene)) fetch_->heard = now;
}

void SceneExchange::on(Time now, const PeerId& from, msg::NoScene& m) {
  if (!is_source(from, m.scene)) return;
  if (!from.empty()) {
    give_source_up(now);
    return;
  }
  fetch_->source.reset();  // its job may not be prepared yet
  fetch_->ask_at = now + ask_again;
}

void SceneExchange::on(Time now, const PeerId& from, msg::NeedChunk& m) {
  Holding* const holding = holding_of(m.scene);
  if (holding != nullptr && m.chunk < holding->content.pieces.size() &&
      holding->content.pieces[m.chunk].arrived()) {
    pass_on(now, from, *holding, m.chunk);
    return;
  }
  if (!fetch_ || fetch_->scene != m.scene || waiting_.size() >= most_waiting) {
    send(from, msg::NoScene{m.scene});
    return;
  }
  if (holding != nullptr && m.chunk >= holding->content.pieces.size()) return;
  const bool known = std::ranges::any_of(waiting_, [&](const Waiting& w) {
    return w.peer == from && w.chunk == m.chunk && w.scene == m.scene;
  });
  if (!known) waiting_.push_back({from, m.scene, m.chunk});
  send(from, msg::ChunkLater{m.scene, m.chunk});
}

void SceneExchange::pass_on(Time now, const PeerId& to, Holding& holding, std::uint32_t chunk) {
  const ScenePiece& piece = holding.content.pieces[chunk];
  holding.used = now;
  tally_.handed_on += piece.content.data.size();
  send(to, msg::Chunk{holding.content.id, chunk, piece.packed, piece.content});
}

Time SceneExchange::tick(Time now) {
  note_opened(now);
  drop_unused(now);
  answer_waiting_workers();
  if (!fetch_) return holdings_.empty() ? never : now + longest_unused;
  open_if_complete(now);
  if (!fetch_ || fetch_->opening) return now + ask_again;
  check_source(now);
  if (!fetch_->source) {
    fetch_->began = std::min(fetch_->began, now);
    if (fetch_->ask_at <= now) {
      send({}, msg::NeedScene{fetch_->scene, fetch_->failed});
      fetch_->ask_at = now + ask_again;
    }
    return fetch_->ask_at;
  }
  repeat(now);
  return now + first_resend_interval / 2;
}

/// Answers the workers that wait for a scene that is no longer fetched.
void SceneExchange::answer_waiting_workers() {
  std::erase_if(waiting_, [&](const Waiting& w) {
    const bool comes = fetch_ && fetch_->scene == w.scene;
    if (!comes) send(w.peer, msg::NoScene{w.scene});
    return !comes;
  });
}

/// Gives up a silent or stalled source. The coordinator is never given up; it is asked again.
void SceneExchange::check_source(Time now) {
  if (!fetch_->source || fetch_->source->empty()) return;
  if (fetch_->heard + patience <= now || fetch_->progressed + longest_stall <= now) {
    give_source_up(now);
  }
}

void SceneExchange::give_source_up(Time now) {
  fetch_->failed = std::min(fetch_->failed + 1, msg::every_source);
  fetch_->source.reset();
  fetch_->in_flight.clear();
  fetch_->ask_at = now;
}

/// Requests chunks again that seem lost. A coordinator with many requests is slow, so each
/// repetition doubles the time until the next.
void SceneExchange::repeat(Time now) {
  const bool quiet = fetch_->heard + fetch_->resend_after <= now;
  bool repeated = false;
  for (auto& [chunk, asked] : fetch_->in_flight) {
    if (asked + 10 * fetch_->resend_after <= now ||
        (quiet && asked + fetch_->resend_after <= now)) {
      send(*fetch_->source, msg::NeedChunk{fetch_->scene, chunk});
      asked = now;
      repeated = true;
    }
  }
  if (repeated && fetch_->source->empty()) {
    fetch_->resend_after = std::min(2 * fetch_->resend_after, longest_resend_interval);
  }
  pull(now);
}

/// Keeps most_in_flight chunks in flight, in order. Other workers request chunks in the same order.
void SceneExchange::pull(Time now) {
  const Holding* const holding = holding_of(fetch_->scene);
  if (holding == nullptr) {
    give_source_up(now);  // the chunks were unused for long and dropped
    return;
  }
  const std::vector<ScenePiece>& pieces = holding->content.pieces;
  for (std::uint32_t i = 0; i < pieces.size() && fetch_->in_flight.size() < most_in_flight; ++i) {
    if (!pieces[i].arrived() && fetch_->in_flight.emplace(i, now).second) {
      send(*fetch_->source, msg::NeedChunk{fetch_->scene, i});
    }
  }
}

void SceneExchange::open_if_complete(Time now) {
  Holding* const holding = fetch_ ? holding_of(fetch_->scene) : nullptr;
  if (holding == nullptr || !holding->complete() || fetch_->opening || !opener_.idle()) return;
  holding->used = now;
  ++tally_.scenes;
  tally_.took = now - std::min(fetch_->began, now);
  fetch_->opening = true;
  opener_.start(holding->content);
}

/// Takes in an opened scene. If the content is not the requested scene, a faulty worker sent it or
/// passed it on. The coordinator is then the only source left.
void SceneExchange::note_opened(Time now) {
  auto opened = opener_.take();
  if (!opened) return;
  const bool wrong = !opened->scene && opened->failure.empty();
  if (!opened->scene) drop(opened->id);
  if (wrong) {
    fetch_ = Fetch{opened->id, msg::every_source, now, {}, now};
    return;
  }
  fetch_.reset();
  opened_.push_back(std::move(*opened));
}

}  // namespace parray::worker
