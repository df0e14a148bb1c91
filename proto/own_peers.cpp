#include "proto/own_peers.h"

#include <arpa/inet.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>

namespace parray::proto {
namespace {

/// An address of either family, as the kernel fills it in.
struct Address {
  sockaddr_storage bytes{};
  socklen_t size = sizeof(sockaddr_storage);

  sockaddr* pointer() { return reinterpret_cast<sockaddr*>(&bytes); }
  [[nodiscard]] int family() const { return bytes.ss_family; }
  [[nodiscard]] const sockaddr_in& v4() const {
    return *reinterpret_cast<const sockaddr_in*>(&bytes);
  }
  [[nodiscard]] const sockaddr_in6& v6() const {
    return *reinterpret_cast<const sockaddr_in6*>(&bytes);
  }
};

constexpr std::uint32_t loopback_net = 127;

bool is_loopback_address(const Address& address) {
  if (address.family() == AF_INET) return ntohl(address.v4().sin_addr.s_addr) >> 24 == loopback_net;
  const in6_addr& v6 = address.v6().sin6_addr;
  return address.family() == AF_INET6 &&
         (IN6_IS_ADDR_LOOPBACK(&v6) ||
          (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == loopback_net));
}

void put(const Address& address, __be32 (&to)[4], __be16& port) {
  if (address.family() == AF_INET) {
    to[0] = address.v4().sin_addr.s_addr;
    port = address.v4().sin_port;
  } else {
    std::memcpy(to, &address.v6().sin6_addr, sizeof to);
    port = address.v6().sin6_port;
  }
}

/// Returns the same address in the other family, if it has one: the other end of a connection may
/// be a socket of either family.
bool other_family(Address& address) {
  Address other;
  if (address.family() == AF_INET) {
    auto& v6 = *reinterpret_cast<sockaddr_in6*>(&other.bytes);
    v6.sin6_family = AF_INET6;
    v6.sin6_port = address.v4().sin_port;
    v6.sin6_addr.s6_addr[10] = v6.sin6_addr.s6_addr[11] = 0xFF;
    std::memcpy(&v6.sin6_addr.s6_addr[12], &address.v4().sin_addr, sizeof(in_addr));
  } else {
    if (!IN6_IS_ADDR_V4MAPPED(&address.v6().sin6_addr)) return false;
    auto& v4 = *reinterpret_cast<sockaddr_in*>(&other.bytes);
    v4.sin_family = AF_INET;
    v4.sin_port = address.v6().sin6_port;
    std::memcpy(&v4.sin_addr, &address.v6().sin6_addr.s6_addr[12], sizeof(in_addr));
  }
  address = other;
  return true;
}

/// Asks the kernel for the socket from `from` to `to`. Returns true if it exists; `user` is then
/// its owner.
bool find_owner(const Address& from, const Address& to, std::uint32_t& user) {
  const int netlink = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG);
  if (netlink < 0) return false;
  struct {
    nlmsghdr head{};
    inet_diag_req_v2 question{};
  } request;
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.question.sdiag_family = static_cast<std::uint8_t>(from.family());
  request.question.sdiag_protocol = IPPROTO_TCP;
  request.question.idiag_states = ~0U;
  put(from, request.question.id.idiag_src, request.question.id.idiag_sport);
  put(to, request.question.id.idiag_dst, request.question.id.idiag_dport);
  request.question.id.idiag_cookie[0] = request.question.id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  const timeval patience{0, 100'000};  // the kernel answers at once
  setsockopt(netlink, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::array<char, 4096> answer{};
  ssize_t size = -1;
  if (send(netlink, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request)) {
    size = recv(netlink, answer.data(), answer.size(), 0);
  }
  close(netlink);
  nlmsghdr head{};
  inet_diag_msg found{};
  if (size < static_cast<ssize_t>(NLMSG_HDRLEN + sizeof found)) return false;
  std::memcpy(&head, answer.data(), sizeof head);
  if (head.nlmsg_type != SOCK_DIAG_BY_FAMILY) return false;
  std::memcpy(&found, answer.data() + NLMSG_HDRLEN, sizeof found);
  user = found.idiag_uid;
  return true;
}

bool is_of_this_user(int socket, Address peer) {
  if (peer.family() == AF_UNIX) {
    ucred who{};
    socklen_t size = sizeof who;
    return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && who.uid == geteuid();
  }
  Address own;
  if (!is_loopback_address(peer) || getsockname(socket, own.pointer(), &own.size) != 0) {
    return false;
  }
  std::uint32_t user = 0;
  const bool found = find_owner(peer, own, user) ||
                     (other_family(peer) && other_family(own) && find_owner(peer, own, user));
  return found && user == geteuid();
}

}  // namespace

bool OwnPeers::has(int socket) {
  Address peer;
  if (socket < 0 || getpeername(socket, peer.pointer(), &peer.size) != 0) return false;
  // All peers of a socket file look alike, and asking is cheap.
  const bool named = peer.family() != AF_UNIX;
  const std::string name(reinterpret_cast<const char*>(&peer.bytes), peer.size);
  const auto known = known_.find(socket);
  if (named && known != known_.end() && known->second.peer == name) return known->second.ours;
  const bool ours = is_of_this_user(socket, peer);
  known_[socket] = {name, ours};
  return ours;
}

}  // namespace parray::proto
