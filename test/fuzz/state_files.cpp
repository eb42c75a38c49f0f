// The small files of a controller's folder, damaged in any way: an epoch is read or refused, a
// damaged emergency stop file means that a stop is engaged, and what was read can be saved and read
// again.

#include <algorithm>
#include <string>

#include "musher/controller/storage/state_store.hpp"
#include "musher/test/fuzz/folder.hpp"
#include "musher/test/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace musher;
  static const fuzz::Folder folder;
  static auto store =
      StateStore::Open(folder.path(), {"fuzz", "", 0, folder.path() + "/fuzz.toml"}).value();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  folder.Write("epoch", text);
  folder.Write("emergency_stop", text);
  folder.Write("remote_actuators", text);
  folder.Write("actuators", text);
  const auto epoch = store.LoadEpoch();
  fuzz::Require(epoch.ok() || !epoch.error().message.empty(), "a damaged file gives an error");
  const StoredStops stops = store.LoadEmergencyStops();
  const bool whole = ("\n" + std::string(text) + "\n").find("\nend\n") != std::string::npos;
  fuzz::Require(whole || !stops.engaged.empty(),
                "a file that cannot be read means a stop is engaged");
  const fuzz::Folder other;
  other.Write("controller.lock", text);
  fuzz::Require(StateStore::OwnerOf(other.path()) >= 0, "an owner is a process id");
  fuzz::Require(store.SaveEmergencyStops(stops).ok(), "read stops can be saved");
  const StoredStops again = store.LoadEmergencyStops();
  fuzz::Require(again.released == stops.released, "released stops stay released");
  fuzz::Require(again.replaced == stops.replaced, "replaced stops stay replaced");
  fuzz::Require(again.engagements == stops.engagements, "no engagement is forgotten");
  const bool same =
      std::equal(stops.engaged.begin(), stops.engaged.end(), again.engaged.begin(),
                 again.engaged.end(), [](const auto& a, const auto& b) { return a.id == b.id; });
  fuzz::Require(same, "a stop stays the same");
  const auto remote = store.LoadRemoteActuators("boot/1");
  fuzz::Require(store.SaveRemoteActuators(remote, "boot/1").ok(), "read actuators can be saved");
  fuzz::Require(store.LoadRemoteActuators("boot/1") == remote, "read actuators stay the same");
  const auto down = StateStore::ActuatorsIn(folder.path(), "boot/1");
  fuzz::Require(store.SaveActuators(down, "boot/1").ok(), "ends that were read can be saved");
  fuzz::Require(StateStore::ActuatorsIn(folder.path(), "boot/1") == down, "they stay the same");
  return 0;
}
