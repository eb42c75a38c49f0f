#include "musher/controller/journal/encoding.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "musher/lifecycle/field.hpp"

namespace musher::fields {

template <>
inline constexpr std::tuple kFields<recording::ConfigText> = {
    Field{"file", &recording::ConfigText::file},
    Field{"hash", &recording::ConfigText::hash},
    Field{"text", &recording::ConfigText::text},
};
template <>
inline constexpr std::tuple kFields<recording::MachineSnapshot> = {
    Field{"config_hash", &recording::MachineSnapshot::config_hash},
    Field{"machine", &recording::MachineSnapshot::machine},
};

}  // namespace musher::fields

namespace musher::recording {
namespace {

using fields::Base;
using fields::Field;
using fields::kEventName;
using fields::kFields;
using fields::kIsComplete;
using fields::kValueNames;
using fields::Part;
using fields::Struct;

using OrderedJson = nlohmann::ordered_json;  // keys in the order they are written here

template <class T>
concept Whole = std::is_integral_v<T> && !std::is_same_v<T, bool>;
template <class T>
concept Enumeration = std::is_enum_v<T>;

constexpr const char* kHex = "hex";
constexpr std::string_view kDigits = "0123456789abcdef";

// Writes values as JSON. `texts_as_hex`: for all texts.
class Writer {
 public:
  explicit Writer(bool texts_as_hex) : texts_as_hex_(texts_as_hex) {}

  OrderedJson Of(bool value) const { return value; }
  template <Whole T>
  OrderedJson Of(T value) const {
    return value;
  }
  template <typename Kind>
  OrderedJson Of(StrongNumber<Kind> number) const {
    return number.value();
  }
  OrderedJson Of(const std::string& text) const {
    if (!texts_as_hex_) return text;
    std::string hex;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      hex += {kDigits[byte >> 4], kDigits[byte & 0xf]};
    }
    return OrderedJson{{kHex, hex}};
  }
  OrderedJson Of(const State& state) const { return Of(state.name()); }
  template <Enumeration T>
  OrderedJson Of(T value) const {
    const auto number = static_cast<std::size_t>(value);
    if (number < kValueNames<T>.size()) return kValueNames<T>[number];
    return number;
  }
  OrderedJson Of(Duration value) const { return value.count(); }
  OrderedJson Of(Time value) const { return Of(Duration(value.time_since_epoch())); }
  template <class T>
  OrderedJson Of(const std::optional<T>& value) const {
    return value ? Of(*value) : OrderedJson();
  }
  template <class T>
  OrderedJson Of(const std::vector<T>& items) const {
    return ListOf<T>(items);
  }
  template <class T>
  OrderedJson Of(const PerActuator<T>& items) const {
    return ListOf<T>(items);
  }
  template <Struct T>
  OrderedJson Of(const T& value) const {
    OrderedJson json = OrderedJson::object();
    AddFields(json, value);
    return json;
  }

  template <Struct T>
  void AddFields(OrderedJson& json, const T& value) const {
    static_assert(kIsComplete<T>, "kFields, at the end of its header, has to name every member");
    std::apply([&](const auto&... fields) { (Add(json, value, fields), ...); }, kFields<T>);
  }

 private:
  template <class T, class M>
  void Add(OrderedJson& json, const T& value, const Field<T, M>& field) const {
    static const T otherwise{};
    if (value.*field.member == otherwise.*field.member) return;
    json[field.name] = Of(value.*field.member);
  }
  template <class T, class M>
  void Add(OrderedJson& json, const T& value, const Part<T, M>& part) const {
    AddFields(json, value.*part.member);
  }
  template <class T, class B>
  void Add(OrderedJson& json, const T& value, const Base<B>& /*base*/) const {
    AddFields(json, static_cast<const B&>(value));
  }

  template <class T, class Items>
  OrderedJson ListOf(const Items& items) const {
    OrderedJson list = OrderedJson::array();
    for (const T& item : items) list.push_back(Of(item));
    return list;
  }

