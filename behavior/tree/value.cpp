#include "musher/behavior/tree/value.hpp"

#include <array>

namespace musher::tree {
namespace {

std::string JsonExpected(const Type& type) {
  return std::string(type.name) + " as JSON, such as json:{...}";
}

constexpr double kWholeNumbers = 0x1p63;  // below it a number may be a 64-bit integer

}  // namespace

bool DerivesFrom(const Type& type, const Type& base) {
  const Type* at = &type;
  while (at != nullptr && at != &base) at = at->base;
  return at != nullptr;
}

const Type* CommonBase(const Type& a, const Type& b) {
  const Type* at = &a;
  while (at != nullptr && !DerivesFrom(b, *at)) at = at->base;
  return at;
}

Value& Value::operator=(const Value& other) {
  if (this == &other) return *this;
  if (type_ == other.type_) {
    if (type_ != nullptr) type_->assign(room_, other.room_);
    return *this;
  }
  Clear();
  if (other.type_ != nullptr) other.type_->copy(room_, other.room_);
  type_ = other.type_;
  return *this;
}

void Value::SetText(std::string_view text) {
  if (auto* present = As<std::string>()) {
    present->assign(text);
  } else {
    Set(std::string(text));
  }
}

std::string Value::Shown() const {
  if (empty()) return "nothing";
  if (const auto* text = Text()) return "'" + *text + "'";
  if (const auto* truth = As<bool>()) return *truth ? "true" : "false";
  if (const auto* status = As<Status>()) return std::string(Name(*status));
  if (const auto json = Json()) return *json;
  double number = 0;
  return ToNumber(number) ? NumberText(number) : std::string(type_->name);
}

std::optional<std::string> Value::Json() const {
  if (type_ == nullptr || type_->to_json == nullptr) return std::nullopt;
  return type_->to_json(room_);
}

Result<> Value::SetAs(const Type& type, const Value& other) {
  double number = 0;
  if (other.type_ == &type) {
    *this = other;
    return Ok();
  }
  if (other.type_ != nullptr && DerivesFrom(*other.type_, type)) {
    Value pointer = other;
    while (pointer.type_ != &type) {
      Value base;
      pointer.type_->to_base(base.room_, pointer.room_);
      base.type_ = pointer.type_->base;
      pointer = base;
    }
    *this = pointer;
    return Ok();
  }
  if (const auto* text = other.Text()) return SetTextAs(type, *text);
  if (other.ToNumber(number)) return SetNumberAs(type, number);
  return Error{kCodeFailed, "a value of type " +
                                std::string(other.empty() ? "nothing" : other.type_->name) +
                                " is not of type " + std::string(type.name)};
}

Result<> Value::SetNumberAs(const Type& type, double number) {
  if (&type == TypeOf<double>()) {
    Set(number);
    return Ok();
  }
  if (&type == TypeOf<std::string>()) {
    SetText(NumberText(number));
    return Ok();
  }
  // A number needs no memory of its own, so the room can be written again.
  const bool reuse = type_ == &type && type.from_number != nullptr;
  if (type.from_number != nullptr && !reuse) Clear();
  if (type.from_number == nullptr || !type.from_number(room_, number)) {
    return Error{kCodeFailed,
                 NumberText(number) + " is not valid: expected " + std::string(type.name)};
  }
  type_ = &type;
  return Ok();
}

Result<> Value::SetTextAs(const Type& type, std::string_view text) {
  if (&type == TypeOf<std::string>()) {
    SetText(text);
    return Ok();
  }
  const auto json = type.from_json == nullptr ? std::nullopt : JsonIn(text);
  if (type.from_text == nullptr && !json) {
    if (type.from_json != nullptr) return NoValue(text, JsonExpected(type));
    return Error{kCodeFailed, "type " + std::string(type.name) +
                                  " has no conversion from a text (Convert<T>::FromText)"};
  }
  Value made;
  Result<> read = json ? type.from_json(made.room_, *json) : type.from_text(made.room_, text);
  if (!read) return read;
  made.type_ = &type;
  *this = made;
  return Ok();
}

std::string NumberText(double number) {
  std::array<char, 40> room{};
  // "100000" instead of "1e+05".
  const bool whole = std::trunc(number) == number && std::abs(number) < kWholeNumbers;
  const double shown = number == 0 ? 0 : number;  // not "-0"
  const auto [end, code] =
      whole ? std::to_chars(room.data(), room.data() + room.size(), shown, std::chars_format::fixed)
            : std::to_chars(room.data(), room.data() + room.size(), shown);
  return code == std::errc() ? std::string(room.data(), end) : "?";
}

}  // namespace musher::tree
