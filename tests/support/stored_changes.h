#pragma once

#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"

namespace parray::test {

/// An unfinished and a finished job, committed.
inline void put_first(Store& store) {
  store.put_scene(digest('a'), "scene a");
  store.put_job(stored_job(1));
  store.append_rows(1, "row 1");
  store.append_rows(1, "row 2");
  store.put_job(stored_job(2, JobState::done, 'b'));
  put_picture(store, 2, "picture 2");
  store.commit();
}

/// Changes of every kind, to be committed together.
inline void put_second(Store& store) {
  store.append_rows(1, "row 3");
  store.put_job(stored_job(1, JobState::running));
  store.put_scene(digest('c'), "scene c");
  store.put_job(stored_job(3, JobState::queued, 'c'));
  store.append_rows(3, "row of 3");
  put_picture(store, 2, "picture 2, again");
}

}  // namespace parray::test
