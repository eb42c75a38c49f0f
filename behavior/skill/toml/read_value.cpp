#include "musher/behavior/skill/toml/read_value.hpp"

namespace musher::skill {

std::optional<Value> ReadValue(const config_toml::Value& value) {
  if (const auto* flag = value.As<bool>()) return *flag;
  if (const auto* whole = value.As<std::int64_t>()) return *whole;
  if (const auto* number = value.As<double>()) return *number;
  if (const auto* text = value.As<std::string>()) return *text;
  const auto* array = value.As<config_toml::Array>();
  if (array == nullptr) return std::nullopt;
  Numbers numbers;
  for (const config_toml::Value& element : *array) {
    if (const auto* number = element.As<double>()) {
      numbers.push_back(*number);
    } else if (const auto* whole = element.As<std::int64_t>()) {
      numbers.push_back(static_cast<double>(*whole));
    } else {
      return std::nullopt;
    }
  }
  return numbers;
}

}  // namespace musher::skill
