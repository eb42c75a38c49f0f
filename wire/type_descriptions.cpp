#include "musher/wire/type_descriptions.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/definitions.hpp"
#include "musher/messages/type_hash.hpp"

namespace musher::transport {
namespace {

// Numbers of type_description_interfaces/msg/FieldType.
constexpr std::uint8_t kNested = 1;
constexpr std::uint8_t kString = 17;
constexpr std::uint8_t kBoundedString = 21;
constexpr std::uint8_t kArray = 48;               // added to the type of the elements
constexpr std::uint8_t kBoundedSequence = 96;     // likewise
constexpr std::uint8_t kUnboundedSequence = 144;  // likewise
constexpr std::array<std::pair<std::string_view, std::uint8_t>, 12> kBasicTypes = {{{"int8", 2},
                                                                                    {"uint8", 3},
                                                                                    {"int16", 4},
                                                                                    {"uint16", 5},
                                                                                    {"int32", 6},
                                                                                    {"uint32", 7},
                                                                                    {"int64", 8},
                                                                                    {"uint64", 9},
                                                                                    {"float32", 10},
                                                                                    {"float64", 11},
                                                                                    {"bool", 15},
                                                                                    {"byte", 16}}};
constexpr std::string_view kBound = "<=";
constexpr std::string_view kOfOtherType = "MSG: ";
constexpr std::size_t kLongestType = 100;  // of a name that is repeated in an answer

const msg::MessageDefinition* FindByRosName(std::string_view ros_type) {
  const auto found =
      std::ranges::find(msg::Definitions(), ros_type, &msg::MessageDefinition::ros_type);
  return found == msg::Definitions().end() ? nullptr : &*found;
}

// The whole name of a type that a definition calls "package/Name".
std::string WholeName(std::string_view short_name) {
  const std::size_t slash = short_name.find('/');
  for (const char* kind : {"/msg", "/action", "/srv"}) {
    const std::string name = std::string(short_name.substr(0, slash)) + kind +
                             std::string(short_name.substr(std::min(slash, short_name.size())));
    if (FindByRosName(name) != nullptr) return name;
  }
  return std::string(short_name);
}

std::uint64_t Number(std::string_view digits) {
  std::uint64_t number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

// The type of a field that the IDL writes as "string<=255[]", "float64[36]" or "std_msgs/Header".
msg::DescribedFieldType FieldTypeOf(std::string_view text) {
  msg::DescribedFieldType type;
  std::uint8_t many = 0;
  if (const std::size_t bracket = text.find('['); bracket != std::string_view::npos) {
    std::string_view size = text.substr(bracket + 1, text.size() - bracket - 2);
    many = size.empty() ? kUnboundedSequence : size.starts_with(kBound) ? kBoundedSequence : kArray;
    if (size.starts_with(kBound)) size.remove_prefix(kBound.size());
    type.capacity = Number(size);
    text = text.substr(0, bracket);
  }
  const auto basic =
      std::ranges::find(kBasicTypes, text, [](const auto& row) { return row.first; });
  if (basic != kBasicTypes.end()) {
    type.type_id = basic->second;
  } else if (text.starts_with("string")) {
    const std::size_t bound = text.find(kBound);
    type.type_id = bound == std::string_view::npos ? kString : kBoundedString;
    if (bound != std::string_view::npos) {
      type.string_capacity = Number(text.substr(bound + kBound.size()));
    }
  } else {
    type.type_id = kNested;
    type.nested_type_name = WholeName(text);
  }
  type.type_id = static_cast<std::uint8_t>(type.type_id + many);
  return type;
}

msg::IndividualTypeDescription DescriptionOf(std::string name, std::string_view fields) {
  msg::IndividualTypeDescription description;
  description.type_name = std::move(name);
  while (!fields.empty()) {
    const std::size_t end = std::min(fields.find('\n'), fields.size());
    const std::string_view line = fields.substr(0, end);
    fields.remove_prefix(std::min(end + 1, fields.size()));
    const std::size_t space = line.find(' ');
    if (space == std::string_view::npos) continue;
    description.fields.push_back(
        {std::string(line.substr(space + 1)), FieldTypeOf(line.substr(0, space)), ""});
  }
  // What ROS 2 adds to a type without fields.
  if (description.fields.empty()) {
    description.fields.push_back({"structure_needs_at_least_one_member", FieldTypeOf("uint8"), ""});
  }
  return description;
}

// The type itself, then each one that it consists of: its name and its fields, one a line.
std::vector<std::pair<std::string, std::string_view>> PartsOf(
    const msg::MessageDefinition& definition) {
  std::vector<std::pair<std::string, std::string_view>> parts;
  std::string name(definition.ros_type);
  std::string_view text = definition.text;
  while (true) {
    const std::size_t line = text.find("=====");
    parts.emplace_back(std::move(name), text.substr(0, line));
    if (line == std::string_view::npos) return parts;
    text.remove_prefix(text.find(kOfOtherType, line) + kOfOtherType.size());
    const std::size_t end = text.find('\n');
    name = WholeName(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
}

}  // namespace

std::optional<msg::TypeDescription> DescribeType(std::string_view ros_type) {
  const msg::MessageDefinition* definition = FindByRosName(ros_type);
  if (definition == nullptr) return std::nullopt;
  msg::TypeDescription description;
  bool first = true;
  for (auto& [name, fields] : PartsOf(*definition)) {
    msg::IndividualTypeDescription part = DescriptionOf(std::move(name), fields);
    if (std::exchange(first, false)) {
      description.type_description = std::move(part);
    } else {
      description.referenced_type_descriptions.push_back(std::move(part));
    }
  }
  return description;
}

msg::GetTypeDescription::Response Describe(const msg::GetTypeDescription::Request& request) {
  msg::GetTypeDescription::Response response;
  const std::string name = request.type_name.substr(0, kLongestType);
  const msg::MessageDefinition* definition = FindByRosName(request.type_name);
  if (definition == nullptr) {
    response.failure_reason = "Musher has no definition of " + name;
    return response;
  }
  const std::string_view hash = msg::TypeHashOf(definition->dds_type);
  if (hash != request.type_hash) {
    response.failure_reason =
        "the hash of " + name + " is " + std::string(hash) + ", not the requested one";
    return response;
  }
  response.successful = true;
  response.type_description = *DescribeType(request.type_name);
  if (!request.include_type_sources) return response;
  for (auto& [part, fields] : PartsOf(*definition)) {
    response.type_sources.push_back({std::move(part), "msg", std::string(fields)});
  }
  return response;
}

}  // namespace musher::transport
