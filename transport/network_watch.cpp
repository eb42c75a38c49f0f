#include "musher/transport/network_watch.hpp"

#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <array>
#include <utility>

namespace musher::transport {
namespace {

// An interface comes up first and gets its address after that.
constexpr Duration kSettleTime = Milliseconds(1000);

}  // namespace

std::unique_ptr<NetworkWatch> NetworkWatch::Make(EventLoop& loop,
                                                 std::vector<std::string> configured,
                                                 OnMissed on_missed) {
  UniqueFd kernel(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE));
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
  if (bind(kernel.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return nullptr;
  }
  return std::unique_ptr<NetworkWatch>(
      new NetworkWatch(loop, std::move(configured), std::move(on_missed), std::move(kernel)));
}

NetworkWatch::NetworkWatch(EventLoop& loop, std::vector<std::string> configured, OnMissed on_missed,
                           UniqueFd kernel)
    : loop_(loop),
      configured_(std::move(configured)),
      on_missed_(std::move(on_missed)),
      kernel_(std::move(kernel)),
      changed_(loop.WhenReadable(kernel_.get(), [this] { OnChange(); })) {}

// What has changed is read again: the kernel drops reports that come too fast.
void NetworkWatch::OnChange() {
  std::array<char, 16 << 10> reports;
  while (recv(kernel_.get(), reports.data(), reports.size(), 0) > 0) {
  }
  if (compare_later_) return;
  compare_later_ = loop_.At(loop_.Now() + kSettleTime, [this] {
    compare_later_ = nullptr;
    Compare();
  });
}

void NetworkWatch::Compare() {
  for (const std::string& missed : MissedInterfaces(at_start_, ReadInterfaces(), configured_)) {
    if (reported_.insert(missed).second) on_missed_(missed);
  }
}

}  // namespace musher::transport
