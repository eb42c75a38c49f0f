#include "musher/view/http/reply.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "musher/view/http/target.hpp"

namespace musher::http {
namespace {

// What a browser may do with what it gets: load from this server only, and not show the page within
// another one.
constexpr std::string_view kProtection =
    "X-Content-Type-Options: nosniff\r\n"
    "Content-Security-Policy: default-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self' ws: wss:; base-uri 'none'; form-action 'self'; frame-ancestors 'none'\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Referrer-Policy: no-referrer\r\n";

std::string_view ReasonOf(unsigned status) {
  switch (status) {
    case 200:
      return "OK";
    case 204:
      return "No Content";
    case 302:
      return "Found";
    case 303:
      return "See Other";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 409:
      return "Conflict";
    case 413:
      return "Content Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 417:
      return "Expectation Failed";
    case 426:
      return "Upgrade Required";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 503:
      return "Service Unavailable";
    case 504:
      return "Gateway Timeout";
    default:
      return "Response";
  }
}

bool IsHeaderText(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t') || byte == 0x7f;
  });
}

bool IsToken(std::string_view text) {
  return !text.empty() && IsHeaderText(text) && text.find_first_of(" \t:") == text.npos;
}

bool AreValid(const Response& response) {
  return response.status >= 200 && response.status <= 599 && IsHeaderText(response.content_type) &&
         std::all_of(response.headers.begin(), response.headers.end(), [](const auto& header) {
           return IsToken(header.first) && IsHeaderText(header.second);
         });
}

bool Has(const Response& response, std::string_view name) {
  return std::any_of(response.headers.begin(), response.headers.end(),
                     [&](const auto& header) { return LowerCase(header.first) == name; });
}

}  // namespace

bool HasBody(unsigned status) {
  return status != 204 && status != 304;
}

std::string ReplyHead(const Response& response, const ReplyContext& context) {
  if (!AreValid(response)) {
    Response failed;
    failed.status = 500;
    failed.body = response.body;  // its length is that of what follows
    return ReplyHead(failed, context);
  }
  std::string head = "HTTP/1.1 " + std::to_string(response.status) + " ";
  head.reserve(640);
  head.append(ReasonOf(response.status)).append("\r\n");
  head.append("Date: ").append(HttpDate(context.unix_s)).append("\r\n");
  if (HasBody(response.status)) {
    const std::size_t length = response.body ? response.body->size() : 0;
    head.append("Content-Length: ").append(std::to_string(length)).append("\r\n");
    if (length > 0) head.append("Content-Type: ").append(response.content_type).append("\r\n");
  }
  const bool api = context.path == "/api" || context.path.starts_with("/api/");
  for (const auto& [name, value] : response.headers) {
    if (api && LowerCase(name) == "cache-control") continue;
    head.append(name).append(": ").append(value).append("\r\n");
  }
  if (api || !Has(response, "cache-control")) {
    const bool checked = !api && Has(response, "etag");
    head.append(checked ? "Cache-Control: no-cache\r\n" : "Cache-Control: no-store\r\n");
  }
  head.append(kProtection);
  if (context.close) head.append("Connection: close\r\n");
  head.append("\r\n");
  return head;
}

std::string HttpDate(std::int64_t unix_s) {
  static constexpr std::array kDays = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  static constexpr std::array kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                         "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t time = unix_s;
  std::tm utc{};
  if (gmtime_r(&time, &utc) == nullptr) return HttpDate(0);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%s, %02d %s %04d %02d:%02d:%02d GMT",
                kDays.at(utc.tm_wday), utc.tm_mday, kMonths.at(utc.tm_mon), utc.tm_year + 1900,
                utc.tm_hour, utc.tm_min, utc.tm_sec);
  return text.data();
}

std::string JsonText(std::string_view text) {
  const bool readable = IsUtf8(text);
  std::string json = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      json.append(1, '\\').append(1, c);
    } else if (byte < 0x20 || byte == 0x7f) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\u%04x", byte);
      json += escape.data();
    } else {
      json += byte < 0x80 || readable ? c : '?';
    }
  }
  return json + "\"";
}

Response ErrorResponse(unsigned status, std::int32_t code, std::string_view message) {
  Response response;
  response.status = status;
  response.body = std::make_shared<std::string>("{\"error\":{\"code\":" + std::to_string(code) +
                                                ",\"message\":" + JsonText(message) + "}}\n");
  return response;
}

Response WithETag(const Request& request, Response response, const std::string& etag) {
  response.headers.emplace_back("ETag", etag);
  const auto known = request.headers.find("if-none-match");
  if (known == request.headers.end()) return response;
  std::string_view rest = known->second;
  while (!rest.empty()) {
    const std::size_t end = rest.find(',');
    std::string_view tag = Trim(rest.substr(0, end));
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag || tag == "*") {
      response.status = 304;
      response.body = nullptr;
      return response;
    }
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  return response;
}

}  // namespace musher::http
