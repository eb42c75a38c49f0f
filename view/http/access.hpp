#pragma once
// Whether a request may come from where it comes from: against pages of other sites that use the
// browser of an operator (cross-site requests, DNS rebinding). Pure; threads: any.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::http {

// The names of this host in Host and Origin.
struct HostNames {
  std::string hostname;            // lower case; empty: unknown
  std::vector<std::string> hosts;  // Options::hosts
};

// What is compared with the headers of a request.
struct Connection {
  std::string local_address;  // of this host, that the client has connected to: "192.168.1.5"
};

// Checks the value of Host. The error is a sentence for the client.
Result<> CheckHost(std::string_view host, const Connection& connection, const HostNames& names);

enum class OriginRule {
  kSamePage,  // a POST: from a page of this server
  kSameHost,  // a WebSocket: from a page of this host
};
// `headers` with names in lower case. Host has been checked.
Result<> CheckOrigin(const std::map<std::string, std::string>& headers, OriginRule rule,
                     const Connection& connection, const HostNames& names);

bool IsAddress(std::string_view text);

// Whether it is an address of 127.0.0.0/8 or ::1, also as ::ffff:127.0.0.1.
bool IsLoopback(std::string_view address);

}  // namespace musher::http
