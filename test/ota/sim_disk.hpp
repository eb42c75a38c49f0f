#pragma once
// A disk in memory that can lose its power after any operation, and in the middle of a write. What
// was not synced is then there, not there, or there in part, as file systems are free to have it:
// of a file the old content, the new, a piece of it, or its length with zeros; of a folder any of
// the names that were made, replaced or removed since it was synced.

#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "musher/ota/disk.hpp"

namespace musher::ota::testing {

class SimDisk : public Disk {
 public:
  SimDisk();
  ~SimDisk() override;

  // What becomes of all that was not synced.
  enum class Lost { kAll, kNothing, kSome };
  // The disk as it is found after a power cut now. Hooks are not taken along.
  std::unique_ptr<SimDisk> AfterPowerCut(Lost lost, std::uint64_t seed) const;

  // Called before each operation that changes something, and in the middle of a write.
  std::function<void(const std::string& what)> on_step;
  // Called with each such operation: an Error is its result, and it has not happened.
  std::function<Result<>(const std::string& what)> fail;
  // A planted flaw: a Sync() for which this holds does nothing.
  std::function<bool(const std::string& path)> forgets_to_sync;
  // Called with each file that is opened, to change it under the reader's feet.
  std::function<void(const std::string& path)> on_open;
  std::uint64_t free_bytes = 1U << 30;

  // For tests: a file with all the folders it needs, on disk at once; "" when there is none.
  void Put(const std::string& path, const std::string& content);
  void PutLink(const std::string& path, const std::string& target);
  std::string Content(const std::string& path) const;
  bool IsThere(const std::string& path) const;

  Result<Info> Look(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& folder) override;
  Result<std::string> ReadLink(const std::string& path) override;
  Result<std::unique_ptr<Reader>> Open(const std::string& path) override;
  Result<std::uint64_t> FreeBytes(const std::string& folder) override;
  Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) override;
  Result<> Sync(const std::string& path) override;
  Result<> MakeFolder(const std::string& path) override;
  Result<> MakeLink(const std::string& target, const std::string& path) override;
  Result<> Rename(const std::string& from, const std::string& to) override;
  Result<> Remove(const std::string& path) override;
  Result<std::unique_ptr<Lock>> Take(const std::string& path, bool wait) override;

 private:
  struct Node;
  using NodePtr = std::shared_ptr<Node>;
  // One change of a folder since it was synced: `name` means `node` now, or nothing any more. A
  // rename is one change of two names.
  struct Change {
    std::string name;
    NodePtr node;
    std::string gone;  // the name it had before
  };
  struct Node {
    Kind kind = Kind::kFile;
    unsigned mode = 0;
    std::string data;                      // of a file; of a link its target
    std::string durable;                   // of it what is on disk
    std::map<std::string, NodePtr> names;  // of a folder
    std::map<std::string, NodePtr> durable_names;
    std::vector<Change> changes;  // that lead from the one to the other
  };
  class SimReader;
  class SimWriter;

  NodePtr Find(const std::string& path) const;
  Result<NodePtr> Folder(const std::string& path) const;
  Result<> Step(const std::string& what);
  static void Apply(std::map<std::string, NodePtr>& names, const Change& change);
  static std::string AfterCut(const Node& file, Lost lost, std::mt19937_64& random);
  static NodePtr Survivor(const Node& node, Lost lost, std::mt19937_64& random);

  NodePtr root_;
  std::map<std::string, bool> locks_;
};

}  // namespace musher::ota::testing
