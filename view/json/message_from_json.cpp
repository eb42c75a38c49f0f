#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "musher/messages/cdr.hpp"
#include "musher/view/json/json.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/json/message_layout.hpp"

namespace musher::view {
namespace {

template <class T>
std::optional<T> IntegerOf(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    return std::in_range<T>(number) ? std::optional(static_cast<T>(number)) : std::nullopt;
  }
  if (value.is_number_integer()) {
    const auto number = value.get<std::int64_t>();
    return std::in_range<T>(number) ? std::optional(static_cast<T>(number)) : std::nullopt;
  }
  if (sizeof(T) < 8 || !value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  T number{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = end.ec == std::errc() && end.ptr == text.data() + text.size();
  return whole ? std::optional(number) : std::nullopt;
}

template <class T>
std::optional<T> RealOf(const Json& value) {
  if (value.is_null()) return std::numeric_limits<T>::quiet_NaN();
  if (!value.is_number()) return std::nullopt;
  const auto number = value.get<double>();
  if constexpr (std::is_same_v<T, float>) {
    constexpr double kRoundsToInfinity = 0x1.ffffffp127;
    if (std::abs(number) >= kRoundsToInfinity) return std::nullopt;
    constexpr double kMost = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(number, -kMost, kMost));
  } else {
    return number;
  }
}

// The beginning of a value, for a sentence.
std::string Shown(const Json& value) {
  constexpr std::size_t kMostShown = 40;
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  if (value.is_object()) return "an object";
  if (!value.is_string()) return value.dump();
  const auto& text = value.get_ref<const std::string&>();
  if (text.size() > kMostShown) return "a text of " + std::to_string(text.size()) + " bytes";
  return value.dump();
}

// Writes one message. The first error ends it; a value that is null as a pointer is not given.
class Encoder {
 public:
  explicit Encoder(const MessageLayout& layout) : layout_(layout) {}

  void Write(const Json& object) {
    if (layout_.envelope) writer_.Put(msg::RequestId{});
    Message(0, &object);
  }
  const std::string& error() const { return error_; }
  msg::Bytes Take() && { return std::move(writer_).Take(); }

 private:
  bool failed() const { return !error_.empty(); }
  void Refuse(const Json& value, const std::string& expected) {
    if (failed()) return;
    error_ =
        (path_.empty() ? "the message" : path_) + " is " + Shown(value) + "; expected " + expected;
  }

  template <class T>
  void Put(const T& value) {
    size_ += sizeof(T);
    if (size_ > MessageJson::kMostWritten && !failed()) {
      error_ = "it has more than " + std::to_string(MessageJson::kMostWritten) + " bytes";
    }
    if (!failed()) writer_.Put(value);
  }

  void Message(std::size_t type, const Json* value) {
    const std::vector<MessageField>& fields = layout_.types[type];
    if (value != nullptr && !value->is_object()) return Refuse(*value, "an object");
    if (value != nullptr) RefuseUnknown(fields, *value);
    if (fields.empty()) Put(std::uint8_t{0});
    const std::size_t outer = path_.size();
    for (const MessageField& field : fields) {
      if (failed()) return;
      path_ += (outer == 0 ? "" : ".") + field.name;
      const bool given = value != nullptr && value->contains(field.name);
      Field(field, given ? &value->at(field.name) : nullptr);
      path_.resize(outer);
    }
  }
  void RefuseUnknown(const std::vector<MessageField>& fields, const Json& object) {
    for (const auto& [name, unused] : object.items()) {
      if (std::ranges::find(fields, name, &MessageField::name) != fields.end()) continue;
      std::string names;
      for (const MessageField& field : fields) names += (names.empty() ? "" : ", ") + field.name;
      if (!failed()) {
        error_ = (path_.empty() ? "the message" : path_) + " has no field " + Shown(Json(name)) +
                 "; its fields: " + (names.empty() ? "none" : names);
      }
      return;
    }
  }

