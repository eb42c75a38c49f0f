#include "musher/test/ota/sim_disk.hpp"

#include <algorithm>
#include <filesystem>

namespace musher::ota::testing {
namespace {

std::string NameOf(const std::string& path) {
  return std::filesystem::path(path).filename();
}

Error NotThere(const std::string& path) {
  return {kCodeFailed, path + ": No such file or directory"};
}

}  // namespace

class SimDisk::SimReader : public Disk::Reader {
 public:
  explicit SimReader(NodePtr node) : node_(std::move(node)) {}
  Result<std::string_view> Read(std::size_t most) override {
    const std::string_view left =
        std::string_view(node_->data).substr(std::min(at_, node_->data.size()));
    const std::string_view bytes = left.substr(0, most);
    at_ += bytes.size();
    return bytes;
  }

 private:
  NodePtr node_;
  std::size_t at_ = 0;
};

class SimDisk::SimWriter : public Disk::Writer {
 public:
  SimWriter(SimDisk& disk, std::string path, NodePtr node)
      : disk_(disk), path_(std::move(path)), node_(std::move(node)) {}
  Result<> Write(std::string_view bytes) override {
    if (auto step = disk_.Step("write " + path_); !step) {
      node_->data += bytes.substr(0, bytes.size() / 2);  // what still fitted
      return step;
    }
    const std::size_t begin = node_->data.size();
    std::size_t reported = 0;
    for (const std::size_t part : {std::size_t{1}, bytes.size() / 2, bytes.size() - 1}) {
      if (part <= reported || part >= bytes.size()) continue;
      node_->data.resize(begin);
      node_->data += bytes.substr(0, part);
      reported = part;
      if (disk_.on_step) disk_.on_step("write " + path_ + ", after " + std::to_string(part));
    }
    node_->data.resize(begin);
    node_->data += bytes;
    return Ok();
  }

