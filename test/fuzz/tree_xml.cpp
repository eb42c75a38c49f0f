// A file with behaviour trees: faults have positions, a tree that can be built is ticked and
// halted, and its nodes can be shown. Nodes that are unknown come from its own models.

#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/cli/config/tree_file.hpp"
#include "musher/test/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace musher;
  using fuzz::Require;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const tree::Reading reading = tree::ReadTree(text, "t.xml");
  for (const Diagnostic& each : reading.diagnostics) {
    Require(!each.message.empty() && each.file == "t.xml", "a fault has a message and a file");
  }
  if (!reading.ok()) return 0;
  static_cast<void>(cli::NodesOf(reading.document, ""));
  tree::Factory factory;
  if (HasError(tree::AddPlaceholders(factory, reading.document))) return 0;
  const tree::Built built = tree::Build(reading.document, factory);
  Require((built.tree == nullptr) == HasError(built.diagnostics),
          "a tree without a fault is built");
  if (built.tree == nullptr || built.tree->size() > 1000) return 0;
  for (int tick = 0; tick < 8; ++tick) {
    static_cast<void>(built.tree->TickOnce(Time(Milliseconds(7 * tick))));
  }
  Require(built.tree->Halt(Time(Milliseconds(60))).ok(), "no node of Musher throws when halted");
  for (tree::NodeId id = 0; id < built.tree->size(); ++id) {
    Require(built.tree->status(id) == tree::Status::kIdle, "a tree that was halted is idle");
  }
  return 0;
}
