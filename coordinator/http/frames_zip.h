#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/http/exchange.h"
#include "coordinator/http/file_body.h"

namespace parray::http {

/// A zip archive (APPNOTE 6.3.10) of files, made while it is sent. The files are stored without
/// compression. Only one file is open at a time. Archives above 4 GiB use the records of Zip64.
class ZipStream final : public BodyStream {
 public:
  /// A file of the archive, below 4 GiB. The stream calls `open` when the file's turn comes. If
  /// `open` throws, or the file is larger, next() throws.
  struct Member {
    std::string name;  ///< file name in the archive
    std::function<std::shared_ptr<const FileBody>()> open;
  };

  /// `held`: a resource, such as a Places::Entry, that this object releases when it is destroyed.
  explicit ZipStream(std::vector<Member> members, std::shared_ptr<const void> held = {})
      : members_(std::move(members)), held_(std::move(held)) {}

  std::optional<std::string> next() override;

 private:
  std::string begin_member();
  std::string directory();

  std::vector<Member> members_;
  const std::shared_ptr<const void> held_;
  std::size_t begun_ = 0;                 ///< members whose header was sent
  std::shared_ptr<const FileBody> file_;  ///< the file that is being sent
  std::uint64_t sent_of_file_ = 0;
  std::uint64_t sent_ = 0;  ///< bytes of the archive
  std::string directory_;   ///< entries of the members that have begun
  bool ended_ = false;
};

}  // namespace parray::http
