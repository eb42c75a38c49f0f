// Recordings of shows: those that exist stay readable.

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "musher/application/fsm_replay_file.hpp"
#include "musher/test/modules/wedding/show_rig.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::wedding::recording_test {

using ::testing::HasSubstr;

// Recorded in September 2026.
TEST(ShowRecording, OfAnEarlierVersionIsReplayedIdentically) {
  Script script;
  std::ostringstream out, err;
  const ReplayExit exit = ReplayFile(
      SourceDir() + "/test/modules/wedding/recordings/guest.record",
      [&](fsm::Machine& machine) -> Result<ReplayedInput> {
        const auto show = std::make_shared<Show>(ShowConfig{}, script);
        if (const Result<> built = show->Build(machine); !built) return built.error();
        show->Resume({});
        return ReplayedInput([show](std::string_view input, std::string_view text) {
          return show->Apply(input, text);
        });
      },
      out, err);
  EXPECT_EQ(exit, ReplayExit::kIdentical) << out.str() << err.str();
  EXPECT_THAT(out.str(), HasSubstr("IDLE -> TRACKING"));
}

}  // namespace musher::wedding::recording_test
