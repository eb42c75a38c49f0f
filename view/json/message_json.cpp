#include "musher/view/json/message_json.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "musher/messages/cdr.hpp"
#include "musher/view/json/json.hpp"
#include "musher/view/json/message_layout.hpp"

namespace musher::view {
namespace {

template <class T>
OrderedJson JsonOf(T value) {
  if constexpr (std::is_same_v<T, float>) {
    if (!std::isfinite(value)) return nullptr;
    // 0.1, not 0.10000000149011612
    std::array<char, 32> text{};
    *std::to_chars(text.data(), text.data() + text.size() - 1, value).ptr = '\0';
    return std::strtod(text.data(), nullptr);
  } else if constexpr (std::is_same_v<T, double>) {
    if (!std::isfinite(value)) return nullptr;
    return value;
  } else if constexpr (sizeof(T) == 8) {
    constexpr T kMost = T{1} << 53;
    if (value > kMost || (std::is_signed_v<T> && value < T{0} - kMost)) {
      return std::to_string(value);
    }
    return value;
  } else {
    return value;
  }
}

class Conversion {
 public:
  Conversion(const MessageLayout& layout, std::span<const std::byte> cdr)
      : layout_(layout), reader_(cdr) {}

  OrderedJson Read() {
    if (layout_.envelope) Skip<msg::RequestId>();
    const std::vector<MessageField>& fields = layout_.types.front();
    OrderedJson object = OrderedJson::object();
    if (fields.empty() && !layout_.envelope) Skip<std::uint8_t>();
    for (std::size_t i = 0; i < fields.size() && ok(); ++i) {
      if (i + layout_.appended >= fields.size() && AtEnd(fields[i])) break;
      object[fields[i].name] = Value(fields[i]);
    }
    return object;
  }
  bool ok() const { return reader_.ok() && !too_long(); }
  // The text would be longer than kMostText. Known before all values are in memory: they take a
  // multiple of the message's bytes.
  bool too_long() const { return least_ > MessageJson::kMostText; }

 private:
  template <class T>
  T Get() {
    T value{};
    reader_.Get(value);
    least_ += 2;  // a digit and a comma
    return value;
  }
  std::string GetText() {
    auto text = Get<std::string>();
    least_ += text.size();
    return text;
  }
  template <class T>
  void Skip() {
    Get<T>();
  }
  // Whether an older peer has sent nothing of this field; padding is nothing.
  bool AtEnd(const MessageField& field) const {
    msg::CdrReader probe = reader_;
    if (field.sequence || field.kind == FieldKind::kString) return !Has<std::uint32_t>(probe);
    switch (field.kind) {
      case FieldKind::kInt16:
      case FieldKind::kUint16:
        return !Has<std::uint16_t>(probe);
      case FieldKind::kInt32:
      case FieldKind::kUint32:
      case FieldKind::kFloat32:
        return !Has<std::uint32_t>(probe);
      case FieldKind::kInt64:
      case FieldKind::kUint64:
      case FieldKind::kFloat64:
        return !Has<std::uint64_t>(probe);
      default:
        return !Has<std::uint8_t>(probe);
    }
  }
  template <class T>
  static bool Has(msg::CdrReader& probe) {
    T value{};
    probe.Get(value);
    return probe.ok();
  }

  OrderedJson Value(const MessageField& field) {
    if (!field.sequence && field.length == 0) return One(field);
    if (field.sequence && (field.kind == FieldKind::kUint8 || field.kind == FieldKind::kInt8)) {
      return Block(field.kind == FieldKind::kInt8);
    }
    const std::size_t count = field.sequence ? Get<std::uint32_t>() : field.length;
    OrderedJson items = OrderedJson::array();
    for (std::size_t i = 0; i < count && ok(); ++i) items.push_back(One(field));
    return items;
  }
  OrderedJson Block(bool is_signed) {
    const auto bytes = Get<std::vector<std::uint8_t>>();
    if (bytes.size() > MessageJson::kMostBytes) return {{"bytes", bytes.size()}};
    OrderedJson items = OrderedJson::array();
    for (const std::uint8_t byte : bytes) {
      items.push_back(is_signed ? static_cast<std::int8_t>(byte) : int{byte});
    }
    return items;
  }
  OrderedJson One(const MessageField& field) {
    switch (field.kind) {
      case FieldKind::kBool:
        return Get<bool>();
      case FieldKind::kInt8:
        return JsonOf(Get<std::int8_t>());
      case FieldKind::kUint8:
        return JsonOf(Get<std::uint8_t>());
      case FieldKind::kInt16:
        return JsonOf(Get<std::int16_t>());
      case FieldKind::kUint16:
        return JsonOf(Get<std::uint16_t>());
      case FieldKind::kInt32:
        return JsonOf(Get<std::int32_t>());
      case FieldKind::kUint32:
        return JsonOf(Get<std::uint32_t>());
      case FieldKind::kInt64:
        return JsonOf(Get<std::int64_t>());
      case FieldKind::kUint64:
        return JsonOf(Get<std::uint64_t>());
      case FieldKind::kFloat32:
        return JsonOf(Get<float>());
      case FieldKind::kFloat64:
        return JsonOf(Get<double>());
      case FieldKind::kString:
        return GetText();
      case FieldKind::kMessage:
        return Nested(field.type);
    }
    return nullptr;
  }
  OrderedJson Nested(std::size_t type) {
    const std::vector<MessageField>& fields = layout_.types[type];
    OrderedJson object = OrderedJson::object();
    if (fields.empty()) Skip<std::uint8_t>();
    for (const MessageField& field : fields) {
      if (!ok()) break;
      least_ += field.name.size();
      object[field.name] = Value(field);
    }
    return object;
  }

  const MessageLayout& layout_;
  msg::CdrReader reader_;
  std::size_t least_ = 0;  // the text has at least so many bytes
};

}  // namespace

MessageJson::MessageJson() = default;
MessageJson::~MessageJson() = default;

const MessageLayout* MessageJson::LayoutOf(std::string_view dds_type) {
  const auto known = layouts_.find(dds_type);
  if (known != layouts_.end()) return known->second.get();
  const msg::MessageDefinition* definition = msg::FindDefinition(dds_type);
  if (definition == nullptr) return nullptr;
  auto layout = std::make_unique<const MessageLayout>(view::LayoutOf(*definition));
  return layouts_.emplace(dds_type, std::move(layout)).first->second.get();
}

Error MessageJson::UnknownType(std::string_view dds_type) {
  return {kCodeParametersInvalid, "Musher does not know the type " + std::string(dds_type)};
}

Result<std::string> MessageJson::ToJson(std::string_view dds_type, std::span<const std::byte> cdr) {
  const MessageLayout* layout = LayoutOf(dds_type);
  if (layout == nullptr) return UnknownType(dds_type);
  Conversion conversion(*layout, cdr);
  const OrderedJson object = conversion.Read();
  const auto too_long = [&] {
    return Error{kCodeParametersInvalid, "a message " + std::string(dds_type) + " of more than " +
                                             std::to_string(kMostText) +
                                             " bytes as JSON; so many are sent at most"};
  };
  if (conversion.too_long()) return too_long();
  if (!conversion.ok()) {
    return Error{kCodeParametersInvalid,
                 std::to_string(cdr.size()) + " bytes are not a message " + std::string(dds_type)};
  }
  std::string text = Dumped(object);
  if (text.size() > kMostText) return too_long();
  return text;
}

}  // namespace musher::view