  void Field(const MessageField& field, const Json* value) {
    if (!field.sequence && field.length == 0) return One(field, value);
    if (value != nullptr && !value->is_array()) {
      const bool cut = value->is_object() && value->contains("bytes");
      return Refuse(*value,
                    cut ? "an array: the bytes were left out when it became JSON" : "an array");
    }
    if (value != nullptr && !field.sequence && value->size() != field.length) {
      return Refuse(*value, "an array of " + std::to_string(field.length));
    }
    const std::size_t given = value == nullptr ? 0 : value->size();
    const std::size_t count = field.sequence ? given : field.length;
    if (field.sequence) Put(static_cast<std::uint32_t>(count));
    const std::size_t outer = path_.size();
    for (std::size_t i = 0; i < count && !failed(); ++i) {
      path_ += "[" + std::to_string(i) + "]";
      One(field, value == nullptr ? nullptr : &(*value)[i]);
      path_.resize(outer);
    }
  }

  template <class T>
  void Integer(const Json* value) {
    if (value == nullptr) return Put(T{0});
    const std::optional<T> number = IntegerOf<T>(*value);
    if (number) return Put(*number);
    Refuse(*value, "an integer from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
                       std::to_string(std::numeric_limits<T>::max()));
  }
  template <class T>
  void Real(const Json* value) {
    if (value == nullptr) return Put(T{0});
    const std::optional<T> number = RealOf<T>(*value);
    if (number) return Put(*number);
    Refuse(*value,
           sizeof(T) == sizeof(float) ? "a number of a float32, or null" : "a number or null");
  }
  void Bool(const Json* value) {
    if (value == nullptr) return Put(false);
    if (!value->is_boolean()) return Refuse(*value, "true or false");
    Put(value->get<bool>());
  }
  void Text(const Json* value) {
    if (value == nullptr) return Put(std::string());
    if (!value->is_string()) return Refuse(*value, "a text");
    Put(value->get_ref<const std::string&>());
  }
  void One(const MessageField& field, const Json* value) {
    switch (field.kind) {
      case FieldKind::kBool:
        return Bool(value);
      case FieldKind::kInt8:
        return Integer<std::int8_t>(value);
      case FieldKind::kUint8:
        return Integer<std::uint8_t>(value);
      case FieldKind::kInt16:
        return Integer<std::int16_t>(value);
      case FieldKind::kUint16:
        return Integer<std::uint16_t>(value);
      case FieldKind::kInt32:
        return Integer<std::int32_t>(value);
      case FieldKind::kUint32:
        return Integer<std::uint32_t>(value);
      case FieldKind::kInt64:
        return Integer<std::int64_t>(value);
      case FieldKind::kUint64:
        return Integer<std::uint64_t>(value);
      case FieldKind::kFloat32:
        return Real<float>(value);
      case FieldKind::kFloat64:
        return Real<double>(value);
      case FieldKind::kString:
        return Text(value);
      case FieldKind::kMessage:
        return Message(field.type, value);
    }
  }

  const MessageLayout& layout_;
  msg::CdrWriter writer_;
  std::string path_;  // of the field that is written: "actuators[1].name"
  std::string error_;
  std::size_t size_ = 0;  // of what is written, nearly
};

// The parser's exceptions know where the text ends to be JSON.
Result<Json> Parse(std::string_view text) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    return Error{kCodeParametersInvalid,
                 "the text is not JSON at byte " + std::to_string(error.byte)};
  } catch (const Json::exception&) {
    return Error{kCodeParametersInvalid, "the text has a number that is too large"};
  }
}

}  // namespace

Result<msg::Bytes> MessageJson::FromJson(std::string_view dds_type, std::string_view text) {
  const MessageLayout* layout = LayoutOf(dds_type);
  if (layout == nullptr) return UnknownType(dds_type);
  const std::string what = "a message " + std::string(dds_type);
  if (text.size() > kMostText) {
    return Error{kCodeParametersInvalid, what + " of " + std::to_string(text.size()) +
                                             " bytes as JSON; at most " +
                                             std::to_string(kMostText) + " are read"};
  }
  const Result<Json> object = Parse(text);
  if (!object) return Error{object.error().code, what + ": " + object.error().message};
  Encoder encoder(*layout);
  encoder.Write(object.value());
  if (!encoder.error().empty()) {
    return Error{kCodeParametersInvalid, what + ": " + encoder.error()};
  }
  return std::move(encoder).Take();
}

}  // namespace musher::view
