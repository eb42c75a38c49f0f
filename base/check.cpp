#include "musher/base/check.hpp"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace musher {
namespace {

thread_local const CheckContext* innermost = nullptr;

}  // namespace

CheckContext::CheckContext(std::string what)
    : what_(std::move(what)), outer_(std::exchange(innermost, this)) {}

CheckContext::~CheckContext() {
  innermost = outer_;
}

std::string CheckContexts() {
  std::string text;
  for (const CheckContext* one = innermost; one != nullptr; one = one->outer_) {
    text += ", in " + one->what_;
  }
  return text;
}

namespace internal {

void FailCheck(std::string_view condition, std::string_view file, int line,
               const std::string& values) {
  std::string message = std::string(file) + ":" + std::to_string(line) +
                        ": a check failed: " + std::string(condition);
  if (!values.empty()) message += " (" + values + ")";
  message += CheckContexts() + "; this is a bug\n";
  std::fputs(message.c_str(), stderr);
  std::fflush(stderr);
  std::abort();
}

}  // namespace internal
}  // namespace musher
