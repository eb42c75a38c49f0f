// What a client of the page's server sends as text: the address, the headers and the login. A path
// never leaves its folder, texts are UTF-8, and no guess opens a session.

#include "musher/test/fuzz/fuzz.hpp"
#include "musher/view/http/head.hpp"
#include "musher/view/http/login.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/http/target.hpp"

namespace {

using namespace musher;
using fuzz::Require;

void CheckTarget(std::string_view text) {
  const auto target = http::ParseTarget(text);
  if (!target) return Require(!target.error().message.empty(), "a refusal has a message");
  const std::string& path = target.value().path;
  Require(path.starts_with('/') && http::IsUtf8(path), "a path is text and begins with '/'");
  Require((path + "/").find("/../") == path.npos && (path + "/").find("/./") == path.npos,
          "a path has no dots as a part");
  Require(path.find('\\') == path.npos && path.find('\0') == path.npos, "a path has plain text");
  for (const auto& [name, value] : target.value().query) {
    Require(http::IsUtf8(name) && http::IsUtf8(value), "a parameter is text");
  }
}

void CheckHeader(fuzz::Input& input) {
  http::Head head;
  head.method = input.Bool() ? "GET" : "POST";
  head.target = "/";
  static constexpr std::string_view kNames[] = {"Host",
                                                "Origin",
                                                "Cookie",
                                                "Connection",
                                                "Upgrade",
                                                "Expect",
                                                "If-None-Match",
                                                "Sec-Fetch-Site",
                                                "Sec-WebSocket-Key",
                                                "Sec-WebSocket-Version",
                                                "X-Other",
                                                "Sec-WebSocket-Protocol"};
  while (!input.empty() && head.fields.size() < 20) {
    const std::string_view name = kNames[input.Below(std::size(kNames))];
    head.fields.emplace_back(name, input.Text());
  }
  const http::HostNames names = {"robot", {"gateway.example"}};
  const auto checked = http::CheckHead(head, {"192.168.1.5"}, names, {"musher.view.v1"});
  if (const auto* refusal = std::get_if<http::HttpError>(&checked)) {
    const auto response =
        http::ErrorResponse(refusal->status, refusal->error.code, refusal->error.message);
    return Require(http::IsUtf8(*response.body) && response.status >= 400, "a refusal is text");
  }
  const auto& request = std::get<http::CheckedHead>(checked).request;
  Require(request.headers.contains("host"), "a request has a host");
  const auto response = http::WithETag(request, {}, "\"1\"");
  Require(response.status == 200 || response.status == 304, "a tag fits or does not");
}

void CheckLogin(fuzz::Input& input) {
  std::uint32_t secrets = 0;
  http::Login login(
      [&](std::span<std::byte> bytes) {
        ++secrets;
        std::fill(bytes.begin(), bytes.end(), std::byte{0xA5});
        std::memcpy(bytes.data(), &secrets, sizeof secrets);
      },
      "0123456789abcdef0123456789abcdef");
  Time now{std::chrono::hours(1)};
  std::string code;
  std::string session;
  bool used = true;
  while (!input.empty()) {
    now += std::chrono::seconds(input.Byte());
    const std::string peer(1, static_cast<char>('a' + input.Below(4)));
    switch (input.Below(5)) {
      case 0:
        code = login.NewCode(std::string(input.Text()), now).code;
        used = false;
        break;
      case 1: {
        const auto opened = login.Redeem(code, peer, now);
        Require(!opened || !used, "a code opens one session");
        if (opened) session = opened.value();
        used = used || opened.ok();
        break;
      }
      case 2:
        Require(!login.Redeem(input.Text(20), peer, now), "a guess opens no session");
        break;
      case 3:
        Require(!login.Find(input.Text(20), now), "a guess is no session");
        break;
      default:
        if (login.Find(session, now)) login.End(session);
        Require(!login.Find(session, now), "an ended session is none");
    }
    Require(login.codes() <= http::kMaxCodes && login.sessions() <= http::kMaxSessions,
            "the number of secrets is bounded");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  switch (input.Below(4)) {
    case 0:
      CheckTarget(input.Rest());
      break;
    case 1:
      CheckHeader(input);
      break;
    case 2:
      CheckLogin(input);
      break;
    default: {
      const std::string_view text = input.Rest();
      for (const auto& [name, value] : http::ParseCookies(text)) {
        Require(!name.empty() && name.size() + value.size() <= text.size(), "a cookie is a part");
      }
      const auto authority = http::ParseAuthority(text);
      Require(!authority || !authority.value().host.empty(), "an authority has a host");
    }
  }
  return 0;
}