  bool texts_as_hex_;
};

// Why a text cannot be decoded.
struct Fault {
  std::string message;
};

// Reads values from JSON; throws Fault with the path of the value.
class Reader {
 public:
  template <class T>
  void Take(const OrderedJson& json, T& value) const {
    Read(json, value);
  }

  template <Struct T>
  void TakeFields(const OrderedJson& json, T& value) const {
    if (!json.is_object()) Fail("an object", json);
    std::apply([&](const auto&... fields) { (TakeOne(json, value, fields), ...); }, kFields<T>);
  }

  Reader At(const std::string& name) const {
    return Reader(path_.empty() ? name : path_ + "." + name);
  }

  [[noreturn]] void Fail(const std::string& expected, const OrderedJson& found) const {
    throw Fault{(path_.empty() ? "" : path_ + ": ") + "expected " + expected + ", found " +
                found.dump(-1, ' ', false, OrderedJson::error_handler_t::replace).substr(0, 60)};
  }

  Reader() = default;

 private:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  template <class T, class M>
  void TakeOne(const OrderedJson& json, T& value, const Field<T, M>& field) const {
    const auto found = json.find(field.name);
    if (found != json.end()) At(field.name).Read(*found, value.*field.member);
  }
  template <class T, class M>
  void TakeOne(const OrderedJson& json, T& value, const Part<T, M>& part) const {
    TakeFields(json, value.*part.member);
  }
  template <class T, class B>
  void TakeOne(const OrderedJson& json, T& value, const Base<B>& /*base*/) const {
    TakeFields(json, static_cast<B&>(value));
  }

  void Read(const OrderedJson& json, bool& value) const {
    if (!json.is_boolean()) Fail("true or false", json);
    value = json.get<bool>();
  }
  template <Whole T>
  void Read(const OrderedJson& json, T& value) const {
    const bool fits = json.is_number_unsigned()
                          ? std::in_range<T>(json.get<std::uint64_t>())
                          : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
    if (!fits) Fail("a whole number that fits", json);
    value = json.get<T>();
  }
  template <typename Kind>
  void Read(const OrderedJson& json, StrongNumber<Kind>& number) const {
    std::uint64_t value = 0;
    Read(json, value);
    number = StrongNumber<Kind>(value);
  }
  void Read(const OrderedJson& json, std::string& text) const {
    if (json.is_string()) {
      text = json.get<std::string>();
      return;
    }
    const auto hex = json.is_object() ? json.find(kHex) : json.end();
    if (hex == json.end() || !hex->is_string() || json.size() != 1) Fail("a text", json);
    const auto& digits = hex->get_ref<const std::string&>();
    if (digits.size() % 2 != 0 || digits.find_first_not_of(kDigits) != std::string::npos) {
      Fail("pairs of hex digits", *hex);
    }
    text.clear();
    for (std::size_t i = 0; i < digits.size(); i += 2) {
      text += static_cast<char>(kDigits.find(digits[i]) << 4 | kDigits.find(digits[i + 1]));
    }
  }
  void Read(const OrderedJson& json, State& state) const {
    std::string name;
    Read(json, name);
    state = State(std::move(name));
  }
  template <Enumeration T>
  void Read(const OrderedJson& json, T& value) const {
    for (std::size_t i = 0; i < kValueNames<T>.size(); ++i) {
      if (json != kValueNames<T>[i]) continue;
      value = static_cast<T>(i);
      return;
    }
    std::string names;
    for (const std::string_view name : kValueNames<T>) names += ", " + std::string(name);
    Fail("one of" + names.substr(1), json);
  }
  void Read(const OrderedJson& json, Duration& value) const {
    std::int64_t count = 0;
    Read(json, count);
    if (count < -kFarthestNs || count > kFarthestNs) Fail("a time that can be computed with", json);
    value = Duration(count);
  }
  void Read(const OrderedJson& json, Time& value) const {
    Duration since{};
    Read(json, since);
    value = Time(since);
  }
  template <class T>
  void Read(const OrderedJson& json, std::optional<T>& value) const {
    value.emplace();
    Read(json, *value);
  }
  template <class T>
  void Read(const OrderedJson& json, std::vector<T>& items) const {
    ReadList<T>(json, items);
  }
  template <class T>
  void Read(const OrderedJson& json, PerActuator<T>& items) const {
    ReadList<T>(json, items);
  }
  template <class T, class Items>
  void ReadList(const OrderedJson& json, Items& items) const {
    if (!json.is_array()) Fail("a list", json);
    items = Items();
    for (std::size_t i = 0; i < json.size(); ++i) {
      T item{};
      Reader(path_ + "[" + std::to_string(i) + "]").Read(json[i], item);
      items.push_back(std::move(item));
    }
  }
  template <Struct T>
  void Read(const OrderedJson& json, T& value) const {
    TakeFields(json, value);
  }

