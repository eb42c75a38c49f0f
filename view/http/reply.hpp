#pragma once
// The head of a response as it is sent, with the headers that protect the page. Pure; threads: any.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/view/http/server.hpp"

namespace musher::http {

struct ReplyContext {
  std::string_view path;  // of the request; empty: it has none
  bool close = false;     // the connection ends with this response
  std::int64_t unix_s = 0;
};

// Text from "HTTP/1.1 200 OK" to the empty line. A line break in a header makes the response 500.
std::string ReplyHead(const Response& response, const ReplyContext& context);

// Whether a response of this status has a body.
bool HasBody(unsigned status);

// "Sun, 06 Nov 1994 08:49:37 GMT"
std::string HttpDate(std::int64_t unix_s);

// `text` between quotes as JSON; bytes that are not UTF-8 become '?'.
std::string JsonText(std::string_view text);

// The response to a request with the ETag `etag` (with its quotes): 304 without the body if the
// client has it.
Response WithETag(const Request& request, Response response, const std::string& etag);

}  // namespace musher::http
