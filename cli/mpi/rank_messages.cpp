#include "cli/mpi/rank_messages.h"

#include <algorithm>
#include <array>
#include <bit>

#include "common/base/error.h"
#include "common/image/cell_records.h"
#include "proto/mpi_window.h"

namespace parray::mpi {
namespace {

enum Tag : int { take_tag = 1, answer_tag, result_tag, records_tag, word_tag };

using TakeMessage = std::array<std::uint64_t, 2>;    // speed's bits, idle
using AnswerMessage = std::array<std::uint64_t, 4>;  // answer, range, fresh
using ResultMessage = std::array<std::uint64_t, 3>;  // range, digest
using WordMessage = std::array<std::uint64_t, 2>;    // word, value

constexpr std::size_t most_bytes = std::size_t{1} << 30;

template <typename Array>
void send(const Array& message, int rank, Tag tag, MPI_Comm comm) {
  check_mpi(
      MPI_Send(message.data(), static_cast<int>(message.size()), MPI_UINT64_T, rank, tag, comm),
      "sending a message");
}

template <typename Array>
Array receive(int rank, Tag tag, MPI_Comm comm) {
  Array message{};
  check_mpi(MPI_Recv(message.data(), static_cast<int>(message.size()), MPI_UINT64_T, rank, tag,
                     comm, MPI_STATUS_IGNORE),
            "receiving a message");
  return message;
}

}  // namespace

RankSource::Part RankMessages::take_part(double samples_per_second, bool idle) {
  send(TakeMessage{std::bit_cast<std::uint64_t>(samples_per_second), idle ? 1ULL : 0ULL}, 0,
       take_tag, comm_);
  const auto answer = receive<AnswerMessage>(0, answer_tag, comm_);
  return {static_cast<Answer>(answer[0]), {answer[1], answer[2]}, answer[3] != 0};
}

void RankMessages::put(const CellRange& cells, std::span<const std::byte> records) {
  const auto digests = cell_digests(records, records.size() / cells.count());
  send(ResultMessage{cells.begin, cells.end, range_digest(digests)}, 0, result_tag, comm_);
  for (std::size_t done = 0; done < records.size(); done += most_bytes) {
    const int count = static_cast<int>(std::min(records.size() - done, most_bytes));
    check_mpi(MPI_Send(records.data() + done, count, MPI_BYTE, 0, records_tag, comm_),
              "sending rows");
  }
}

void RankMessages::publish(WindowLayout::RankWord word, std::uint64_t value) {
  send(WordMessage{static_cast<std::uint64_t>(word), value}, 0, word_tag, comm_);
}

void MessageServer::poll() {
  // Records are received with the result that announces them. A first look may only let a message
  // in that the second finds.
  for (int misses = 0; misses < 2;) {
    int arrived = 0;
    MPI_Status status;
    check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm_, &arrived, &status),
              "looking for messages");
    if (arrived == 0) {
      ++misses;
      continue;
    }
    switch (status.MPI_TAG) {
      case take_tag:
        answer_take(status.MPI_SOURCE);
        break;
      case result_tag:
        receive_result(status.MPI_SOURCE);
        break;
      case word_tag:
        receive_word(status.MPI_SOURCE);
        break;
      default:
        throw RunError("message of an unknown kind from rank " + std::to_string(status.MPI_SOURCE));
    }
  }
}

void MessageServer::answer_take(int rank) {
  const auto [speed, idle] = receive<TakeMessage>(rank, take_tag, comm_);
  const auto part =
      sources_[static_cast<std::size_t>(rank)]->take_part(std::bit_cast<double>(speed), idle != 0);
  send(AnswerMessage{static_cast<std::uint64_t>(part.answer), part.cells.begin, part.cells.end,
                     part.fresh ? 1ULL : 0ULL},
       rank, answer_tag, comm_);
}

void MessageServer::receive_result(int rank) {
  const auto [begin, end, digest] = receive<ResultMessage>(rank, result_tag, comm_);
  if (begin >= end || end > layout_.cells()) {
    throw RunError("impossible result from rank " + std::to_string(rank));
  }
  std::byte* const target = memory_.data() + layout_.record_offset(begin);
  const std::size_t bytes = (end - begin) * layout_.record_bytes();
  for (std::size_t done = 0; done < bytes; done += most_bytes) {
    const int count = static_cast<int>(std::min(bytes - done, most_bytes));
    check_mpi(MPI_Recv(target + done, count, MPI_BYTE, rank, records_tag, comm_, MPI_STATUS_IGNORE),
              "receiving rows");
  }
  sources_[static_cast<std::size_t>(rank)]->log({begin, end}, digest);
}

void MessageServer::receive_word(int rank) {
  const auto [word, value] = receive<WordMessage>(rank, word_tag, comm_);
  sources_[static_cast<std::size_t>(rank)]->publish(static_cast<WindowLayout::RankWord>(word),
                                                    value);
}

}  // namespace parray::mpi
