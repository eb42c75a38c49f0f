#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/behavior/tree/xml/places.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"

namespace musher::tree {
namespace {

constexpr std::size_t kMostBytes = 4U << 20U;
constexpr std::size_t kMostFiles = 200;

class Reader {
 public:
  explicit Reader(const ReadText& read) : read_(read) {}

  Reading Run(std::string_view text, const std::string& file, bool needs_tree) && {
    ReadOne(text, file, true);
    if (needs_tree) CheckTrees();
    return {std::move(document_), std::move(found_)};
  }

 private:
  void Report(Place place, Severity severity, std::string message) {
    found_.push_back(document_.At(place, severity, std::move(message)));
  }
  void Error(Place place, std::string message) {
    Report(place, Severity::kError, std::move(message));
  }

  void ReadOne(std::string_view text, const std::string& file, bool first) {
    const auto id = static_cast<std::uint32_t>(document_.files.size());
    document_.files.push_back({file, std::string(text.substr(0, kMostBytes))});
    if (text.size() > kMostBytes) return Error({id, 0}, "the file is larger than 4 MiB");
    tinyxml2::XMLDocument xml;
    xml.Parse(text.data(), text.size());
    if (xml.Error()) return ReportSyntax(xml, id);
    const tinyxml2::XMLElement* root = xml.RootElement();
    if (root == nullptr) return Error({id, 0}, "there is no element <root>");
    places_ = FindPlaces(text);
    next_place_ = 0;
    Element element = Convert(*root, id);
    ReadRoot(std::move(element), file, first);
  }

  // The parser names a line only.
  void ReportSyntax(const tinyxml2::XMLDocument& xml, std::uint32_t id) {
    const std::string& text = document_.files[id].text;
    std::size_t at = 0;
    for (int line = 1; line < xml.ErrorLineNum() && at < text.size(); ++line) {
      at = std::min(text.find('\n', at), text.size() - 1) + 1;
    }
    at = std::min(std::min(text.find_first_not_of(" \t", at), text.size()), text.size());
    std::string what = "this is no XML";
    switch (xml.ErrorID()) {
      case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
        what = "an element is not closed, or closed with another name";
        break;
      case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
        what = "an attribute is not written as name=\"value\", or is there twice";
        break;
      case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
        what = "the text is empty";
        break;
      case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
        what = "elements are nested deeper than " + std::to_string(TINYXML2_MAX_ELEMENT_DEPTH) +
               "; use subtrees";
        break;
      default:
        break;
    }
    Error({id, static_cast<std::uint32_t>(at)}, std::move(what));
  }

  // Where the element stands, and its attributes; 0 and none where the text was not understood.
  std::pair<std::uint32_t, std::span<const AttributePlace>> PlacesOf(std::size_t element) const {
    const std::vector<ElementPlace>& elements = places_.elements;
    if (element >= elements.size()) return {0, {}};
    const std::size_t first = elements[element].first_attribute;
    const std::size_t end = element + 1 < elements.size() ? elements[element + 1].first_attribute
                                                          : places_.attributes.size();
    return {elements[element].at, std::span(places_.attributes).subspan(first, end - first)};
  }

  Element Convert(const tinyxml2::XMLElement& from, std::uint32_t file) {
    const std::size_t index = next_place_++;
    Element element;
    element.name = from.Name();
    const auto [place, attributes] = PlacesOf(index);
    element.at = {file, place};
    std::size_t i = 0;
    for (const auto* each = from.FirstAttribute(); each != nullptr; each = each->Next(), ++i) {
      const bool known = i < attributes.size();
      element.attributes.push_back({each->Name(), each->Value(),
                                    known ? Place{file, attributes[i].name_at} : element.at,
                                    known ? Place{file, attributes[i].value_at} : element.at});
    }
    std::size_t count = 0;
    for (const auto* child = from.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      ++count;
    }
    element.children.reserve(count);
    for (const auto* child = from.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      element.children.push_back(Convert(*child, file));
    }
    return element;
  }

