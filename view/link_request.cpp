#include "musher/view/link_request.hpp"

#include "musher/view/http/post.hpp"
#include "musher/view/json/json.hpp"

namespace musher::view {

Result<std::string> RequestLink(const std::string& address, std::uint16_t port,
                                const std::string& token, const std::string& name) {
  const Error no_answer{kCodeNetError,
                        "no musher-view answers at " + address + ":" + std::to_string(port)};
  const auto reply =
      http::Post(address, port, "/api/link", Json{{"token", token}, {"name", name}}.dump(),
                 std::chrono::seconds(3));
  if (!reply) return no_answer;
  const Json body = Json::parse(reply.value().body, nullptr, false);
  if (!body.is_object()) return no_answer;
  if (body.contains("path") && body["path"].is_string()) return body["path"].get<std::string>();
  const auto why = body.find("error");
  if (why == body.end() || !why->is_object()) return no_answer;
  return Error{kCodePermissionDenied, "musher-view gives no link: " + why->value("message", "")};
}

}  // namespace musher::view
