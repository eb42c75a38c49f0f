// A changed snapshot file of a state machine: either it is refused, with positions, and changes
// nothing; or the machine is restored as the file says, and continues.

#include "musher/behavior/fsm/snapshot.hpp"

#include "musher/behavior/fsm/toml/snapshot_toml.hpp"
#include "musher/test/fuzz/greeting.hpp"

namespace musher::fsm {
namespace {

using fuzz::Greeter;
using fuzz::Require;

std::string Saved(const Greeter& greeter) {
  const auto snapshot = greeter.machine->Save();
  Require(snapshot.ok(), "a snapshot can be taken");
  const auto text = WriteSnapshot(snapshot.value());
  Require(text.ok(), "a snapshot can be written");
  return text.value();
}

void RequireConsistent(std::string_view text) {
  const Time now(std::chrono::hours(1));
  Greeter greeter;
  const std::string before = Saved(greeter);
  if (const Result<> restored = RestoreSnapshot(*greeter.machine, text, "a.toml", now); !restored) {
    Require(restored.error().message.starts_with("a.toml:"), "an error has a position");
    Require(Saved(greeter) == before, "a refused snapshot changes nothing");
    return;
  }
  const std::string saved = Saved(greeter);
  Greeter other;
  const Result<> again = RestoreSnapshot(*other.machine, saved, "b.toml", now);
  Require(again.ok(), "a saved snapshot can be restored: " + (again ? "" : again.error().message));
  Require(Saved(other) == saved, "and gives the same state");
  for (int i = 1; i <= 200; ++i) {
    greeter.machine->RunOnce(now + i * Milliseconds(20));
    other.machine->RunOnce(now + i * Milliseconds(20));
  }
  Require(Saved(other) == Saved(greeter), "both continue in the same way");
}

}  // namespace
}  // namespace musher::fsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Input input(data, size);
  musher::fsm::RequireConsistent(input.Rest());
  return 0;
}
