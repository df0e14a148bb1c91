#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/replica/changes.h"
#include "coordinator/replica/replica_request.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/store.h"

namespace parray::replica {

/// The primary's end of the replica link: the seam behind which tests lose what is asked.
class ReplicaLine {
 public:
  virtual ~ReplicaLine() = default;

  /// Asks until there is an answer, for some seconds; nothing: there is none. Its number is the
  /// line's to choose.
  virtual std::optional<ReplicaReply> ask(ReplicaRequest ask) = 0;
  /// The standby does not know the session that was asked in last.
  [[nodiscard]] virtual bool session_lost() const = 0;
  /// Of the standby, for messages.
  [[nodiscard]] virtual const std::string& address() const = 0;
};

/// A store that a standby has a copy of: a commit sends what was put to it first, and returns when
/// both have committed. A standby that is not exactly where this store is gets a full copy, in
/// pieces.
///
/// While the standby does not answer, or has no room, commit() throws StorageFull and forgets
/// nothing; call it again. It throws RunError once the standby serves itself, or holds another
/// farm's state: nothing can be committed here any more. Call commit() every now and then even when
/// nothing was put: a standby that comes back is filled up then.
class ReplicatedStore final : public Store {
 public:
  /// `inner` and `line` outlive this. `random`: numbers that do not come again. Throws InputError
  /// when `inner` is a copy that is not whole, and what its commit() throws.
  ReplicatedStore(Store& inner, ReplicaLine& line, std::function<std::uint64_t()> random);

  void put_job(const JobRecord& job) override;
  void put_scene(const std::string& digest, std::string_view bytes) override;
  void append_rows(JobId job, std::string entry) override;
  void drop_rows(JobId job) override;
  void keep_rows(JobId job, std::uint64_t entries) override;
  void put_picture(JobId job, std::span<const std::string_view> pieces) override;
  void drop_work(JobId job) override;
  void drop_job(JobId job) override;
  void put_note(const std::string& name, const std::string& text) override;
  void put_mark(const std::string& text) override { inner_.put_mark(text); }
  void put_reached_mark(const std::string& text) override { inner_.put_reached_mark(text); }
  void commit() override;

  Usage usage() override { return inner_.usage(); }
  std::string note(const std::string& name) override { return inner_.note(name); }
  std::map<std::string, std::string> notes() override { return inner_.notes(); }
  std::string mark() override { return inner_.mark(); }
  std::string reached_mark() override { return inner_.reached_mark(); }
  std::vector<JobRecord> jobs() override { return inner_.jobs(); }
  std::optional<std::string> scene(const std::string& digest) override {
    return inner_.scene(digest);
  }
  void each_rows(JobId job, const RowsVisitor& visit) override { inner_.each_rows(job, visit); }
  std::optional<std::string> picture(JobId job) override { return inner_.picture(job); }
  std::uint64_t picture_bytes(JobId job) override { return inner_.picture_bytes(job); }
  void tidy(double keep_lost) override { inner_.tidy(keep_lost); }
  bool restore_picture(JobId job) override;

 private:
  void find_replication_state();
  void catch_up();
  void begin_session();
  void copy_everything(std::uint64_t session);
  void copy_job(const JobRecord& job, Changes& changes);
  void send_if_large(Changes& changes);
  void send_batch(std::string_view batch, bool whole);
  std::string fetch_picture(JobId job);
  ReplicaReply ask(ReplicaRequest ask);
  [[noreturn]] void fail(const std::string& what) const;

  Store& inner_;
  ReplicaLine& line_;
  std::function<std::uint64_t()> random_;
  ReplicationState replication_{};
  bool behind_ = false;        ///< the standby has committed a batch that `inner_` has not
  Position position_{};        ///< that the standby has committed
  Position marked_{};          ///< the last that was put to the inner store
  std::uint64_t session_ = 0;  ///< 0: there is none
  Changes fresh_;              ///< put since the batch under way
  std::string batch_;          ///< under way; the standby may have it
};

}  // namespace parray::replica
