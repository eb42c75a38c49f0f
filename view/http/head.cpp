#include "musher/view/http/head.hpp"

#include <algorithm>

#include "musher/base/joined.hpp"
#include "musher/view/http/target.hpp"

namespace musher::http {
namespace {

HttpError InvalidHead(std::string message) {
  return {400, {kCodeParametersInvalid, std::move(message)}};
}

std::string_view ValueOf(const Request& request, const std::string& name) {
  const auto found = request.headers.find(name);
  return found == request.headers.end() ? std::string_view() : std::string_view(found->second);
}

// Calls `item` with each item of a list that commas separate.
template <typename Function>
void ForEachItem(std::string_view list, const Function& item) {
  while (true) {
    const std::size_t end = list.find(',');
    const std::string_view text = Trim(list.substr(0, end));
    if (!text.empty()) item(text);
    if (end == std::string_view::npos) return;
    list.remove_prefix(end + 1);
  }
}

// Fills the headers; returns the name of a header that is repeated and must not be.
std::string FillHeaders(const Head& head, Request& request) {
  std::string repeated;
  for (const auto& [name, value] : head.fields) {
    const std::string key = LowerCase(name);
    const auto [at, first] = request.headers.emplace(key, value);
    if (first) continue;
    if (key == "host" || key == "origin" || key == "sec-websocket-key") repeated = key;
    at->second.append(key == "cookie" ? "; " : ", ").append(value);
  }
  return repeated;
}

// Through a proxy on this host, each client would seem to be on this host.
bool IsProxied(const Request& request) {
  constexpr std::string_view kForwarded = "x-forwarded-";  // …for, …proto, …host
  const auto forwarded = request.headers.lower_bound(std::string(kForwarded));
  return request.headers.contains("forwarded") || request.headers.contains("via") ||
         request.headers.contains("x-real-ip") ||
         (forwarded != request.headers.end() && forwarded->first.starts_with(kForwarded));
}

std::string ChooseSubprotocol(std::string_view offered, const std::vector<std::string>& known) {
  for (const std::string& name : known) {
    bool found = false;
    ForEachItem(offered, [&](std::string_view item) { found = found || item == name; });
    if (found) return name;
  }
  return {};
}

std::variant<CheckedHead, HttpError> CheckUpgrade(CheckedHead checked,
                                                  const std::vector<std::string>& subprotocols) {
  const Request& request = checked.request;
  if (request.method != "GET" || checked.without_body) {
    return InvalidHead("a WebSocket begins with GET");
  }
  if (ValueOf(request, "sec-websocket-version") != "13") {
    return HttpError{426, {kCodeUnSupport, "the server knows WebSockets of version 13 only"}};
  }
  constexpr std::size_t kKeyLength = 24;  // 16 bytes in base64
  checked.key = ValueOf(request, "sec-websocket-key");
  if (checked.key.size() != kKeyLength)
    return InvalidHead("Sec-WebSocket-Key is missing or invalid");
  const std::string_view offered = ValueOf(request, "sec-websocket-protocol");
  checked.subprotocol = ChooseSubprotocol(offered, subprotocols);
  if (!offered.empty() && checked.subprotocol.empty()) {
    return InvalidHead("the server has none of the offered subprotocols; it has: " +
                       Joined(subprotocols));
  }
  checked.websocket = true;
  return checked;
}

}  // namespace

std::variant<CheckedHead, HttpError> CheckHead(const Head& head, const Connection& connection,
                                               const HostNames& names,
                                               const std::vector<std::string>& subprotocols) {
  if (head.target.size() > kMaxTarget) {
    return HttpError{414,
                     {kCodeParametersInvalid,
                      "the address is longer than " + std::to_string(kMaxTarget) + " bytes"}};
  }
  CheckedHead checked;
  Request& request = checked.request;
  const std::string repeated = FillHeaders(head, request);
  if (!repeated.empty()) return InvalidHead("the header " + repeated + " is repeated");
  if (!request.headers.contains("host")) return InvalidHead("the header Host is missing");
  const auto host = CheckHost(request.headers["host"], connection, names);
  if (!host) return HttpError{403, host.error()};

  checked.without_body = head.method == "HEAD";
  request.method = checked.without_body ? "GET" : head.method;
  if (request.method != "GET" && request.method != "POST") {
    return HttpError{405, {kCodeUnSupport, "the server knows GET, HEAD and POST only"}};
  }
  auto target = ParseTarget(head.target);
  if (!target) return HttpError{400, target.error()};
  request.path = std::move(target.value().path);
  request.query = std::move(target.value().query);
  request.cookies = ParseCookies(ValueOf(request, "cookie"));
  request.local = !IsProxied(request);

  const bool upgrade = HasToken(ValueOf(request, "connection"), "upgrade") &&
                       HasToken(ValueOf(request, "upgrade"), "websocket");
  if (upgrade || request.method == "POST") {
    const auto rule = upgrade ? OriginRule::kSameHost : OriginRule::kSamePage;
    const auto origin = CheckOrigin(request.headers, rule, connection, names);
    if (!origin) return HttpError{403, origin.error()};
  }
  const std::string_view expected = ValueOf(request, "expect");
  checked.expects_continue = LowerCase(expected) == "100-continue";
  if (!expected.empty() && !checked.expects_continue) {
    return HttpError{417, {kCodeUnSupport, "the server knows the expectation 100-continue only"}};
  }
  return upgrade ? CheckUpgrade(std::move(checked), subprotocols) : std::move(checked);
}

std::string ForwardedAddress(const Request& request) {
  std::string nearest(ValueOf(request, "x-real-ip"));
  ForEachItem(ValueOf(request, "x-forwarded-for"), [&](std::string_view item) { nearest = item; });
  return IsAddress(nearest) ? nearest : std::string();
}

bool HasToken(std::string_view list, std::string_view token) {
  bool found = false;
  ForEachItem(list, [&](std::string_view item) { found = found || LowerCase(item) == token; });
  return found;
}

}  // namespace musher::http
