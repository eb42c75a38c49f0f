#pragma once
// A result that comes later, polled by a skill in each step; nothing waits.
//
//   // the skill, in its first step:    plan_ = planner.Ask(goal);
//   // in each step:                    if (!plan_.done()) return Next::Stay();
//   //                                  if (!plan_.result()) return Next::Fail(…);
//   // the planner keeps the Source:    Source<Path> source; … return source.future();
//   //                                  source.Finish(path); or source.Fail("no path");
//
// A source that is destroyed without a result fails its future, so a crash of the other side is
// never waited for. When no future is left, wanted() is false: the work can be dropped.
//
// A future is not saved. After a restore it is not valid(), and the skill asks again.
//
// Threads: all of them on one thread. The result of another thread goes through the event loop.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/result.hpp"

namespace musher::skill {

template <class T>
class Future {
 public:
  Future() = default;

  // Whether a source belongs to it.
  bool valid() const { return shared_ != nullptr; }
  bool done() const { return valid() && shared_->has_value(); }
  // Only when it is done.
  const Result<T>& result() const {
    MUSHER_CHECK(done());
    return **shared_;
  }
  // The result is not wanted any more.
  void Drop() { shared_.reset(); }

 private:
  template <class>
  friend class Source;
  using Shared = std::shared_ptr<std::optional<Result<T>>>;
  explicit Future(Shared shared) : shared_(std::move(shared)) {}

  Shared shared_;
};

template <class T>
class Source {
 public:
  Source() : shared_(std::make_shared<std::optional<Result<T>>>()) {}
  ~Source() { Abandon(); }
  Source(Source&&) noexcept = default;
  Source& operator=(Source&& other) noexcept {
    if (this != &other) Abandon();
    shared_ = std::move(other.shared_);
    return *this;
  }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  Future<T> future() const { return Future<T>(shared_); }
  bool wanted() const { return shared_ && shared_.use_count() > 1; }

  // The first result counts.
  void Set(Result<T> result) {
    if (shared_ && !shared_->has_value()) shared_->emplace(std::move(result));
  }
  void Finish(T value) { Set(Result<T>(std::move(value))); }
  void Fail(std::string why) { Set(Result<T>(Error{kCodeFailed, std::move(why)})); }

 private:
  void Abandon() {
    if (shared_) Set(Error{kCodeFailed, "the work was abandoned"});
  }

  std::shared_ptr<std::optional<Result<T>>> shared_;
};

}  // namespace musher::skill
