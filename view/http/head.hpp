#pragma once
// What a server decides by the head of a request: whether it is valid, whether it may come from
// where it comes from, and whether it opens a WebSocket. Pure; threads: any.

#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "musher/view/http/access.hpp"
#include "musher/view/http/server.hpp"

namespace musher::http {

// As received.
struct Head {
  std::string method;
  std::string target;
  std::vector<std::pair<std::string, std::string>> fields;
};

struct HttpError {
  unsigned status;
  Error error;
};

struct CheckedHead {
  Request request;            // without body, peer and local
  bool without_body = false;  // HEAD
  bool expects_continue = false;
  bool websocket = false;
  std::string key;          // Sec-WebSocket-Key
  std::string subprotocol;  // empty: the client requested none
};

std::variant<CheckedHead, HttpError> CheckHead(const Head& head, const Connection& connection,
                                               const HostNames& names,
                                               const std::vector<std::string>& subprotocols);

// The address of the client as a proxy names it, the nearest one if there are several; empty: none
// does. Worth as much as the proxy: any program may send these headers.
std::string ForwardedAddress(const Request& request);

// Whether a list ("keep-alive, Upgrade") has `token`, in any case.
bool HasToken(std::string_view list, std::string_view token);

}  // namespace musher::http
