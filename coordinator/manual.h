#pragma once

#include "common/rooms.h"

namespace parray::coordinator {

/// What the man page says beyond the options, in the form of common/process/manual_page.h.
inline constexpr const char* coordinator_manual =
    R"(Workers may come, go, stall and die while a job runs. With `--state`, so may the coordinator:
started again, it goes on with every row that it had acknowledged. A second one with the same
`--state` and `--wait` serves within a second when the first has ended.

# State
`--check DIR` reads a state and names each damage; `--repair DIR` builds a lost or damaged database from
the files beside it; `--backup DIR TARGET` copies a state, also one that is being served. A damaged
database is not served. Files that no record names move to `lost` below the state.

# Keys
Beyond this machine it listens to keys only, made by `parray keygen`; `--insecure` is the way round,
and says what that means.

# Standby
With `--replicate-to` and `--standby` the state is kept on two machines, which have the same
directory of keys. Nothing is acknowledged before both have it. While the standby is away jobs wait
and say so; start it again, or a new one with an empty directory, which gets a full copy. After
`--takeover-after` seconds of silence a standby that was in step serves; the old one, should it come
back, is told and ends with status 1. Workers and clients take a list of both addresses.

# Trust
- A job that workers cannot trace, or that kills them, fails by itself with the reason.
- Memory is that of the pictures being rendered; other jobs wait for their turn, and one that could
  never have it is refused with the figure. A full disk holds all jobs until there is room.
- A result is believed from the holder of the lease only. Another machine, or the referee, traces a
  share of the leases again (`--spot-checks`). Where two machines return different bits the referee
  traces the cells again: a process of the coordinator with the lowest priority. While it cannot, the
  job is held.
- A machine that differs from the referee gets no more leases, and what it traced is traced again. That
  ends after 24 hours, or for a machine with a key of its own by `parray workers readmit`.
)";

}  // namespace parray::coordinator
