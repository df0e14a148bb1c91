#include "coordinator/jobs/replaying.h"

#include "common/base/bytes.h"

namespace parray::coordinator {

/// Returns what is wrong with the first entry that cannot be replayed. Empty: nothing.
static std::string replay_rows(JobPicture& picture, Store& store, JobId id) {
  std::uint64_t sound = 0;
  std::string damage;
  try {
    store.each_rows(id, [&](std::string_view entry) {
      picture.replay(entry);
      ++sound;
    });
  } catch (const StorageFull&) {
    throw;
  } catch (const RunError& error) {
    damage = error.what();
  } catch (const DecodeError& error) {
    damage = error.what();
  }
  if (!damage.empty()) {
    store.keep_rows(id, sound);
  }
  return damage;
}

TakenUp take_up(JobPicture& picture, Store* store, JobId id) {
  TakenUp taken;
  if (store != nullptr) {
    taken.damage = replay_rows(picture, *store, id);
    picture.end_replay();
  }
  const bool under_way = picture.has_begun() && !picture.collector().done();
  taken.complete = !under_way && !picture.begin_pass();
  return taken;
}

}  // namespace parray::coordinator
