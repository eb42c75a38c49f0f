#include "musher/modules/meilin/nodes/drawn_form.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace musher::meilin {
namespace {

class DrawnForm {
 public:
  explicit DrawnForm(const tree::Document& document) : document_(document) {}

  void Accept(tree::Element& element) {
    const bool is_switch = element.name == "SwitchSegmentType";
    for (tree::Element& child : element.children) {
      if (is_switch) NameByType(child);
      if (child.name == "ForceSuccess" && child.children.empty()) {
        Report(child.at, Severity::kWarning,
               "<ForceSuccess> has no child; it is read as <AlwaysSuccess>");
        child.name = "AlwaysSuccess";
      }
      Accept(child);
    }
  }
  std::vector<Diagnostic> Take() && { return std::move(found_); }

 private:
  void NameByType(tree::Element& child) {
    const auto type = std::ranges::find(child.attributes, "segment_type", &tree::Attribute::name);
    if (type == child.attributes.end()) return;
    const tree::Attribute* name = child.Find("name");
    if (name == nullptr) {
      Report(type->at, Severity::kWarning,
             "a child of <SwitchSegmentType> is chosen by its name; segment_type=\"" + type->value +
                 "\" is read as name=\"" + type->value + "\"");
      type->name = "name";
      return;
    }
    const bool same = name->value == type->value;
    Report(type->at, same ? Severity::kWarning : Severity::kError,
           "a child of <SwitchSegmentType> is chosen by its name, \"" + name->value + "\"; " +
               (same ? "segment_type is not needed"
                     : "segment_type=\"" + type->value + "\" contradicts it"));
    child.attributes.erase(type);
  }
  void Report(tree::Place place, Severity severity, std::string message) {
    found_.push_back(document_.At(place, severity, std::move(message)));
  }

  const tree::Document& document_;
  std::vector<Diagnostic> found_;
};

}  // namespace

std::vector<Diagnostic> AcceptDrawnForm(tree::Document& document) {
  DrawnForm form(document);
  for (tree::Document::Tree& tree : document.trees) form.Accept(tree.content);
  return std::move(form).Take();
}

}  // namespace musher::meilin
