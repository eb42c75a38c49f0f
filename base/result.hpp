#pragma once
// Musher's three lanes of error:
//   MUSHER_CHECK a bug in Musher itself; the program stops where it happened (check.hpp).
//   Result       an expected failure (a refusal, a missing file, a lost peer).
//   Diagnostic   an error in a file that a person wrote, with line and column (diagnostic.hpp).
//
// Threads: any; one Result is for one thread at a time.

#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "musher/base/check.hpp"
#include "musher/base/code.hpp"

namespace musher {

// Why an operation failed: CyberDog's code for programs, a sentence for people.
struct Error {
  std::int32_t code = kCodeFailed;
  std::string message;

  friend bool operator==(const Error&, const Error&) = default;
};

// "3009 (MotionManager: SelfCheckFailed), the leg does not answer".
inline std::string ErrorText(const Error& error) {
  return CodeText(error.code) + (error.message.empty() ? "" : ", ") + error.message;
}

// A value, or the reason why there is none. A dropped Result is a compile error.
template <typename T = void>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    MUSHER_CHECK(ok(), "the error is:", std::get<Error>(content_).message);
    return std::get<T>(content_);
  }
  T& value() & {
    MUSHER_CHECK(ok(), "the error is:", std::get<Error>(content_).message);
    return std::get<T>(content_);
  }
  T&& value() && {
    MUSHER_CHECK(ok(), "the error is:", std::get<Error>(content_).message);
    return std::get<T>(std::move(content_));
  }
  const Error& error() const {
    MUSHER_CHECK(!ok());
    return std::get<Error>(content_);
  }

 private:
  std::variant<T, Error> content_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error)  // NOLINT(google-explicit-constructor)
      : failed_(true), error_(std::move(error)) {}

  bool ok() const { return !failed_; }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    MUSHER_CHECK(failed_);
    return error_;
  }

 private:
  bool failed_ = false;
  Error error_;
};

inline Result<void> Ok() {
  return {};
}

}  // namespace musher
