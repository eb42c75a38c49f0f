#include "musher/view/link_request.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <nlohmann/json.hpp>

namespace musher::view {
namespace {

namespace beast = boost::beast;
using LinkJson = nlohmann::json;

constexpr auto kPatience = std::chrono::seconds(3);

// Runs what was begun until its handler has run; false: it failed, or the time is over.
bool Done(boost::asio::io_context& io, const beast::error_code& error) {
  io.restart();
  io.run();
  return !error;
}

}  // namespace

Result<std::string> RequestLink(const std::string& address, std::uint16_t port,
                                const std::string& token, const std::string& name) {
  const Error nobody{kCodeNetError,
                     "no musher-view answers at " + address + ":" + std::to_string(port)};
  boost::asio::io_context io;
  beast::tcp_stream stream(io);
  beast::error_code error;
  const auto ip = boost::asio::ip::make_address(address, error);
  if (error) return nobody;
  stream.expires_after(kPatience);
  stream.async_connect({ip, port}, [&error](const beast::error_code& e) { error = e; });
  if (!Done(io, error)) return nobody;

  beast::http::request<beast::http::string_body> request(beast::http::verb::post, "/api/link", 11);
  request.set(beast::http::field::host, "localhost");
  request.set(beast::http::field::content_type, "application/json");
  request.body() = LinkJson{{"token", token}, {"name", name}}.dump();
  request.prepare_payload();
  beast::http::async_write(stream, request,
                           [&error](const beast::error_code& e, std::size_t) { error = e; });
  if (!Done(io, error)) return nobody;
  beast::flat_buffer buffer;
  beast::http::response<beast::http::string_body> response;
  beast::http::async_read(stream, buffer, response,
                          [&error](const beast::error_code& e, std::size_t) { error = e; });
  if (!Done(io, error)) return nobody;

  const LinkJson body = LinkJson::parse(response.body(), nullptr, false);
  if (!body.is_object()) return nobody;
  if (body.contains("path") && body["path"].is_string()) return body["path"].get<std::string>();
  const auto why = body.find("error");
  if (why == body.end() || !why->is_object()) return nobody;
  return Error{kCodePermissionDenied, "musher-view gives no link: " + why->value("message", "")};
}

}  // namespace musher::view
