#pragma once
// Named values: the parameters of a skill, its data, and the details of its feedback. Plain values;
// the unit of each is part of its name or of the text that declares it.

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::skill {

using Numbers = std::vector<double>;
using Value = std::variant<bool, std::int64_t, double, std::string, Numbers>;

// In the order of Value.
enum class Kind : std::uint8_t { kBool, kInteger, kNumber, kText, kNumbers };
std::string_view Name(Kind kind);  // "true or false", "an integer", ...
Kind KindOf(const Value& value);

// `value` as that kind: an integer is also a number. Fails for another kind, for a number that is
// infinite or not a number, with the expected kind.
Result<Value> As(Kind kind, const Value& value);
// "2.5", "true", "[10, 20, 0]", "car"; a text may stand in quotation marks. Fails with the expected
// kind.
Result<Value> Parse(Kind kind, std::string_view text);
// The text that Parse() reads.
std::string ToText(const Value& value);

class Values {
 public:
  struct Named {
    std::string name;
    Value value;
    friend bool operator==(const Named&, const Named&) = default;
  };

  Values() = default;
  Values(std::initializer_list<Named> values) : values_(values) {}

  // Null: it has no such value.
  const Value* Find(std::string_view name) const;
  // The value, or `otherwise` where it is missing or has another type.
  template <class T>
  T Get(std::string_view name, T otherwise) const {
    const Value* found = Find(name);
    const T* value = found == nullptr ? nullptr : std::get_if<T>(found);
    return value == nullptr ? otherwise : *value;
  }
  double Number(std::string_view name) const { return Get<double>(name, 0); }
  std::string Text(std::string_view name) const { return Get<std::string>(name, ""); }

  void Set(std::string_view name, Value value);
  void Remove(std::string_view name);
  void Clear() { values_.clear(); }

  bool empty() const { return values_.empty(); }
  auto begin() const { return values_.begin(); }  // in the order in which they were set
  auto end() const { return values_.end(); }

  friend bool operator==(const Values&, const Values&) = default;

 private:
  std::vector<Named> values_;
};

}  // namespace musher::skill
