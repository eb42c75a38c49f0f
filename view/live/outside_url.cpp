#include "musher/view/live/outside_url.hpp"

#include <algorithm>

#include "musher/view/http/access.hpp"

namespace musher::view {
namespace {

std::string OutsideAddress(const std::vector<transport::NetworkInterface>& interfaces) {
  const auto uses = transport::ChooseInterfaces(interfaces, {});
  std::string any;
  for (const transport::NetworkInterface& one : interfaces) {
    if (one.loopback || !one.up || one.addresses.empty()) continue;
    const auto use = std::ranges::find(uses, one.name, &transport::InterfaceUse::name);
    if (use->used) return one.addresses.front();
    if (any.empty()) any = one.addresses.front();
  }
  return any;
}

}  // namespace

std::string OutsideUrl(const std::string& bind,
                       const std::vector<transport::NetworkInterface>& interfaces,
                       std::uint16_t port) {
  if (http::IsLoopback(bind)) return "";
  std::string address = bind == "0.0.0.0" || bind == "::" ? OutsideAddress(interfaces) : bind;
  if (address.empty()) return "";
  if (address.find(':') != std::string::npos) address = "[" + address + "]";
  return "http://" + address + ":" + std::to_string(port);
}

}  // namespace musher::view
