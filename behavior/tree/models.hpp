#pragma once
// Models of nodes: name, kind and ports, as <TreeNodesModel> of BehaviorTree.CPP 4 has them. An
// editor such as Groot2 reads them, and a tree can be checked without the program that has its
// nodes:
//
//   tree::Factory factory;                                       // the nodes that Musher has
//   found = tree::AddPlaceholders(factory, reading.document);    // and those of the models
//   built = tree::Build(reading.document, factory);
//
// A placeholder has the ports and the number of children of its node. Its tick fails.
//
// Threads: any; nothing is shared.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {

// The nodes of the factory as an XML document, sorted by kind and name.
std::string ModelsXml(const Factory& factory);
// The same as tables in Markdown.
std::string ModelsMarkdown(const Factory& factory);

// Adds a placeholder for each node of the document's models that the factory lacks. Errors and
// warnings have their places in the document. A tree that is built with it gives no warnings that
// depend on whether a node takes time.
std::vector<Diagnostic> AddPlaceholders(Factory& factory, const Document& models);

// What a node that Musher has does; empty for another one.
std::string_view DescriptionOf(std::string_view node);

}  // namespace musher::tree
