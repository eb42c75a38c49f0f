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
  // With CCACHE_BASEDIR the compiler sees paths that are relative to the build.
  while (file.substr(0, 3) == "../") file.remove_prefix(3);
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
