#pragma once
// The address of the page for other hosts, such as a phone. Pure; threads: any.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/transport/network.hpp"

namespace musher::view {

// "http://192.168.1.7:8765"; of a page that listens on all addresses that of the first interface
// to other hosts (ChooseInterfaces()), else of any. Empty: only this host can connect.
std::string OutsideUrl(const std::string& bind,
                       const std::vector<transport::NetworkInterface>& interfaces,
                       std::uint16_t port);

}  // namespace musher::view
