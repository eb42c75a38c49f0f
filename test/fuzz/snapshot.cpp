// A saved machine as a file that anybody may have mended: it is refused, with places, and nothing
// has changed; or the machine is as the file says, and goes on.

#include "musher/behavior/fsm/snapshot.hpp"

#include "musher/behavior/fsm/toml/snapshot_toml.hpp"
#include "musher/test/fuzz/greeting.hpp"

namespace musher::fsm {
namespace {

using fuzz::Greeter;
using fuzz::Require;

std::string Saved(const Greeter& greeter) {
  const auto snapshot = greeter.machine->Save();
  Require(snapshot.ok(), "it can be saved");
  const auto text = WriteSnapshot(snapshot.value());
  Require(text.ok(), "it can be written");
  return text.value();
}

void RequireSense(std::string_view text) {
  const Time now(std::chrono::hours(1));
  Greeter greeter;
  const std::string before = Saved(greeter);
  if (const Result<> restored = RestoreSnapshot(*greeter.machine, text, "a.toml", now); !restored) {
    Require(restored.error().message.starts_with("a.toml:"), "a fault has its place");
    Require(Saved(greeter) == before, "what was refused changed nothing");
    return;
  }
  const std::string saved = Saved(greeter);
  Greeter other;
  const Result<> again = RestoreSnapshot(*other.machine, saved, "b.toml", now);
  Require(again.ok(), "what was saved can be restored: " + (again ? "" : again.error().message));
  Require(Saved(other) == saved, "and is the same");
  for (int i = 1; i <= 200; ++i) {
    greeter.machine->RunOnce(now + i * Milliseconds(20));
    other.machine->RunOnce(now + i * Milliseconds(20));
  }
  Require(Saved(other) == Saved(greeter), "both go on alike");
}

}  // namespace
}  // namespace musher::fsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fsm::RequireSense(input.Rest());
  return 0;
}
