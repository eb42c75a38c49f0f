#include "musher/view/link_request.hpp"

#include "musher/view/http/post.hpp"
#include "musher/view/json/json.hpp"

namespace musher::view {
namespace {

Error NoAnswer(const RunningView& view) {
  return {kCodeNetError,
          "no musher-view answers at " + view.address + ":" + std::to_string(view.port)};
}

Result<Json> PostTo(const RunningView& view, const std::string& path, const Json& body) {
  const auto reply =
      http::Post(view.address, view.port, path, body.dump(), std::chrono::seconds(3));
  if (!reply) return NoAnswer(view);
  Json answer = Json::parse(reply.value().body, nullptr, false);
  if (!answer.is_object()) return NoAnswer(view);
  const auto why = answer.find("error");
  if (why == answer.end()) return answer;
  if (!why->is_object()) return NoAnswer(view);
  return Error{kCodePermissionDenied, why->value("message", "")};
}

}  // namespace

Result<http::LoginLink> RequestLink(const RunningView& view, const std::string& name) {
  const auto answer = PostTo(view, "/api/link", Json{{"token", view.token}, {"name", name}});
  if (!answer) {
    Error error = answer.error();
    if (error.code == kCodePermissionDenied) {
      error.message = "musher-view gives no link: " + error.message;
    }
    return error;
  }
  const auto text = [&](const char* key) {
    const auto found = answer.value().find(key);
    return found != answer.value().end() && found->is_string() ? found->get<std::string>() : "";
  };
  if (text("path").empty()) return NoAnswer(view);
  return http::LoginLink{text("path"), text("pin"), text("outside")};
}

Result<> RequestLogout(const RunningView& view) {
  const auto answer = PostTo(view, "/api/logout", Json{{"token", view.token}});
  if (answer) return Ok();
  return answer.error();
}

}  // namespace musher::view
