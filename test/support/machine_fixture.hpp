#pragma once
// A fixture for a machine of real processes, which is led through the real `musher` program: a
// domain, a namespace and a folder of its own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "musher/test/support/domain.hpp"
#include "musher/test/support/musher.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::testing {

class MachineFixture : public ::testing::Test {
 protected:
  MachineFixture() {
    AdoptOrphans();
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("MUSHER_NAMESPACE", name_space_.c_str(), 1);
  }
  // Nothing that a test started outlives it.
  ~MachineFixture() override { KillChildren(); }

  const TempFolder folder_;
  const std::string name_space_ = "test_" + std::to_string(getpid());
};

}  // namespace musher::testing
