#include "musher/view/json/message_layout.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>

#include "musher/base/check.hpp"

namespace musher::view {
namespace {

const std::map<std::string_view, FieldKind> kKinds = {
    {"bool", FieldKind::kBool},       {"byte", FieldKind::kUint8},
    {"int8", FieldKind::kInt8},       {"uint8", FieldKind::kUint8},
    {"int16", FieldKind::kInt16},     {"uint16", FieldKind::kUint16},
    {"int32", FieldKind::kInt32},     {"uint32", FieldKind::kUint32},
    {"int64", FieldKind::kInt64},     {"uint64", FieldKind::kUint64},
    {"float32", FieldKind::kFloat32}, {"float64", FieldKind::kFloat64},
    {"string", FieldKind::kString},
};

// The types of a text by name, "" for the first one, each with its lines.
using Texts = std::vector<std::pair<std::string_view, std::vector<std::string_view>>>;

Texts Split(std::string_view text) {
  constexpr std::string_view kName = "MSG: ";
  Texts types(1);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (line.starts_with('=')) continue;
    if (line.starts_with(kName)) {
      types.emplace_back(line.substr(kName.size()), std::vector<std::string_view>());
    } else {
      types.back().second.push_back(line);
    }
  }
  return types;
}

// "float64[36] covariance", "string<=20[] names", "std_msgs/Header header"
MessageField FieldOf(std::string_view line, const std::map<std::string_view, std::size_t>& types) {
  const std::size_t space = line.find(' ');
  MUSHER_CHECK(space != std::string_view::npos, std::string(line));
  MessageField field;
  field.name = line.substr(space + 1);
  std::string_view type = line.substr(0, space);
  if (const std::size_t bracket = type.find('['); bracket != std::string_view::npos) {
    const std::string_view length = type.substr(bracket + 1);
    const char* const end = length.data() + length.size() - 1;
    const auto number = std::from_chars(length.data(), end, field.length);
    field.sequence = number.ec != std::errc();  // "[]", "[<=5]"
    type = type.substr(0, bracket);
  }
  type = type.substr(0, type.find("<="));
  if (const auto kind = kKinds.find(type); kind != kKinds.end()) {
    field.kind = kind->second;
  } else {
    MUSHER_CHECK(types.contains(type), std::string(line));
    field.kind = FieldKind::kMessage;
    field.type = types.at(type);
  }
  return field;
}

}  // namespace

MessageLayout LayoutOf(const msg::MessageDefinition& definition) {
  const Texts texts = Split(definition.text);
  std::map<std::string_view, std::size_t> indices;
  for (std::size_t i = 1; i < texts.size(); ++i) indices[texts[i].first] = i;
  MessageLayout layout;
  layout.envelope = definition.envelope;
  layout.appended = definition.appended;
  for (const auto& [name, lines] : texts) {
    std::vector<MessageField>& fields = layout.types.emplace_back();
    for (const std::string_view line : lines) fields.push_back(FieldOf(line, indices));
  }
  return layout;
}

}  // namespace musher::view
