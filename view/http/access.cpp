#include "musher/view/http/access.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>

#include "musher/view/http/target.hpp"

namespace musher::http {
namespace {

using Address = std::array<std::uint8_t, 16>;  // IPv4 as ::ffff:a.b.c.d

std::optional<Address> ParseAddress(std::string_view text) {
  const std::string copy(text);
  Address address{};
  if (inet_pton(AF_INET6, copy.c_str(), address.data()) == 1) return address;
  address = {};
  address[10] = address[11] = 0xFF;
  if (inet_pton(AF_INET, copy.c_str(), address.data() + 12) == 1) return address;
  return std::nullopt;
}

bool IsLoopback(const Address& address) {
  static constexpr Address kFour = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127};
  static constexpr Address kSix = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return address == kSix || std::equal(address.begin(), address.begin() + 13, kFour.begin());
}

bool IsListed(const std::string& host, const HostNames& names) {
  return std::any_of(names.hosts.begin(), names.hosts.end(),
                     [&](const std::string& name) { return LowerCase(name) == host; });
}

bool IsThisHost(const std::string& host, const Connection& connection, const HostNames& names) {
  if (host == "localhost") return true;
  if (!names.hostname.empty() && (host == names.hostname || host == names.hostname + ".local")) {
    return true;
  }
  const auto address = ParseAddress(host);
  if (!address) return false;
  return IsLoopback(*address) || address == ParseAddress(connection.local_address);
}

Error Denied(std::string message) {
  return {kCodePermissionDenied, std::move(message)};
}

// The authority of "http://robot:8765"; empty for other schemes.
std::string_view AuthorityOf(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme)) return origin.substr(scheme.size());
  }
  return {};
}

}  // namespace

bool IsAddress(std::string_view text) {
  return ParseAddress(text).has_value();
}

bool IsLoopback(std::string_view address) {
  const auto parsed = ParseAddress(address);
  return parsed && IsLoopback(*parsed);
}

Result<> CheckHost(std::string_view host, const Connection& connection, const HostNames& names) {
  const auto authority = ParseAuthority(host);
  if (!authority) return Denied("the header Host is invalid: " + authority.error().message);
  const std::string& name = authority.value().host;
  if (IsThisHost(name, connection, names) || IsListed(name, names)) return Ok();
  return Denied("'" + name + "' is not a name of this host; use its address, its hostname or a " +
                "name that the server is configured to accept");
}

Result<> CheckOrigin(const std::map<std::string, std::string>& headers, OriginRule rule,
                     const Connection& connection, const HostNames& names) {
  const auto found = headers.find("origin");
  if (found == headers.end()) {
    const auto site = headers.find("sec-fetch-site");
    if (site == headers.end() || site->second == "same-origin" || site->second == "none") {
      return Ok();
    }
    return Denied("the browser reports a request of another site without its Origin");
  }
  const std::string origin = LowerCase(found->second);
  if (IsListed(origin, names)) return Ok();
  const auto authority = ParseAuthority(AuthorityOf(origin));
  const auto host = headers.find("host");
  if (authority && host != headers.end()) {
    const std::string& name = authority.value().host;
    if (LowerCase(host->second) == AuthorityOf(origin) || IsListed(name, names)) return Ok();
    if (rule == OriginRule::kSameHost && IsThisHost(name, connection, names)) return Ok();
  }
  const std::string sent_to = host == headers.end() ? std::string("none") : host->second;
  return Denied("a page of another site ('" + origin + "') may not use this server ('" + sent_to +
                "'); a proxy has to pass the header Host on as it is");
}

}  // namespace musher::http