 private:
  SimDisk& disk_;
  std::string path_;
  NodePtr node_;
};

SimDisk::SimDisk() : root_(std::make_shared<Node>()) {
  root_->kind = Kind::kFolder;
}

SimDisk::~SimDisk() = default;

SimDisk::NodePtr SimDisk::Find(const std::string& path) const {
  NodePtr node = root_;
  for (const auto& part : std::filesystem::path(path).relative_path()) {
    if (part.empty() || part == ".") continue;
    if (node->kind != Kind::kFolder) return nullptr;
    const auto next = node->names.find(part);
    if (next == node->names.end()) return nullptr;
    node = next->second;
  }
  return node;
}

Result<SimDisk::NodePtr> SimDisk::Folder(const std::string& path) const {
  NodePtr folder = Find(FolderOf(path));
  if (!folder || folder->kind != Kind::kFolder) return NotThere(path);
  return folder;
}

Result<> SimDisk::Step(const std::string& what) {
  if (on_step) on_step(what);
  return fail ? fail(what) : Ok();
}

void SimDisk::Apply(std::map<std::string, NodePtr>& names, const Change& change) {
  if (!change.gone.empty()) names.erase(change.gone);
  if (change.name.empty()) return;
  if (change.node) {
    names[change.name] = change.node;
  } else {
    names.erase(change.name);
  }
}

std::string SimDisk::AfterCut(const Node& file, Lost lost, std::mt19937_64& random) {
  if (file.data == file.durable || lost == Lost::kNothing) return file.data;
  if (lost == Lost::kAll) return file.durable;
  switch (random() % 4) {
    case 0:
      return file.durable;
    case 1:
      return file.data;
    case 2:
      return file.data.substr(0, random() % (file.data.size() + 1));
    default: {  // its length is known, not all that is in it
      std::string holes = file.data;
      for (std::size_t i = random() % (holes.size() + 1); i < holes.size(); ++i) holes[i] = '\0';
      return holes;
    }
  }
}

SimDisk::NodePtr SimDisk::Survivor(const Node& node, Lost lost, std::mt19937_64& random) {
  auto copy = std::make_shared<Node>();
  copy->kind = node.kind;
  copy->mode = node.mode;
  if (node.kind != Kind::kFolder) {
    copy->data = copy->durable =
        node.kind == Kind::kFile ? AfterCut(node, lost, random) : node.data;
    return copy;
  }
  std::map<std::string, NodePtr> names = node.durable_names;
  for (const Change& change : node.changes) {
    const bool kept = lost == Lost::kNothing || (lost == Lost::kSome && random() % 2 == 0);
    if (kept) Apply(names, change);
  }
  for (const auto& [name, child] : names) copy->names[name] = Survivor(*child, lost, random);
  copy->durable_names = copy->names;
  return copy;
}

std::unique_ptr<SimDisk> SimDisk::AfterPowerCut(Lost lost, std::uint64_t seed) const {
  auto disk = std::make_unique<SimDisk>();
  std::mt19937_64 random(seed);
  disk->root_ = Survivor(*root_, lost, random);
  disk->free_bytes = free_bytes;
  return disk;
}

void SimDisk::Put(const std::string& path, const std::string& content) {
  NodePtr node = root_;
  for (const auto& part : std::filesystem::path(path).relative_path()) {
    NodePtr& next = node->names[part];
    if (!next) {
      next = std::make_shared<Node>();
      next->kind = Kind::kFolder;
    }
    node->durable_names[part] = next;
    node = next;
  }
  node->kind = Kind::kFile;
  node->mode = 0644;
  node->data = node->durable = content;
}

void SimDisk::PutLink(const std::string& path, const std::string& target) {
  Put(path, target);
  Find(path)->kind = Kind::kLink;
}

std::string SimDisk::Content(const std::string& path) const {
  const NodePtr node = Find(path);
  return node ? node->data : "";
}

bool SimDisk::IsThere(const std::string& path) const {
  return Find(path) != nullptr;
}

Result<Disk::Info> SimDisk::Look(const std::string& path) {
  const NodePtr node = Find(path);
  if (!node) return Info{};
  return Info{node->kind, node->data.size(), node->mode};
}

Result<std::vector<std::string>> SimDisk::List(const std::string& folder) {
  const NodePtr node = Find(folder);
  if (!node || node->kind != Kind::kFolder) return NotThere(folder);
  std::vector<std::string> names;
  for (const auto& [name, child] : node->names) names.push_back(name);
  return names;
}

Result<std::string> SimDisk::ReadLink(const std::string& path) {
  const NodePtr node = Find(path);
  if (!node || node->kind != Kind::kLink) return NotThere(path);
  return node->data;
}

Result<std::unique_ptr<Disk::Reader>> SimDisk::Open(const std::string& path) {
  if (on_open) on_open(path);
  const NodePtr node = Find(path);
  if (!node || node->kind != Kind::kFile) return NotThere(path);
  return std::unique_ptr<Reader>(std::make_unique<SimReader>(node));
}

Result<std::uint64_t> SimDisk::FreeBytes(const std::string&) {
  return free_bytes;
}

Result<std::unique_ptr<Disk::Writer>> SimDisk::Create(const std::string& path, unsigned mode) {
  if (auto step = Step("create " + path); !step) return step.error();
  const auto folder = Folder(path);
  if (!folder) return folder.error();
  NodePtr node = Find(path);
  if (!node) {
    node = std::make_shared<Node>();
    const Change change{NameOf(path), node, ""};
    Apply(folder.value()->names, change);
    folder.value()->changes.push_back(change);
  }
  if (node->kind != Kind::kFile) return NotThere(path);
  node->data.clear();
  node->mode = mode;
  return std::unique_ptr<Writer>(std::make_unique<SimWriter>(*this, path, node));
}

Result<> SimDisk::Sync(const std::string& path) {
  if (auto step = Step("sync " + path); !step) return step;
  const NodePtr node = Find(path);
  if (!node) return NotThere(path);
  if (forgets_to_sync && forgets_to_sync(path)) return Ok();
  node->durable = node->data;
  node->durable_names = node->names;
  node->changes.clear();
  return Ok();
}

Result<> SimDisk::MakeFolder(const std::string& path) {
  if (auto step = Step("make folder " + path); !step) return step;
  if (IsThere(path)) return Ok();
  const auto folder = Folder(path);
  if (!folder) return folder.error();
  auto node = std::make_shared<Node>();
  node->kind = Kind::kFolder;
  const Change change{NameOf(path), node, ""};
  Apply(folder.value()->names, change);
  folder.value()->changes.push_back(change);
  return Ok();
}

Result<> SimDisk::MakeLink(const std::string& target, const std::string& path) {
  if (auto step = Step("link " + path); !step) return step;
  const auto folder = Folder(path);
  if (!folder) return folder.error();
  auto node = std::make_shared<Node>();
  node->kind = Kind::kLink;
  node->data = node->durable = target;
  const Change change{NameOf(path), node, ""};
  Apply(folder.value()->names, change);
  folder.value()->changes.push_back(change);
  return Ok();
}

Result<> SimDisk::Rename(const std::string& from, const std::string& to) {
  if (auto step = Step("rename " + from); !step) return step;
  const auto folder = Folder(from);
  const NodePtr node = Find(from);
  if (!folder || !node) return NotThere(from);
  const Change change{NameOf(to), node, NameOf(from)};
  Apply(folder.value()->names, change);
  folder.value()->changes.push_back(change);
  return Ok();
}

Result<> SimDisk::Remove(const std::string& path) {
  if (auto step = Step("remove " + path); !step) return step;
  const auto folder = Folder(path);
  if (!folder) return folder.error();
  const Change change{NameOf(path), nullptr, ""};
  Apply(folder.value()->names, change);
  folder.value()->changes.push_back(change);
  return Ok();
}

Result<std::unique_ptr<Disk::Lock>> SimDisk::Take(const std::string& path, bool) {
  struct Held : Lock {
    explicit Held(bool& taken) : taken_(taken) { taken_ = true; }
    ~Held() override { taken_ = false; }
    bool& taken_;
  };
  bool& taken = locks_[path];
  if (taken) return Error{kCodeTargetBusy, path + " is held"};
  return std::unique_ptr<Lock>(std::make_unique<Held>(taken));
}

}  // namespace musher::ota::testing
