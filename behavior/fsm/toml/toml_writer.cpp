#include "musher/behavior/fsm/toml/toml_writer.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "musher/base/toml/text.hpp"

namespace musher::fsm {
namespace {

std::string Escaped(char c) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  if (c == '"' || c == '\\') return {'\\', c};
  if (c == '\n') return "\\n";
  const auto byte = static_cast<unsigned char>(c);
  if (byte >= 0x20 && byte != 0x7f) return {c};
  return std::string("\\u00") + kHex[byte >> 4] + kHex[byte & 0xf];
}

}  // namespace

void TomlWriter::Line(const std::string& key, const std::string& value) {
  text_ += key;
  text_ += " = ";
  text_ += value;
  text_ += '\n';
}

std::string TomlWriter::Key(const std::string& name) {
  constexpr std::string_view kBare =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  const bool bare = !name.empty() && name.find_first_not_of(kBare) == std::string::npos;
  return bare ? name : Quoted(name, "a name");
}

std::string TomlWriter::Quoted(std::string_view text, std::string_view key) {
  std::string quoted = "\"";
  while (!text.empty()) {
    const std::size_t size = config_toml::CharacterSize(text);
    if (size == 0 || text.front() == '\0') {
      unwritable_ = key;
      break;
    }
    quoted += size == 1 ? Escaped(text.front()) : std::string(text.substr(0, size));
    text.remove_prefix(size);
  }
  return quoted + "\"";
}

std::string TomlWriter::NumberText(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  std::string number(digits.data(), end);
  if (std::isfinite(value) && number.find_first_of(".e") == std::string::npos) number += ".0";
  return number;
}

Result<std::string> TomlWriter::Written(const std::string& name) {
  if (unwritable_.empty()) return std::move(text_);
  return Error{kCodeFailed,
               name + ": " + unwritable_ + " cannot be saved: it is not UTF-8, or has a NUL"};
}

}  // namespace musher::fsm
