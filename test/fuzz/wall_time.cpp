// The argument of `--since`: an invalid time gives an error, a valid one can be written again.

#include "musher/cli/console/wall_time.hpp"

#include "musher/test/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace musher;
  constexpr std::int64_t kNow = 1'770'000'000'000'000'000;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto since = cli::ParseSince(text, kNow);
  if (!since) {
    fuzz::Require(!since.error().message.empty(), "a refusal has a message");
    return 0;
  }
  const auto again = cli::ParseSince(cli::UtcText(since.value()), kNow);
  constexpr std::int64_t kMillisecond = 1'000'000;
  fuzz::Require(again.ok(), "a written time can be read");
  const std::int64_t lost = since.value() - again.value();
  fuzz::Require(lost >= 0 && lost < kMillisecond, "it is the same within a millisecond");
  fuzz::Require(!cli::LocalText(since.value()).empty() && !cli::LocalTime(since.value()).empty(),
                "it can be written");
  return 0;
}
