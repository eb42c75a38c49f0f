#include "musher/view/http/target.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace musher::http {
namespace {

Error Invalid(std::string message) {
  return {kCodeParametersInvalid, std::move(message)};
}

std::optional<unsigned> HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

// Without its escapes; nullopt if one is incomplete.
std::optional<std::string> Unescape(std::string_view text, bool plus_is_space) {
  std::string plain;
  plain.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_space) {
      plain += ' ';
    } else if (text[i] != '%') {
      plain += text[i];
    } else {
      if (i + 2 >= text.size()) return std::nullopt;
      const auto high = HexDigit(text[i + 1]);
      const auto low = HexDigit(text[i + 2]);
      if (!high || !low) return std::nullopt;
      plain += static_cast<char>(*high * 16 + *low);
      i += 2;
    }
  }
  return plain;
}

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7f;
}

bool HasControl(std::string_view text) {
  return std::any_of(text.begin(), text.end(), IsControl);
}

bool HasEscapedSlash(std::string_view text) {
  return LowerCase(text).find("%2f") != std::string::npos;
}

// Calls `part` with each part of `text` between separators.
template <typename Function>
void Split(std::string_view text, char separator, const Function& part) {
  while (true) {
    const std::size_t end = text.find(separator);
    part(text.substr(0, end));
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

Result<std::string> ParsePath(std::string_view text) {
  if (!text.starts_with('/')) return Invalid("the path does not begin with '/'");
  if (HasEscapedSlash(text)) return Invalid("the path contains an escaped '/'");
  const auto plain = Unescape(text, false);
  if (!plain) return Invalid("the path has an incomplete escape; '%' is followed by two digits");
  if (HasControl(*plain)) return Invalid("the path contains a control character");
  if (plain->find('\\') != std::string::npos) return Invalid("the path contains a backslash");
  if (!IsUtf8(*plain)) return Invalid("the path is not UTF-8");
  std::string path;
  bool dots = false;
  Split(std::string_view(*plain).substr(1), '/', [&](std::string_view part) {
    if (part == "." || part == "..") dots = true;
    if (!part.empty()) path.append("/").append(part);
  });
  if (dots) return Invalid("the path contains '.' or '..' as a part");
  if (path.empty() || plain->ends_with('/')) path += '/';
  return path;
}

Result<std::map<std::string, std::string>> ParseQuery(std::string_view text) {
  std::map<std::string, std::string> query;
  std::string wrong;
  Split(text, '&', [&](std::string_view part) {
    if (part.empty() || !wrong.empty()) return;
    const std::size_t equals = part.find('=');
    const auto name = Unescape(part.substr(0, equals), true);
    const auto value = Unescape(
        equals == std::string_view::npos ? std::string_view() : part.substr(equals + 1), true);
    if (!name || !value) {
      wrong = "a parameter has an incomplete escape; '%' is followed by two digits";
    } else if (!IsUtf8(*name) || !IsUtf8(*value)) {
      wrong = "a parameter is not UTF-8";
    } else if (HasControl(*name) || value->find('\0') != std::string::npos) {
      wrong = "a parameter contains a control character";
    } else if (query.emplace(*name, *value).second && query.size() > kMaxParameters) {
      wrong = "more than " + std::to_string(kMaxParameters) + " parameters";
    }
  });
  if (!wrong.empty()) return Invalid(std::move(wrong));
  return query;
}

// The length of a UTF-8 character by its first byte, 0 if none begins so; `least` is the lowest
// code point that needs this length.
std::size_t LengthOf(unsigned char first, std::uint32_t& code, std::uint32_t& least) {
  if (first < 0x80) return code = first, least = 0, 1;
  if ((first & 0xE0) == 0xC0) return code = first & 0x1F, least = 0x80, 2;
  if ((first & 0xF0) == 0xE0) return code = first & 0x0F, least = 0x800, 3;
  if ((first & 0xF8) == 0xF0) return code = first & 0x07, least = 0x10000, 4;
  return 0;
}

}  // namespace

Result<Target> ParseTarget(std::string_view target) {
  if (target.size() > kMaxTarget) {
    return Invalid("the address is longer than " + std::to_string(kMaxTarget) + " bytes");
  }
  target = target.substr(0, target.find('#'));
  const std::size_t mark = target.find('?');
  auto path = ParsePath(target.substr(0, mark));
  if (!path) return path.error();
  Target parsed;
  parsed.path = std::move(path).value();
  if (mark == std::string_view::npos) return parsed;
  auto query = ParseQuery(target.substr(mark + 1));
  if (!query) return query.error();
  parsed.query = std::move(query).value();
  return parsed;
}

std::map<std::string, std::string> ParseCookies(std::string_view header) {
  std::map<std::string, std::string> cookies;
  Split(header, ';', [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || cookies.size() >= kMaxParameters) return;
    const std::string_view name = Trim(part.substr(0, equals));
    std::string_view value = Trim(part.substr(equals + 1));
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') {
      value = value.substr(1, value.size() - 2);
    }
    if (!name.empty()) cookies.emplace(name, value);
  });
  return cookies;
}

bool IsUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    std::uint32_t code = 0;
    std::uint32_t least = 0;
    const std::size_t length = LengthOf(static_cast<unsigned char>(text[i]), code, least);
    if (length == 0 || i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xC0) != 0x80) return false;
      code = code << 6 | (next & 0x3F);
    }
    const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
    if (code < least || code > 0x10FFFF || surrogate) return false;
    i += length;
  }
  return true;
}

Result<Authority> ParseAuthority(std::string_view text) {
  Authority authority;
  std::string_view rest;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return Invalid("the address has no ']'");
    authority.host = LowerCase(text.substr(1, end - 1));
    rest = text.substr(end + 1);
  } else {
    const std::size_t end = text.find(':');
    authority.host = LowerCase(text.substr(0, end));
    if (end != std::string_view::npos) rest = text.substr(end);
  }
  const bool named = !authority.host.empty() &&
                     std::all_of(authority.host.begin(), authority.host.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
                              c == '.' || c == ':' || c == '_';
                     });
  if (!named) return Invalid("it is not a name or an address");
  if (rest.empty()) return authority;
  authority.port = rest.substr(1);
  const bool number = rest.front() == ':' && !authority.port.empty() &&
                      authority.port.size() <= 5 &&
                      std::all_of(authority.port.begin(), authority.port.end(),
                                  [](char c) { return c >= '0' && c <= '9'; });
  if (!number) return Invalid("the port is not a number");
  return authority;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string_view Trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

}  // namespace musher::http
