#pragma once
// Checks of what the code itself guarantees, in every build: a failed one is a fault of Musher, or
// of a caller that ignores a documented condition. The process ends (SIGABRT) and prints the place,
// the condition and the given values; what can fail from outside is a Result instead.
//
//   MUSHER_CHECK(period > Duration::zero(), "period", period.count());

#include <string>
#include <string_view>
#include <type_traits>

// The condition is evaluated once, the values only when it is false.
#define MUSHER_CHECK(condition, ...)                                   \
  (static_cast<bool>(condition)                                        \
       ? static_cast<void>(0)                                          \
       : ::musher::internal::FailCheck(#condition, __FILE__, __LINE__, \
                                       ::musher::internal::CheckValues(__VA_ARGS__)))

namespace musher {

// While it exists, adds what the thread is doing to the message of a failed check: "seed 42".
class CheckContext {
 public:
  explicit CheckContext(std::string what);
  ~CheckContext();
  CheckContext(const CheckContext&) = delete;
  CheckContext& operator=(const CheckContext&) = delete;

 private:
  friend std::string CheckContexts();
  std::string what_;
  const CheckContext* outer_;
};

namespace internal {

template <typename T>
std::string CheckValue(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::to_string(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (std::is_arithmetic_v<T>) {
    return std::to_string(value);
  } else {
    return std::string(value);
  }
}

template <typename... Values>
std::string CheckValues(const Values&... values) {
  std::string text;
  ((text += (text.empty() ? "" : " ") + CheckValue(values)), ...);
  return text;
}

[[noreturn]] void FailCheck(std::string_view condition, std::string_view file, int line,
                            const std::string& values);

}  // namespace internal
}  // namespace musher