  void ReadRoot(Element root, const std::string& file, bool first) {
    if (root.name != "root") {
      return Error(root.at, "the outermost element is <" + root.name + ">; expected <root>");
    }
    CheckFormat(root);
    const Attribute* main = root.Find("main_tree_to_execute");
    if (main != nullptr && first) document_.main = *main;
    std::vector<Element> includes;
    for (Element& child : root.children) {
      if (child.name == "include") {
        includes.push_back(std::move(child));
      } else if (child.name == "BehaviorTree") {
        AddTree(std::move(child));
      } else if (child.name == "TreeNodesModel") {
        for (Element& model : child.children) {
          if (model.name == "SubTree" && model.Find("ID") == nullptr) {
            Report(model.at, Severity::kWarning,
                   "<SubTree> needs the attribute 'ID', the name of a tree; it has no effect");
          }
          document_.models.push_back(std::move(model));
        }
      } else {
        static const std::vector<std::string> known = {"BehaviorTree", "include", "TreeNodesModel"};
        const std::string hint = DidYouMean(child.name, known, "<>");
        Error(child.at, "<" + child.name + "> has no place in <root>" +
                            (hint.empty() ? "; expected <BehaviorTree>, <include> or "
                                            "<TreeNodesModel>"
                                          : hint));
      }
    }
    for (const Element& include : includes) Include(include, file);
  }

  void CheckFormat(const Element& root) {
    const Attribute* format = root.Find("BTCPP_format");
    if (format == nullptr) {
      Report(root.at, Severity::kWarning,
             "the attribute BTCPP_format=\"4\" is missing; the file is read as version 4");
    } else if (format->value != "4") {
      Error(format->value_at, "BTCPP_format is '" + format->value + "'; expected 4");
    }
  }

  void AddTree(Element tree) {
    const Attribute* id = tree.Find("ID");
    const std::string name =
        id != nullptr ? id->value : "BehaviorTree_" + std::to_string(document_.trees.size());
    if (const Document::Tree* other = document_.Find(name)) {
      const Diagnostic at = document_.At(other->content.at, Severity::kNote, "");
      return Error(
          id != nullptr ? id->value_at : tree.at,
          "there is already a tree '" + name + "', at " + at.file + ":" + std::to_string(at.line));
    }
    document_.trees.push_back({name, std::move(tree)});
  }

  void Include(const Element& include, const std::string& file) {
    const Attribute* path = include.Find("path");
    if (path == nullptr) return Error(include.at, "<include> needs the attribute 'path'");
    if (const Attribute* package = include.Find("ros_pkg")) {
      return Error(package->at, "ros_pkg is not supported; expected a path relative to this file");
    }
    if (document_.files.size() >= kMostFiles) {
      return Error(include.at, "there are more than " + std::to_string(kMostFiles) + " files");
    }
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    const std::string full = (folder / path->value).lexically_normal().string();
    const bool known = std::ranges::any_of(document_.files, [&full](const Document::File& other) {
      return std::filesystem::path(other.path).lexically_normal() == full;
    });
    if (known) return;
    if (!read_)
      return Error(path->value_at, "a text without a file can not include '" + full + "'");
    const Result<std::string> text = read_(full);
    if (!text)
      return Error(path->value_at, "can not include '" + full + "': " + text.error().message);
    ReadOne(text.value(), full, false);
  }

  void CheckTrees() {
    if (HasError(found_) || !document_.trees.empty()) return;
    found_.push_back(
        {document_.files.front().path, 0, 0, Severity::kError, "there is no <BehaviorTree>"});
  }

  const ReadText& read_;
  Document document_;
  std::vector<Diagnostic> found_;
  Places places_;
  std::size_t next_place_ = 0;
};

Reading ReadFile(const std::string& path, bool needs_tree) {
  const ReadText read = [](const std::string& file) {
    return config_toml::ReadTextFile(file, kMostBytes);
  };
  const Result<std::string> text = read(path);
  if (text) return Reader(read).Run(text.value(), path, needs_tree);
  return {{}, {{path, 0, 0, Severity::kError, text.error().message}}};
}

}  // namespace

Reading ReadTree(std::string_view text, const std::string& file, const ReadText& read) {
  return Reader(read).Run(text, file, true);
}

Reading ReadTreeFile(const std::string& path) {
  return ReadFile(path, true);
}

Reading ReadModelsFile(const std::string& path) {
  return ReadFile(path, false);
}

}  // namespace musher::tree
