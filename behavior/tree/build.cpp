#include "musher/behavior/tree/build.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "musher/base/suggest.hpp"
#include "musher/base/words.hpp"
#include "musher/behavior/tree/builder.hpp"
#include "musher/behavior/tree/conditions.hpp"

namespace musher::tree {
namespace {

constexpr std::size_t kMostDiagnostics = 200;

// The subtree as a node: its child is the root of the other tree.
class Subtree : public Decorator {
  Status OnTick(Tick& tick) override { return TickChild(tick); }
};

bool IsForm(std::string_view name) {
  return name == "Action" || name == "Condition" || name == "Decorator" || name == "Control";
}

bool IsSubtree(std::string_view name) {
  return name == "SubTree" || name == "SubTreePlus";
}

// Whether the class of this name is the program's, not the library's.
bool IsOwn(std::string_view id, const Factory::Registered* registered) {
  static const Factory library;
  const Factory::Registered* known = library.Find(id);
  return registered != nullptr &&
         (known == nullptr || known->make.target_type() != registered->make.target_type());
}

std::size_t CountElements(const Element& element) {
  std::size_t count = 1;
  for (const Element& child : element.children) count += CountElements(child);
  return count;
}

std::string Quoted(std::string_view text) {
  return "'" + std::string(text) + "'";
}

std::vector<std::string> TreeNames(const Document& document) {
  std::vector<std::string> names;
  for (const Document::Tree& tree : document.trees) names.push_back(tree.id);
  return names;
}

// "" for one time.
std::string Times(std::size_t times) {
  return times == 1 ? "" : " (" + std::to_string(times) + " times)";
}

// The class of a node: of <Move/> or <Action ID="Move"/>.
const std::string& ClassOf(const Element& element) {
  const Attribute* id = IsForm(element.name) ? element.Find("ID") : nullptr;
  return id == nullptr ? element.name : id->value;
}

void NoteSubtrees(const Element& element, std::set<std::string>& used) {
  for (const Element& child : element.children) {
    const Attribute* id = IsSubtree(child.name) ? child.Find("ID") : nullptr;
    if (id != nullptr) used.insert(id->value);
    NoteSubtrees(child, used);
  }
}

// The trees, first those that no other one uses.
std::vector<const Document::Tree*> RootsFirst(const Document& document) {
  std::set<std::string> used;
  for (const Document::Tree& tree : document.trees) NoteSubtrees(tree.content, used);
  std::vector<const Document::Tree*> trees;
  for (const Document::Tree& tree : document.trees) trees.push_back(&tree);
  std::stable_partition(trees.begin(), trees.end(),
                        [&](const auto* tree) { return !used.contains(tree->id); });
  return trees;
}

// What the entries of a given board, and of the boards around it, are before the build.
class GivenTypes {
 public:
  explicit GivenTypes(Board* board) : board_(board) {
    ForEach([this](Entry& entry) { before_[&entry] = {entry.type, entry.declared}; });
  }
  void Restore() const {
    ForEach([this](Entry& entry) {
      const auto found = before_.find(&entry);
      const auto before = found != before_.end() ? found->second : Before{};
      entry.type = before.type;
      entry.declared = before.declared;
    });
  }

 private:
  struct Before {
    const Type* type = nullptr;
    bool declared = false;
  };
  template <class Do>
  void ForEach(const Do& act) const {
    if (board_ == nullptr) return;
    for (const std::string& key : board_->Keys()) act(*board_->Find(key));
  }