  std::string path_;
};

// The text of the JSON that `make` makes with a Writer.
template <class Make>
std::string Encode(const Make& make) {
  try {
    return make(Writer(false)).dump();
  } catch (const OrderedJson::type_error&) {  // a text that is not UTF-8
    return make(Writer(true)).dump();
  }
}

template <class T, class Take>
Result<T> Decode(std::string_view text, const Take& take) {
  try {
    T value;
    take(OrderedJson::parse(text), value);
    return value;
  } catch (const OrderedJson::exception& e) {
    return Error{kCodeParametersInvalid, std::string("not JSON: ") + e.what()};
  } catch (const Fault& fault) {
    return Error{kCodeParametersInvalid, fault.message};
  }
}

template <std::size_t I = 0>
void TakeEvent(const OrderedJson& json, const std::string& name, Event& event) {
  if constexpr (I == std::variant_size_v<Event>) {
    throw Fault{"event: '" + name + "' is not known"};
  } else {
    using E = std::variant_alternative_t<I, Event>;
    static_assert(!kEventName<E>.empty(), "event.hpp has to name every event");
    if (name != kEventName<E>) return TakeEvent<I + 1>(json, name, event);
    Reader().TakeFields(json, event.emplace<E>());
  }
}

}  // namespace

std::string EncodeEvent(const Event& event, Time now) {
  return Encode([&](const Writer& writer) {
    return std::visit(
        [&]<class E>(const E& e) {
          OrderedJson json = {{"event", kEventName<E>}, {"now", writer.Of(now)}};
          writer.AddFields(json, e);
          return json;
        },
        event);
  });
}

Result<TimedEvent> DecodeEvent(std::string_view text) {
  return Decode<TimedEvent>(text, [](const OrderedJson& json, TimedEvent& value) {
    if (!json.is_object()) Reader().Fail("an object", json);
    std::string name;
    Reader().At("event").Take(json.value("event", OrderedJson()), name);
    Reader().At("now").Take(json.value("now", OrderedJson()), value.now);
    TakeEvent(json, name, value.event);
  });
}

std::string EncodeSnapshot(const MachineSnapshot& snapshot) {
  return Encode([&](const Writer& writer) { return writer.Of(snapshot); });
}

Result<MachineSnapshot> DecodeSnapshot(std::string_view text) {
  return Decode<MachineSnapshot>(text, [](const OrderedJson& json, MachineSnapshot& value) {
    Reader().TakeFields(json, value);
  });
}

std::string EncodeConfig(const ConfigText& config) {
  return Encode([&](const Writer& writer) { return writer.Of(config); });
}

Result<ConfigText> DecodeConfig(std::string_view text) {
  return Decode<ConfigText>(
      text, [](const OrderedJson& json, ConfigText& value) { Reader().TakeFields(json, value); });
}

}  // namespace musher::recording
