#pragma once
// What the contract suite needs of a transport. The same tests run on the simulated network and on
// real DDS, which keeps the simulation honest.

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "musher/transport/node.hpp"

namespace musher::transport {

class World {
 public:
  virtual ~World() = default;

  // All nodes of a world run when the world does. A simulated one is a participant of its own; the
  // real ones of this process are one.
  virtual std::unique_ptr<Node> MakeNode() = 0;
  virtual EventLoop& loop() = 0;
  // Runs all nodes until `done` holds; false when it never does within the time a test may take.
  bool RunUntil(const std::function<bool()>& done) {
    return loop().RunUntil(done, loop().Now() + std::chrono::seconds(120));
  }
};

using MakeWorld = std::unique_ptr<World> (*)();
std::unique_ptr<World> MakeSimWorld();
std::unique_ptr<World> MakeDdsWorld();

// The value, or a test failure with the reason (and then the end of the process: nothing can go
// on).
template <class T>
T Must(Result<T> result) {
  if (!result) {
    ADD_FAILURE() << result.error().message;
    std::abort();
  }
  return std::move(result).value();
}

class Contract : public ::testing::TestWithParam<MakeWorld> {
 protected:
  bool RunUntil(const std::function<bool()>& done) { return world_->RunUntil(done); }
  std::unique_ptr<Node> MakeNode() { return world_->MakeNode(); }
  EventLoop& loop() { return world_->loop(); }

  // A name that no other test uses, also none that runs at the same time.
  static std::string Unique(const std::string& name);

 private:
  std::unique_ptr<World> world_ = GetParam()();
};

std::string WorldName(const ::testing::TestParamInfo<MakeWorld>& info);

}  // namespace musher::transport

#define MUSHER_ON_EVERY_TRANSPORT(Suite) \
  INSTANTIATE_TEST_SUITE_P(, Suite, ::testing::Values(&MakeSimWorld, &MakeDdsWorld), WorldName)
