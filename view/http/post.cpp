#include "musher/view/http/post.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace musher::http {
namespace {

namespace client {
namespace asio = boost::asio;
using boost::beast::error_code;
using boost::beast::http::field;
using boost::beast::http::verb;
using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Reply = boost::beast::http::response<boost::beast::http::string_body>;
}  // namespace client

// Runs what was begun until its handler has run; false: it failed, or the time is over.
bool Ran(client::asio::io_context& io, const client::error_code& error) {
  io.restart();
  io.run();
  return !error;
}

}  // namespace

Result<PostReply> Post(const std::string& address, std::uint16_t port, const std::string& path,
                       const std::string& json, Duration timeout) {
  client::asio::io_context io;
  boost::beast::tcp_stream stream(io);
  client::error_code error;
  const auto no_answer = [&] {
    return Error{kCodeNetError,
                 "no reply from " + address + ":" + std::to_string(port) + ": " + error.message()};
  };
  const auto ip = client::asio::ip::make_address(address, error);
  if (error) return no_answer();
  stream.expires_after(timeout);
  stream.async_connect({ip, port}, [&error](const client::error_code& e) { error = e; });
  if (!Ran(io, error)) return no_answer();
  client::Request request(client::verb::post, path, 11);
  request.set(client::field::host, "localhost");
  request.set(client::field::content_type, "application/json");
  request.body() = json;
  request.prepare_payload();
  boost::beast::http::async_write(
      stream, request, [&error](const client::error_code& e, std::size_t) { error = e; });
  if (!Ran(io, error)) return no_answer();
  boost::beast::flat_buffer buffer;
  client::Reply reply;
  boost::beast::http::async_read(stream, buffer, reply,
                                 [&error](const client::error_code& e, std::size_t) { error = e; });
  if (!Ran(io, error)) return no_answer();
  return PostReply{reply.result_int(), reply.body()};
}

}  // namespace musher::http