  Board* board_;
  std::map<const Entry*, Before> before_;
};

bool IsCondition(std::string_view name) {
  return std::ranges::find(kConditionNames, name) != kConditionNames.end();
}

// Attributes of every element that are no ports.
bool IsReserved(std::string_view name) {
  return name == "name" || name == "ID" || name == "_description" || name == "_autoremap" ||
         name == "_collapsed" || name == "_uid" || name == "_fullpath" || name == "_fullPath" ||
         name == "__shared_blackboard";
}

std::string PortText(const PortModel& model) {
  return "port '" + model.name + "'" +
         (model.type == nullptr ? "" : " (" + std::string(model.type->name) + ")");
}

}  // namespace

Builder::Builder(const Document& document, const Factory& factory)
    : document_(document), factory_(factory) {
  for (const Document::File& file : document.files) {
    std::vector<std::uint32_t>& begins = lines_.emplace_back(1, 0U);
    for (std::size_t at = file.text.find('\n'); at != std::string::npos;
         at = file.text.find('\n', at + 1)) {
      begins.push_back(static_cast<std::uint32_t>(at + 1));
    }
  }
}

bool Builder::failed() const {
  if (!unknown_.empty()) return true;
  return std::ranges::any_of(
      found_, [](const auto& one) { return std::get<Severity>(one) == Severity::kError; });
}

void Builder::ReportScript(const Attribute& attribute, const Script::Finding& finding) {
  Report(document_.Inside(attribute, finding.at),
         finding.error ? Severity::kError : Severity::kWarning,
         "script in " + attribute.name + ": " + finding.what);
}

void Builder::NoteUnset(const Element& element, const std::string& port) {
  Unset& unset = unset_[ClassOf(element)];
  unset.places.insert(element.at);
  unset.ports.insert(port);
}

std::vector<Diagnostic> Builder::Take() && {
  std::vector<std::string> names = factory_.Names();
  names.emplace_back("SubTree");
  for (const auto& unknown : unknown_) {
    const auto& [id, places] = unknown;
    const bool modelled = std::ranges::any_of(document_.models, [&unknown](const Element& model) {
      const Attribute* attribute = model.Find("ID");
      return attribute != nullptr && attribute->value == unknown.first;
    });
    Report(*places.begin(), Severity::kError,
           "there is no node " + Quoted(id) + DidYouMean(id, names) +
               (modelled ? "; <TreeNodesModel> describes it, but the program does not register it"
                         : "") +
               Times(places.size()));
  }
  for (const auto& [id, unset] : unset_) {
    std::string ports;
    for (const std::string& port : unset.ports) ports += (ports.empty() ? "" : ", ") + Quoted(port);
    Report(*unset.places.begin(), Severity::kWarning,
           "node " + Quoted(id) + " leaves out inputs that have no default in its model: " + ports +
               Times(unset.places.size()));
  }
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  std::vector<Diagnostic> diagnostics;
  for (auto& [place, severity, message] : found_) {
    if (diagnostics.size() >= kMostDiagnostics) break;
    diagnostics.push_back(document_.At(place, severity, std::move(message)));
  }
  return diagnostics;
}

std::unique_ptr<Tree> Builder::Make(const Document::Tree& main, std::size_t history,
                                    std::shared_ptr<Board> board) {
  tree_ = std::unique_ptr<Tree>(new Tree(main.id, history));
  tree_->enums_ = factory_.shared_enums();
  for (const Document::File& file : document_.files) tree_->files_.push_back(file.path);
  tree_->boards_.push_back(board != nullptr ? std::move(board) : std::make_shared<Board>());
  elements_.clear();
  registered_.clear();
  types_.clear();
  pointers_.clear();
  read_as_text_.clear();
  constants_.clear();
  reads_.clear();
  script_reads_.clear();
  writes_.clear();
  made_.clear();
  needed_.clear();
  const std::size_t count = CountElements(main.content);  // more nodes where it has subtrees
  tree_->nodes_.reserve(count);
  tree_->infos_.reserve(count);
  elements_.reserve(count);
  registered_.reserve(count);
  MakeContent(main, {});
  UnifyPointers();
  if (failed()) return nullptr;
  tree_->trace_.Resize(tree_->nodes_.size());
  FitValues();
  SetConstants();
  Warn();
  return failed() ? nullptr : std::move(tree_);
}

Node* Builder::MakeContent(const Document::Tree& tree, const Around& around) {
  used_.push_back(tree.id);
  if (tree.content.children.size() != 1) {
    Report(tree.content.at, Severity::kError,
           "tree " + Quoted(tree.id) + " has " + Counted(tree.content.children.size(), "node") +
               " at its top; expected 1");
  }
  inside_.push_back(tree.id);
  Node* root = nullptr;
  for (const Element& child : tree.content.children) {
    Node* made = MakeNode(child, around);
    if (root == nullptr) root = made;
  }
  inside_.pop_back();
  return root;
}

Node* Builder::MakeNode(const Element& element, const Around& around) {
  if (tree_->nodes_.size() >= kMostNodes || around.depth > kDeepestTree) {
    if (!too_large_) {
      Report(element.at, Severity::kError,
             tree_->nodes_.size() >= kMostNodes
                 ? "the tree has more than " + std::to_string(kMostNodes) + " nodes"
                 : "the tree is deeper than " + std::to_string(kDeepestTree) + " nodes");
    }
    too_large_ = true;
    return nullptr;
  }
  if (IsSubtree(element.name)) return MakeSubtree(element, around);
  std::string_view id = element.name;
  Place at = element.at;
  if (IsForm(id)) {
    const Attribute* attribute = element.Find("ID");
    if (attribute == nullptr) {
      Report(element.at, Severity::kError, "<" + element.name + "> needs the attribute 'ID'");
      return nullptr;
    }
    id = attribute->value;
    at = attribute->value_at;
  }
  const auto [known, is_new] = classes_.try_emplace(id);
  if (is_new) {
    known->second.registered = factory_.Find(id);
    known->second.is_own = IsOwn(id, known->second.registered);
  }
  const auto [registered, is_own] = known->second;
  if (registered == nullptr) {
    UnknownNode(at, id);
    for (const Element& child : element.children) MakeNode(child, around);
    return nullptr;
  }
  const auto is_leaf = [](std::string_view name) {
    return name == "Action" || name == "Condition";
  };
  const std::string_view kind = Name(registered->kind);
  if (IsForm(element.name) && element.name != kind && !(is_leaf(element.name) && is_leaf(kind))) {
    Report(element.at, Severity::kError,
           "node " + Quoted(id) + " is registered as " + std::string(Name(registered->kind)) +
               ", not as " + element.name);
  }
  Node* const node = MakeRegistered(element, id, *registered, around);
  if (node != nullptr && is_own) node->special_ = true;  // it may leave its children running
  return node;
}

void Builder::UnknownNode(Place place, std::string_view id) {
  if (document_.Find(id) != nullptr) {
    Report(place, Severity::kError,
           Quoted(id) + " is a tree; write <SubTree ID=\"" + std::string(id) + "\"/>");
    return;
  }
  const auto found = unknown_.find(id);
  (found != unknown_.end() ? found->second : unknown_[std::string(id)]).insert(place);
}

// The names from the root, as patterns of test nodes have them.
std::string Builder::PlainPath(NodeId id) const {
  std::string path;
  for (NodeId at = id; at != kNoNode; at = tree_->infos_[at].parent) {
    path = "/" + tree_->infos_[at].name + path;
  }
  return tree_->name() + path;
}

std::string Builder::TreePath(NodeId id) const {
  std::string path = tree_->infos_[id].name;
  for (NodeId at = tree_->infos_[id].parent; at != kNoNode; at = tree_->infos_[at].parent) {
    const NodeInfo& info = tree_->infos_[at];
    if (info.kind == NodeKind::kSubtree) path = info.name + "/" + path;
  }
  return path;
}

NodeId Builder::Reserve(const Element& element, std::string_view id, NodeKind kind,
                        const Factory::Registered* registered, const Around& around) {
  const Attribute* name = element.Find("name");
  const std::vector<std::uint32_t>& begins = lines_[element.at.file];
  const auto line = std::ranges::upper_bound(begins, element.at.at);
  tree_->nodes_.push_back(nullptr);
  elements_.push_back(&element);
  registered_.push_back(registered);
  tree_->infos_.push_back({.name = name != nullptr ? name->value : std::string(id),
                           .id = std::string(id),
                           .kind = kind,
                           .parent = around.parent,
                           .board = around.board,
                           .takes_time = false,
                           .place = element.at,
                           .line = static_cast<int>(line - begins.begin()),
                           .column = static_cast<int>(element.at.at - *std::prev(line) + 1)});
  return static_cast<NodeId>(tree_->nodes_.size() - 1);
}

Node* Builder::Keep(NodeId id, std::unique_ptr<Node> node) {
  node->id_ = id;
  Node* kept = node.get();
  const std::type_info* const type = &typeid(*kept);
  if (std::ranges::find(no_observers_, type) == no_observers_.end()) {
    if (auto* observer = dynamic_cast<RunObserver*>(kept)) {
      tree_->run_observers_.emplace_back(kept, observer);
    } else {
      no_observers_.push_back(type);
    }
  }
  tree_->nodes_[id] = std::move(node);
  return kept;
}

// Makes a node by the function of its class. If that throws, reports it and returns null.
std::unique_ptr<Node> Builder::Call(const Factory::Registered& registered, Setup& setup,
                                    const Element& element, std::string_view id) {
  const auto fail = [&](const std::string& what) {
    Report(element.at, Severity::kError, "node " + Quoted(id) + " can not be made: " + what);
  };
  try {
    return registered.make(setup);
  } catch (const std::exception& error) {
    fail(error.what());
  } catch (...) {
    fail("an unknown exception");
  }
  return nullptr;
}

Node* Builder::MakeRegistered(const Element& element, std::string_view id,
                              const Factory::Registered& registered, const Around& around) {
  const NodeId node_id = Reserve(element, id, registered.kind, &registered, around);
  tree_->infos_[node_id].takes_time = registered.takes_time;
  Board& board = *tree_->boards_[around.board];
  Setup setup(this, element, board, factory_.enums());
  used_attributes_.clear();
  std::unique_ptr<Node> made = Call(registered, setup, element, id);
  if (made == nullptr) return nullptr;
  CheckAttributes(element, setup);
  const Substitution* substitute = nullptr;
  if (factory_.has_substitutes() && element.children.empty()) {
    leaves_.push_back({tree_->infos_[node_id].name, tree_->infos_[node_id].id, PlainPath(node_id),
                       TreePath(node_id)});
    substitute = factory_.Substituted(leaves_.back());
  }
  if (substitute != nullptr && substitute->node.empty()) {
    made = MakeTestNode(setup, substitute->config);
    tree_->infos_[node_id].takes_time =
        substitute->config.delay > Duration{} || substitute->config.result_of;
  } else if (substitute != nullptr) {
    id = substitute->node;
    const Factory::Registered& other = *factory_.Find(id);
    const std::size_t found = found_.size();
    Setup setup_of_other(this, element, board, factory_.enums());
    made = Call(other, setup_of_other, element, id);
    if (found_.size() > found) {
      Report(element.at, Severity::kNote,
             "a substitution makes it the node " + Quoted(id) + ", whose ports it needs");
    }
    if (made == nullptr) return nullptr;
    tree_->infos_[node_id].takes_time = other.takes_time;
  }
  Node* node = Keep(node_id, std::move(made));
  SetConditions(element, *node, board);
  MakeChildren(element, node, node_id, around);
  CheckChildren(element, *node, id);
  return node;
}

Control* Builder::AsControl(Node* node) {
  return node->shape_ == Node::Shape::kControl ? static_cast<Control*>(node) : nullptr;
}

Decorator* Builder::AsDecorator(Node* node) {
  return node->shape_ == Node::Shape::kDecorator ? static_cast<Decorator*>(node) : nullptr;
}

void Builder::MakeChildren(const Element& element, Node* node, NodeId id, const Around& around) {
  Control* const control = AsControl(node);
  Decorator* const decorator = AsDecorator(node);
  if (control != nullptr) {
    control->children_.reserve(element.children.size());
    control->child_names_.reserve(element.children.size());
  }
  for (const Element& child : element.children) {
    Node* made = MakeNode(child, {id, around.board, around.depth + 1});
    if (made == nullptr) continue;
    if (control != nullptr) {
      control->children_.push_back(made);
      control->child_names_.push_back(tree_->infos_[made->id_].name);
    }
    if (decorator != nullptr) decorator->child_ = made;
  }
}

void Builder::CheckChildren(const Element& element, Node& node, std::string_view id) {
  const std::size_t count = element.children.size();
  std::size_t least = 0;
  std::size_t most = 0;
  if (AsDecorator(&node) != nullptr) {
    least = most = 1;
  } else if (const Control* control = AsControl(&node)) {
    least = control->least_;
    most = control->most_;
  }
  if (count >= least && count <= most) return;
  std::string expected = std::to_string(least);
  if (most == Control::kAny) expected = "at least " + expected;
  if (most != Control::kAny && most != least) expected += " to " + std::to_string(most);
  Report(element.at, Severity::kError,
         "node " + Quoted(id) + " has " + Counted(count, "child", "children") + "; expected " +
             expected);
}

Node* Builder::MakeSubtree(const Element& element, const Around& around) {
  const Attribute* attribute = element.Find("ID");
  if (attribute == nullptr) {
    Report(element.at, Severity::kError, "<SubTree> needs the attribute 'ID', the name of a tree");
    return nullptr;
  }
  if (!element.children.empty()) {
    Report(element.at, Severity::kError, "<SubTree> has children; expected none");
  }
  const std::string& id = attribute->value;
  const Document::Tree* tree = document_.Find(id);
  if (tree == nullptr) {
    Report(attribute->value_at, Severity::kError,
           "there is no tree " + Quoted(id) + DidYouMean(id, TreeNames(document_)));
    return nullptr;
  }
  if (std::ranges::find(inside_, id) != inside_.end()) {
    std::string circle;
    for (const std::string& each : inside_) circle += each + " -> ";
    Report(attribute->value_at, Severity::kError, "the trees are recursive: " + circle + id);
    return nullptr;
  }
  const NodeId node_id = Reserve(element, id, NodeKind::kSubtree, factory_.Find(id), around);
  Node* node = Keep(node_id, std::make_unique<Subtree>());
  SetConditions(element, *node, *tree_->boards_[around.board]);
  const std::uint32_t board = MakeBoard(element, id, around.board);
  static_cast<Decorator*>(node)->child_ = MakeContent(*tree, {node_id, board, around.depth + 1});
  return node;
}

Built Build(const Document& document, const Factory& factory, const BuildOptions& options) {
  Builder builder(document, factory);
  const auto fail = [&](Place place, std::string message) -> Built {
    builder.Report(place, Severity::kError, std::move(message));
    return {nullptr, std::move(builder).Take()};
  };
  if (document.trees.empty()) return fail({}, "there is no <BehaviorTree>");
  std::string name = options.tree;
  if (name.empty() && document.main) name = document.main->value;
  const std::vector<const Document::Tree*> trees = RootsFirst(document);
  if (name.empty() && options.any_root) name = trees.front()->id;
  if (name.empty() && document.trees.size() > 1) {
    return fail({}, "there are " + std::to_string(document.trees.size()) +
                        " trees; name the first one: <root main_tree_to_execute=\"" +
                        document.trees.front().id + "\">");
  }
  const Document::Tree* main = name.empty() ? &document.trees.front() : document.Find(name);
  if (main == nullptr) {
    return fail(options.tree.empty() && document.main ? document.main->value_at : Place{},
                "there is no tree " + Quoted(name) + DidYouMean(name, TreeNames(document)));
  }
  const GivenTypes given(options.board.get());
  std::unique_ptr<Tree> tree = builder.Make(*main, options.history, options.board);
  const Builder::FittingValues fitting = builder.TakeFittingValues();
  // Trees that nothing uses are checked, too.
  for (const Document::Tree* other : trees) {
    const auto& used = builder.used();
    if (std::ranges::find(used, other->id) == used.end()) builder.Make(*other, 0, nullptr);
  }
  builder.CheckSubstitutions();
  if (builder.failed()) {
    tree = nullptr;
    given.Restore();
  } else {
    for (const auto& [entry, value] : fitting) entry->value = value;
  }
  return {std::move(tree), std::move(builder).Take()};
}

WakeUp Builder::wake_up() const {
  if (tree_->wake_up_ == nullptr) tree_->wake_up_ = std::make_shared<WakeUp::State>();
  return WakeUp(tree_->wake_up_);
}

// --- attributes and entries of blackboards: ports, conditions, remapping ---

Setup::Connection Builder::Connect(const Element& element, Board& board, const PortModel& model) {
  const Attribute* attribute = element.Find(model.name);
  if (attribute == nullptr) {
    const auto otherwise = KeyOf(model.otherwise, model.name);
    if (otherwise && model.direction != Direction::kText) {
      Entry& entry = Use(board.At(*otherwise), element.at, model);
      // A default is not misspelt: only what is set is noted.
      if (model.direction != Direction::kIn) NoteWrite(entry, element.at);
      return {&entry, nullptr};
    }
    if (model.required) {
      Report(element.at, Severity::kError,
             "<" + element.name + "> needs " + PortText(model) +
                 (model.doc.empty() ? "" : ": " + model.doc));
    }
    return {};
  }
  MarkUsed(*attribute);
  if (model.direction == Direction::kText) return {nullptr, attribute};
  const auto key = KeyOf(attribute->value, model.name);
  if (key) {
    Entry& entry = Use(board.At(*key), attribute->value_at, model);
    if (model.direction != Direction::kOut) NoteRead(entry, attribute->value_at);
    if (model.direction != Direction::kIn) NoteWrite(entry, attribute->value_at);
    return {&entry, nullptr};
  }
  if (model.direction == Direction::kInOut) {
    Report(attribute->value_at, Severity::kWarning,
           PortText(model) + " is a fixed text: what is written to it is lost");
  } else if (model.direction == Direction::kOut) {
    Report(attribute->value_at, Severity::kError,
           PortText(model) + " is written; expected an entry, such as \"{" + model.name + "}\"");
    return {};
  }
  return {nullptr, attribute};
}

Entry& Builder::Use(Entry& entry, Place place, const PortModel& model) {
  entry.declared = true;
  Unify(entry, place, model);
  return entry;
}

void Builder::Unify(Entry& entry, Place place, const PortModel& model) {
  if (model.type == nullptr) return;
  // Everything that is a text or a number can be read as a text.
  if (model.direction == Direction::kIn && model.type == TypeOf<std::string>()) {
    read_as_text_.insert(&entry);
    return;
  }
  const auto read_at =
      model.direction != Direction::kOut ? std::optional<Place>(place) : std::nullopt;
  const bool writes = model.direction != Direction::kIn;
  const bool elsewhere = entry.type != nullptr;
  const auto [first, is_first] =
      types_.try_emplace(&entry, FirstUse{elsewhere ? entry.type : model.type, place, elsewhere});
  if (is_first && !elsewhere) entry.type = model.type;
  const Type* known = first->second.type;
  if (known == model.type) {
    if (!first->second.read_at) first->second.read_at = read_at;
    first->second.writes |= writes;
    return;
  }
  if (entry.type == nullptr) return;
  if (known == TypeOf<std::string>() || model.type == TypeOf<std::string>()) {
    entry.type = nullptr;
    return;
  }
  if (CommonBase(*known, *model.type) != nullptr) {
    pointers_[&entry].push_back({model.type, place, false, writes, read_at});
    return;
  }
  const Diagnostic at = document_.At(first->second.place, Severity::kNote, "");
  Report(place, Severity::kError,
         PortText(model) + " uses '" + entry.key + "', which is of type " +
             std::string(known->name) +
             (first->second.elsewhere ? " in another tree that shares the board"
                                      : " at " + at.file + ":" + std::to_string(at.line) + ":" +
                                            std::to_string(at.column)));
}

// Pointers to classes of which one is the base of the others: the entry has the nearest common base
// of what is written.
void Builder::UnifyPointers() {
  for (auto& [entry, uses] : pointers_) {
    const FirstUse first = types_.at(entry);
    uses.push_back(first);
    const Type* written = first.elsewhere ? first.type : nullptr;
    for (const FirstUse& use : uses) {
      if (!use.writes || first.elsewhere) continue;
      written = written == nullptr ? use.type : CommonBase(*written, *use.type);
    }
    entry->type = written;
    if (written == nullptr) continue;  // the program sets it
    const std::string is = "'" + entry->key + "' is of type " + std::string(written->name) +
                           (first.elsewhere ? " in another tree that shares the board"
                                            : ", the base of all that is written to it");
    for (const FirstUse& use : uses) {
      const std::string port = "; a port of type " + std::string(use.type->name);
      if (use.writes && !DerivesFrom(*use.type, *written)) {
        Report(use.place, Severity::kError, is + port + " can not write it");
      } else if (use.read_at && !DerivesFrom(*written, *use.type)) {
        Report(*use.read_at, Severity::kError, is + port + " can not read it");
      }
    }
  }
}

void Builder::NoteScript(const Script& script, Place place, bool always) {
  for (const Entry* entry : script.reads()) {
    NoteRead(*entry, place);
    script_reads_.emplace_back(entry, place);
  }
  for (const Entry* entry : script.writes()) {
    writes_.emplace(entry, place);
    if (std::ranges::find(script.needs(), entry) != script.needs().end()) continue;
    made_[entry].push_back(present());
  }
  for (const Entry* entry : script.needs()) needed_.push_back({entry, place, present(), always});
}

void Builder::CheckAttributes(const Element& element, const Setup& setup) {
  for (const PortModel& port : setup.ports()) {
    if (port.name != "name" && port.name != "ID" && !port.name.starts_with('_')) continue;
    Report(element.at, Severity::kError,
           "node '" + element.name + "' has a port '" + port.name +
               "', which is reserved; give the port another name");
  }
  for (const Attribute& attribute : element.attributes) {
    if (IsReserved(attribute.name) || IsCondition(attribute.name)) continue;
    if (std::ranges::find(used_attributes_, &attribute) != used_attributes_.end()) continue;
    std::vector<std::string> known = {"name"};
    for (const PortModel& port : setup.ports()) known.push_back(port.name);
    const bool special = attribute.name.starts_with('_');
    if (special) known.assign(kConditionNames.begin(), kConditionNames.end());
    Report(attribute.at, special ? Severity::kWarning : Severity::kError,
           (special ? "attribute '" + attribute.name + "' has no meaning"
                    : "<" + element.name + "> has no port '" + attribute.name + "'") +
               DidYouMean(attribute.name, known));
  }
}

void Builder::SetConditions(const Element& element, Node& node, Board& board) {
  const bool may_have = std::ranges::any_of(
      element.attributes, [](const Attribute& each) { return each.name.starts_with('_'); });
  if (!may_have) return;
  for (std::size_t i = 0; i < kConditionNames.size(); ++i) {
    const Attribute* attribute = element.Find(kConditionNames[i]);
    if (attribute == nullptr) continue;
    std::vector<Script::Finding> findings;
    Script script =
        Script::Parse(attribute->value, board, factory_.enums(), i < kConditionsBefore, findings);
    for (const Script::Finding& finding : findings) ReportScript(*attribute, finding);
    NoteScript(script, attribute->value_at, false);
    if (node.conditions_ == nullptr) node.conditions_ = std::make_unique<Conditions>();
    node.conditions_->scripts[i] = std::make_unique<const Script>(std::move(script));
    node.special_ = true;
  }
}

// The board of a subtree, with the keys that the element and the model of the subtree give it.
std::uint32_t Builder::MakeBoard(const Element& element, std::string_view id,
                                 std::uint32_t outer_id) {
  Board& outer = *tree_->boards_[outer_id];
  const Attribute* auto_attribute = element.Find("_autoremap");
  bool autoremap = element.name == "SubTreePlus";
  if (auto_attribute != nullptr) {
    const Result<bool> value = Convert<bool>::FromText(auto_attribute->value);
    if (!value) Report(auto_attribute->value_at, Severity::kError, value.error().message);
    autoremap = value && value.value();
  }
  tree_->boards_.push_back(std::make_shared<Board>(outer, autoremap));
  const auto board_id = static_cast<std::uint32_t>(tree_->boards_.size() - 1);
  Board& board = *tree_->boards_.back();
  const auto give = [&](const std::string& name, const std::string& value, Place place,
                        const Attribute* attribute) {
    if (const auto key = KeyOf(value, name)) {
      board.Remap(name, *key);
    } else {
      constants_.push_back({&board.Own(name), attribute, value, place});
    }
  };
  std::vector<std::string> given;
  for (const Attribute& attribute : element.attributes) {
    if (attribute.name == "ID" || attribute.name == "name" || attribute.name.starts_with('_')) {
      if (!IsReserved(attribute.name) && !IsCondition(attribute.name)) {
        Report(attribute.at, Severity::kWarning,
               "attribute '" + attribute.name + "' has no meaning");
      }
      continue;
    }
    give(attribute.name, attribute.value, attribute.value_at, &attribute);
  }
  for (const Element& model : document_.models) {
    const Attribute* model_id = model.Find("ID");
    if (model.name != "SubTree" || model_id == nullptr || model_id->value != id) continue;
    for (const Element& port : model.children) {
      const Attribute* name = port.Find("name");
      if (name == nullptr || element.Find(name->value) != nullptr || autoremap) continue;
      const Attribute* value = port.Find("default");
      if (value != nullptr) {
        give(name->value, value->value, value->value_at, value);
      } else {
        Report(element.at, Severity::kError,
               "<SubTree ID=\"" + std::string(id) + "\"> needs '" + name->value +
                   "', which <TreeNodesModel> declares without a default");
      }
    }
  }
  return board_id;
}

// What a given board has already becomes a value of the type of its ports: once nothing can fail.
void Builder::FitValues() {
  for (const auto& [entry, use] : types_) {
    if (entry->type == nullptr || entry->value.empty()) continue;
    if (entry->value.type() == entry->type) continue;
    Value value;
    if (const Result<> fits = value.SetAs(*entry->type, entry->value); !fits) {
      Report(use.place, Severity::kError,
             "'" + entry->key + "' of the given board is " + entry->value.Shown() + ": " +
                 fits.error().message);
    } else {
      fitting_.emplace_back(entry, std::move(value));
    }
  }
}

// Fixed texts of subtrees become values once the types of their entries are known: a number where
// the whole text is one, as in BehaviorTree.CPP.
void Builder::SetConstants() {
  for (const Constant& constant : constants_) {
    Result<> set;
    const Result<double> number = Convert<double>::FromText(constant.text);
    const auto known = factory_.enums().find(constant.text);
    if (known != factory_.enums().end() && constant.entry->type != TypeOf<std::string>()) {
      set = constant.entry->AssignNumber(known->second);
    } else if (constant.entry->type == nullptr && !read_as_text_.contains(constant.entry) &&
               number) {
      set = constant.entry->AssignNumber(number.value());
    } else {
      set = constant.entry->AssignText(constant.text);
    }
    if (!set) {
      Report(constant.place, Severity::kError,
             "'" + constant.entry->key + "': " + set.error().message);
    }
  }
}

}  // namespace musher::tree
