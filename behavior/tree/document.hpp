#pragma once
// The text of behaviour trees, as it was read: plain values with their places in the files. What
// the nodes mean is checked when a tree is built (build.hpp).

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher::tree {

// A byte of a file of the document.
struct Place {
  std::uint32_t file = 0;
  std::uint32_t at = 0;

  friend bool operator==(const Place&, const Place&) = default;
  friend bool operator<(const Place& a, const Place& b) {
    return a.file != b.file ? a.file < b.file : a.at < b.at;
  }
};

struct Attribute {
  std::string name;
  std::string value;  // without entities: '<' for "&lt;"
  Place at;
  Place value_at;
};

struct Element {
  std::string name;
  Place at;
  std::vector<Attribute> attributes;
  std::vector<Element> children;

  const Attribute* Find(std::string_view attribute) const;  // null: it has none
};

struct Document {
  struct File {
    std::string path;
    std::string text;
  };
  struct Tree {
    std::string id;
    Element content;  // <BehaviorTree>
  };

  std::vector<File> files;
  std::vector<Tree> trees;
  std::vector<Element> models;    // the elements of all <TreeNodesModel>
  std::optional<Attribute> main;  // main_tree_to_execute

  const Tree* Find(std::string_view id) const;  // null: there is none
  Diagnostic At(Place place, Severity severity, std::string message) const;
  // The place of the character at `offset` of an attribute's value.
  Place Inside(const Attribute& attribute, std::size_t offset) const;
};

}  // namespace musher::tree
