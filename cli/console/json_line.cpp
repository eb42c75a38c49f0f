#include "musher/cli/console/json_line.hpp"

#include <nlohmann/json.hpp>

namespace musher::cli {

OrderedJson Known(const std::string& text) {
  return text.empty() ? OrderedJson() : OrderedJson(text);
}

OrderedJson Known(int number) {
  return number == 0 ? OrderedJson() : OrderedJson(number);
}

OrderedJson Known(std::uint32_t number) {
  return number == 0 ? OrderedJson() : OrderedJson(number);
}

OrderedJson Known(std::int64_t number) {
  return number == 0 ? OrderedJson() : OrderedJson(number);
}

OrderedJson Known(std::uint64_t number) {
  return number == 0 ? OrderedJson() : OrderedJson(number);
}

std::string JsonLine(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace musher::cli
