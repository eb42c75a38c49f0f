#pragma once
// A type of a robot as JSON, by the list of its fields:
//
//   template <>
//   struct musher::tree::Convert<Pallet> : musher::tree::JsonFields<Pallet> {
//     static constexpr std::string_view kName = "Pallet";  // in messages
//     static void Fields(auto& json, auto& pallet) {
//       json("x_m", pallet.x_m);
//       json("tags", pallet.tags);
//     }
//   };
//
// Then pallet='json:{"x_m": 1, "tags": ["a"]}' is a Pallet in XML, such a text in an entry is one,
// and people see an entry with a Pallet as JSON. A field is a number, bool or text, a vector of
// them, or a type with fields. All of them have to be there, and no other one.
//
// Threads: any; nothing is shared.

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/behavior/tree/convert.hpp"
#include "musher/behavior/tree/value.hpp"

namespace musher::tree {

namespace internal {

// Reads one JSON text; the first error stops it.
class JsonReader {
 public:
  explicit JsonReader(std::string_view json);
  ~JsonReader();
  JsonReader(const JsonReader&) = delete;
  JsonReader& operator=(const JsonReader&) = delete;

  template <class T>
  Result<T> Read() {
    T value{};
    ReadValue(value);
    if (!error_.empty()) return Error{kCodeFailed, error_};
    return value;
  }
  template <class F>
  void operator()(std::string_view field, F& value) {
    if (!Enter(field)) return;
    ReadValue(value);
    Leave();
  }

 private:
  template <class F>
  void ReadValue(F& value) {
    if constexpr (requires { Convert<F>::Fields(*this, value); }) {
      if (!BeginObject()) return;
      Convert<F>::Fields(*this, value);
      EndObject();
    } else if constexpr (requires { typename F::value_type; } && !std::same_as<F, std::string>) {
      const std::size_t size = BeginArray();
      value.clear();
      for (std::size_t i = 0; i < size; ++i) {
        EnterItem(i);
        typename F::value_type item{};
        ReadValue(item);
        Leave();
        value.push_back(std::move(item));
      }
    } else if constexpr (std::same_as<F, std::string>) {
      ReadText(value);
    } else if constexpr (std::same_as<F, bool>) {
      ReadBool(value);
    } else if constexpr (std::integral<F>) {
      if constexpr (std::unsigned_integral<F> && sizeof(F) == sizeof(std::uint64_t)) {
        std::uint64_t large = 0;
        if (ReadUnsigned(large)) {
          value = large;
          return;
        }
      }
      std::int64_t whole = 0;
      if (!ReadWhole(whole)) return;
      if (!std::in_range<F>(whole)) return Expect(Convert<F>::kName);
      value = static_cast<F>(whole);
    } else {
      double number = 0;
      if (!ReadNumber(number)) return;
      if constexpr (std::floating_point<F>) {
        const auto most = static_cast<double>(std::numeric_limits<F>::max());
        if (!(std::abs(number) <= most)) return Expect("a number that a float can have");
      }
      if (!Fits<F>(number)) return Expect("a number of the enum");
      value = static_cast<F>(number);
    }
  }

  bool Enter(std::string_view field);
  void EnterItem(std::size_t index);
  void Leave();
  bool BeginObject();
  void EndObject();
  std::size_t BeginArray();
  void ReadText(std::string& value);
  void ReadBool(bool& value);
  bool ReadNumber(double& value);
  bool ReadWhole(std::int64_t& value);
  // False: it is negative, has a point, or is no number.
  bool ReadUnsigned(std::uint64_t& value);
  void Expect(std::string_view what);
  void Fail(const std::string& why);

  struct State;
  std::unique_ptr<State> state_;
  std::string error_;
};

class JsonWriter {
 public:
  template <class T>
  std::string Write(const T& value) && {
    WriteValue(value);
    return std::move(text_);
  }
  template <class F>
  void operator()(std::string_view field, const F& value) {
    if (text_.back() != '{') text_ += ',';
    WriteText(field);
    text_ += ':';
    WriteValue(value);
  }

 private:
  template <class F>
  void WriteValue(const F& value) {
    if constexpr (requires { Convert<F>::Fields(*this, value); }) {
      text_ += '{';
      Convert<F>::Fields(*this, value);
      text_ += '}';
    } else if constexpr (std::same_as<F, std::string>) {
      WriteText(value);
    } else if constexpr (requires { typename F::value_type; }) {
      text_ += '[';
      for (const auto& item : value) {
        if (text_.back() != '[') text_ += ',';
        WriteValue(static_cast<const typename F::value_type&>(item));
      }
      text_ += ']';
    } else if constexpr (std::same_as<F, bool>) {
      text_ += value ? "true" : "false";
    } else if constexpr (std::integral<F>) {
      text_ += std::to_string(value);
    } else {
      WriteNumber(static_cast<double>(value));
    }
  }
  void WriteText(std::string_view text);
  void WriteNumber(double number);

  std::string text_;
};

}  // namespace internal

template <class T>
struct JsonFields {
  static Result<T> FromJson(std::string_view json) {
    return internal::JsonReader(json).template Read<T>();
  }
  static std::string ToJson(const T& value) { return internal::JsonWriter().Write(value); }
};

}  // namespace musher::tree
