#pragma once
// Writes tables, keys and values of a TOML text that is saved.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::fsm {

class TomlWriter {
 protected:
  // For a writer that derives from it.
  // A field of saved data, by its type.
  void Field(const std::string& name, bool value) { Bool(Key(name), value); }
  void Field(const std::string& name, std::int64_t value) {
    Line(Key(name), std::to_string(value));
  }
  void Field(const std::string& name, const std::string& value) { Text(Key(name), value); }
  void Field(const std::string& name, double value) { Line(Key(name), NumberText(value)); }

  void Table(const std::string& path) { text_ += "\n[" + path + "]\n"; }
  void ArrayTable(const std::string& path) { text_ += "\n[[" + path + "]]\n"; }
  void Bool(const std::string& key, bool value) { Line(key, value ? "true" : "false"); }
  void Number(const std::string& key, std::uint64_t value) { Line(key, std::to_string(value)); }
  void Time(const std::string& key, Duration value) { Line(key, std::to_string(value.count())); }
  void Text(const std::string& key, std::string_view value) { Line(key, Quoted(value, key)); }
  void Line(const std::string& key, const std::string& value);

  std::string Key(const std::string& name);
  // `key` names the text where it cannot be written.
  std::string Quoted(std::string_view text, std::string_view key);
  static std::string NumberText(double value);

  // What was written. Fails, with `name` before the key, where a text is not UTF-8 or has a NUL,
  // which TOML cannot represent.
  Result<std::string> Written(const std::string& name);

  void Append(std::string_view text) { text_ += text; }

 private:
  std::string text_;
  std::string unwritable_;  // the key of a text that TOML cannot represent
};

}  // namespace musher::fsm
