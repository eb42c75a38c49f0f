#pragma once
// A value of any copyable type, as an entry of a blackboard holds it. A type of up to 32 bytes lies
// inside. Setting a value of the type that is already there assigns: it allocates nothing of its
// own.

#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "musher/behavior/tree/convert.hpp"

namespace musher::tree {

// What a value can do without knowing its type. Null: it can not.
struct Type {
  std::string_view name;
  void (*copy)(void* to, const void* from) = nullptr;    // into raw room
  void (*assign)(void* to, const void* from) = nullptr;  // to a value of the type
  void (*destroy)(void* value) = nullptr;
  bool (*to_number)(const void* value, double& number) = nullptr;
  bool (*from_number)(void* room, double number) = nullptr;  // into raw room; false: does not fit
  Result<> (*from_text)(void* room, std::string_view text) = nullptr;
  Result<> (*from_json)(void* room, std::string_view json) = nullptr;
  std::string (*to_json)(const void* value) = nullptr;
  const Type* base = nullptr;                                // of pointers to its base class
  void (*to_base)(void* room, const void* value) = nullptr;  // into raw room
};

// Whether each value of `type` is one of `base`.
bool DerivesFrom(const Type& type, const Type& base);
// The nearest type that both derive from; null: there is none.
const Type* CommonBase(const Type& a, const Type& b);

// A whole number within T, or any for a floating-point type.
template <Numeric T>
bool Fits(double number) {
  if constexpr (std::is_enum_v<T>) {
    return Fits<std::underlying_type_t<T>>(number);
  } else if constexpr (std::is_floating_point_v<T> || std::same_as<T, bool>) {
    return true;
  } else {
    return std::trunc(number) == number &&
           number >= static_cast<double>(std::numeric_limits<T>::min()) &&
           number < std::ldexp(1.0, std::numeric_limits<T>::digits);
  }
}

namespace internal {

template <class T>
constexpr std::string_view TypeName() {
  if constexpr (requires { Convert<T>::kName; }) {
    return Convert<T>::kName;
  } else {
    constexpr std::string_view kMark = "T = ";
    std::string_view name = __PRETTY_FUNCTION__;
    name.remove_prefix(name.find(kMark) + kMark.size());
    return name.substr(0, name.find_first_of(";]"));
  }
}

inline constexpr std::size_t kRoom = 32;
inline constexpr std::size_t kRoomAlignment = alignof(std::max_align_t);
constexpr bool FitsInside(std::size_t size, std::size_t alignment) {
  return size <= kRoom && alignment <= kRoomAlignment;
}

template <class T>
struct Room {
  static constexpr bool kInside = FitsInside(sizeof(T), alignof(T));

  static T& At(void* room) {
    if constexpr (kInside) {
      return *std::launder(static_cast<T*>(room));
    } else {
      return **static_cast<T**>(room);
    }
  }
  static const T& At(const void* room) { return At(const_cast<void*>(room)); }
  template <class... Args>
  static void Make(void* room, Args&&... args) {
    if constexpr (kInside) {
      new (room) T(std::forward<Args>(args)...);
    } else {
      *static_cast<T**>(room) = new T(std::forward<Args>(args)...);
    }
  }
};

template <class T>
constexpr Type MakeType();
template <class T>
inline constexpr Type kType = MakeType<T>();

template <class T>
constexpr Type MakeType() {
  using In = Room<T>;
  Type type{.name = TypeName<T>(),
            .copy = [](void* to, const void* from) { In::Make(to, In::At(from)); },
            .assign = [](void* to, const void* from) { In::At(to) = In::At(from); },
            .destroy =
                [](void* value) {
                  if constexpr (In::kInside) {
                    In::At(value).~T();
                  } else {
                    delete &In::At(value);
                  }
                }};
  if constexpr (Numeric<T>) {
    type.to_number = [](const void* value, double& number) {
      number = static_cast<double>(In::At(value));
      return true;
    };
    type.from_number = [](void* room, double number) {
      if (!Fits<T>(number)) return false;
      In::Make(room, static_cast<T>(number));
      return true;
    };
  }
  if constexpr (HasText<T>) {
    type.from_text = [](void* room, std::string_view text) -> Result<> {
      Result<T> value = Convert<T>::FromText(text);
      if (!value) return value.error();
      In::Make(room, std::move(value).value());
      return Ok();
    };
  }
  if constexpr (HasJson<T>) {
    type.from_json = [](void* room, std::string_view json) -> Result<> {
      Result<T> value = Convert<T>::FromJson(json);
      if (!value) return value.error();
      In::Make(room, std::move(value).value());
      return Ok();
    };
    type.to_json = [](const void* value) { return Convert<T>::ToJson(In::At(value)); };
  }
  if constexpr (HasBase<T>) {
    using Base = typename Convert<T>::Base;
    type.base = &kType<Base>;
    type.to_base = [](void* room, const void* value) { Room<Base>::Make(room, In::At(value)); };
  }
  return type;
}

}  // namespace internal

template <class T>
constexpr const Type* TypeOf() {
  return &internal::kType<T>;
}

class Value {
 public:
  Value() = default;
  Value(const Value& other) { *this = other; }
  Value& operator=(const Value& other);
  ~Value() { Clear(); }

  bool empty() const { return type_ == nullptr; }
  const Type* type() const { return type_; }  // null: empty
  void Clear() {
    if (type_ != nullptr) type_->destroy(room_);
    type_ = nullptr;
  }

  template <class T>
  const T* As() const {  // null: empty, or of another type
    return type_ == TypeOf<T>() ? &internal::Room<T>::At(room_) : nullptr;
  }
  template <class T>
  T* As() {
    return type_ == TypeOf<T>() ? &internal::Room<T>::At(room_) : nullptr;
  }
  template <class T>
  void Set(const T& value) {
    if (type_ == TypeOf<T>()) {
      internal::Room<T>::At(room_) = value;
      return;
    }
    Clear();
    internal::Room<T>::Make(room_, value);
    type_ = TypeOf<T>();
  }
  void SetText(std::string_view text);  // within the capacity of the text that is there

  bool ToNumber(double& number) const {
    return type_ != nullptr && type_->to_number != nullptr && type_->to_number(room_, number);
  }
  const std::string* Text() const { return As<std::string>(); }

  // This value as a text for people; a value without one gives its type.
  std::string Shown() const;
  // As JSON. Nothing: its type has none.
  std::optional<std::string> Json() const;

  // Becomes `other` as a value of `type`: a number or text is converted, the same type is copied, a
  // pointer becomes one to its base class.
  Result<> SetAs(const Type& type, const Value& other);
  Result<> SetNumberAs(const Type& type, double number);
  Result<> SetTextAs(const Type& type, std::string_view text);

 private:
  const Type* type_ = nullptr;
  alignas(internal::kRoomAlignment) std::byte room_[internal::kRoom];
};

// A number for people and for texts: "3", "0.5".
std::string NumberText(double number);

}  // namespace musher::tree
